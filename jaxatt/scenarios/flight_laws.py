"""Read the feedback laws of a flight's file."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxatt.control.feedback import FeedbackLaw
from jaxatt.control.krstic_tsiotras import KrsticTsiotras
from jaxatt.control.latched_min_norm import LatchedMinNorm
from jaxatt.control.min_norm import GainScheduledMinNorm, MinNorm
from jaxatt.control.proportional_derivative import ProportionalDerivative
from jaxatt.control.sliding_mode import SlidingMode
from jaxatt.control.super_twisting import SuperTwisting
from jaxatt.control.tracking import Tracking
from jaxatt.problems.reading.fields import Table
from jaxatt.scenarios.flight_law_keys import LAW
from jaxatt.spacecraft import Spacecraft


def read_law(data: Any, origin: str, name: str, vehicle: Spacecraft) -> tuple[FeedbackLaw, str]:
    """Read and check the law of a [laws.NAME] table, and its title; gains are in units of J_s."""
    label = f"[laws.{name}]"
    table = Table(data, origin, label, LAW.of(data))
    kind = table.choice("kind")
    return _law(kind, table, vehicle), table.text("title", name)


def _law(kind: str, table: Table, vehicle: Spacecraft) -> FeedbackLaw:
    inertia = jnp.asarray(np.asarray(vehicle.inertia_without_spin))
    sums = inertia @ jnp.ones(3)
    if kind in ("pd", "tracking"):
        law = ProportionalDerivative(
            inertia,
            table.number("proportional_1_s2"),
            table.number("derivative_1_s"),
        )
        return law if kind == "pd" else Tracking(law)
    if kind in ("sliding-mode", "super-twisting"):
        surface = table.choice("surface")
        slope = table.number("slope_1_s")
        if kind == "sliding-mode":
            return SlidingMode(table.number("gain_1_s2") * sums, slope, surface)
        return SuperTwisting(
            table.number("first_gain") * sums,
            table.number("second_gain") * jnp.ones(3),
            table.number("beta"),
            slope,
            surface,
        )
    if kind == "krstic-tsiotras":
        return KrsticTsiotras(
            inertia,
            table.number("first_gain_1_s"),
            table.number("second_gain_1_s"),
            table.number("factor"),
        )
    coupling = table.number("coupling_1_s")
    printed = table.flag("inverse_inertia")
    if kind == "min-norm":
        return MinNorm(
            inertia,
            table.number("proportional_1_s2"),
            table.number("derivative_1_s"),
            coupling,
            printed,
        )
    gains = [table.vector(key) for key in ("proportional_1_s2", "derivative_1_s")]
    for key, pair in zip(("proportional_1_s2", "derivative_1_s"), gains, strict=True):
        if not (pair > 0.0).all():
            table.fail(key, "must be greater than 0", "give the low gain, then the high one")
    if kind == "latched":
        return LatchedMinNorm(
            inertia, jnp.asarray(gains[0]), jnp.asarray(gains[1]), coupling, printed
        )
    threshold = table.number("threshold_Nm")
    return GainScheduledMinNorm(
        inertia, jnp.asarray(gains[0]), jnp.asarray(gains[1]), coupling, threshold, printed
    )
