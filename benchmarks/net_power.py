"""A turn that earns the most energy, as a user writes it: ten states, three torques, 80 intervals.

Chapter 4 of B. A. Kristiansen, "Energy and Time Optimal Spacecraft Attitude Control and
Operations", NTNU 2023: solar power of six faces less the power of the wheels, with the last
attitude and rate as equations in place of a weighted cost.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

import jaxatt

HORIZON_S, INTERVALS = 40.0, 80
PARAMETERS: dict[str, Any] = {
    "inertia": np.array([[0.0775, 2e-4, -2e-4], [2e-4, 0.1067, 5e-4], [-2e-4, 5e-4, 0.0389]]),
    "wheel": 2.1e-4,
    "sun": np.array([0.2673, 0.5345, 0.8018]),
    "areas": np.array([0.03, 0.06, 0.02, 0.03, 0.06, 0.02]),
    "irradiance": 272.2,
    "efficiency": 0.85,
    "smoothing": 1e-7,
    "baumgarte": 1e-2,
    "target": np.array([0.0, 1.0, 0.0, 0.0]),
    "torque": 3.2e-3,
}
PARAMETERS["inverse"] = np.linalg.inv(PARAMETERS["inertia"] - PARAMETERS["wheel"] * np.eye(3))
START = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def dynamics(x: Array, u: Array, p: dict[str, Any]) -> Array:
    """Equations (4.9b) to (4.9d)."""
    q, rate, wheels = x[:4], x[4:7], x[7:]
    norm = jnp.sum(q * q)
    turned = jnp.concatenate([-jnp.sum(q[1:] * rate)[None], q[0] * rate + jnp.cross(q[1:], rate)])
    momentum = p["inertia"] @ rate + p["wheel"] * wheels
    change = p["inverse"] @ (-jnp.cross(rate, momentum) - u)
    return jnp.concatenate(
        [
            0.5 * turned + 0.5 * p["baumgarte"] * q * (1.0 / norm - 1.0),
            change,
            u / p["wheel"] - change,
        ]
    )


def lost_power(x: Array, u: Array, p: dict[str, Any]) -> Array:
    """Less the net power [W], equations (4.1), (4.4) and (4.6)."""
    q, wheels = x[:4], x[7:]
    once = jnp.cross(q[1:], p["sun"])
    sun = p["sun"] - 2.0 * q[0] * once + 2.0 * jnp.cross(q[1:], once)
    toward = jnp.concatenate([sun, -sun])
    lit = 0.5 * (toward + jnp.sqrt(toward**2 + p["smoothing"]))
    earned = p["irradiance"] * jnp.sum(lit * toward * p["areas"])
    return -earned - jnp.sum(u * wheels) / p["efficiency"]


def missed(x: Array, p: dict[str, Any]) -> Array:
    """Attitude and rate at the end."""
    q, target = x[:4], p["target"]
    turned = target[0] * q[1:] - q[0] * target[1:] - jnp.cross(target[1:], q[1:])
    return jnp.concatenate([2.0 * turned, 10.0 * x[4:7]])


def net_power() -> jaxatt.OptimalControlProgram:
    """The problem, without a derivative written by hand."""
    return jaxatt.transcribe(
        dynamics,
        states=10,
        controls=3,
        intervals=INTERVALS,
        initial_state=START,
        final_time=HORIZON_S,
        running_cost=lost_power,
        terminal_equality=missed,
        control_bounds=lambda p: (-p["torque"], p["torque"]),
    )
