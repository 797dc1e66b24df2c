"""Attitude and rate errors of a state against a constant reference, for the continuous laws."""

from __future__ import annotations

from jax import Array

from jaxatt.attitude import errors, quaternion
from jaxatt.environment.table import Environment
from jaxatt.spacecraft import dynamics
from jaxatt.spacecraft.dynamics import AttitudeState


def departure(
    reference: Array, reference_rate: Array, state: AttitudeState, environment: Environment
) -> tuple[Array, Array]:
    """Vector part eps_e (3,) of the error quaternion, the short way round, and omega_e (3,)
    [rad/s].

    reference : (4,), q_ob.  reference_rate : (3,) [rad/s], omega_ob.
    """
    error = quaternion.canonical(errors.error_quaternion(reference, state.q_ob))
    return error[1:], dynamics.relative_rate(state, environment) - reference_rate
