"""Least time in which a body axis is pointed, with any roll, by CasADi and IPOPT.

    python -m benchmarks.casadi_boresight mrp-k3 [--axis 0 0 1] [--starts 20] [--intervals 30]

The same turns, dynamics and transcription as `casadi_reorientation` with Runge-Kutta steps, rho 0,
and at the end two rows instead of three: what the axis has across the direction that the case's own
target gives it.  The starts are paths to that target, rolled about the axis by random angles.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.casadi_compiled import compiled_solver
from benchmarks.casadi_reorientation import OPTIONS, step_function
from benchmarks.reorientation_numbers import Floats, Start, Turn, case, random_path


def turned(sigma: ca.MX, axis: Floats) -> ca.MX:
    """Components of a body axis in the axes in which sigma is zero."""
    squared = ca.sumsqr(sigma)
    once = ca.cross(sigma, axis)
    twice = ca.cross(sigma, once)
    return ca.DM(axis) + (8 * twice + 4 * (1 - squared) * once) / (1 + squared) ** 2


def program(turn: Turn, axis: Floats) -> dict[str, ca.MX]:
    """Least time; its variables are the step, then torques and next state, interval by interval."""
    n, b = turn.intervals, turn.torques
    variables = ca.MX.sym("variables", 1 + n * (b + 6))
    step, stages = variables[0], ca.reshape(variables[1:], b + 6, n)
    torques, states = stages[:b, :], stages[b:, :]
    begin = ca.horzcat(ca.MX.zeros(6), states[:, :-1])
    gaps = step_function(turn, True).map(n)(begin, torques, ca.repmat(step, 1, n)) - states
    wanted = Rotation.from_mrp(turn.sigma).apply(axis)
    _, _, frame = np.linalg.svd(wanted[None])
    pointed = turned(states[:3, -1], axis)
    ends = ca.vertcat(ca.DM(frame[1:]) @ pointed, states[3:, -1], ca.dot(wanted, pointed))
    return {"x": variables, "f": n * step, "g": ca.vertcat(ca.vec(gaps), ends)}


def rolled(turn: Turn, axis: Floats, seed: int, index: int) -> Start:
    """A random path to the case's target with a random roll."""
    angle = np.random.default_rng([seed, index, 1]).uniform(-np.pi, np.pi)
    whole = Rotation.from_mrp(turn.sigma) * Rotation.from_rotvec(angle * axis)
    return random_path(replace(turn, sigma=whole.as_mrp(), weight=0.0), seed, index)


def fastest(
    turn: Turn, axis: Floats, starts: int, seed: int, folder: Path
) -> list[tuple[float, str]]:
    """Final time [s] and IPOPT's word of every start."""
    n, b = turn.intervals, turn.torques
    function = compiled_solver("ipopt", program(turn, axis), OPTIONS, folder)
    bounds = np.r_[np.inf, np.tile(np.r_[np.full(b, turn.limit), np.full(6, np.inf)], n)]
    lower = np.r_[1e-6, -bounds[1:]]
    least = np.r_[np.zeros(6 * n + 5), 0.0]
    most = np.r_[np.zeros(6 * n + 5), np.inf]
    found = []
    for index in range(starts):
        start = rolled(turn, axis, seed, index)
        x = np.r_[start.step, np.column_stack([start.torques, start.states[1:]]).ravel()]
        answer = function(x0=x, lbx=lower, ubx=bounds, lbg=least, ubg=most)
        found.append((float(answer["f"]), str(function.stats()["return_status"])))
    return found


def main() -> None:
    """Solve and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case")
    parser.add_argument("--axis", type=float, nargs=3, default=[0.0, 0.0, 1.0])
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--intervals", type=int, default=30)
    options = parser.parse_args()
    turn = replace(case(options.case), intervals=options.intervals)
    axis = np.array(options.axis) / np.linalg.norm(options.axis)
    with tempfile.TemporaryDirectory() as folder:
        found = fastest(turn, axis, options.starts, options.seed, Path(folder))
    times = sorted(time for time, word in found if word == "Solve_Succeeded")
    print(f"{options.case}, axis {axis}, N = {turn.intervals}: ", end="")
    print(f"{len(times)} of {len(found)} solved; least {times[0]:.6f} s, most {times[-1]:.6f} s")


if __name__ == "__main__":
    main()
