"""Cost of a final time, and the record of the final times tried."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.candidates import Candidates
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats

Rebuild = Callable[[SparseTask, float], SparseTask]
"""(task, final time [s]) -> the same task on a grid that ends then."""

FLOOR = 1e-3
"""Share of the longest final time below which none is tried: nothing is left of an interval."""


@dataclass(frozen=True)
class Trial:
    """Record of one final time that was tried.

    final_time : [s].  cost : with the time's own; infinite where nothing reached the target.
    active_intervals : of the best answer there.  reached : whether it reached the target.
    how : "starts", "search", "support" (one support of active intervals), "exchange" (many) or
        "least time" (one support, with the step as a variable).
    """

    final_time: float
    cost: float
    active_intervals: int
    reached: bool
    how: str


@dataclass(frozen=True)
class Pricing:
    """Cost of the final time T, and the shortest and longest that are allowed [s].

    weight : [1/s], cost of a second in active intervals.

    The cost is what the task ranks its answers by, plus `weight` T:  the weighted count of active
    intervals;  for L1 with the target as a constraint the integral of the slacks, in units of an
    interval of the longest horizon at the limit, because their sum over ever shorter intervals is
    no fuel;  for a printed cost that cost, a second counting as `weight` active intervals do in it.
    """

    weight: float
    shortest: float
    longest: float

    @property
    def lowest(self) -> float:
        """Shortest final time that is tried [s]."""
        return max(self.shortest, FLOOR * self.longest)

    def costs(self, task: SparseTask, answers: Candidates) -> Floats:
        """Costs (S,); infinite where the target is a constraint and not reached."""
        goal, first, price = task.goal, answers.rank[:, 0], 1.0
        if goal.terminal == "penalty":
            price = task.effort_weight if goal.kind == "l1" else task.sparsity_weight
        elif goal.kind == "l1":
            scaled = task.from_controls(answers.controls)
            first = task.slack_sum(scaled) * task.final_time / self.longest
        total = first + price * self.weight * task.final_time
        arrived = answers.verdict.reached | (goal.terminal == "penalty")
        return np.where(arrived, total, np.inf)


@dataclass(frozen=True)
class Offer:
    """An answer (S = 1) at its final time.

    cost : with the time's own.
    """

    task: SparseTask
    answer: Candidates
    cost: float

    @property
    def final_time(self) -> float:
        """Final time of the task [s]."""
        return self.task.final_time


@dataclass(frozen=True)
class Ledger:
    """Computes the costs of answers and records the final times tried.

    progress : called with the number of final times just tried, by the host.
    """

    pricing: Pricing
    progress: Callable[[int], None] | None = None
    trials: list[Trial] = field(default_factory=list)

    def offer(self, task: SparseTask, answers: Candidates, how: str, exact: bool = False) -> Offer:
        """Record some answers and return the cheapest; effort breaks ties.

        exact : whether only those count whose constraints held for the solver, and not those that
        only just reach thanks to the target's tolerances.
        """
        costs = self.pricing.costs(task, answers)
        if exact:
            met = np.isin(answers.status, (int(Status.CONVERGED), int(Status.FEASIBLE)))
            costs = np.where(met, costs, np.inf)
        arrived = answers.verdict.reached
        keys = (answers.rank[:, 2], costs, np.where(arrived, 0.0, answers.verdict.shortfall))
        order = np.lexsort(keys if np.isinf(costs).all() else keys[:2])
        answer = answers.pick(order[0])
        made = Offer(task, answer, float(costs[order[0]]))
        count = int(task.active(answer.controls[0]).any(axis=1).sum())
        reached = bool(answer.verdict.reached[0] and not (exact and np.isinf(made.cost)))
        self.trials.append(Trial(made.final_time, made.cost, count, reached, how))
        if self.progress is not None:
            self.progress(1)
        return made


def cheaper(a: Offer, b: Offer) -> bool:
    """Whether offer a beats offer b: by cost, by effort where the costs agree to rounding."""
    margin = 1e-9 * max(1.0, abs(b.cost)) if np.isfinite(b.cost) else 0.0
    if abs(a.cost - b.cost) > margin:
        return a.cost < b.cost
    return bool(a.answer.rank[0, 2] < b.answer.rank[0, 2])
