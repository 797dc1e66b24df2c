"""Feedback flights of wheels with friction and falling torque, beside SciPy's DOP853."""

import jax.numpy as jnp
import numpy as np
from references import short_flights, wheeled_body
from scipy.integrate import solve_ivp

from jaxatt import simulate

COULOMB, VISCOUS = 2e-5, 1e-6
MU = 3.986004418e14  # of the package where a file states none
BEGINS = np.array([100.0, -50.0, 30.0, 20.0])


def flight(**wheels):
    return short_flights.flight(
        vehicle={"wheels": wheels},
        environment={"gravity_gradient": False},
        simulation={"duration_s": 20.0, "sampling_s": 0.02, "records": 20},
    )


def test_friction_acts_between_wheel_and_body():
    asked = flight(coulomb_friction_Nm=COULOMB, viscous_friction_Nms=VISCOUS)
    torque = np.array([1e-5, -2e-5, 3e-5])
    flown = simulate(asked, short_flights.ConstantTorque(jnp.asarray(torque))).flown.recorded
    wheels = asked.vehicle.wheels
    body = wheeled_body.Body(
        np.asarray(asked.vehicle.inertia), np.asarray(wheels.axes), np.asarray(wheels.inertia)
    )
    space = wheeled_body.Space((6852.2e3, 0.002, *np.radians([97.0, 280.0, 0.0, 90.0])), MU)
    r, v = wheeled_body.orbit_state(space)
    q = np.asarray(asked.initial.q_ob)
    omega = np.asarray(asked.initial.omega_ob)
    omega = omega + wheeled_body.rotation(q).T @ wheeled_body.orbit_rate(r, v)
    motors = np.asarray(wheels.allocation) @ torque

    def slope(t, y):
        speeds = y[13:]
        taken = motors - COULOMB * np.sign(speeds) - VISCOUS * speeds
        return wheeled_body.rates(body, space, t, y, taken)

    begin = np.concatenate([r, v, q, omega, BEGINS])
    end = solve_ivp(slope, (0.0, 20.0), begin, method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    found = np.asarray(flown.omega_bw)[0, -1]
    lost = np.abs(end[13:] - BEGINS)
    assert (lost > 1.0).all()
    # The friction is held over a sample, as torques are.
    np.testing.assert_allclose(found, end[13:], atol=2e-4)
    assert wheeled_body.angle_between(np.asarray(flown.q_ob)[0, -1], end[6:10]) < 1e-5


def test_the_law_gets_no_more_than_the_motors_give_at_that_speed():
    asked = flight(full_torque_speed_rad_s=20.0, no_torque_speed_rad_s=60.0)
    whole = short_flights.ConstantTorque(jnp.asarray([0.0, 0.0, 2e-3]))
    speeds = np.asarray(simulate(asked, whole).flown.recorded.omega_bw)[0]
    # The third wheel drives up towards 60 rad/s, where nothing is left, and does not pass it.
    assert speeds[-1, 2] > 55.0 and speeds[:, 2].max() < 60.0
    free = np.asarray(simulate(flight(), whole).flown.recorded.omega_bw)[0]
    assert free[-1, 2] > 120.0
