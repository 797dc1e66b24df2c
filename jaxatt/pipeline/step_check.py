"""Whether the steps of a closed-loop flight are short enough for its law and for what turns.

The nominal run is flown again with half the Runge-Kutta step; where it does not settle, also with a
law that is sampled more often.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from jaxatt.control.feedback import FeedbackLaw
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.flight_build import Plan, build_flight
from jaxatt.scenarios.flight_model import FlightScenario, Timing
from jaxatt.simulation.campaign import fly_runs
from jaxatt.simulation.closed_loop import FLYING, Flown
from jaxatt.simulation.flight_error import AGREE, FlightError, between
from jaxatt.simulation.step_error import States

_OFTENER = 4
"""Times as many samples, where the law does not settle."""
_ORDER = 4
_SMALL = 0.3
"""[rad], of nutation or rotation in a step, at most where a step is advised."""


def check_steps(
    flight: FlightScenario, law: FeedbackLaw, nominal: Flown, seed: int, plan: Plan | None
) -> tuple[FlightError | None, tuple[str, ...]]:
    """What half the step changes in the nominal run, and words on steps that are too long.

    nominal : that run as it was flown, (1, ...).  The tolerance is the band in which the law is to
    settle.  None where the run diverges: then nothing is to be compared.
    """
    timing = flight.timing
    notes: list[str] = []
    if not _settles(nominal) and plan is None:
        often = replace(
            timing,
            sampling=timing.sampling / _OFTENER,
            step=min(timing.step, timing.sampling / _OFTENER),
        )
        if _settles(_flown(flight, often, law, seed, plan)):
            notes.append(
                f"sampling_s = {timing.sampling:g} is too long for the law: sampled every "
                f"{often.sampling:g} s the nominal run settles, and as it is it does not"
            )
    fine = timing.sampling * max(_rates(flight, nominal)) / _SMALL  # steps a sample
    if _flies(nominal):
        finer = _flown(flight, replace(timing, step=0.5 * timing.step), law, seed, plan)
        band = {"attitude": math.inf, "rate": math.inf, flight.signal: flight.band}
        error = between(_states(nominal), _states(finer), 2 * timing.steps, band)
        if not error.agreed:
            off = getattr(error, flight.signal) / (AGREE * flight.band)
            more = 2.0 if not math.isfinite(off) else max(2.0, off ** (1.0 / _ORDER))
            advised = timing.sampling / math.ceil(max(more * timing.steps, fine))
            changes = f"{math.degrees(error.attitude):.3g} deg and {error.rate:.3g} rad/s"
            notes.append(
                f"{_too_long(flight, nominal)}; half of it changes the nominal run by {changes}; "
                f"take {advised:.3g}"
            )
        return error, tuple(notes)
    advised = timing.sampling / max(1, math.ceil(fine))
    shorter = replace(timing, step=advised)
    if advised < timing.step and _flies(_flown(flight, shorter, law, seed, plan)):
        why = "the nominal run diverges, and with shorter steps it does not"
        notes.append(f"{_too_long(flight, nominal)}; {why}; take {advised:.3g}")
    return None, tuple(notes)


def _flown(
    flight: FlightScenario, timing: Timing, law: FeedbackLaw, seed: int, plan: Plan | None
) -> Flown:
    shared, start = build_flight(replace(flight, timing=timing), plan)
    return fly_runs(shared, start, law, 1, seed)


def _flies(flown: Flown) -> bool:
    return int(np.asarray(flown.what)[0]) == FLYING


def _settles(flown: Flown) -> bool:
    axes = np.asarray(flown.figures.settling)[0, :3]
    return _flies(flown) and bool(np.isfinite(axes).all())


def _states(flown: Flown) -> States:
    recorded = flown.recorded
    return np.asarray(recorded.q_ob)[0], np.asarray(recorded.omega_ob)[0]


def _rates(flight: FlightScenario, flown: Flown) -> tuple[float, float]:
    """Largest rate of the body, and of its nutation by the wheels' momentum, [rad/s]."""
    craft, initial, recorded = flight.vehicle, flight.initial, flown.recorded
    speeds = np.concatenate([initial.omega_bw[None], np.asarray(recorded.omega_bw)[0]])
    rates = np.concatenate([initial.omega_ob[None], np.asarray(recorded.omega_ob)[0]])
    stored = (speeds * np.asarray(craft.wheels.inertia)) @ np.asarray(craft.wheels.axes).T
    least = np.linalg.eigvalsh(np.asarray(craft.inertia_without_spin)).min()
    return _largest(rates), _largest(stored) / float(least)


def _largest(vectors: Floats) -> float:
    """Largest length of those that are numbers."""
    return float(np.nan_to_num(np.linalg.norm(vectors, axis=-1), nan=0.0, posinf=0.0).max())


def _too_long(flight: FlightScenario, flown: Flown) -> str:
    """Words on a Runge-Kutta step that is too long, and on what turns too far in it."""
    step = flight.timing.step
    turned, nutation = (math.degrees(rate * step) for rate in _rates(flight, flown))
    cause = f"the rate of the body, which turns by {turned:.3g} deg a step"
    if nutation > turned:
        cause = f"the momentum of the wheels: nutation by {nutation:.3g} deg a step"
    return f"step_s = {step:g} is too long for {cause}"
