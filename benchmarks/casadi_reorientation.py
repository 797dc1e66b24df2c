"""Reorientation in free time with CasADi and IPOPT in the strongest form that was found.

    python -m benchmarks.casadi_reorientation mrp-k4 --starts 20 [--rk4] [--rho 0.01]

Problem II of the source (see `reorientation_numbers`): multiple shooting in sigma and the body
rate, the step a variable, first and last state eliminated, exact derivatives, everything expanded,
mapped over the intervals and compiled.  The starts are the paper's random paths, states included.

Tried without gain: adaptive mu, mu_init from 1e-2 to 1, other bound pushes (a longer tail), no
scaling, no multiplier estimate.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.casadi_compiled import compiled_solver
from benchmarks.reorientation_numbers import Floats, Start, Turn, case, random_path

OPTIONS: dict[str, Any] = {
    "ipopt.tol": 1e-9,
    "ipopt.bound_push": 0.1,
    "ipopt.bound_frac": 0.1,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}


def slope(turn: Turn, state: ca.SX, torques: ca.SX) -> ca.SX:
    """Time derivative of sigma and rate: equations (4), (5) and (1) with h = 0."""
    sigma, omega = state[:3], state[3:]
    straight = (1 - ca.dot(sigma, sigma)) * omega
    turning = 2 * ca.cross(sigma, omega) + 2 * ca.dot(sigma, omega) * sigma
    return ca.vertcat(0.25 * (straight + turning), ca.DM(turn.acceleration) @ torques)


def step_function(turn: Turn, rk4: bool) -> ca.Function:
    """(state, torques, step) -> next state, by forward Euler (15), (18) or RK4."""
    x, u, h = ca.SX.sym("x", 6), ca.SX.sym("u", turn.torques), ca.SX.sym("h")
    k1 = slope(turn, x, u)
    if not rk4:
        return ca.Function("step", [x, u, h], [x + h * k1])
    k2 = slope(turn, x + h / 2 * k1, u)
    k3 = slope(turn, x + h / 2 * k2, u)
    k4 = slope(turn, x + h * k3, u)
    return ca.Function("step", [x, u, h], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])


def program(turn: Turn, rk4: bool) -> dict[str, ca.MX]:
    """Problem II; its variables are the step, then torques and next state, interval by interval.

    The last interval has torques only.  The parameters are the target's sigma and rho.
    """
    n, b = turn.intervals, turn.torques
    variables, parameters = ca.MX.sym("variables", 1 + n * (b + 6) - 6), ca.MX.sym("p", 4)
    step, rho = variables[0], parameters[3]
    stages = ca.reshape(ca.vertcat(variables[1:], parameters[:3], ca.MX.zeros(3)), b + 6, n)
    torques, states = stages[:b, :], stages[b:, :]
    begin = ca.horzcat(ca.MX.zeros(6), states[:, :-1])
    gaps = step_function(turn, rk4).map(n)(begin, torques, ca.repmat(step, 1, n)) - states
    cost = step * (n + rho * ca.sumsqr(torques))
    return {"x": variables, "p": parameters, "f": cost, "g": ca.vec(gaps)}


def packed(start: Start) -> Floats:
    """A start as variables of `program`."""
    stages = np.column_stack([start.torques, start.states[1:]])
    return np.r_[start.step, stages.ravel()[:-6]]


@dataclass(frozen=True, eq=False)
class Optimum:
    """What IPOPT returned: torques (N, b) [N m], step [s], cost [s], its word and its work."""

    torques: Floats
    step: float
    cost: float
    status: str
    iterations: int
    cpu_s: float

    @property
    def effort(self) -> float:
        """Integral of the squared torques [(N m)^2 s]."""
        return self.step * float(np.sum(self.torques**2))


def timed(
    function: ca.Function, limits: dict[str, Any], x0: Floats, turn: Turn, rho: float | None
) -> tuple[Floats, float, dict[str, Any], float]:
    """Variables of an answer, objective, statistics and CPU time [s]; rho : None for the turn's."""
    begin = time.process_time()
    weight = turn.weight if rho is None else rho
    answer = function(x0=x0, p=np.r_[turn.sigma, weight], **limits)
    spent = time.process_time() - begin
    return np.asarray(answer["x"]).ravel(), float(answer["f"]), function.stats(), spent


