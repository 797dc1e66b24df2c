"""Choose the comparison with printed values that fits a family of problems."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from jaxatt import scenarios
from jaxatt.runtime.chunks import Report
from jaxatt.studies.comparison import Comparison, compare_controllers
from jaxatt.studies.energy_comparison import EnergyComparison, compare_energy
from jaxatt.studies.time_comparison import TimeComparison, compare_times

Study = Callable[
    [scenarios.Scenario, int | None, int | None, Report | None],
    Comparison | TimeComparison | EnergyComparison,
]

_STUDIES: dict[str, Study] = {
    "hands-off": compare_controllers,
    "toy": compare_controllers,
    "time-optimal": compare_times,
    "net-power": compare_energy,
}
"""Name of a family -> what compares its scenarios."""


def compare(
    scenario: scenarios.Scenario | str | Path,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> Comparison | TimeComparison | EnergyComparison:
    """Run every controller of the source on a scenario, or every transcription of a turn.

    starts, seed : replace the scenario's own.  report : as in `solve`.
    Raises `ScenarioError` for a family without printed values.
    """
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    if scenario.family not in _STUDIES:
        raise scenarios.ScenarioError(
            f"{scenario.name}: there is no comparison for {scenario.family}; compare a scenario of "
            f"{', '.join(_STUDIES)}"
        )
    return _STUDIES[scenario.family](scenario, starts, seed, report)
