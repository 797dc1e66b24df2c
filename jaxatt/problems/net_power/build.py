"""Make the manoeuvre of a scenario, and the state in which one phase begins."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.magnetic.manoeuvre import FreeManoeuvre
from jaxatt.problems.net_power.manoeuvre import End, Manoeuvre, Motion
from jaxatt.problems.net_power.options import NetPowerOptions
from jaxatt.problems.net_power.orbit_frame import inertial_pose
from jaxatt.problems.scenario import Scenario


def options_of(scenario: Scenario) -> NetPowerOptions:
    """The family's own part of a scenario."""
    assert isinstance(scenario.options, NetPowerOptions)
    return scenario.options


def beginning(scenario: Scenario, start: PhaseStart) -> tuple[Motion, float]:
    """State in inertial axes and charge of the battery [J] with which a phase begins."""
    options = options_of(scenario)
    if start.state is not None:
        state = start.state
        return Motion(state.q_ob, state.omega_ob, state.omega_bw), float(state.state[0])
    pose = inertial_pose(scenario.initial, options.initial_frame, options.satellite.orbit)
    battery = options.satellite.craft.battery
    charge = 0.0 if battery is None else float(battery.charge)
    return Motion(pose.q_ib, pose.omega_ib, scenario.initial.omega_bw), charge


def carried_on(motion: Motion, charge: float) -> InitialState:
    """State from which the next phase begins: in inertial axes, with the charge behind it."""
    return InitialState(motion.q_ib, motion.omega_ib, motion.omega_bw, np.array([charge]))


def manoeuvre_of(scenario: Scenario, start: PhaseStart) -> Manoeuvre:
    """The single manoeuvre of a scenario without tasks."""
    options, horizon = options_of(scenario), scenario.horizon
    motion, charge = beginning(scenario, start)
    end = _end(scenario, start.time + horizon.duration)
    return Manoeuvre(
        satellite=options.satellite,
        start=motion,
        # Where the roll is free, the one that is nearest is what rolls are told from.
        end=None if end is None else end.facing(motion.q_ib),
        start_time=start.time,
        duration=horizon.duration,
        intervals=horizon.intervals,
        load=options.load,
        terminal=scenario.objective.terminal,
        attitude_weight=options.weights.attitude,
        rate_weight=options.weights.rate,
        substeps=horizon.substeps,
        floor=options.floor,
        charge=charge,
    )


def free_manoeuvre_of(scenario: Scenario, start: PhaseStart) -> FreeManoeuvre:
    """The manoeuvre of a scenario in free time."""
    options, horizon = options_of(scenario), scenario.horizon
    motion, charge = beginning(scenario, start)
    return FreeManoeuvre(
        satellite=options.satellite,
        start=motion,
        target=scenario.targets[0],
        frame=options.target_frame,
        intervals=horizon.intervals,
        shortest=horizon.shortest,
        longest=horizon.longest,
        start_time=start.time,
        cost=options.cost,
        terminal=scenario.objective.terminal,
        attitude_weight=options.weights.attitude,
        rate_weight=options.weights.rate,
        time_weight=options.weights.time,
        load=options.load,
        charge=charge,
        substeps=horizon.substeps,
    )


def _end(scenario: Scenario, time: float) -> End | None:
    """State to end in; one that the orbit carries along is taken at that time [s]."""
    if not scenario.targets:
        return None
    target, options = scenario.targets[0], options_of(scenario)
    wanted = InitialState(target.q_ob, target.omega_ob, np.zeros(0))
    pose = inertial_pose(wanted, options.target_frame, options.satellite.orbit, time)
    return End(
        pose.q_ib,
        pose.omega_ib,
        target.attitude_tolerance,
        target.rate_tolerance,
        options.wheel_speed_at_end,
        target.boresight,
    )
