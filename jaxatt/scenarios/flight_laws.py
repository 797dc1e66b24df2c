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
from jaxatt.control.surfaces import SURFACES
from jaxatt.control.tracking import Tracking
from jaxatt.problems.reading.fields import Table
from jaxatt.scenarios.flight_schema import LAW_KEYS
from jaxatt.spacecraft import Spacecraft


def read_law(data: Any, origin: str, name: str, vehicle: Spacecraft) -> tuple[FeedbackLaw, str]:
    """Read and check the law of a [laws.NAME] table, and its title; gains are in units of J_s."""
    label = f"[laws.{name}]"
    every = tuple(dict.fromkeys(key for keys in LAW_KEYS.values() for key in keys))
    table = Table(data, origin, label, ("kind", "title", *every))
    table.require("kind", '"pd"')
    kind = table.choice("kind", tuple(LAW_KEYS), "pd")
    table = Table(data, origin, label, ("kind", "title", *LAW_KEYS[kind]))
    return _law(kind, table, vehicle), table.text("title", name)


def _law(kind: str, table: Table, vehicle: Spacecraft) -> FeedbackLaw:
    inertia = jnp.asarray(np.asarray(vehicle.inertia_without_spin))
    sums = inertia @ jnp.ones(3)
    if kind in ("pd", "tracking"):
        law = ProportionalDerivative(
            inertia,
            table.number("proportional_1_s2", at_least=0.0),
            table.number("derivative_1_s", at_least=0.0),
        )
        return law if kind == "pd" else Tracking(law)
    if kind in ("sliding-mode", "super-twisting"):
        surface = table.choice("surface", SURFACES, "pointing")
        slope = table.number("slope_1_s", at_least=0.0)
        if kind == "sliding-mode":
            return SlidingMode(table.number("gain_1_s2", above=0.0) * sums, slope, surface)
        return SuperTwisting(
            table.number("first_gain", above=0.0) * sums,
            table.number("second_gain", above=0.0) * jnp.ones(3),
            table.number("beta", above=0.0),
            slope,
            surface,
        )
    if kind == "krstic-tsiotras":
        return KrsticTsiotras(
            inertia,
            table.number("first_gain_1_s", above=0.0),
            table.number("second_gain_1_s", above=0.0),
            table.number("factor", 1.5, above=0.0),
        )
    coupling = table.number("coupling_1_s", at_least=0.0)
    printed = table.flag("inverse_inertia")
    if kind == "min-norm":
        return MinNorm(
            inertia,
            table.number("proportional_1_s2", at_least=0.0),
            table.number("derivative_1_s", at_least=0.0),
            coupling,
            printed,
        )
    gains = [table.vector(key, 2) for key in ("proportional_1_s2", "derivative_1_s")]
    for key, pair in zip(("proportional_1_s2", "derivative_1_s"), gains, strict=True):
        if not (pair > 0.0).all():
            table.fail(key, "must be greater than 0", "give the low gain, then the high one")
    if kind == "latched":
        return LatchedMinNorm(
            inertia, jnp.asarray(gains[0]), jnp.asarray(gains[1]), coupling, printed
        )
    threshold = table.number("threshold_Nm", above=0.0)
    return GainScheduledMinNorm(
        inertia, jnp.asarray(gains[0]), jnp.asarray(gains[1]), coupling, threshold, printed
    )
