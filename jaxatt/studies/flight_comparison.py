"""Comparison of every law of a flight with the printed values, with deviations marked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.control.eigenaxis import Eigenaxis
from jaxatt.control.latched_min_norm import LatchedMinNorm
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.pipeline.simulate import plan_of, simulate
from jaxatt.report import flight_plots
from jaxatt.report.flight_result import FlightResult
from jaxatt.report.flight_table import comparison_table
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.scenarios import load_flight
from jaxatt.scenarios.flight_model import FlightScenario

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


REPRODUCED = 0.05
"""Relative difference up to which a printed value counts as reproduced."""

_INSIDE = -1.0  # printed for a channel that never leaves its band


@dataclass(frozen=True)
class Line:
    """One printed figure of one law beside the obtained one.

    worst : largest relative difference.  why : what is known of a difference.
    """

    law: str
    figure: str
    obtained: tuple[float, ...]
    printed: tuple[float, ...] | None
    worst: float | None
    reproduced: bool | None
    why: str


@dataclass(frozen=True, eq=False)
class FlightComparison:
    """Table of printed and obtained figures, and the nominal run of each law."""

    scenario: FlightScenario
    lines: tuple[Line, ...]
    results: Mapping[str, FlightResult]

    def table(self) -> Any:
        """Return the comparison as a rich renderable."""
        return comparison_table(self.scenario, [asdict(line) for line in self.lines])

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return {
            "scenario": self.scenario.name,
            "source": self.scenario.source,
            "lines": [asdict(line) for line in self.lines],
        }

    def plot(self) -> Picture:
        """Plot the errors of all laws over time."""
        return flight_plots.compare(self.results)

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and figures, and each law's result into its own folder below."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "comparison.json")
            save_figure(self.plot(), partial / "comparison.png")
            save_figure(flight_plots.portraits(self.results), partial / "phase_portraits.png")
        names = ("comparison.json", "comparison.png", "phase_portraits.png")
        files = [Path(folder) / name for name in names]
        for law, result in self.results.items():
            files += result.save(Path(folder) / law)
        return files

    def __repr__(self) -> str:
        judged = [line for line in self.lines if line.reproduced is not None]
        held = sum(bool(line.reproduced) for line in judged)
        return (
            f"FlightComparison({self.scenario.name}: {len(self.results)} laws, "
            f"{held} of {len(judged)} printed figures within {100 * REPRODUCED:g} %)"
        )

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def compare_flight(
    flight: FlightScenario | str | Path, seed: int | None = None, report: Report | None = None
) -> FlightComparison:
    """Fly the nominal run of every law of a flight."""
    if not isinstance(flight, FlightScenario):
        flight = load_flight(flight)
    plan = plan_of(flight, report) if flight.asked.manoeuvre else None
    results = {}
    for law in flight.laws:
        results[law] = simulate(flight, law, seed=seed, plan=plan)
        if report is not None:
            report(f"flown {flight.law_titles[law]}", 1)
    lines = tuple(line for law, result in results.items() for line in _lines(flight, law, result))
    return FlightComparison(flight, lines, results)


def _settling(result: FlightResult) -> list[float]:
    """Settling times of the three axes [s]; -1 for one that never left the band, as the sources
    print.
    """
    figures = result.flown.figures
    inside = np.asarray(figures.always_inside)[0, :3]
    return np.where(inside, _INSIDE, np.asarray(figures.settling)[0, :3]).tolist()


FIGURES: Mapping[str, Callable[[FlightResult], list[float]]] = {
    "settling_s": _settling,
    "settling_worst_s": lambda r: [float(np.max(np.asarray(r.flown.figures.settling)[0, :3]))],
    "rms_deg": lambda r: np.degrees(np.asarray(r.flown.figures.rms)[0, :3]).tolist(),
    "rms_rad_s": lambda r: np.asarray(r.flown.figures.rms)[0, :3].tolist(),
    "peak_Nm": lambda r: np.asarray(r.flown.figures.peak)[0].tolist(),
    "settling_limit_s": lambda r: [_limit(r.scenario.laws[r.law])],
    "integral_Nms": lambda r: [float(np.asarray(r.flown.figures.integral)[0])],
}


def _limit(law: Any) -> float:
    """Settling limit (31) of a latched law on one axis, which does not depend on its high gains."""
    low = Eigenaxis(float(law.proportional[0]), float(law.derivative[0]))
    return low.settling_limit(0.5 * float(law.coupling))


def _lines(flight: FlightScenario, law: str, result: FlightResult) -> list[Line]:
    printed = flight.printed.get(law, {})
    reasons = {**flight.printed.get("why", {}), **printed.get("why", {})}
    always: tuple[str, ...] = (
        "settling_s",
        "rms_deg" if flight.signal == "attitude" else "rms_rad_s",
    )
    latched = isinstance(flight.laws[law], LatchedMinNorm)
    always = (*always, "settling_limit_s", "peak_Nm", "integral_Nms")
    wanted = [
        name
        for name in FIGURES
        if (name in printed or name in always) and (latched or name != "settling_limit_s")
    ]
    lines = []
    for name in wanted:
        ours = FIGURES[name](result)
        theirs = printed.get(name)
        values = None if theirs is None else np.atleast_1d(np.asarray(theirs, float)).tolist()
        worst = None if values is None else _difference(ours, values)
        good = None if worst is None else bool(worst <= REPRODUCED)
        why = "" if good is not False else str(reasons.get(name, "no reason is known"))
        title = flight.law_titles[law]
        pair = None if values is None else tuple(values)
        lines.append(Line(title, name, tuple(ours), pair, worst, good, why))
    return lines


def _difference(ours: list[float], theirs: list[float]) -> float:
    """Largest relative difference; both must agree on which channels never leave the band."""
    worst = 0.0
    for a, b in zip(ours, theirs, strict=True):
        if _INSIDE in (a, b):
            worst = max(worst, 0.0 if a == b else math.inf)
        else:
            apart = abs(a - b) if math.isfinite(a) else math.inf
            worst = max(worst, apart and (apart / abs(b) if b else math.inf))
    return worst
