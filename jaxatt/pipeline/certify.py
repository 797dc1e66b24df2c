"""Is the answer the sparsest there is?  Every cheaper support is tried, and all that cost as much.

What this shows is numerical: on each support Newton's method looks for torques that meet the
target, from rest and from random points, both ways round.  A support on which it arrives is
feasible beyond doubt; one on which it does not is very likely not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from rich.table import Table

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.enumeration import (
    Enumerated,
    SupportClass,
    classes_up_to,
    enumerate_class,
    group_weights,
    masks_of,
)
from jaxatt.problems.hands_off.search.polish import Method, polish
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Task
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import TIME_KINDS
from jaxatt.report import certificate_report
from jaxatt.report.figure import Picture
from jaxatt.report.figure import save as save_figure
from jaxatt.report.files import filling, replacing
from jaxatt.report.rendering import as_html, as_text
from jaxatt.report.result import Phase, Result
from jaxatt.report.summary import write_json
from jaxatt.runtime.arrays import Flags
from jaxatt.runtime.chunks import Report, chunk_for

if TYPE_CHECKING:
    import xarray

MOST_SUPPORTS = 50_000
"""Supports that are tried without being asked for more, both ways round counted once."""

_ATTEMPTS = 4
_FLOWN = 32
_SECONDS_A_SUPPORT = 2e-4


@dataclass(frozen=True)
class ClassRecord:
    """What became of the supports of one class.

    kind : which supports.  short, long : tried the short and the long way round; None if the class
    is out of reach, or where there is but one way.  seconds : wall clock, or what it would take.
    """

    kind: SupportClass
    short: Enumerated | None
    long: Enumerated | None
    seconds: float

    @property
    def tried(self) -> bool:
        """Whether all supports of the class were tried."""
        return self.short is not None

    @property
    def reached(self) -> Flags:
        """(S,) supports that reach one way round or the other."""
        if self.short is None:
            return np.zeros(0, bool)
        return self.short.reached if self.long is None else self.short.reached | self.long.reached


@dataclass(frozen=True, eq=False)
class PhaseCertificate:
    """Certificate of one phase.

    found : the verified answer.  found_cost : its weighted count.
    cheaper, equal : classes of supports that cost less, and as much.
    best : (K, 2) interval and group of the best support of the found cost by L1 effort, verified in
    flight; None if those were out of reach.  best_effort : [N m s].  best_long : the way round.
    consistent : whether the answer's own support was found to reach, as it must be.
    """

    found: Phase
    found_cost: float
    cheaper: tuple[ClassRecord, ...]
    equal: tuple[ClassRecord, ...]
    best: npt.NDArray[np.int64] | None
    best_effort: float | None
    best_long: bool
    consistent: bool = True

    @property
    def minimal(self) -> bool:
        """Whether every cheaper support was tried, by a method to be trusted, and none reached."""
        nothing = all(record.tried and not record.reached.any() for record in self.cheaper)
        return self.found.reached and self.consistent and nothing

    @property
    def refuted(self) -> bool:
        """Whether a cheaper support reaches."""
        return any(record.reached.any() for record in self.cheaper)


@dataclass(frozen=True, eq=False)
class Certificate:
    """What was shown of the answer of a solve, and what was only tried."""

    result: Result
    phases: tuple[PhaseCertificate, ...]

    @property
    def minimal(self) -> bool:
        """Whether no phase has a cheaper support that reaches, all of them tried."""
        return all(phase.minimal for phase in self.phases)

    def sentences(self) -> list[str]:
        """What was shown, in words."""
        return certificate_report.sentences(self)

    def table(self) -> Table:
        """The classes of supports and what became of them."""
        return certificate_report.table(self)

    def plot(self) -> Picture:
        """Map of the feasible pairs of intervals."""
        return certificate_report.plot(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, ready for JSON."""
        return certificate_report.to_dict(self)

    def to_dataset(self) -> xarray.Dataset:
        """Every support of the found cost, with effort and residual both ways round."""
        return certificate_report.to_dataset(self)

    def save(self, folder: str | Path) -> list[Path]:
        """Write certificate.json, certificate.nc and certificate.png; all of them, or none."""
        names = ("certificate.json", "certificate.nc", "certificate.png")
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / names[0])
            with replacing(partial / names[1]) as path:
                self.to_dataset().to_netcdf(path, engine="h5netcdf")
            save_figure(self.plot(), partial / names[2])
        return [Path(folder) / name for name in names]

    def __repr__(self) -> str:
        return f"Certificate({self.result.scenario.name}: {' '.join(self.sentences())})"

    def __str__(self) -> str:
        return as_text(self.table()) + "\n" + "\n".join(self.sentences())

    def _repr_html_(self) -> str:
        return as_html(self.table()) + "".join(f"<p>{s}</p>" for s in self.sentences())


