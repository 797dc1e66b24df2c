"""Reference of a flight that follows a path: the attitudes of a file, or directions."""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.attitude.host_turns import conjugate, product, to_body
from jaxatt.environment.along_orbit import Nodes
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.spacecraft.vehicle import total_momentum


def followed(
    scenario: FlightScenario, path: AttitudePath, time: Floats, nodes: Nodes
) -> tuple[Floats, Floats, Floats]:
    """Attitude q_ob (K, 4), rate omega_ob (K, 3) [rad/s] and torque on the wheels (K, 3) [N m].

    time : (K,) [s], the last sampling instants of the flight.  nodes : of all its instants.
    The torque is what turns the body along the path: its momentum stays where it is in inertial
    axes, since torques from outside are left to the law.  It is the mean over each sample.
    """
    q_ib, omega_ib = path.at(time)
    q_io, omega_io = np.asarray(nodes.attitude.array), np.asarray(nodes.rate.array)
    start = scenario.initial
    q_start = product(q_io[0], start.q_ob)
    omega_start = start.omega_ob + to_body(start.q_ob, omega_io[0])
    momentum = np.asarray(total_momentum(scenario.vehicle, omega_start, start.omega_bw))
    stored = to_body(q_ib, to_body(conjugate(q_start), momentum))
    carried = np.cross(omega_ib, stored)
    slope = np.diff(omega_ib, axis=0) / np.diff(time)[:, None]
    inertia = np.asarray(scenario.vehicle.inertia_without_spin)
    torque = np.zeros_like(omega_ib)
    torque[:-1] = -slope @ inertia.T - 0.5 * (carried[1:] + carried[:-1])
    q_io, omega_io = q_io[-len(time) :], omega_io[-len(time) :]
    q_ob = product(conjugate(q_io), q_ib)
    return q_ob, omega_ib - to_body(q_ob, omega_io), torque
