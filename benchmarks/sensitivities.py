"""What all sensitivities of an answer cost, in interior-point passes a parameter.

    python -m benchmarks.sensitivities [--cases mrp-k4-rk4 eseo-3] [--repeats 15]

A pass is that of the method which finds the answer, from one start: of the interior-point method
for turns; for the programmes on a support, a Newton step on their KKT matrix (derivatives,
elimination, step), which is what a pass of an interior-point method on them costs.  Both sides are
compiled before and take turns, straight after each other; what is compared is CPU time.  Central
differences of the data of the problem, for which nothing is solved, stand apart.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import jaxatt

jaxatt.configure()

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402

from jaxatt.optimize.interior_point.method import InteriorPoint  # noqa: E402
from jaxatt.optimize.interior_point.state import InteriorSettings  # noqa: E402
from jaxatt.optimize.sensitivity.answer import Answer  # noqa: E402
from jaxatt.problems.family import PhaseStart, SearchOptions  # noqa: E402
from jaxatt.problems.registry import family_of  # noqa: E402
from jaxatt.problems.time_optimal.family import TimeAnswer  # noqa: E402
from jaxatt.studies.sensitivity.parameters import directions_of  # noqa: E402

CASES = ("mrp-k4-rk4", "hypso1-90-45-15", "eseo-3")
GOAL = 2.0


class Cost(NamedTuple):
    """parameters : number of them.  pass_s, all_s, data_s : medians [s], data for all parameters.

    ratios : of every turn, all sensitivities over as many passes as there are parameters.
    """

    parameters: int
    pass_s: float
    all_s: float
    data_s: float
    ratios: list[float]


def interior_pass(found: TimeAnswer, args: Any) -> Callable[[], Any]:
    """One pass of the interior-point method near the answer of a turn."""
    best, task = found.found.best, found.task.with_substeps(found.found.substeps)
    solver, program = InteriorPoint(InteriorSettings()), task.program
    start = jnp.asarray(found.found.scaled[best]), jnp.asarray(found.found.states[best])
    state = jax.jit(lambda args: solver.init(program, start, args))(args)
    step = jax.jit(lambda state, args: solver.step(program, state, args))
    return lambda: step(state, args)


def newton_pass(answer: Answer) -> Callable[[], Any]:
    """One Newton step on the first-order conditions of an answer."""
    conditions = answer.conditions

    @jax.jit
    def step(point: Any, args: Any, active: Any) -> Any:
        system = conditions.system(point, args)
        left = conditions.residual(system, point, active)
        right = jax.tree.map(jnp.negative, left)
        return conditions.moved(point, conditions.solve(system, active, right))

    return lambda: step(answer.point, answer.args, answer.active)


def cost_of(case: str, starts: int, repeats: int) -> Cost:
    """Solve a case and time its sensitivities and a pass in turn."""
    scenario = jaxatt.scenarios.replace(jaxatt.scenarios.load(case), {"solver.starts": starts})
    family = family_of(scenario)
    found = family.search(scenario, PhaseStart(), SearchOptions(), None)
    sensitive = family.sensitive(scenario, PhaseStart(), found)
    answer = sensitive.optimum.answer
    once = newton_pass(answer)
    if isinstance(found, TimeAnswer):
        once = interior_pass(found, answer.args)
    began = time.process_time()
    along = directions_of(scenario, sensitive.arguments, None)
    data = time.process_time() - began

    def every() -> Any:
        return sensitive.optimum.along(along.names, along.values, along.along)

    def timed(run: Callable[[], Any]) -> float:
        began = time.process_time()
        jax.block_until_ready(run())
        return time.process_time() - began

    timed(once), timed(every)
    turns = [(timed(once), timed(every)) for _ in range(repeats)]
    count = len(along.names)
    return Cost(
        count,
        statistics.median(single for single, _ in turns),
        statistics.median(whole for _, whole in turns),
        data,
        [whole / (count * single) for single, whole in turns],
    )


def main() -> None:
    """Print a row for every case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", nargs="*", default=list(CASES))
    parser.add_argument("--starts", type=int, default=8)
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    head = ("case", "parameters", "a pass [ms]", "all sensitivities [ms]", "passes a parameter")
    head = (*head, "data, a parameter [ms]")
    print("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    for case in options.cases:
        c = cost_of(case, options.starts, options.repeats)
        print(
            f"| {case} | {c.parameters} | {1e3 * c.pass_s:.2f} | {1e3 * c.all_s:.1f} | "
            f"{statistics.median(c.ratios):.2f} ({min(c.ratios):.2f} to {max(c.ratios):.2f}) | "
            f"{1e3 * c.data_s / c.parameters:.0f} |",
            flush=True,
        )
    print(f"\nThe goal is {GOAL:g} passes a parameter.")


if __name__ == "__main__":
    main()
