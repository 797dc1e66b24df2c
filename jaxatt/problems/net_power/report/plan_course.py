"""Course of a plan over time, from its phases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.plan.report.course import Course
from jaxatt.problems.net_power.record import net_power
from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Floats


def is_plan(answer: Answer) -> bool:
    """Whether an answer is a plan of tasks."""
    return bool(net_power(answer.phases[0]).task)


def course_of(answer: Answer) -> Course:
    """The course of a plan; where one task ends and the next begins there are two instants."""
    options, phases = answer.scenario.options, answer.phases
    craft, orbit = answer.scenario.vehicle, answer.scenario.orbit
    battery = None if craft is None else craft.battery
    stored = battery is not None and "charge" in phases[0].series
    time = np.concatenate(
        [phase.start_time + phase.step * np.arange(_nodes(phase)) for phase in phases]
    )
    return Course(
        tasks=options.tasks,
        days=None if orbit is None else orbit.days,
        time=time,
        light=_joined(phases, "light"),
        solar_power=_joined(phases, "solar_power"),
        net_power=_joined(phases, "net_power"),
        energy=_added([phase.series["net_energy"] for phase in phases]),
        baseline=_added([_baseline(phase) for phase in phases]),
        charge=_joined(phases, "charge") if stored else np.full(len(time), np.nan),
        capacity=np.inf if battery is None else float(battery.capacity),
        wheel_speed=_joined(phases, "omega_bw"),
        rate=np.linalg.norm(_joined(phases, "omega_ib"), axis=1),
        floor=options.floor,
    )


def _nodes(phase: Phase) -> int:
    return len(phase.series["net_energy"])


def _joined(phases: Sequence[Phase], name: str) -> Floats:
    return np.concatenate([phase.series[name] for phase in phases])


def _baseline(phase: Phase) -> Floats:
    series: Mapping[str, Floats] = net_power(phase).baseline
    return series.get("net_energy", np.full(_nodes(phase), np.nan))


def _added(parts: Sequence[Floats]) -> Floats:
    """Energies that count from each phase's start, added up."""
    before = np.cumsum([0.0, *(part[-1] for part in parts[:-1])])
    return np.concatenate([start + part for start, part in zip(before, parts, strict=True)])
