"""Campaigns: many runs of one flight with random deviations, flown in chunks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.control.feedback import FeedbackLaw
from jaxatt.control.gains import check_gains
from jaxatt.runtime.chunks import Progress, chunk_for, in_chunks, workers
from jaxatt.runtime.settings import QUICK_TO_COMPILE
from jaxatt.simulation.closed_loop import Flight, Flown, fly
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.wheels import ReactionWheels


@dataclass(frozen=True)
class Spread:
    """Standard deviations of the random deviations between runs; all zero flies the nominal case.

    attitude : [rad], of each component of a rotation away from the start.
    rate : [rad/s], of each component of omega_ib at the start.
    inertia : relative, of the mass distribution.  misalignment : [rad], of each wheel axis.
    gain : relative, of each gain of the law.
    """

    attitude: float = 0.0
    rate: float = 0.0
    inertia: float = 0.0
    misalignment: float = 0.0
    gain: float = 0.0


@dataclass(frozen=True)
class Start:
    """Initial state of the nominal run: q_ob (4,), omega_ob (3,) [rad/s], omega_bw (n,) [rad/s]."""

    q_ob: Any
    omega_ob: Any
    omega_bw: Any


def _run(
    spread: Array, flight: Flight, begin: tuple[Array, Array, Array], law: FeedbackLaw, data: Array
) -> Flown:
    keys = jax.random.split(jax.random.wrap_key_data(data), 6)
    attitude, rate, inertia, misalignment, gain = (spread[i] for i in range(5))
    q_ob, omega_ob, omega_bw = begin
    away = attitude * jax.random.normal(keys[0], (3,))
    q_ob = quaternion.multiply(q_ob, quaternion.from_rotation_vector(away))
    orbit_rate = jax.tree.map(lambda x: x[0, 0], flight.nodes.rate).array
    omega_ib = omega_ob + quaternion.rotate_inverse(q_ob, orbit_rate)
    omega_ib = omega_ib + rate * jax.random.normal(keys[1], (3,))
    craft = replace(
        flight.nominal,
        inertia=_other_inertia(keys[2], jnp.asarray(flight.nominal.inertia), inertia),
        wheels=_other_axes(keys[3], flight.nominal.wheels, misalignment),
    )
    leaves, shape = jax.tree.flatten(law)
    factors = 1.0 + gain * jax.random.normal(keys[4], (max(len(leaves), 1),))
    law = jax.tree.unflatten(shape, [leaf * factors[i] for i, leaf in enumerate(leaves)])
    return fly(flight, craft, AttitudeState(q_ob, omega_ib, omega_bw), law, keys[5])


_each_law = jax.jit(
    jax.vmap(_run, in_axes=(None, None, None, 0, None)), compiler_options=QUICK_TO_COMPILE
)


def fly_laws(flight: Flight, start: Start, laws: FeedbackLaw) -> Flown:
    """Fly the nominal run under many laws of one kind, given as a law whose leaves lead with an
    axis.
    """
    begin = tuple(jnp.asarray(v) for v in (start.q_ob, start.omega_ob, start.omega_bw))
    data, shared = jax.random.key_data(jax.random.key(0)), jax.device_put(flight)
    count = len(jax.tree.leaves(laws)[0])
    flown: Flown = in_chunks(
        lambda rows: _each_law(jnp.zeros(5), shared, begin, rows, data), laws, chunk_for(count)
    )
    return flown


def _other_inertia(key: Array, inertia: Array, size: Array) -> Array:
    """Draw a physical inertia near the nominal one by scaling its second moments of mass."""
    moments = 0.5 * jnp.trace(inertia) * jnp.eye(3) - inertia
    drawn = jax.random.normal(key, (3, 3))
    stretch = jnp.eye(3) + 0.5 * size * 0.5 * (drawn + drawn.T)
    changed = stretch @ moments @ stretch
    return jnp.trace(changed) * jnp.eye(3) - changed


def _other_axes(key: Array, wheels: ReactionWheels, size: Array) -> ReactionWheels:
    axes = jnp.asarray(wheels.axes)
    turn = size * jax.random.normal(key, axes.shape)
    turned = axes + jnp.cross(turn, axes, axisa=0, axisb=0, axisc=0)
    turned = turned / jnp.linalg.norm(turned, axis=0, keepdims=True)
    return replace(wheels, axes=turned)


_runs = jax.jit(
    jax.vmap(_run, in_axes=(None, None, None, None, 0)), compiler_options=QUICK_TO_COMPILE
)


def fly_runs(
    flight: Flight,
    start: Start,
    law: FeedbackLaw,
    runs: int = 1,
    seed: int = 0,
    spread: Spread | None = None,
    progress: Progress | None = None,
    alike: int | None = None,
) -> Flown:
    """Fly `runs` runs of a flight; run i depends on the seed and on i only.

    spread : None flies the nominal case in every run, with noise of its own.
    progress : called by the host with the number of runs that have just ended.
    alike : number of runs of the campaign whose compiled program this one is to share.

    Raises `ValueError` where a gain has the wrong sign or shape.
    """
    check_gains(law)
    drawn = spread or Spread()
    sizes = jnp.asarray([drawn.attitude, drawn.rate, drawn.inertia, drawn.misalignment, drawn.gain])
    if not all(math.isfinite(size) and size >= 0.0 for size in sizes.tolist()):
        raise ValueError(f"spread: {drawn} holds a negative or infinite deviation; give 0 or more")
    root = jax.random.key(seed)
    keys = jax.vmap(lambda i: jax.random.fold_in(root, i))(jnp.arange(runs))
    data = np.asarray(jax.random.key_data(keys))
    shared = jax.device_put(flight)
    begin = tuple(jnp.asarray(v) for v in (start.q_ob, start.omega_ob, start.omega_bw))
    gains = jax.tree.map(jnp.asarray, law)
    # Few sizes of chunks, so that other numbers of runs find the program compiled.
    size = alike or runs
    rows = 1 if size == 1 else 16 if size <= 32 else chunk_for(max(size, 64 * workers()))
    flown: Flown = in_chunks(
        lambda chunk: _runs(sizes, shared, begin, gains, chunk), data, rows, progress
    )
    return flown
