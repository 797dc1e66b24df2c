"""SparseTask of a slew: arguments for the solver, and judgement of answers."""

from __future__ import annotations

import copy
import functools
import math
from concurrent.futures import Executor
from dataclasses import replace

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.attitude import errors
from jaxatt.attitude.host_turns import conjugate, product, turn_of
from jaxatt.environment.table import Surroundings, coarsen, tabulate
from jaxatt.problems.coasting import needed_substeps
from jaxatt.problems.hands_off.printed_cost import partly_open, support_cost
from jaxatt.problems.hands_off.slew.arguments import begin, slew_arguments, slew_parameters
from jaxatt.problems.hands_off.slew.flights import SlewFlights
from jaxatt.problems.hands_off.slew.model import SlewForm
from jaxatt.problems.hands_off.slew.mounting import mounting
from jaxatt.problems.hands_off.slew.moving_starts import moving_starts
from jaxatt.problems.hands_off.slew.path_names import path_names
from jaxatt.problems.hands_off.slew.system import slew_system
from jaxatt.problems.hands_off.task import Goal, SparseTask
from jaxatt.problems.manoeuvre import (
    Grid,
    InitialState,
    Target,
    Waypoint,
    long_way_probability,
)
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.pointing.case import FREE, Pointing
from jaxatt.problems.pointing.spare_cones import with_spare_cones
from jaxatt.problems.pointing.watch import ObservedPath, PathMonitor
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import overstay, speed_excess, speed_range
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.chunks import in_chunks
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.simulation.flight import Trajectory
from jaxatt.simulation.flight_error import judging_steps
from jaxatt.simulation.pulses import Pulses
from jaxatt.spacecraft.scale import IDLE_SHARE, least_torque_limit
from jaxatt.spacecraft.vehicle import Spacecraft
from jaxatt.spacecraft.wheel_bias import bias_of

_SMALL_GYROSCOPIC_TURN = 0.5
"""|H| T / J up to which the derivatives of `pulse_equations` make Newton's method contract well."""


def _compared(q_ref: Floats, q: Floats | Array) -> tuple[Floats, Floats]:
    """As `_compare`, for (4,) or (S, 4) and (S, 4), on the host."""
    pairs = np.broadcast_to(q_ref, np.shape(q)), q
    return in_chunks(lambda pair: _compare(*pair), pairs, key="compare")


def _angle_and_metric(q_ref: Array, q: Array) -> tuple[Array, Array]:
    """Angle [rad] and smoothed metric g (5.2) between attitudes."""
    return errors.angle(q_ref, q), errors.smooth_pseudo_metric(q_ref, q)


_compare = Routine(_angle_and_metric, options=RUNS_ONCE)


