"""An open-loop flight beside Basilisk; skipped where the package bsk is not installed."""

import jax.numpy as jnp
import numpy as np
import pytest
from references import basilisk_flight, short_flights, wheeled_body

from jaxatt import simulate
from jaxatt.attitude import quaternion
from jaxatt.environment import frames, kepler
from jaxatt.problems.surroundings import elements_of

pytest.importorskip("Basilisk", reason="Basilisk (package bsk) is not installed")

pytestmark = [
    pytest.mark.basilisk,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


def test_wheels_orbit_and_gravity_gradient_agree_over_minutes():
    duration, step = 300.0, 0.05
    flight = short_flights.flight(
        simulation={"duration_s": duration, "sampling_s": step, "records": 60}
    )
    torque = np.array([2e-5, -1e-5, 1.5e-5])
    flown = simulate(flight, short_flights.ConstantTorque(jnp.asarray(torque))).flown.recorded
    orbit, initial, craft = flight.surroundings.orbit, flight.initial, flight.vehicle
    r_i, v_i = kepler.to_state(elements_of(orbit), orbit.gravitational_parameter)
    q_io = frames.quaternion_io(r_i, v_i)
    rate = quaternion.rotate_inverse(initial.q_ob, frames.omega_io(r_i, v_i))
    case = basilisk_flight.Case(
        np.asarray(craft.inertia),
        np.asarray(craft.wheels.axes),
        2.1e-4,
        np.asarray(quaternion.multiply(q_io, initial.q_ob)),
        initial.omega_ob + np.asarray(rate),
        initial.omega_bw,
        np.asarray(r_i),
        np.asarray(v_i),
        orbit.gravitational_parameter,
        np.asarray(craft.wheels.allocation) @ torque,
        step,
        duration,
    )
    q, omega = basilisk_flight.fly(case)
    from jaxatt.environment.orbit import propagate

    r_e, v_e = propagate(r_i, v_i, duration, orbit.gravitational_parameter)
    q_ie = frames.quaternion_io(r_e, v_e)
    ours = np.asarray(quaternion.multiply(q_ie, flown.q_ob[0, -1]))
    turning = quaternion.rotate_inverse(flown.q_ob[0, -1], frames.omega_io(r_e, v_e))
    assert np.linalg.norm(omega - case.omega) > 1e-3  # it has moved
    assert wheeled_body.angle_between(ours, q) < 1e-8
    np.testing.assert_allclose(flown.omega_ob[0, -1] + np.asarray(turning), omega, atol=1e-9)
