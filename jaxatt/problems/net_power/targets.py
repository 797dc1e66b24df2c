"""Manoeuvres that earn energy, to many targets: the starts of all of them are one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.status import Status
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.baseline import fly_baseline
from jaxatt.problems.net_power.build import manoeuvre_of, options_of
from jaxatt.problems.net_power.flight import fly_many, steps_for
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.verdict import Verdict
from jaxatt.records.targets import TargetAnswers
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight_error import AGREE
from jaxatt.simulation.step_error import each_apart

_AT_ONCE = 64
"""Targets that are solved together, which bounds the memory."""
_TRIES = 3
"""Answers of a target that are flown, the best by the solver's count first, until one reaches."""


def answer_targets(scenario: Scenario, targets: Floats) -> TargetAnswers:
    """Answer a manoeuvre with wheels for many targets (M, 4), in place of its own."""
    parts = []
    room = min(_AT_ONCE, len(targets))
    for first in range(0, len(targets), _AT_ONCE):
        asked = [_manoeuvre(scenario, q) for q in targets[first : first + _AT_ONCE]]
        parts.append(_answered(scenario, asked, room))
    return TargetAnswers.join(parts)


def _manoeuvre(scenario: Scenario, q: Floats) -> Manoeuvre:
    target = replace(scenario.targets[0], q_ob=q)
    return manoeuvre_of(replace(scenario, targets=(target,)), PhaseStart())


def _answered(scenario: Scenario, manoeuvres: Sequence[Manoeuvre], room: int) -> TargetAnswers:
    """Answers of so many manoeuvres as are solved together."""
    solver, count = scenario.solver, len(manoeuvres)
    law = options_of(scenario).baseline
    solved = search_wheels(
        manoeuvres, solver.starts, solver.seed, None, shared=True, room=room, law=law
    )
    order = [_from_best_to_worst(one) for one in solved]
    reached = np.zeros(count, bool)
    numbers: dict[str, Floats] = {}
    torque, left = np.zeros((count, *solved[0].torque.shape[1:])), np.arange(count)
    for attempt in range(min(_TRIES, solver.starts)):
        some = left.tolist()
        chosen = [int(order[k][attempt]) for k in some]
        found = _flown([manoeuvres[k] for k in some], [solved[k] for k in some], chosen)
        for name, values in found.numbers.items():
            numbers.setdefault(name, np.full(count, np.nan))[left] = values
        reached[left], torque[left] = found.reached, found.controls
        left = np.flatnonzero(~reached)
        if not len(left):
            break
    if law is not None:
        base = fly_baseline(manoeuvres, law).energy.net_J
        numbers["energy.gain_J"] = numbers["energy.net_J"] - base
    return TargetAnswers(reached, numbers, torque, np.array([one.step for one in manoeuvres]))


def _from_best_to_worst(solved: Solved) -> npt.NDArray[np.int64]:
    failed = solved.status != int(Status.CONVERGED)
    return np.lexsort((-np.nan_to_num(solved.claimed, nan=-np.inf), failed))


def _flown(
    manoeuvres: Sequence[Manoeuvre], solved: Sequence[Solved], chosen: Sequence[int]
) -> TargetAnswers:
    """Fly one answer to each manoeuvre, twice: the second time with twice as many steps."""
    torque = np.stack([one.torque[k] for one, k in zip(solved, chosen, strict=True)])
    dipoles = [
        one.dipole[k] for one, k in zip(solved, chosen, strict=True) if one.dipole is not None
    ]
    dipole = np.stack(dipoles) if dipoles else None
    steps, of = max(steps_for(one) for one in manoeuvres), np.arange(len(manoeuvres))
    coarse, fine = (fly_many(manoeuvres, of, torque, dipole, times * steps) for times in (1, 2))
    verdicts = [
        judge_flight(one, fine, dipole is not None).pick(np.array([k]))
        for k, one in enumerate(manoeuvres)
    ]
    verdict = Verdict.join(verdicts)
    apart = each_apart((coarse.q_ib, coarse.omega_ib), (fine.q_ib, fine.omega_ib))
    attitude, rate = (x.max(axis=1) for x in apart)
    certain = attitude <= AGREE * verdict.tolerances["attitude"]
    certain &= rate <= AGREE * verdict.tolerances["rate"]

    def picked(name: str) -> Floats:
        return np.array([getattr(one, name)[k] for one, k in zip(solved, chosen, strict=True)])

    return TargetAnswers(
        verdict.reached & certain,
        {
            "energy.net_J": fine.energy.net_J,
            "attitude_error_deg": np.degrees(verdict.errors["attitude"]),
            "rate_error_rad_s": verdict.errors["rate"],
            "flight_error_deg": np.degrees(attitude),
            "flight_error_rad_s": rate,
            "kkt.violation": picked("violation"),
            "kkt.stationarity": picked("stationarity"),
        },
        torque,
        fine.step,
    )
