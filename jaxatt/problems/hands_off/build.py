"""From a scenario to the tasks that solve it."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from jaxatt.environment import MU_EARTH, KeplerianElements
from jaxatt.environment.table import Surroundings, environment_at
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Goal, Task, Weights
from jaxatt.problems.manoeuvre import Aim, Departure, Grid, Passage, automatic_substeps
from jaxatt.problems.scenario import SPACECRAFT, Orbit, Scenario
from jaxatt.problems.toy.task import ToyTask
from jaxatt.scenarios.pointing import Moment
from jaxatt.scenarios.windows import forbidden_mask, window_weights


def elements_of(orbit: Orbit) -> KeplerianElements:
    """Keplerian elements at time zero."""
    return KeplerianElements(
        *(
            jnp.asarray(value)
            for value in (
                orbit.semi_major_axis,
                orbit.eccentricity,
                orbit.inclination,
                orbit.raan,
                orbit.argument_of_periapsis,
                orbit.true_anomaly,
            )
        )
    )


def surroundings_of(scenario: Scenario) -> Surroundings:
    """Orbit and known disturbances of a spacecraft's scenario."""
    orbit, disturbances = scenario.orbit, scenario.disturbances
    return Surroundings(
        None if orbit is None else elements_of(orbit),
        jnp.asarray(MU_EARTH if orbit is None else orbit.gravitational_parameter),
        jnp.asarray(float(disturbances.gravity_gradient)),
        jnp.asarray(disturbances.sinusoidal_torque),
        jnp.asarray(disturbances.sinusoidal_frequency),
    )


def moments_of(scenario: Scenario) -> list[Moment]:
    """Start, waypoint and targets of a spacecraft's scenario, with the orbit frame then."""
    horizon, initial, passing = scenario.horizon, scenario.initial, scenario.waypoint
    asked = [("start", 0.0, initial.q_ob, initial.omega_ob)]
    if passing is not None:
        asked.append(("waypoint", passing.time, passing.q_ob, np.zeros(3)))
    for index, target in enumerate(scenario.targets):
        label = "target" if len(scenario.targets) == 1 else f"target of leg {index + 1}"
        asked.append((label, (index + 1) * horizon.duration, target.q_ob, target.omega_ob))
    times = jnp.asarray([time for _, time, _, _ in asked])
    around = environment_at(surroundings_of(scenario), times)
    frames = zip(np.asarray(around.orbit_attitude), np.asarray(around.orbit_rate), strict=True)
    return [Moment(*known, *frame) for known, frame in zip(asked, frames, strict=True)]


def goal_of(scenario: Scenario) -> Goal:
    """What the scenario minimises."""
    o = scenario.objective
    weights = Weights(
        o.rate_weight,
        o.attitude_weight,
        o.sparsity_weight,
        o.waypoint_weight,
        o.on_off_weight,
        o.on_off_form == "printed",
    )
    return Goal(o.kind, o.terminal, o.design, o.epsilon, weights)


def build_task(
    scenario: Scenario,
    leg: int = 0,
    departure: Departure | None = None,
    enforce_speed_limits: bool = True,
    final_time: float | None = None,
    start_time: float | None = None,
) -> Task:
    """Task of one leg of a scenario.

    leg : index into `scenario.targets`.  departure : where the leg begins, by default where the
    scenario does; successive legs hand over the flown end of the one before.
    enforce_speed_limits : False to leave wheel speed limits to the verdict.
    final_time : [s] from the leg's start, by default the scenario's horizon.
    start_time : [s] at which the leg starts, by default after as many horizons as there are legs
    before it.
    """
    horizon, target, goal = scenario.horizon, scenario.targets[leg], goal_of(scenario)
    duration = horizon.duration if final_time is None else final_time
    if scenario.system != SPACECRAFT:
        return ToyTask(
            scenario.system,
            scenario.initial.state,
            target.state,
            horizon.intervals,
            duration / horizon.intervals,
            scenario.control.limit,
            target.state_tolerance,
            goal,
            horizon.substeps or 2,
        )
    assert scenario.vehicle is not None
    initial, passing = scenario.initial, scenario.waypoint
    surroundings, substeps = surroundings_of(scenario), horizon.substeps
    if horizon.free and substeps is None:
        # As many as the longest interval needs: with the same number everywhere nothing recompiles.
        substeps = automatic_substeps(horizon.longest / horizon.intervals, surroundings)
    moving = goal.kind == "moving-l0"
    return SlewTask(
        craft=scenario.vehicle,
        surroundings=surroundings,
        departure=departure or Departure(initial.q_ob, initial.omega_ob, initial.omega_bw),
        aim=Aim(target.q_ob, target.omega_ob, target.attitude_tolerance, target.rate_tolerance),
        grid=Grid(
            horizon.intervals,
            duration / horizon.intervals,
            horizon.coast_intervals,
            leg * horizon.duration if start_time is None else start_time,
            substeps,
        ),
        goal=goal,
        weight=window_weights(scenario) if moving else np.ones(horizon.intervals),
        forbidden=forbidden_mask(scenario),
        passage=None if passing is None else Passage(passing.q_ob, passing.node, passing.tolerance),
        axes=scenario.control.axes,
        enforce_speed_limits=enforce_speed_limits,
        pointing=scenario.pointing,
    )
