"""Problems of one's own, without a derivative written by hand: the package beside CasADi and IPOPT.

    python -m benchmarks.own_programmes [--only "net power"] [--starts 32] [--ipopt 8] [--turns 5]

Both sides get the same Runge-Kutta step, the same random starts and a tolerance of 1e-8.  IPOPT
solves its share of them one by one, as its user builds it and compiled to C.  The sides take
turns, straight after each other, so that a slow minute of the machine slows both; what is compared
is CPU time a start, which does not depend on how many cores each side uses.  Building and compiling
stand apart.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import jaxatt

jaxatt.configure()

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402

from benchmarks.casadi_own import MODELS, Answer, Solver  # noqa: E402
from benchmarks.net_power import PARAMETERS, net_power  # noqa: E402
from jaxatt.multistart.programs.starts import draw_starts  # noqa: E402
from jaxatt.problems.toy.published_programs import PUBLISHED  # noqa: E402

NAMES = (*PUBLISHED, "net power")


def problem(name: str) -> tuple[jaxatt.OptimalControlProgram, Any]:
    """The programme and its parameters."""
    if name == "net power":
        return net_power(), PARAMETERS
    found = PUBLISHED[name]()
    return found.program, found.parameters


def same_starts(
    program: jaxatt.OptimalControlProgram, parameters: Any, count: int, seed: int
) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """The package's random starts for IPOPT: scaled controls, states and final time [s]."""
    args = jax.tree.map(jnp.asarray, parameters)
    drawn, layout = draw_starts(program, args, count, seed), program.layout
    assert layout is not None
    times = [float(layout.times(jnp.asarray(x[0]), args)[-1]) for x in drawn.x]
    states = drawn.x[:, :, : layout.states]
    return list(zip(drawn.u, states, times, strict=True))


def line(
    name: str,
    side: str,
    starts: int,
    build: float,
    spent: list[float],
    share: float,
    best: float,
    passes: float,
) -> str:
    """A row of the table."""
    return (
        f"| {name} | {side} | {starts} | {build:.1f} | {1e3 * statistics.median(spent):.1f} | "
        f"{100.0 * share:.0f} % | {best:.6g} | {passes:.0f} |"
    )


def in_turn(name: str, options: argparse.Namespace) -> tuple[float, float]:
    """Let both sides take turns, print three rows, and return IPOPT's CPU a start over ours."""
    program, parameters = problem(name)
    began = time.process_time()
    first = jaxatt.solve_program(program, parameters, starts=options.starts, seed=0)
    jaxatt.solve_program(program, parameters, starts=options.starts, seed=0)
    building = time.process_time() - began
    with tempfile.TemporaryDirectory() as folder:
        model = MODELS[name](len(first.controls))
        solvers = {"IPOPT": Solver(model), "IPOPT, compiled": Solver(model, Path(folder))}
        spent: dict[str, list[float]] = {"jaxatt": []} | {side: [] for side in solvers}
        answers: dict[str, list[Answer]] = {side: [] for side in solvers}
        found = []
        for turn in range(options.turns):
            began = time.process_time()
            found.append(
                jaxatt.solve_program(program, parameters, starts=options.starts, seed=turn)
            )
            spent["jaxatt"].append((time.process_time() - began) / options.starts)
            starts = same_starts(program, parameters, options.ipopt, turn)
            for side, solver in solvers.items():
                solved = [solver(*start) for start in starts]
                answers[side] += solved
                spent[side].append(sum(answer.cpu_s for answer in solved) / len(solved))
    # The two solves before the turns, less what they ran.
    building -= 2.0 * options.starts * statistics.median(spent["jaxatt"])
    status = np.concatenate([one.starts.status for one in found])
    passes = np.median(np.concatenate([one.starts.iterations for one in found]))
    best = min(one.objective for one in found)
    count = options.starts * options.turns
    share = float((status == 0).mean())
    print(line(name, "jaxatt", count, building, spent["jaxatt"], share, best, float(passes)))
    for side, solver in solvers.items():
        own = answers[side]
        share = sum(answer.solved for answer in own) / len(own)
        best = min((a.objective for a in own if a.solved), default=float("nan"))
        middle = statistics.median(a.iterations for a in own)
        print(line(name, side, len(own), solver.build_s, spent[side], share, best, middle))
    ratios = [
        statistics.median(t / o for t, o in zip(spent[side], spent["jaxatt"], strict=True))
        for side in solvers
    ]
    return ratios[0], ratios[1]


def main() -> None:
    """Run all problems and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=NAMES, nargs="*", default=list(NAMES))
    parser.add_argument("--starts", type=int, default=32)
    parser.add_argument("--ipopt", type=int, default=8, help="starts that IPOPT solves in a turn")
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    options.ipopt = min(options.ipopt, options.starts)
    head = ("problem", "side", "starts", "build [s]", "CPU a start [ms]")
    head = (*head, "converged", "best", "passes")
    print("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    ratios = {name: in_turn(name, options) for name in options.only}
    print()
    print("CPU a start of IPOPT over the package's, median over the turns: as built, compiled")
    for name, (built, compiled) in ratios.items():
        print(f"  {name}: {built:.2f}, {compiled:.2f}")


if __name__ == "__main__":
    main()
