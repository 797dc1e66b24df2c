"""Numbers, labelled arrays and figure of the final times that were tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour, tidy, whole_ticks
from jaxatt.problems.hands_off.record import FinalTimes, sparse_section
from jaxatt.records.labels import Variable
from jaxatt.records.phase import Phase
from jaxatt.records.wording import plural, short
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def final_times_summary(tried: FinalTimes | None) -> dict[str, Any] | None:
    """Plain numbers; infinite costs, where nothing reached, become None in JSON."""
    if tried is None:
        return None
    columns = (tried.final_time, tried.costs, tried.active_intervals, tried.reached, tried.how)
    names = ("final_time_s", "cost", "active_intervals", "reached", "how")
    return {
        "time_weight_1_s": tried.time_weight,
        "cost": tried.cost,
        "tried": [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)],
    }


def final_time_text(phase_summary: Mapping[str, Any]) -> str:
    """Text of the final time with the length of an interval, where it was free."""
    if phase_summary["final_times"] is None:
        return ""
    step = phase_summary["step_s"]
    return f"{short(phase_summary['final_time_s'], 6)} ({short(step)} an interval)"


def cost_text(phase_summary: Mapping[str, Any]) -> str:
    """Text of the cost with its time, and of how many final times were tried for it."""
    tried = phase_summary["final_times"]
    if tried is None:
        return ""
    times = plural(len(tried["tried"]), "final time")
    return f"{short(tried['cost'], 6) or 'not reached'} ({times} tried)"


def final_times_variables(phase: Phase, rows: int) -> dict[str, Variable]:
    """The final times as labelled arrays of `rows` rows, the last ones empty; none where fixed."""
    tried = sparse_section(phase).final_times
    if tried is None:
        return {}

    def filled(values: Sequence[float] | Floats) -> Floats:
        padded = np.full(rows, np.nan)
        padded[: len(values)] = values
        return padded

    columns = {
        "final_time": (tried.final_time, "s", "final time that was tried"),
        "cost": (tried.costs, "1", "cost with the time's own, infinite where nothing reached"),
        "active_intervals": (tried.active_intervals, "1", "active intervals of the best answer"),
        "reached": (tried.reached.astype(float), "1", "1 where an answer reached the target"),
    }
    return {
        f"trial_{name}": (("trial",), filled(values), {"long_name": words, "units": unit})
        for name, (values, unit, words) in columns.items()
    }


def final_times_panels(axes: Sequence[Axes], phase: Phase) -> None:
    """Draw cost and active intervals against final time, with a star for the answer."""
    tried = sparse_section(phase).final_times
    assert tried is not None
    above, below = axes
    known = np.isfinite(tried.costs)
    for panel, values in ((above, tried.costs), (below, tried.active_intervals)):
        panel.scatter(tried.final_time[known], values[known], s=22, c=colour(0), alpha=0.7)
        panel.set_xlim(0.0, 1.04 * float(tried.final_time.max()))
        tidy(panel)
    for time in tried.final_time[~known]:
        for panel in axes:
            panel.axvline(time, color=colour(1), linewidth=0.5, alpha=0.4, zorder=0)
    answer: dict[str, Any] = {
        "s": 170,
        "c": colour(4),
        "marker": "*",
        "edgecolor": "black",
        "zorder": 5,
    }
    if np.isfinite(tried.cost):
        above.scatter(phase.final_time, tried.cost, **answer)
        below.scatter(phase.final_time, phase.active_intervals, **answer)
        # What costs far more than the answer would leave no room for what competes with it.
        top = min(3.0 * tried.cost, float(tried.costs[known].max()))
        above.set_ylim(0.0, 1.08 * top if top > 0.0 else 1.0)
        most = float(tried.active_intervals[known].max())
        below.set_ylim(0.0, 1.08 * min(3.0 * phase.active_intervals + 4.0, most + 1.0))
    above.plot([], [], "o", color=colour(0), alpha=0.7, label="cheapest answer")
    above.plot(
        [], [], color=colour(1), linewidth=0.8, alpha=0.6, label="none of those tried reached"
    )
    above.set_ylabel("cost")
    above.legend(fontsize=8, frameon=False, loc="best")
    below.set_ylabel("active intervals")
    whole_ticks(below.yaxis)
    below.set_xlabel("final time [s]")
