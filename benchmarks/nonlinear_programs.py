"""Published small programmes, solved here and by IPOPT through CasADi from the same starts.

    python benchmarks/nonlinear_programs.py [--starts 1 8] [--only NAME ...] [--held-out]

A programme counts as solved if the point returned violates no constraint by more than 1e-6 and its
objective is within 1e-4 (relative where it exceeds 1) of the published optimum.  A claim of
convergence is false if violation, gradient of the Lagrangian, sign or complementarity, computed
here by CasADi's derivatives, do not hold to 1e-6, multipliers scaled as IPOPT scales them.
IPOPT gets one start and its own defaults, tolerance 1e-8; `--starts` is what is compared to it.
Infeasible and unbounded programmes count as solved if the status says so.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import casadi as ca
import jax
import numpy as np

jax.config.update("jax_enable_x64", True)
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from references.nonlinear_programs import HELD_OUT, PROGRAMS, NonlinearProgram  # noqa: E402
from references.switchboard import by_size  # noqa: E402

import jaxatt  # noqa: E402

TOLERANCE = 1e-6
SAYS = {
    "infeasible": ("INFEASIBLE", "Infeasible_Problem_Detected"),
    "unbounded": ("UNBOUNDED", "Diverging_Iterates"),
}


class CasadiModule:
    """The functions that programmes ask for, on symbols."""

    exp, log, sin, cos, sqrt, atan = ca.exp, ca.log, ca.sin, ca.cos, ca.sqrt, ca.atan
    array, sum = staticmethod(ca.DM), staticmethod(ca.sum1)


class Model:
    """One programme in CasADi: f, g, bounds and derivatives."""

    def __init__(self, program: NonlinearProgram) -> None:
        self.program = program
        n = len(program.x0)
        x = ca.SX.sym("x", n)
        parts = [x[i] for i in range(n)]
        equal = list(program.equality(parts, CasadiModule)) if program.equality else []
        above = list(program.inequality(parts, CasadiModule)) if program.inequality else []
        self.f = ca.SX(program.objective(parts, CasadiModule))
        self.g = ca.vertcat(ca.SX(0, 1), *equal, *above)
        self.x, self.m, self.p = x, len(equal), len(above)
        self.lower = np.full(n, -np.inf) if program.lower is None else np.array(program.lower)
        self.upper = np.full(n, np.inf) if program.upper is None else np.array(program.upper)
        self.values = ca.Function(
            "values", [x], [self.f, self.g, ca.gradient(self.f, x), ca.jacobian(self.g, x)]
        )

    def ipopt(self) -> tuple[np.ndarray, str, np.ndarray, float]:
        """Point, return status, multipliers of g, seconds."""
        options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
        solver = ca.nlpsol("s", "ipopt", {"x": self.x, "f": self.f, "g": self.g}, options)
        above = np.concatenate([np.zeros(self.m), np.full(self.p, np.inf)])
        began = time.perf_counter()
        try:
            found = solver(
                x0=self.program.x0, lbx=self.lower, ubx=self.upper,
                lbg=np.zeros(self.m + self.p), ubg=above,
            )  # fmt: skip
        except RuntimeError:
            return np.array(self.program.x0), "Exception", np.zeros(0), 0.0
        taken = time.perf_counter() - began
        x = np.clip(np.array(found["x"]).ravel(), self.lower, self.upper)
        return x, solver.stats()["return_status"], np.array(found["lam_g"]).ravel(), taken

    def violation(self, x: np.ndarray) -> tuple[float, float]:
        """Objective and largest violation, bounds included."""
        f, g, _, _ = (np.array(value) for value in self.values(x))
        rows = g.ravel()
        amiss = [np.abs(rows[: self.m]), -rows[self.m :], self.lower - x, x - self.upper]
        return float(f.item()), max(0.0, *(part.max(initial=0.0) for part in amiss))

    def kkt(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> float:
        """Largest scaled residual with y of equalities, z >= 0 of inequalities, bounds fitted."""
        _, g, slope, jacobian = (np.array(value) for value in self.values(x))
        g, slope = g.ravel(), slope.ravel()
        lagrangian = slope + jacobian.reshape(-1, len(x)).T @ np.concatenate([y, -z])
        gap = np.where(lagrangian > 0, x - self.lower, self.upper - x)
        rest = np.minimum(np.abs(lagrangian), gap * np.maximum(1.0, np.abs(lagrangian)))
        bounds = np.where(rest < np.abs(lagrangian), np.abs(lagrangian), 0.0)
        every = np.concatenate([np.abs(y), z, bounds])
        scale = max(100.0, every.mean()) / 100.0
        worst = max(rest.max(), np.abs(g[self.m :] * z).max(initial=0.0)) / scale
        return max(worst, -z.min(initial=0.0))


def solved(program: NonlinearProgram, says: str, f: float, violation: float) -> bool:
    """Whether the answer is the published one."""
    if program.answer != "optimum":
        return says in SAYS[program.answer]
    assert program.optimum is not None
    near = abs(f - program.optimum) <= 1e-4 * max(1.0, abs(program.optimum))
    return violation <= TOLERANCE and near


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, nargs="+", default=[1, 8])
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--held-out", action="store_true", help="those that nothing was tuned on")
    chosen = parser.parse_args()
    programs = HELD_OUT if chosen.held_out else PROGRAMS
    programs = [q for q in programs if not chosen.only or q.name in chosen.only]
    columns = [f"{s} start{'s' * (s > 1)}" for s in chosen.starts]
    tally = dict.fromkeys([*columns, "ipopt"], 0)
    false = dict.fromkeys(columns, 0)
    claimed = dict.fromkeys(columns, 0)
    seconds = dict.fromkeys([*columns, "ipopt"], 0.0)
    print(f"{'programme':26s} {'published':>14s}  " + "  ".join(f"{c:>32s}" for c in tally))
    for board in by_size(programs):
        for index, program in enumerate(board.programs):
            model = Model(program)
            n, m, p = board.counts[index]
            cells: list[str] = []
            for column, starts in zip(columns, chosen.starts, strict=True):
                if index == 0:
                    board.solve(jaxatt.minimize, 0, starts=starts)
                began = time.perf_counter()
                found: Any = board.solve(jaxatt.minimize, index, starts=starts)
                seconds[column] += time.perf_counter() - began
                x = found.x[:n]
                f, violation = model.violation(x)
                right = solved(program, found.status.name, f, violation)
                tally[column] += right
                mark = "" if right else " wrong"
                if found.status.name == "CONVERGED":
                    claimed[column] += 1
                    multipliers = found.multipliers
                    kkt = model.kkt(x, multipliers.equality[:m], multipliers.inequality[:p])
                    if not (violation <= TOLERANCE and kkt <= TOLERANCE):
                        false[column] += 1
                        mark += f" FALSE {violation:.0e} {kkt:.0e}"
                cells.append(f"{f:14.7g} {found.status.name}{mark}")
            x, says, _, taken = model.ipopt()
            seconds["ipopt"] += taken
            f, violation = model.violation(x)
            right = solved(program, says, f, violation)
            tally["ipopt"] += right
            cells.append(f"{f:14.7g} {says[:22]}{'' if right else ' wrong'}")
            wanted = program.answer if program.optimum is None else f"{program.optimum:.7g}"
            print(f"{program.name:26s} {wanted:>14s}  " + "  ".join(f"{c:>32s}" for c in cells),
                  flush=True)  # fmt: skip
    print()
    for column, count in tally.items():
        line = f"{column:10s} solved {count} of {len(programs)} in {seconds[column]:.1f} s"
        if column in false:
            line += f", {claimed[column]} converged of which {false[column]} falsely"
        print(line)


if __name__ == "__main__":
    main()
