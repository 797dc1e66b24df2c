"""Choose the comparison with printed values that fits a family of problems."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from jaxatt import scenarios
from jaxatt.runtime.chunks import Report
from jaxatt.studies.comparison import Comparison, compare_controllers
from jaxatt.studies.energy_comparison import EnergyComparison, compare_energy
from jaxatt.studies.time_comparison import TimeComparison, compare_times
from jaxatt.studies.weight_comparison import WeightComparison, compare_weights

AnyComparison = Comparison | TimeComparison | EnergyComparison | WeightComparison
Study = Callable[[scenarios.Scenario, int | None, int | None, Report | None], AnyComparison]


def _compare_net_power(
    scenario: scenarios.Scenario,
    starts: int | None,
    seed: int | None,
    report: Report | None,
) -> EnergyComparison | WeightComparison:
    """Compare one manoeuvre or plan, or those for all weights of time that are printed."""
    many = scenario.horizon.free and "time_weight_W_s" in scenario.printed
    study = compare_weights if many else compare_energy
    return study(scenario, starts, seed, report)


_STUDIES: dict[str, Study] = {
    "hands-off": compare_controllers,
    "toy": compare_controllers,
    "time-optimal": compare_times,
    "net-power": _compare_net_power,
}
"""Name of a family -> what compares its scenarios."""


def compare(
    scenario: scenarios.Scenario | str | Path,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> AnyComparison:
    """Run every controller of the source on a scenario, every transcription of a turn, or every
    weight of time.

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