def certify(
    scenario: scenarios.Scenario | str | Path,
    *,
    objective: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    most: int = MOST_SUPPORTS,
    report: Report | None = None,
) -> Certificate:
    """Solve a scenario, then try every support that costs less than the answer, or as much.

    objective, starts, seed : as in `solve`.  most : supports of a class beyond which it counts as
    out of reach.  report : called by the host with (stage, supports tried).

    The target is a constraint here (`terminal = "reach"`), whatever the scenario says.  Raises
    `ScenarioError` where enumeration means nothing: for L1, where time is minimised, and with path
    constraints.
    """
    if most < 1:
        raise ValueError(f"most = {most}: expected at least one support")
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    kind = objective or scenario.objective.kind
    if kind in ("l1", *TIME_KINDS):
        raise scenarios.ScenarioError(
            f'objective.kind = "{kind}": its minimum is not a matter of supports; certify "l0" or '
            '"moving-l0"'
        )
    scenario = scenarios.replace(scenario, {"objective.kind": kind, "objective.terminal": "reach"})
    _checked(scenario)
    result = solve(scenario, starts=starts, seed=seed, report=report)
    phases: list[PhaseCertificate] = []
    initial_state: InitialState | None = None
    for index, phase in enumerate(result.phases):
        task = build_slew(
            result.scenario,
            index,
            initial_state,
            enforce_speed_limits=False,
            final_time=phase.final_time,
            start_time=phase.start_time,
        )
        phases.append(_certify_phase(task, phase, most, result.seed, report))
        initial_state = _end_of(phase)
    return Certificate(result, tuple(phases))


def _checked(scenario: scenarios.Scenario) -> None:
    task = build_slew(scenario)
    if task.system.response is None or (isinstance(task, SlewTask) and task.pointing):
        raise scenarios.ScenarioError(
            f"{scenario.name}: has path constraints (wheel speed limits, cones, limits on the "
            "rate), under which supports cannot be tried one by one; certify it without them"
        )


def _end_of(phase: Phase) -> InitialState | None:
    if "q_ob" not in phase.series:
        return None
    end = len(phase.controls)
    return InitialState(*(phase.series[name][end] for name in ("q_ob", "omega_ob", "omega_bw")))


def _certify_phase(
    task: Task, phase: Phase, most: int, seed: int, report: Report | None
) -> PhaseCertificate:
    if not phase.reached:
        return PhaseCertificate(phase, math.inf, (), (), None, None, False)
    weight = group_weights(task)
    cost = float(np.nansum(weight[support_of(task, phase.controls)]))
    classes = classes_up_to(task, cost)
    tie = cost * (1.0 - 1e-9)
    rate = _SECONDS_A_SUPPORT
    signs = (1.0, -1.0) if isinstance(task, SlewTask) else (1.0,)
    rows = chunk_for(len(phase.starts.status))  # as in the search: nothing is compiled again

    def tried(kind: SupportClass, attempts: int, thorough: bool) -> ClassRecord:
        nonlocal rate
        if kind.number > most:
            return ClassRecord(kind, None, None, len(signs) * rate * attempts * kind.number)
        stage = f"trying supports of {kind.size}"
        progress = None if report is None else lambda done: report(stage, done)
        method = Method("l0", rows=rows, progress=progress)
        ways = [
            enumerate_class(task, kind, sign, method, attempts, seed, thorough) for sign in signs
        ]
        seconds = sum(way.seconds for way in ways)
        if kind.number >= 500:
            rate = seconds / (len(signs) * attempts * kind.number)
        return ClassRecord(kind, ways[0], ways[1] if len(ways) > 1 else None, seconds)

    same = [kind for kind in classes if kind.cost >= tie]
    equal = tuple(tried(kind, 1, False) for kind in same)
    own = np.argwhere(support_of(task, phase.controls))
    if not _finds(equal, own):
        # Limits bind too much for the quick way, as the answer's own support shows.
        equal = tuple(tried(kind, 1, True) for kind in same)
    cheaper = tuple(tried(kind, _ATTEMPTS, True) for kind in classes if kind.cost < tie)
    best, effort, long_way = _best(task, equal, rows)
    consistent = _finds(equal, own) or not all(record.tried for record in equal)
    return PhaseCertificate(phase, cost, cheaper, equal, best, effort, long_way, consistent)


def _finds(records: Sequence[ClassRecord], support: npt.NDArray[np.int64]) -> bool:
    """Whether a support that is known to reach was found to."""
    return any(
        way is not None
        and way.groups.shape[1:] == support.shape
        and bool((way.reached & (way.groups == support[None]).all(axis=(1, 2))).any())
        for record in records
        for way in (record.short, record.long)
    )


def _best(
    task: Task, records: Sequence[ClassRecord], rows: int
) -> tuple[npt.NDArray[np.int64] | None, float | None, bool]:
    """The support of least L1 effort among those that reach, polished and verified in flight."""
    ways: list[tuple[float, npt.NDArray[np.int64], float]] = []
    for record in records:
        for sign, way in ((1.0, record.short), (-1.0, record.long)):
            if way is None:
                continue
            order = np.argsort(np.where(way.reached, way.effort, np.inf))[:_FLOWN]
            ways += [(float(way.effort[i]), way.groups[i], sign) for i in order if way.reached[i]]
    ways = sorted(ways, key=lambda entry: entry[0])[:_FLOWN]
    if not ways:
        return None, None, False
    masks = np.concatenate([masks_of(task, groups[None]) for _, groups, _ in ways])
    signs = np.asarray([sign for _, _, sign in ways])
    rest = np.zeros((len(ways), task.intervals, task.size))
    ended = polish(task, rest, masks, signs, Method("l0", rows=rows))
    flown = np.where(ended.verdict.reached, ended.rank[:, -1], np.inf)
    index = int(np.argmin(flown))
    if not np.isfinite(flown[index]):
        return None, None, False
    return ways[index][1], float(flown[index]), bool(signs[index] < 0)
