"""The references' plain data as the package's own types; the only bridge between the two."""

import jax.numpy as jnp
import numpy as np

from jaxatt.environment import KeplerianElements
from jaxatt.environment.motion import TwoBody
from jaxatt.environment.table import Surroundings
from jaxatt.spacecraft import create, reaction_wheels


def craft(body, torque_limit=5e-3, speed_limit=np.inf):
    return create(
        body.inertia, reaction_wheels(body.axes, body.spin, torque_limit, speed_limit), "random"
    )


def surroundings(space):
    return Surroundings(
        TwoBody(
            KeplerianElements(*(jnp.asarray(value) for value in space.elements)),
            jnp.asarray(space.mu),
        ),
        jnp.asarray(float(space.gravity_gradient)),
        jnp.asarray(space.sine_amplitude),
        jnp.asarray(space.sine_frequency),
    )