class SlewTask(SparseTask):
    """SparseTask of one slew, or of one phase of several.

    craft : vehicle.  initial_state, target, waypoint : where it begins, ends and passes.
    axes : "body" or "wheels", the axes of the decision variables.
    weight : (N,), h_k.  forbidden : (N,), intervals without torque.
    enforce_speed_limits : False to leave wheel speed limits to the verdict, which always has them.
    pointing : cones and rate limits; left to the verdict until `enforcing` puts them in the way.
    """

    threshold = IDLE_SHARE
    ways: tuple[float, ...] = (1.0, -1.0)

    def __init__(
        self,
        craft: Spacecraft,
        surroundings: Surroundings,
        initial_state: InitialState,
        target: Target,
        grid: Grid,
        goal: Goal,
        weight: Floats,
        forbidden: Flags,
        waypoint: Waypoint | None = None,
        axes: str = "body",
        enforce_speed_limits: bool = True,
        pointing: Pointing = FREE,
    ):
        # Where the roll is free, the one that is nearest is what rolls are told from.
        target = target.facing(initial_state.q_ob)
        self.craft, self.initial_state, self.target, self.goal = craft, initial_state, target, goal
        if self.leaves_roll_free:
            self.ways = (1.0,)  # a whole roll leads from one to the other
        self.grid, self.waypoint, self.axes = grid, waypoint, axes
        self.intervals, self.step = grid.intervals, grid.step
        self.needed_substeps = needed_substeps(
            craft, initial_state, target, surroundings, grid.step, grid.intervals
        )
        substeps = grid.substeps or self.needed_substeps
        fine = substeps * math.ceil(judging_steps(self.needed_substeps) / substeps)
        self.table = tabulate(
            surroundings, grid.start_time, grid.step, grid.intervals + grid.coast, fine
        )
        self.substeps = substeps
        first = jax.tree.map(lambda leaf: leaf[0], self.table.nodes)
        beginning = begin(
            craft, initial_state.q_ob, initial_state.omega_ob, initial_state.omega_bw, first
        )
        self.start = beginning.state
        self.pointing = pointing
        self.constraint_margin: Floats | None = None
        self.speed_margin: Floats = np.zeros(craft.wheels.count)
        self.torque_margin: Floats = np.zeros(craft.wheels.count)
        self.judges_path, self.judges_bias = True, False
        self.path_monitor = PathMonitor(self.table, pointing, grid.start_time)
        self.flights = SlewFlights(
            craft, self.start, surroundings, grid, self.path_monitor, substeps
        )
        self.null_torque = np.zeros((grid.intervals, craft.wheels.count))
        self.mounting = mounting(craft, axes)
        self.scale = self.mounting.scale
        self.size = len(self.scale)
        form = SlewForm(
            disturbed=bool(surroundings.gravity_gradient) or bool(surroundings.sine_amplitude),
            has_waypoint=waypoint is not None,
            speed_limited=enforce_speed_limits
            and self.has_speed_limits
            and craft.thrusters.count == 0,
            gyroscopic=self._gyroscopic_turn(beginning.momentum) > _SMALL_GYROSCOPIC_TURN,
            has_thrusters=craft.thrusters.count > 0,
        )
        self.form, self.system = form, slew_system(form)
        if goal.terminal == "penalty":
            self.sparsity_weight = goal.weights.sparsity
            l1 = goal.kind == "l1"
            # On a frozen support the effort only breaks ties of the printed cost.
            self.effort_weight = goal.weights.sparsity * float(self.scale.max()) if l1 else 1e-4
        plant = slew_parameters(
            craft,
            self.mounting,
            beginning,
            coarsen(self.table, self.intervals, substeps),
            target,
            waypoint,
            grid.step,
            form,
        )
        self.arguments = slew_arguments(plant, self.mounting, goal, weight, forbidden, form, axes)

    def enforcing(
        self, constraint_margin: Floats | None, speeds: bool, speed_margin: Floats | None = None
    ) -> SlewTask:
        """The same slew with path constraints in the programme, not only in the verdict.

        constraint_margin : (m + 1,), how much stricter cones [rad] and rates (a share) are taken
        than they are; None leaves them to the verdict.  speeds : whether wheel speed limits are
        enforced.  speed_margin : (n,), how much stricter those are taken, as a share.
        """
        other = copy.copy(self)
        other.constraint_margin = constraint_margin
        plant = self.arguments.plant
        if speed_margin is not None:
            other.speed_margin = speed_margin
            ends = speed_range(
                self.craft.wheels, self.start.omega_bw, speed_margin, every_band=True
            )
            slowest, fastest = (jax.device_put(end) for end in ends)
            plant = replace(plant, speed_lower=slowest, speed_upper=fastest)
        speeds = speeds and self.has_speed_limits and not self.form.has_thrusters
        other.form = replace(self.form, speed_limited=speeds, pointed=constraint_margin is not None)
        other.system = slew_system(other.form)
        if constraint_margin is not None:
            path = self.pointing.path(self.path_monitor.at_nodes(self.intervals), constraint_margin)
            spare = self.form.spare_cones(path.limits.count)
            plant = replace(plant, pointing=with_spare_cones(path, spare))
        other.arguments = replace(self.arguments, plant=plant)
        return other

    def weaker(self, torque_margin: Floats) -> SlewTask:
        """The same slew searched with less torque than the wheels' limits, which the verdict keeps.

        torque_margin : (n,), the shares of the limits that are left out.
        """
        other = copy.copy(self)
        other.torque_margin = torque_margin
        plant = self.arguments.plant
        left = (1.0 - self.torque_margin) / (1.0 - torque_margin)
        to_wheels = jax.device_put(np.asarray(plant.to_wheels) * left[:, None])
        other.arguments = replace(self.arguments, plant=replace(plant, to_wheels=to_wheels))
        return other

    def adding(self, null_torque: Floats) -> SlewTask:
        """The same slew flown with more torque (N, n) [N m] on the wheels, which must cancel in the
        body; its verdict then has the wheels' bias, too."""
        other = copy.copy(self)
        other.null_torque = null_torque
        other.judges_bias = True
        return other

    def keeping_path_limits_of(self, like: SparseTask) -> SlewTask:
        """See `SparseTask.keeping_path_limits_of`."""
        if not self.watches:
            return self
        margin: Floats | None = None
        if self.pointing:
            given = like.constraint_margin if isinstance(like, SlewTask) else None
            margin = np.zeros(len(self.pointing.cones) + 1) if given is None else given
        if not isinstance(like, SlewTask):
            return self.enforcing(margin, like.limits_speeds)
        kept = self.enforcing(margin, like.limits_speeds, like.speed_margin)
        return kept.weaker(like.torque_margin)

    @property
    def path_names(self) -> tuple[str, ...]:
        """Names of wheel speed limits, then of cones and rate limits, at nodes 1 to N."""
        return path_names(self.form, self.pointing, self.craft.wheels.names, self.intervals)

    def aiming_at(self, targets: Floats) -> SlewTask:
        """The same slew as a batch whose rows have targets q_ob (S, 4) of their own."""
        other = copy.copy(self)
        other.target = replace(self.target, q_ob=targets)
        nearer = np.where(targets @ np.asarray(self.start.q_ob) < 0.0, -1.0, 1.0)
        other.aims = targets * nearer[:, None]
        return other

    def pick(self, rows: npt.NDArray[np.int64]) -> SlewTask:
        """See `SparseTask.pick`."""
        return self if self.aims is None else self.aiming_at(np.asarray(self.target.q_ob)[rows])

    def sharing_programs(self) -> SlewTask:
        """See `SparseTask.sharing_programs`."""
        other = super().sharing_programs()
        other.flights = replace(self.flights, shared=True)
        return other

    def ignoring_path_limits(self) -> SlewTask:
        """The same slew without path constraints, not even in the verdict."""
        other = self.enforcing(None, False)
        other.judges_path = False
        return other

    @property
    def leaves_roll_free(self) -> bool:
        """Whether any roll about a direction will do at the end."""
        return self.target.boresight is not None

    @property
    def limits_speeds(self) -> bool:
        """Whether the programme keeps limits of wheel speeds."""
        return self.form.speed_limited

    @property
    def watches(self) -> bool:
        """Whether flights are checked between the nodes."""
        wheels = self.craft.wheels
        limited = bool(self.pointing) or wheels.has_speed_limits or not wheels.motors.ideal
        return limited and self.judges_path

    @property
    def has_path_limits(self) -> bool:
        """Whether there are path constraints besides limits of the controls."""
        return bool(self.pointing) or (self.has_speed_limits and not self.form.has_thrusters)

    @property
    def has_speed_limits(self) -> bool:
        """Whether there are speeds that a wheel must never have, or must leave soon."""
        return self.craft.wheels.has_speed_limits

    def _gyroscopic_turn(self, momentum: Array) -> float:
        """Angle |H| T / J that the momentum could turn the body, J the least inertia."""
        least = np.linalg.eigvalsh(np.asarray(self.craft.inertia_without_spin)).min()
        return float(np.linalg.norm(momentum)) * self.intervals * self.step / float(least)

    def to_controls(self, u: Floats | Array) -> Floats:
        """Torques in the optimisation's axes [N m], clipped to limits and thresholded."""
        bounded = np.clip(np.asarray(u, float), self.mounting.lower, self.mounting.upper)
        size = _largest(bounded) if self.shared else np.abs(bounded)
        torque = np.where(size <= self.threshold, 0.0, bounded * self.scale)
        if self.craft.wheels.count == 0:
            return np.asarray(torque)
        relative = self.wheel_torque(torque) / np.asarray(self.craft.wheels.torque_limit)
        return np.asarray(torque / np.maximum(1.0, _largest(relative)))

    def from_controls(self, controls: Floats) -> Floats:
        """Scaled variables from torques in the optimisation's axes [N m]."""
        return np.asarray(controls / self.scale)

    effort_name = "N m s"

    @property
    def control_unit(self) -> Floats:
        """Torques of a unit of the scaled variables, (b,) [N m]."""
        return self.scale

    def wheel_torque(self, controls: Floats) -> Floats:
        """Wheel torques (..., N, n) [N m]."""
        return np.asarray(controls @ self.mounting.to_wheel.T) + self.null_torque

    def thrust(self, controls: Floats) -> Floats:
        """Torque of each thruster (..., N, m) [N m]."""
        return np.asarray(controls @ self.mounting.to_thrust.T)

    def body_torque(self, controls: Floats) -> Floats:
        """Torque on the wheels in body axes, (..., N, 3) [N m]."""
        return np.asarray(controls @ self.mounting.to_body.T)

    def external_torque(self, controls: Floats) -> Floats:
        """Torque of the thrusters in body axes, (..., N, 3) [N m]."""
        return np.asarray(controls @ self.mounting.to_external.T)

    def fly(self, controls: Floats, times: int = 1) -> Trajectory:
        """Fly (S, N, b) torques on the full model with at least 20 substeps, then coast.

        times : how many times as many substeps, for a single flight.
        """
        torque = np.concatenate([self.wheel_torque(controls), self.thrust(controls)], axis=-1)
        return self.flights.torques(torque, self.watches, times)

    def begin_verifying(self, pool: Executor, most: int) -> None:
        """Compile ahead what `fly` runs for one and for `most` controls."""
        self.flights.begin(pool, self.watches, most)

    def fly_pulses(self, pulses: Pulses, coarse: bool = False, times: int = 1) -> Trajectory:
        """Fly openings of valves at their exact times; see `SlewFlights.pulses`."""
        return self.flights.pulses(pulses, self.watches, coarse, times)

    @property
    def tolerances(self) -> dict[str, float]:
        """Allowed errors at the end: "attitude" [rad] and "rate" [rad/s]."""
        return {"attitude": self.target.attitude_tolerance, "rate": self.target.rate_tolerance}

    def end_errors(self, q_ob: Floats | Array, omega_ob: Floats | Array) -> dict[str, Floats]:
        """Errors (S,) of flights (S, nodes, ...) at the end of the horizon, as `tolerances`."""
        end = self.intervals
        target = self.target.facing(np.asarray(q_ob[:, end]))
        return {
            "attitude": _compared(target.q_ob, q_ob[:, end])[0],
            "rate": np.linalg.norm(omega_ob[:, end] - target.omega_ob, axis=-1),
        }

    def judge(self, flown: Trajectory, controls: Floats) -> Verdict:
        """Judge the errors of flights at the end of the horizon and at the waypoint."""
        found, tolerances = self.end_errors(flown.q_ob, flown.omega_ob), self.tolerances
        if self.waypoint is not None:
            q = flown.q_ob[:, self.waypoint.node]
            found["waypoint"] = _compared(self.waypoint.q_ob, q)[0]
            tolerances["waypoint"] = self.waypoint.tolerance
        wheels, thrusters = self.craft.wheels, self.craft.thrusters
        if self.judges_bias and self.target.wheel_bias is not None:
            speeds = np.asarray(flown.omega_bw[:, self.intervals])
            missed = [bias_of(wheels, one) - self.target.wheel_bias for one in speeds]
            found["wheel bias"] = np.abs(missed).max(axis=1)
            tolerances["wheel bias"] = self.target.bias_tolerance
        wheel, thrust = self.wheel_torque(controls), self.thrust(controls)
        excess = np.concatenate(
            [
                np.abs(wheel) - np.asarray(wheels.torque_limit),
                np.maximum(thrust - np.asarray(thrusters.torque_limit), -thrust),
            ],
            axis=-1,
        )
        path = np.zeros(len(controls))
        if self.watches and self.pointing:
            path = self.watch(flown).violation
        speeds, step = self.wheel_speeds(flown)
        speed = speed_excess(wheels, speeds).max(axis=1, initial=0.0)
        speed = np.maximum(speed, overstay(wheels, speeds, step))
        speed = np.maximum(speed, motor_excess(wheels, wheel, speeds).max(axis=1, initial=0.0))
        return Verdict(
            found,
            tolerances,
            np.maximum(0.0, excess.max(axis=(1, 2))),
            np.maximum(path, speed * self.judges_path),
            least_torque_limit(self.craft),
        )

    def verify(self, controls: Floats) -> tuple[Verdict, dict[str, Floats]]:
        """Fly the torques again on the full model and judge the flights."""
        flown = self.fly(controls)
        return self.judge(flown, controls), self.cost(flown, controls)

    def l1_effort(self, controls: Floats) -> Floats:
        """L1 effort, the sum over intervals and body axes of |tau| h, (S,) [N m s]."""
        wheels = np.abs(self.body_torque(controls)).sum(axis=(-2, -1))
        pushes = np.abs(self.mounting.to_external).sum(axis=0)
        return np.asarray((wheels + (np.abs(controls) @ pushes).sum(axis=-1)) * self.step)

    def watch(self, flown: Trajectory) -> ObservedPath:
        """Angles of cones and rates along flights (S, ...), between the nodes too."""
        return self.path_monitor.watch(flown, self.intervals)

    def wheel_speeds(self, flown: Trajectory) -> tuple[Floats, float]:
        """Wheel speeds (S, T, n) [rad/s] until the end, and the time [s] between two of them.

        At every Runge-Kutta step where flights are watched.
        """
        if flown.fine is None:
            return np.asarray(flown.omega_bw[:, : self.intervals + 1]), self.step
        every = self.path_monitor.every
        speeds = flown.fine.omega_bw[:, : self.intervals * every + 1]
        return np.asarray(speeds), self.step / every

    def cost(self, flown: Trajectory, controls: Floats) -> dict[str, Floats]:
        """Parts of the printed cost, (5.3a), (5.5a), (5.7a), (5.9) or (5.14a), each (S,)."""
        w, end = self.goal.weights, self.intervals
        target = self.target.facing(np.asarray(flown.q_ob[:, end]))
        rate = flown.omega_ob[:, end] - target.omega_ob
        parts = {
            "rate": w.rate * np.sum(rate**2, axis=-1),
            "attitude": w.attitude * _compared(target.q_ob, flown.q_ob[:, end])[1],
        }
        if self.waypoint is not None:
            q = flown.q_ob[:, self.waypoint.node]
            parts["waypoint"] = w.waypoint * _compared(self.waypoint.q_ob, q)[1]
        if self.goal.kind == "l1":
            parts["l1"] = w.sparsity * self.slack_sum(controls)
        else:
            weight = np.asarray(self.arguments.weight)
            parts["sparsity"] = w.sparsity * support_cost(controls, self.goal, weight)
        if self.form.has_thrusters and w.on_off > 0.0:
            limit = np.asarray(self.craft.thrusters.torque_limit)
            parts["on_off"] = w.on_off * partly_open(
                controls, self.thrust(controls), limit, self.goal
            )
        return parts

    @property
    def in_motion(self) -> bool:
        """Whether the wheels' momentum or a rate at either end turns the body far."""
        rates = np.stack([self.initial_state.omega_ob, self.target.omega_ob])
        turned = float(np.linalg.norm(rates, axis=1).max()) * self.intervals * self.step
        far = self.form.gyroscopic or turned > _SMALL_GYROSCOPIC_TURN
        return far and not self.form.has_thrusters

    def moving_starts(self, count: int, seed: int) -> tuple[Floats, Floats]:
        """See `SparseTask.moving_starts`."""
        plant = self.arguments.plant
        return moving_starts(self.craft, self.mounting, plant, self.target, count, seed)

    def long_way_probability(self) -> float:
        """See `jaxatt.problems.manoeuvre.long_way_probability`."""
        if self.leaves_roll_free:
            return 0.0
        between = product(conjugate(np.asarray(self.start.q_ob)), np.asarray(self.target.q_ob))
        turn = turn_of(between if between[0] >= 0.0 else -between)
        rate, duration = self.initial_state.omega_ob, self.intervals * self.step
        return long_way_probability(turn, rate, duration)


def _largest(values: Floats) -> Floats:
    """Largest magnitude along the last axis, (..., 1), faster than NumPy for short axes."""
    sizes = np.moveaxis(np.abs(values), -1, 0)
    return np.asarray(functools.reduce(np.maximum, sizes))[..., None]
