"""Optimal-control problems in continuous time with published answers, none of them a family.

They are written as a user of `jaxatt.transcribe` would write them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.transcription.transcribe import transcribe


class PublishedProgram(NamedTuple):
    """program and parameters : as for `solve_program`.  objective : the published one."""

    program: OptimalControlProgram
    parameters: Any
    objective: float


def brachistochrone(intervals: int = 50) -> PublishedProgram:
    """The quickest slide to a point 10 m across and 5 m down (Betts, "Practical methods", 4.16).

    State: across, down [m], speed [m/s].  Control: slope of the path below the horizontal [rad].
    """

    def dynamics(x: Array, u: Array, p: Any) -> Array:
        speed, slope = x[2], u[0]
        return jnp.stack([speed * jnp.cos(slope), speed * jnp.sin(slope), p["g"] * jnp.sin(slope)])

    program = transcribe(
        dynamics,
        states=3,
        controls=1,
        intervals=intervals,
        initial_state=np.zeros(3),
        final_time=(0.1, 10.0),
        terminal_cost=lambda x, p, final_time: final_time,
        terminal_equality=lambda x, p: x[:2] - p["target"],
        control_bounds=(-0.5 * np.pi, 0.5 * np.pi),
    )
    return PublishedProgram(program, {"g": 9.80665, "target": np.array([10.0, 5.0])}, 1.8016)


def bryson_denham(intervals: int = 120) -> PublishedProgram:
    """A mass thrown back with least squared force before it gets too far (Bryson and Ho, 3.11)."""
    program = transcribe(
        lambda x, u, p: jnp.stack([x[1], u[0]]),
        states=2,
        controls=1,
        intervals=intervals,
        initial_state=np.array([0.0, 1.0]),
        final_time=1.0,
        running_cost=lambda x, u, p: 0.5 * u[0] ** 2,
        terminal_equality=lambda x, p: x - jnp.array([0.0, -1.0]),
        state_bounds=([-np.inf, -np.inf], [1.0 / 9.0, np.inf]),
    )
    return PublishedProgram(program, (), 4.0)


def double_integrator(intervals: int = 40) -> PublishedProgram:
    """From rest to rest at a distance of 1 in the least time, with a force of at most 1."""
    program = transcribe(
        lambda x, u, p: jnp.stack([x[1], u[0]]),
        states=2,
        controls=1,
        intervals=intervals,
        initial_state=np.zeros(2),
        final_time=(0.1, 20.0),
        terminal_cost=lambda x, p, final_time: final_time,
        terminal_equality=lambda x, p: x - jnp.stack([p["distance"], 0.0]),
        control_bounds=lambda p: (-p["force"], p["force"]),
    )
    return PublishedProgram(program, {"distance": 1.0, "force": 1.0}, 2.0)


def _turned(q: Array, v: Array) -> Array:
    """Quaternion q after a turn of modified Rodrigues parameters v / 4 in body axes."""
    s = 0.25 * v
    squared = jnp.sum(s * s)
    w, r = (1.0 - squared) / (1.0 + squared), 2.0 * s / (1.0 + squared)
    return jnp.concatenate(
        [(q[0] * w - jnp.sum(q[1:] * r))[None], q[0] * r + w * q[1:] + jnp.cross(q[1:], r)]
    )


def _turn(q: Array, reference: Array) -> Array:
    """The v that takes a reference quaternion to q."""
    w = jnp.sum(reference * q)
    r = reference[0] * q[1:] - q[0] * reference[1:] - jnp.cross(reference[1:], q[1:])
    return 4.0 * r / jnp.maximum(1.0 + w, 1e-6)


def rigid_body(intervals: int = 50) -> PublishedProgram:
    """The quickest half turn of a body of unit inertia, torques of at most 1 about each axis.

    State: attitude as a quaternion, rate [rad/s].  Published by Bilimoria and Wie, "Time-optimal
    three-axis reorientation of a rigid spacecraft", JGCD 16 (3), 1993.
    """

    def dynamics(x: Array, u: Array, p: Any) -> Array:
        q, w = x[:4], x[4:]
        scalar = -0.5 * jnp.sum(q[1:] * w)
        vector = 0.5 * (q[0] * w + jnp.cross(q[1:], w))
        return jnp.concatenate([scalar[None], vector, u / p["inertia"]])

    def missed(x: Array, p: Any) -> Array:
        q, target = x[:4], p["target"]
        turned = target[0] * q[1:] - q[0] * target[1:] - jnp.cross(target[1:], q[1:])
        return jnp.concatenate([2.0 * turned, x[4:]])

    program = transcribe(
        dynamics,
        states=7,
        controls=3,
        intervals=intervals,
        initial_state=np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        final_time=(1.0, 10.0),
        terminal_cost=lambda x, p, final_time: final_time,
        terminal_equality=missed,
        control_bounds=lambda p: (-p["torque"], p["torque"]),
        retract=lambda x, e: jnp.concatenate([_turned(x[:4], e[:3]), x[4:] + e[3:]]),
        difference=lambda x, r: jnp.concatenate([_turn(x[:4], r[:4]), x[4:] - r[4:]]),
        error_size=6,
    )
    parameters = {
        "inertia": np.ones(3),
        "torque": np.ones(3),
        "target": np.array([0.0, 0.0, 0.0, 1.0]),
    }
    return PublishedProgram(program, parameters, 3.2431)


PUBLISHED = {
    "brachistochrone": brachistochrone,
    "Bryson-Denham": bryson_denham,
    "double integrator": double_integrator,
    "rigid body": rigid_body,
}
"""By name: function of the number of intervals."""