class Solver:
    """Problem II of one turn, compiled; the target and rho may change between solves."""

    def __init__(
        self, turn: Turn, rk4: bool, folder: Path, options: dict[str, Any] | None = None
    ) -> None:
        """Build and compile into `folder`."""
        self.turn = turn
        settings = OPTIONS if options is None else options
        self.function = compiled_solver("ipopt", program(turn, rk4), settings, folder)
        n, b = turn.intervals, turn.torques
        bounds = np.tile(np.r_[np.full(b, turn.limit), np.full(6, np.inf)], n)[:-6]
        self.limits = {
            "lbx": np.r_[1e-6, -bounds],
            "ubx": np.r_[np.inf, bounds],
            "lbg": 0.0,
            "ubg": 0.0,
        }

    def __call__(self, start: Start, rho: float | None = None) -> Optimum:
        """Solve from a start."""
        n, b = self.turn.intervals, self.turn.torques
        x, cost, stats, spent = timed(self.function, self.limits, packed(start), self.turn, rho)
        torques = np.r_[x[1:], np.zeros(6)].reshape(n, b + 6)[:, :b]
        status, iterations = stats["return_status"], stats["iter_count"]
        return Optimum(torques, float(x[0]), cost, status, iterations, spent)


def minima(optima: list[Optimum], tolerance: float = 1e-6) -> list[tuple[float, int]]:
    """Costs of the distinct minima among the solves that ended well, with their counts."""
    good = sorted(o.cost for o in optima if o.status == "Solve_Succeeded")
    found: list[list[float]] = []
    for cost in good:
        if found and cost - found[-1][0] <= tolerance * max(1.0, abs(cost)):
            found[-1].append(cost)
        else:
            found.append([cost])
    return [(group[0], len(group)) for group in found]


def main() -> None:
    """Solve and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case")
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rk4", action="store_true")
    parser.add_argument("--rho", type=float, help="[1/(N m)^2], the case's own by default")
    parser.add_argument("--intervals", type=int, help="N, the case's own by default")
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    options = parser.parse_args()
    turn = case(options.case)
    turn = replace(turn, intervals=options.intervals or turn.intervals)
    turn = turn if options.rho is None else replace(turn, weight=options.rho)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        began = time.perf_counter()
        solver = Solver(turn, options.rk4, folder)
        built = time.perf_counter() - began
        starts = [random_path(turn, options.seed, i) for i in range(options.starts)]
        optima = [solver(start) for start in starts]
    found = minima(optima)
    best = min(optima, key=lambda o: (o.status != "Solve_Succeeded", o.cost))
    work = [1e3 * o.cpu_s for o in optima]
    count = [o.iterations for o in optima]
    print(f"{options.case}, {'RK4' if options.rk4 else 'Euler'}, rho {turn.weight:g}")
    print(f"  tf {turn.intervals * best.step:.6f} s, step {best.step:.6f} s, cost {best.cost:.6f}")
    print(f"  effort {best.effort:.6f} (N m)^2 s, largest torque {np.abs(best.torques).max():.4f}")
    print(f"  built in {built:.1f} s; {np.median(work):.1f} ms CPU and ", end="")
    print(f"{np.median(count):.0f} iterations a start in the median, {max(count)} at most")
    stopped = sum(o.status != "Solve_Succeeded" for o in optima)
    print(f"  {len(optima)} starts, {found[0][1] if found else 0} at the best minimum, ", end="")
    print(f"{stopped} not solved; minima " + ", ".join(f"{c:.6f} x{k}" for c, k in found[:8]))


if __name__ == "__main__":
    main()
