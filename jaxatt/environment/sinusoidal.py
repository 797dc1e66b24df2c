"""A sinusoidal torque that represents unmodelled disturbances."""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch, floating


def sinusoidal_torque(t: ArrayLike, amplitude: ArrayLike, frequency: ArrayLike = 1.0) -> jax.Array:
    """Torque A sin(w t) along (1, 1, 1); Schaanning (2021), eq. (4.12), where w = 1 rad/s.

    Parameters
    ----------
    t : (...) [s]
    amplitude : (...) [N m]
        On each axis.
    frequency : (...) [rad/s]

    Returns
    -------
    (..., 3) [N m]
        In body axes.
    """
    t, amplitude, frequency = broadcast_batch(
        *(floating(x)[..., None] for x in (t, amplitude, frequency))
    )
    wave = amplitude * jnp.sin(frequency * t)
    return jnp.broadcast_to(wave, (*wave.shape[:-1], 3))
