"""An answer of the package flown again by the reference: its torque and scenario, nothing else."""

import numpy as np
from references import wheeled_body


def body_of(scenario):
    craft = scenario.vehicle
    return wheeled_body.Body(
        np.asarray(craft.inertia), np.asarray(craft.wheels.axes), np.asarray(craft.wheels.inertia)
    )


def space_of(scenario):
    o, d = scenario.orbit, scenario.disturbances
    return wheeled_body.Space(
        (
            o.semi_major_axis,
            o.eccentricity,
            o.inclination,
            o.raan,
            o.argument_of_periapsis,
            o.true_anomaly,
        ),
        o.gravitational_parameter,
        d.gravity_gradient,
        d.sinusoidal_torque,
        d.sinusoidal_frequency,
    )


def refly(scenario, result, pieces=1):
    """Flights of all phases, each from the end that this reference flew of the one before.

    pieces : samples an interval.
    """
    initial = scenario.initial
    state = (initial.q_ob, initial.omega_ob, initial.omega_bw)
    flights = []
    for phase in result.phases:
        controls = phase.controls
        if scenario.control.axes == "body":
            controls = controls @ np.linalg.pinv(np.asarray(scenario.vehicle.wheels.axes)).T
        flight = wheeled_body.fly(
            body_of(scenario),
            space_of(scenario),
            *state,
            controls,
            phase.step,
            phase.start_time,
            pieces,
        )
        state = (flight.q[-1], flight.relative[-1], flight.speeds[-1])
        flights.append((controls, flight))
    return flights


def cone_angle(flight, boresight, direction):
    """Angles [rad] at all samples between a body-fixed boresight and an inertial direction."""
    return np.arccos(np.clip(flight.attitudes @ boresight @ direction, -1.0, 1.0))


def assert_reached(scenario, result, attitude_deg=0.01, rate=1e-5, waypoint_deg=0.1):
    """Every phase ends at its target within these errors and within all limits, by SciPy's
    flight.
    """
    wheels = scenario.vehicle.wheels
    flights = refly(scenario, result)
    for target, (torque, flight) in zip(scenario.targets, flights, strict=True):
        angle = wheeled_body.angle_between(flight.q[-1], target.q_ob)
        assert np.rad2deg(angle) < attitude_deg
        assert np.linalg.norm(flight.relative[-1] - target.omega_ob) < rate
        assert (np.abs(torque) - np.asarray(wheels.torque_limit)).max() <= 1e-9
        assert (np.abs(flight.speeds) <= np.asarray(wheels.speed_limit) * (1 + 1e-6)).all()
    if scenario.waypoint is not None:
        passed = flights[0][1].q[scenario.waypoint.node]
        angle = wheeled_body.angle_between(passed, scenario.waypoint.q_ob)
        assert np.rad2deg(angle) < waypoint_deg
    return [flight for _, flight in flights]
