"""Build the simulator's arrays from a checked flight."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.environment import epoch, igrf
from jaxatt.environment.along_orbit import Nodes, OrbitTask, inertial_nodes, tabulate
from jaxatt.environment.external import Along
from jaxatt.problems.reading.dates import moment_of
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.scenarios.path_reference import followed
from jaxatt.simulation.campaign import Start
from jaxatt.simulation.closed_loop import Flight, Noise, Reference
from jaxatt.simulation.settling import Band
from jaxatt.spacecraft.checks import Float64


class Plan(NamedTuple):
    """Optimised manoeuvre at the sampling instants, for a law to track.

    q_ob : (K, 4).  omega_ob : (K, 3) [rad/s].  torque : (K, 3) [N m], on the wheels in body axes.
    After its end the last attitude is held.
    """

    q_ob: Float64
    omega_ob: Float64
    torque: Float64


def build_flight(scenario: FlightScenario, plan: Plan | None = None) -> tuple[Flight, Start]:
    """Build the data that all runs share, and the nominal initial state."""
    timing = scenario.timing
    samples, steps = timing.samples, timing.steps
    along, nodes = _surroundings(scenario, samples * steps, steps)
    reference = _reference(scenario, plan, nodes)

    each = samples // timing.records

    def split(tree: Any, *inner: int) -> Any:
        return jax.tree.map(lambda x: np.asarray(x).reshape(timing.records, each, *inner), tree)

    flight = Flight(
        nominal=scenario.vehicle,
        torques=scenario.surroundings.torques,
        along=split(along, steps, 4),
        nodes=split(_but_last(nodes)),
        reference=split(_but_last(reference)),
        ends=jax.tree.map(lambda x: np.asarray(x)[each::each], (nodes, reference)),
        period=jnp.asarray(timing.sampling),
        band=Band(jnp.asarray(scenario.band), jnp.asarray(scenario.since)),
        noise=Noise(*map(jnp.asarray, scenario.noise)),
        dumping=scenario.dumping,
        tumbling=jnp.asarray(timing.tumbling),
        signal=scenario.signal,
        noisy=any(size > 0.0 for size in scenario.noise),
    )
    initial = scenario.initial
    return flight, Start(initial.q_ob, initial.omega_ob, initial.omega_bw)


def _but_last(tree: Any) -> Any:
    return jax.tree.map(lambda leaf: leaf[:-1], tree)


def _surroundings(scenario: FlightScenario, count: int, steps: int) -> tuple[Along, Nodes]:
    """Environment (count, 4) of the Runge-Kutta steps, and nodes of the samples and of the end."""
    around, step = scenario.surroundings, scenario.timing.step
    if around.orbit is None:
        half = 0.5 * step * (2 * np.arange(count)[:, None] + np.array([0, 1, 1, 2]))
        wave = jnp.asarray(around.sine * np.sin(around.frequency * half))
        return Along(disturbance=Vector(wave, wave, wave)), inertial_nodes(count // steps + 1)
    field, days = None, 0.0
    if around.days is not None:
        days = around.days
        if around.torques.magnetic or scenario.dumping is not None:
            field = igrf.at_year(epoch.decimal_year(moment_of(days)))
    task = OrbitTask(
        motion_of(around.orbit),
        jnp.asarray(days),
        field,
        None if around.sun is None else jnp.asarray(around.sun),
        jnp.asarray(around.sine),
        jnp.asarray(around.frequency),
    )
    along, nodes = tabulate(task, around.torques, around.gravity_gradient, step, count)
    return along, jax.tree.map(lambda leaf: leaf[::steps], nodes)


def _reference(scenario: FlightScenario, plan: Plan | None, nodes: Nodes) -> Reference:
    asked, count = scenario.asked, scenario.timing.samples + 1
    time = scenario.timing.sampling * np.arange(count)
    on = time >= asked.since - 1e-9
    q = np.where(on[:, None], asked.q_ob, scenario.initial.q_ob)
    rate = np.where(on[:, None], asked.omega_ob, 0.0)
    held = np.where(on & (not asked.held), 0.0, 1.0)
    torque = np.zeros((count, 3))
    if asked.held and asked.omega_ob.any():
        turned = np.where(on, time - asked.since, 0.0)[:, None] * asked.omega_ob
        q = np.asarray(quaternion.multiply(q, quaternion.from_rotation_vector(turned)))
    if asked.path is not None:
        q[on], rate[on], torque[on] = followed(
            scenario, asked.path, np.asarray(time[on], np.float64), nodes
        )
    if plan is not None:
        first = int(np.argmax(on))
        covered = min(len(plan.q_ob), count - first)
        rows = slice(first, first + covered)
        q[first + covered :] = plan.q_ob[-1]
        q[rows], rate[rows] = plan.q_ob[:covered], plan.omega_ob[:covered]
        driven = min(len(plan.torque), count - first)
        torque[first : first + driven] = plan.torque[:driven]
    return Reference(Quaternion.of(q), Vector.of(rate), jnp.asarray(held), Vector.of(torque))
