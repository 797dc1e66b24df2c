"""Relative sparsity against the number of intervals and the torque limit, with a lower bound.

Relative sparsity is the share of control intervals with torque: eq. (5) of Kristiansen and Gravdahl
(2023), "Maximum hands-off attitude control of a spacecraft actuated by thrusters".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt import scenarios
from jaxatt.attitude import errors
from jaxatt.drawing.figure import picture, save, tidy
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.bang_off_bang import nearest_bang_off_bang, try_bang_off_bang
from jaxatt.problems.hands_off.search.candidates import join
from jaxatt.problems.hands_off.search.limited_search import search_within_limits
from jaxatt.problems.hands_off.search.polish import Method
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.reading.tables.objective import SPARSE_KINDS
from jaxatt.records.wording import plural
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.studies.impulse_balance import (
    eigenaxis_on_time,
    least_intervals,
    least_on_time,
)

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


@dataclass(frozen=True)
class Point:
    """Relative sparsity of one solved case, with its bounds.

    percent, bound_percent, eigenaxis_percent : relative sparsity found, the least that the impulse
    balance allows, and that of a slew about one axis with valves that switch at any instant.
    """

    intervals: int
    torque_limit_Nm: float
    reached: bool
    active_intervals: int
    percent: float
    bound_percent: float
    eigenaxis_percent: float
    attitude_error_deg: float
    rate_error_rad_s: float


@dataclass(frozen=True, eq=False)
class Study:
    """Curves of relative sparsity against the number of intervals and against the torque limit."""

    scenario: scenarios.Scenario
    against_intervals: tuple[Point, ...]
    against_limit: tuple[Point, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "against_intervals": [asdict(point) for point in self.against_intervals],
            "against_limit": [asdict(point) for point in self.against_limit],
        }

    def plot(self) -> Picture:
        """Plot both curves with the impulse balance's bound below them."""
        figure = picture(9.0, 3.8, f"{self.scenario.title}: relative sparsity")
        left, right = figure.subplots(1, 2)
        for axes, points, key, label in (
            (left, self.against_intervals, "intervals", "control intervals N"),
            (right, self.against_limit, "torque_limit_Nm", "torque limit [N m]"),
        ):
            x = [getattr(point, key) for point in points]
            met = [point.percent if point.reached else np.nan for point in points]
            axes.plot(x, met, "o-", color="#0072B2", label="found, flown again")
            axes.plot(
                x,
                [point.eigenaxis_percent for point in points],
                "--",
                color="#009E73",
                label="about one axis, any instant",
            )
            axes.plot(
                x, [point.bound_percent for point in points], color="#D55E00", label="no slew below"
            )
            axes.set_xlabel(label)
            axes.set_ylim(bottom=0.0)
            tidy(axes)
        left.set_ylabel("relative sparsity [%]")
        right.legend(frameon=False, fontsize=8)
        return figure

    def save(self, folder: str | Path) -> list[Path]:
        """Write relative_sparsity.json and the figure into a folder; return the files."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "relative_sparsity.json")
            save(self.plot(), partial / "relative_sparsity.png")
        return [Path(folder) / f"relative_sparsity.{kind}" for kind in ("json", "png")]

    def __repr__(self) -> str:
        number = len(self.against_intervals) + len(self.against_limit)
        return f"Study({self.scenario.name}: {number} cases)"


@dataclass(frozen=True)
class Attainable:
    """Evidence on whether some number of active intervals suffices rest to rest.

    size : active intervals.  least : fewest that the impulse balance allows.  tried : bang-off-bang
    supports that were tried, each both ways round from several beginnings.
    reached : whether one of them reaches.  attitude_error_deg, rate_error_rad_s : of the nearest.
    """

    size: int
    least: int
    tried: int
    reached: bool
    attitude_error_deg: float
    rate_error_rad_s: float

    def sentence(self) -> str:
        """State the finding in words."""
        count = plural(self.size, "active interval")
        if self.reached:
            return f"{count}: a flight reaches the target."
        if self.size < self.least:
            return (
                f"{count}: out of reach of every slew; by the impulse balance at least "
                f"{self.least} are needed."
            )
        return (
            f"{count}: not met by any of the {self.tried} supports of a first and a last burst; "
            f"the nearest ends {self.attitude_error_deg:.2g} deg off at "
            f"{self.rate_error_rad_s:.2g} rad/s. The impulse balance alone excludes fewer than "
            f"{self.least}, so this is evidence and no proof."
        )


def relative_sparsity(
    scenario: scenarios.Scenario | str | Path,
    intervals: Iterable[int] = (15, 30, 45, 60, 90, 120),
    limit_factors: Iterable[float] = (0.4, 0.5, 0.65, 0.8, 1.0, 1.5, 2.0),
    starts: int = 16,
    report: Report | None = None,
) -> Study:
    """Solve a slew with thrusters for several numbers of intervals and torque limits.

    limit_factors : multiples of the scenario's torque limits.  starts : of every case.
    """
    base = _with_thrusters(scenario)
    craft = base.vehicle
    assert craft is not None
    limits = np.asarray(craft.thrusters.torque_limit)
    along = tuple(
        _solved(base, {"horizon.intervals": int(count)}, starts, report) for count in intervals
    )
    across = tuple(
        _solved(
            base, {"vehicle.thrusters.torque_limit_Nm": (factor * limits).tolist()}, starts, report
        )
        for factor in limit_factors
    )
    return Study(base, along, across)


def attainable(
    scenario: scenarios.Scenario | str | Path, size: int, report: Report | None = None
) -> Attainable:
    """Test whether `size` active intervals suffice for the first target of such a scenario."""
    task = build_slew(_with_thrusters(scenario)).reaching()
    progress = None if report is None else lambda done: report("trying bang-off-bang", done)
    method = Method("l0", progress=progress)
    tried = join(try_bang_off_bang(task, size, method), nearest_bang_off_bang(task, size, method))
    nearest = int(tried.order(True)[0])
    return Attainable(
        size,
        least_intervals(*_slew(task), task.step),
        size + 1,
        bool(tried.verdict.reached[nearest]),
        math.degrees(float(tried.verdict.errors["attitude"][nearest])),
        float(tried.verdict.errors["rate"][nearest]),
    )


def _with_thrusters(scenario: scenarios.Scenario | str | Path) -> scenarios.Scenario:
    base = scenario if isinstance(scenario, scenarios.Scenario) else scenarios.load(scenario)
    if base.vehicle is None or base.vehicle.thrusters.count == 0:
        raise scenarios.ScenarioError(
            f"{base.name}: the study is for vehicles with thrusters; choose a scenario with some"
        )
    if base.objective.kind not in SPARSE_KINDS:
        raise scenarios.ScenarioError(
            f"{base.name}: kind = {base.objective.kind} is not sparse; choose a scenario with l0"
        )
    if base.leaves_roll_free:
        raise scenarios.ScenarioError(
            f"{base.name}: [target] leaves the roll free, and the study compares with a turn to "
            "one attitude; add constrain beside align"
        )
    return base


def _slew(task: SlewTask) -> tuple[Any, np.ndarray, float]:
    """Vehicle, rotation vector [rad] and duration [s] of a task, for the impulse balance."""
    turn = np.asarray(errors.rotation_vector(task.start.q_ob, task.target.q_ob))
    return task.craft, turn, task.intervals * task.step


def _solved(
    base: scenarios.Scenario, changes: Mapping[str, Any], starts: int, report: Report | None
) -> Point:
    scenario = scenarios.replace(base, {**changes, "objective.terminal": "reach"})
    task = build_slew(scenario)
    found = search_within_limits(task, starts, scenario.solver.seed, report=report).found
    best, duration = found.best, task.intervals * task.step
    active = int((best.controls[0] > 0.0).any(axis=1).sum())
    slew = _slew(task)
    return Point(
        task.intervals,
        float(np.max(np.asarray(task.craft.thrusters.torque_limit))),
        bool(best.verdict.reached[0]),
        active,
        100.0 * active / task.intervals,
        100.0 * least_on_time(*slew) / duration,
        100.0 * eigenaxis_on_time(*slew) / duration,
        math.degrees(float(best.verdict.errors["attitude"][0])),
        float(best.verdict.errors["rate"][0]),
    )
