"""Mean elements of an orbit about an oblate Earth: averages of the osculating ones.

Osculating elements are those of the ellipse that the satellite would follow if the perturbations
stopped at once.  J2 makes them swing within a revolution, the semi-major axis by some kilometres;
here mean elements are their averages over one revolution around the moment they are given for.
They are not the mean elements of a TLE, which only SGP4 understands.
"""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import kepler, orbit
from jaxatt.environment.kepler import KeplerianElements
from jaxatt.environment.orbit_data.j2 import Propagation
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_INSTANTS = 128  # of a revolution
_PASSES = 5
"""Each leaves about a thousandth, the size of J2, of what was missing."""


def _smooth(r: jax.Array, v: jax.Array, mu: jax.Array) -> jax.Array:
    """Elements (..., 6) that are smooth on circular orbits, too, of states (..., 3).

    Semi-major axis, e cos w, e sin w, inclination, node, and w + M; w the argument of perigee.
    """
    found = kepler.from_state(r, v, mu)
    e, w, half = found.eccentricity, found.argument_of_perigee, 0.5 * found.true_anomaly
    eccentric = 2.0 * jnp.arctan2(
        jnp.sqrt(1.0 - e) * jnp.sin(half), jnp.sqrt(1.0 + e) * jnp.cos(half)
    )
    mean = eccentric - e * jnp.sin(eccentric)
    return jnp.stack(
        [
            found.semi_major_axis,
            e * jnp.cos(w),
            e * jnp.sin(w),
            found.inclination,
            found.raan,
            w + mean,
        ],
        axis=-1,
    )


def _state(smooth: jax.Array, mu: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Position and velocity (3,) of the smooth elements (6,)."""
    a, ex, ey, inclination, node, along = (smooth[k] for k in range(6))
    e, w = jnp.hypot(ex, ey), jnp.arctan2(ey, ex)
    r, v = kepler.to_state(KeplerianElements(a, e, inclination, node, w, jnp.zeros(())), mu)
    return orbit.propagate(r, v, (along - w) / orbit.mean_motion(a, mu), mu)


_smooth_of = jax.jit(_smooth, compiler_options=RUNS_ONCE)
_state_of = jax.jit(_state, compiler_options=RUNS_ONCE)
_started = jax.jit(kepler.to_state, compiler_options=RUNS_ONCE)
_elements_of = jax.jit(kepler.from_state, compiler_options=RUNS_ONCE)


def averaged(r: Floats, v: Floats, pole: Floats, mu: float) -> Floats:
    """Mean elements (6,), smooth ones, of a state (3,) [m], (3,) [m/s]."""
    with jax.enable_x64(True):
        own = np.asarray(_smooth_of(r, v, mu))
        period = 2.0 * math.pi * math.sqrt(own[0] ** 3 / mu)
        # Halfway between the ends of equal parts: an average without its two ends counted twice.
        times = period * ((np.arange(_INSTANTS) + 0.5) / _INSTANTS - 0.5)
        along = np.array(_smooth_of(*Propagation(r, v, pole, mu)(times), mu))
    motion = 2.0 * math.pi / period
    along[:, 5] -= motion * times
    for angle in (4, 5):
        along[:, angle] = (
            own[angle] + (along[:, angle] - own[angle] + math.pi) % (2.0 * math.pi) - math.pi
        )
    return np.asarray(along.mean(axis=0))


def osculating_state(mean: KeplerianElements, pole: Floats, mu: float) -> tuple[Floats, Floats]:
    """Position (3,) [m] and velocity (3,) [m/s] of the orbit with these mean elements."""
    with jax.enable_x64(True):
        wanted = np.asarray(_smooth_of(*_started(mean, mu), mu))
        smooth = wanted.copy()
        for _ in range(_PASSES):
            r, v = (np.asarray(part) for part in _state_of(smooth, mu))
            missing = wanted - averaged(r, v, pole, mu)
            missing[4:] = (missing[4:] + math.pi) % (2.0 * math.pi) - math.pi
            smooth = smooth + missing
        r, v = _state_of(smooth, mu)
    return np.asarray(r), np.asarray(v)


def mean_elements(r: Floats, v: Floats, pole: Floats, mu: float) -> KeplerianElements:
    """Mean Keplerian elements of a state (3,) [m], (3,) [m/s]."""
    with jax.enable_x64(True):
        return _elements_of(*_state_of(averaged(r, v, pole, mu), mu), mu)
