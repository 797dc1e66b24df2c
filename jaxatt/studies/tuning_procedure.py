"""The tuning procedure of Horri, Palmer and Roberts, section IV.F, as printed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.control.eigenaxis import Eigenaxis
from jaxatt.control.latched_min_norm import LatchedMinNorm
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.flight_build import build_flight
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.simulation.campaign import fly_laws

_GROWTH = 1.02


@dataclass(frozen=True, eq=False)
class Procedure:
    """Chosen gains, and every step of raising the high gains.

    gamma : [1/s], of the settling limit; the law's coupling is twice that.
    law : with the highest gains within the torque.
    proportional : (K,) [1/s^2], high gains tried.  settling : (K,) [s], integral : (K,) [N m s] and
    peak : (K,) [N m], what they came to.  chosen : index of the law's.
    """

    limit: float
    gamma: float
    law: LatchedMinNorm
    proportional: Floats
    settling: Floats
    integral: Floats
    peak: Floats
    chosen: int


def tune_as_printed(
    scenario: FlightScenario,
    law: str,
    limit: float,
    *,
    peak_limit: float | None = None,
    most: float = 200.0,
) -> Procedure:
    """Choose gamma from a settling limit, then raise the high gains up to the torque limit.

    law : a `LatchedMinNorm` whose low gains are those of the benchmark.  limit : [s], of (31); of
    the two gammas that have it the smaller one is taken.
    peak_limit : [N m]; by default the benchmark's own torque at the start.
    most : how many times the low gain the high one is raised at most.

    Raises `ValueError` where no gamma has the limit, or the law is no `LatchedMinNorm`.
    """
    first = scenario.laws[law]
    if not isinstance(first, LatchedMinNorm):
        raise ValueError(
            f"law = {law!r}: is no latched min-norm law; the procedure is made for one"
        )
    low = Eigenaxis(float(first.proportional[0]), float(first.derivative[0]))
    gamma = low.gamma_for(limit)
    count = int(np.ceil(np.log(most) / np.log(_GROWTH)))
    gains: Floats = np.asarray(low.proportional * _GROWTH ** np.arange(count + 1))
    derivative = np.array([low.derivative_for(gain) for gain in gains])
    laws = replace(
        first,
        inertia=jnp.broadcast_to(jnp.asarray(first.inertia), (len(gains), 3, 3)),
        proportional=jnp.stack([jnp.full_like(gains, low.proportional), gains], axis=1),
        derivative=jnp.stack([jnp.full_like(gains, low.derivative), derivative], axis=1),
        coupling=jnp.full_like(gains, 2.0 * gamma),  # of eps = theta / 2
    )
    shared, start = build_flight(replace(scenario, noise=(0.0, 0.0)))
    figures = fly_laws(shared, start, laws).figures
    settling = np.max(np.asarray(figures.settling)[:, :3], axis=1)
    peak = np.max(np.abs(np.asarray(figures.peak)), axis=1)
    allowed = peak[0] if peak_limit is None else peak_limit
    over = np.flatnonzero(peak > allowed * (1.0 + 1e-9))
    chosen = (int(over[0]) if len(over) else len(gains)) - 1
    if chosen < 0:
        raise ValueError(
            f"peak_limit = {allowed:g} N m: the benchmark itself asks for {peak[0]:g}; lower kp1"
        )
    best: Any = jax.tree.map(lambda leaf: leaf[chosen], laws)
    return Procedure(
        limit, gamma, best, gains, settling, np.asarray(figures.integral), peak, chosen
    )
