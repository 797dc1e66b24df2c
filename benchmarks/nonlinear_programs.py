"""Published small programmes, solved here and by IPOPT through CasADi from the same starts.

    python benchmarks/nonlinear_programs.py [--starts 1 8] [--only NAME ...] [--held-out]
                                            [--json FILE]

One start takes about five minutes on one core, nearly all of it to compile the collection in
three groups of similar size; every further number of starts takes as long again.

A programme counts as solved if the point returned violates no constraint by more than 1e-6 and its
objective is within 1e-4 (relative where it exceeds 1) of the published optimum.  A claim of
convergence is false if violation, gradient of the Lagrangian, sign or complementarity, computed
here by CasADi's derivatives, do not hold to 1e-6, multipliers scaled as IPOPT scales them.
IPOPT's claims ("Solve_Succeeded") are put to the same test, which is not its own: it promises
1e-8 for its scaled programme, and bounds and complementarity less strictly in the user's units.
It gets one start and its defaults; `--starts` is what is compared to it.
Infeasible and unbounded programmes count as solved if the status says so.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import jax
import numpy as np

jax.config.update("jax_enable_x64", True)
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from references.nonlinear_programs import HELD_OUT, PROGRAMS, NonlinearProgram  # noqa: E402
from references.switchboard import Switchboard, by_size  # noqa: E402

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
    return bool(violation <= TOLERANCE and near)


@dataclass(frozen=True)
class Row:
    """How one programme ended for one solver.  kkt : None where convergence was not claimed."""

    name: str
    objective: float
    violation: float
    status: str
    solved: bool
    kkt: float | None
    seconds: float

    @property
    def false(self) -> bool:
        """Whether convergence was claimed wrongly."""
        return self.kkt is not None and not max(self.violation, self.kkt) <= TOLERANCE

    def __str__(self) -> str:
        mark = "" if self.solved else " wrong"
        if self.false:
            mark += f" FALSE {self.violation:.0e} {self.kkt:.0e}"
        return f"{self.objective:14.7g} {self.status[:22]}{mark}"


def ours(board: Switchboard, index: int, starts: int, model: Model) -> Row:
    """Solved by `minimize`."""
    program = model.program
    began = time.perf_counter()
    found: Any = board.solve(jaxatt.minimize, index, starts=starts)
    taken = time.perf_counter() - began
    x, status = found.x[: len(program.x0)], found.status.name
    f, violation = model.violation(x)
    kkt = None
    if status == "CONVERGED":
        y, z = found.multipliers.equality, found.multipliers.inequality
        kkt = model.kkt(x, y[: model.m], z[: model.p])
    right = solved(program, status, f, violation)
    return Row(program.name, f, violation, status, right, kkt, taken)


def theirs(model: Model) -> Row:
    """Solved by IPOPT."""
    program = model.program
    x, says, multipliers, taken = model.ipopt()
    f, violation = model.violation(x)
    kkt = None
    if says == "Solve_Succeeded":
        kkt = model.kkt(x, multipliers[: model.m], np.maximum(0.0, -multipliers[model.m :]))
    right = solved(program, says, f, violation)
    return Row(program.name, f, violation, says, right, kkt, taken)


def table(
    programs: Sequence[NonlinearProgram], starts: Sequence[int]
) -> tuple[dict[str, list[Row]], dict[str, float]]:
    """Rows by solver, printed as they come, and seconds of compilation."""
    columns = {f"{s} start{'s' * (s > 1)}": s for s in starts}
    results: dict[str, list[Row]] = {column: [] for column in [*columns, "ipopt"]}
    compiling = dict.fromkeys(columns, 0.0)
    print(f"{'':7s} {'programme':26s} {'published':>14s}  "
          + "  ".join(f"{c:>32s}" for c in results))  # fmt: skip
    done = 0
    for board in by_size(programs):
        for column, count in columns.items():
            began = time.perf_counter()
            board.solve(jaxatt.minimize, 0, starts=count)
            taken = time.perf_counter() - began
            compiling[column] += taken
            size = len(board.programs)
            print(f"-- {size} programmes, {column}: compiled in {taken:.1f} s", flush=True)
        for index, program in enumerate(board.programs):
            model = Model(program)
            rows = {c: ours(board, index, count, model) for c, count in columns.items()}
            rows["ipopt"] = theirs(model)
            for column, row in rows.items():
                results[column].append(row)
            done += 1
            wanted = program.answer if program.optimum is None else f"{program.optimum:.7g}"
            print(f"{done:3d}/{len(programs):3d} {program.name:26s} {wanted:>14s}  "
                  + "  ".join(f"{row!s:>32s}" for row in rows.values()), flush=True)  # fmt: skip
    return results, compiling


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, nargs="+", default=[1])
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--held-out", action="store_true", help="those that nothing was tuned on")
    parser.add_argument("--json", type=Path, help="file for all results")
    chosen = parser.parse_args()
    programs = HELD_OUT if chosen.held_out else PROGRAMS
    programs = [q for q in programs if not chosen.only or q.name in chosen.only]
    if not programs:
        parser.error("no programme of that name; names are in tests/references")
    results, compiling = table(programs, chosen.starts)
    print(f"\n{'':10s} {'solved':>9s} {'converged':>9s} {'not 1e-6':>9s} {'solve, s':>9s} "
          f"{'compile, s':>10s}")  # fmt: skip
    summary = {}
    for column, rows in results.items():
        summary[column] = tally = {
            "programmes": len(rows),
            "solved": sum(row.solved for row in rows),
            "converged": sum(row.kkt is not None for row in rows),
            "not_to_1e-6": sum(row.false for row in rows),
            "seconds": sum(row.seconds for row in rows),
            "compile_seconds": compiling.get(column, 0.0),
        }
        share = f"{tally['solved']}/{len(rows)}"
        print(f"{column:10s} {share:>9s} {tally['converged']:9d} {tally['not_to_1e-6']:9d} "
              f"{tally['seconds']:9.2f} {tally['compile_seconds']:10.1f}")  # fmt: skip
    if chosen.json:
        content = {c: [asdict(row) for row in rows] for c, rows in results.items()}
        chosen.json.write_text(json.dumps({"summary": summary, "results": content}, indent=1))


if __name__ == "__main__":
    main()
