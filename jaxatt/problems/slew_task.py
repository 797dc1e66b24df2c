"""A slew of a spacecraft: arguments for the solver, and its judge."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude import errors, quaternion
from jaxatt.environment.table import EnvironmentTable, Surroundings, coarsen, tabulate
from jaxatt.problems import sparsity
from jaxatt.problems.hands_off import SparseArguments
from jaxatt.problems.mounting import mounting
from jaxatt.problems.slew import RATE_SCALE, SlewForm, SlewParameters
from jaxatt.problems.slew_system import slew_system
from jaxatt.problems.task import Flags, Floats, Goal, Task, Verdict
from jaxatt.runtime import QUICK_TO_COMPILE
from jaxatt.simulation.chunks import in_chunks
from jaxatt.simulation.flight import MINIMUM_SUBSTEPS, Trajectory, fly_torque
from jaxatt.simulation.momentum_model import BodyParameters
from jaxatt.simulation.pulse_flight import fly_pulses
from jaxatt.simulation.pulses import Pulses
from jaxatt.spacecraft.dynamics import AttitudeState, at_relative_rate
from jaxatt.spacecraft.vehicle import Spacecraft, total_momentum

_SMALL_GYROSCOPIC_TURN = 0.5
"""|H| T / J up to which the derivatives of `pulse_equations` make Newton's method contract well."""

_LONGEST_SUBSTEP_PHASE = 0.35
"""[rad] of the sinusoidal torque in one RK4 step: four steps in 1.4 s at 1 rad/s."""


@dataclass(frozen=True, eq=False)
class Departure:
    """Where a slew begins: q_ob (4,), omega_ob (3,) [rad/s], omega_bw (n,) [rad/s]."""

    q_ob: Floats
    omega_ob: Floats
    omega_bw: Floats


@dataclass(frozen=True, eq=False)
class Aim:
    """Where a slew must end: attitude (4,), rate (3,) [rad/s] and their tolerances [rad, rad/s]."""

    q_ob: Floats
    omega_ob: Floats
    attitude_tolerance: float
    rate_tolerance: float


@dataclass(frozen=True, eq=False)
class Passage:
    """An attitude to pass: (4,), the node (1 .. N) and the tolerance [rad]."""

    q_ob: Floats
    node: int
    tolerance: float


@dataclass(frozen=True, eq=False)
class Grid:
    """N control intervals of `step` [s], the coasting intervals after them, the first time [s]."""

    intervals: int
    step: float
    coast: int
    start_time: float
    substeps: int | None = None


def automatic_substeps(step: float, surroundings: Surroundings) -> int:
    """RK4 steps an interval: one, or as many as a sinusoidal torque needs."""
    if float(surroundings.sine_amplitude) == 0.0:
        return 1
    phase = step * abs(float(surroundings.sine_frequency))
    return max(1, int(np.ceil(phase / _LONGEST_SUBSTEP_PHASE - 1e-9)))


def _compared(q_ref: Floats, q: Floats | Array) -> tuple[Floats, Floats]:
    """As `_compare`, for (4,) and (S, 4), on the host."""
    return in_chunks(lambda chunk: _compare(q_ref, chunk), q, key="compare")


_turn = jax.jit(errors.rotation_vector)


@jax.jit
def _compare(q_ref: Array, q: Array) -> tuple[Array, Array]:
    """Angle [rad] and smoothed metric g (5.2) between attitudes."""
    return errors.angle(q_ref, q), errors.smooth_pseudo_metric(q_ref, q)


@functools.partial(jax.jit, compiler_options=QUICK_TO_COMPILE)
def _fly_many(
    craft: Spacecraft, start: AttitudeState, torque: Array, table: EnvironmentTable
) -> Trajectory:
    return jax.vmap(lambda one: fly_torque(craft, start, one, table))(torque)


_fly_pulses = jax.jit(fly_pulses, static_argnums=6)
_COARSE_PIECES = 4


class SlewTask(Task):
    """One slew, or one leg of several.

    craft : vehicle.  departure, aim, passage : where it begins, ends and passes.
    axes : "body" or "wheels", the axes of the decision variables.
    weight : (N,), h_k.  forbidden : (N,), intervals without torque.
    enforce_speed_limits : False to leave wheel speed limits to the verdict, which always has them.
    """

    threshold = 1e-6

    def __init__(
        self,
        craft: Spacecraft,
        surroundings: Surroundings,
        departure: Departure,
        aim: Aim,
        grid: Grid,
        goal: Goal,
        weight: Floats,
        forbidden: Flags,
        passage: Passage | None = None,
        axes: str = "body",
        enforce_speed_limits: bool = True,
    ):
        self.craft, self.departure, self.aim, self.goal = craft, departure, aim, goal
        self.grid, self.passage, self.axes = grid, passage, axes
        self.intervals, self.step = grid.intervals, grid.step
        substeps = grid.substeps or automatic_substeps(grid.step, surroundings)
        fine = substeps * int(np.ceil(MINIMUM_SUBSTEPS / substeps))
        self.table = tabulate(
            surroundings, grid.start_time, grid.step, grid.intervals + grid.coast, fine
        )
        self.substeps = substeps
        self.start = at_relative_rate(
            jnp.asarray(departure.q_ob),
            jnp.asarray(departure.omega_ob),
            jnp.asarray(departure.omega_bw),
            jax.tree.map(lambda leaf: leaf[0], self.table.nodes),
        )
        self.mounting = mounting(craft, axes)
        self.scale = self.mounting.scale
        self.size = len(self.scale)
        form = SlewForm(
            disturbed=bool(surroundings.gravity_gradient) or bool(surroundings.sine_amplitude),
            has_waypoint=passage is not None,
            speed_limited=enforce_speed_limits
            and self.has_speed_limits
            and craft.thrusters.count == 0,
            gyroscopic=self._gyroscopic_turn() > _SMALL_GYROSCOPIC_TURN,
            propelled=craft.thrusters.count > 0,
        )
        self.form, self.system = form, slew_system(form)
        if goal.terminal == "penalty":
            self.sparsity_weight = goal.weights.sparsity
            l1 = goal.kind == "l1"
            # On a frozen support the effort only breaks ties of the printed cost.
            self.effort_weight = goal.weights.sparsity * float(self.scale.max()) if l1 else 1e-4
        self.arguments = self._arguments(weight, forbidden)

    @property
    def has_speed_limits(self) -> bool:
        """Whether any wheel has a speed limit."""
        return bool(np.isfinite(self.craft.wheels.speed_limit).any())

    def _gyroscopic_turn(self) -> float:
        """|H| T over the least moment of inertia: how far the momentum could turn the body."""
        momentum = total_momentum(self.craft, self.start.omega_ib, self.start.omega_bw)
        least = np.linalg.eigvalsh(np.asarray(self.craft.inertia_without_spin)).min()
        return float(np.linalg.norm(momentum)) * self.intervals * self.step / float(least)

    def _arguments(self, weight: Floats, forbidden: Flags) -> SparseArguments:
        craft, start, goal = self.craft, self.start, self.goal
        wheels, m = craft.wheels, self.mounting
        inertia = jnp.asarray(craft.inertia)
        reference = np.asarray(self.aim.q_ob)
        reference = reference * (1.0 if float(reference @ np.asarray(start.q_ob)) >= 0 else -1.0)
        passing = self.passage
        waypoint = reference if passing is None else np.asarray(passing.q_ob)
        waypoint = waypoint * (1.0 if float(waypoint @ np.asarray(start.q_ob)) >= 0 else -1.0)
        q_ib = quaternion.multiply(self.table.nodes.orbit_attitude[0], start.q_ob)
        momentum = total_momentum(craft, start.omega_ib, start.omega_bw)
        plant = SlewParameters(
            body=BodyParameters(inertia, jnp.linalg.inv(jnp.asarray(craft.inertia_without_spin))),
            table=coarsen(self.table, self.intervals, self.substeps),
            start=jnp.concatenate([q_ib, start.omega_ib]),
            momentum=momentum if self.form.propelled else quaternion.rotate(q_ib, momentum),
            reference=jnp.asarray(reference),
            reference_rate=jnp.asarray(self.aim.omega_ob),
            waypoint=jnp.asarray(waypoint),
            waypoint_node=jnp.asarray(1 if passing is None else passing.node),
            to_body=jnp.asarray(m.to_body * self.scale),
            to_external=jnp.asarray(m.to_external * self.scale),
            to_wheels=jnp.asarray(
                m.to_wheel * self.scale / np.asarray(wheels.torque_limit)[:, None]
            ),
            lower=jnp.asarray(m.lower),
            upper=jnp.asarray(m.upper),
            step=jnp.asarray(self.step),
            wheel_speed=jnp.asarray(start.omega_bw),
            wheel_axes=jnp.asarray(wheels.axes),
            wheel_inertia=jnp.asarray(wheels.inertia),
            wheel_torque=jnp.asarray(m.to_wheel * self.scale),
            speed_limit=jnp.asarray(wheels.speed_limit),
        )
        effort_map = m.to_body * self.scale / self.scale.max()
        if self.form.propelled:
            # Each actuator pays for itself: the torques of opposed thrusters must not cancel.
            pushes = np.abs(m.to_body + m.to_external).sum(axis=0)
            effort_map = np.diag(pushes * self.scale / self.scale.max())
        elif self.axes == "wheels":
            # The null space of the mounting turns nothing; a little cost keeps it still.
            effort_map = np.concatenate([effort_map, 1e-3 * np.eye(self.size)])
        w = goal.weights
        rows = [w.attitude / 4.0] * 3 + [2.0 * w.rate / RATE_SCALE**2] * 3
        rows += [w.waypoint / 4.0] * (3 if passing is not None else 0)
        soft = goal.terminal == "penalty"
        free = np.where(np.asarray(forbidden, bool)[:, None], 0.0, np.ones((1, self.size)))
        return SparseArguments(
            plant=plant,
            weight=jnp.asarray(weight),
            free=jnp.asarray(free),
            count_scale=jnp.asarray(1.0),
            effort_scale=jnp.asarray(0.0),
            effort_map=jnp.asarray(effort_map),
            row_weight=jnp.asarray(rows if soft else np.full(len(rows), np.inf)),
        )

    def to_controls(self, u: Floats | Array) -> Floats:
        """Torques in the optimisation's axes [N m], within limits, thresholded."""
        bounded = np.clip(np.asarray(u, float), self.mounting.lower, self.mounting.upper)
        torque = bounded * self.scale
        size = np.abs(torque).max(axis=-1, keepdims=True) if self.shared else np.abs(torque)
        torque = np.where(size <= self.threshold, 0.0, torque)
        if self.craft.wheels.count == 0:
            return np.asarray(torque)
        relative = np.abs(self.wheel_torque(torque)) / np.asarray(self.craft.wheels.torque_limit)
        return np.asarray(torque / np.maximum(1.0, relative.max(axis=-1, keepdims=True)))

    def from_controls(self, controls: Floats) -> Floats:
        """Scaled variables from torques in the optimisation's axes [N m]."""
        return np.asarray(controls / self.scale)

    def wheel_torque(self, controls: Floats) -> Floats:
        """Wheel torques (..., N, n) [N m]."""
        return np.asarray(controls @ self.mounting.to_wheel.T)

    def thrust(self, controls: Floats) -> Floats:
        """Torque of each thruster (..., N, m) [N m]."""
        return np.asarray(controls @ self.mounting.to_thrust.T)

    def body_torque(self, controls: Floats) -> Floats:
        """Torque on the wheels in body axes, (..., N, 3) [N m]."""
        return np.asarray(controls @ self.mounting.to_body.T)

    def external_torque(self, controls: Floats) -> Floats:
        """Torque of the thrusters in body axes, (..., N, 3) [N m]."""
        return np.asarray(controls @ self.mounting.to_external.T)

    def fly(self, controls: Floats) -> Trajectory:
        """Fly (S, N, b) torques on the full model with at least 20 substeps, then coast."""
        start, craft, table = self.start, self.craft, self.table
        torque = np.concatenate([self.wheel_torque(controls), self.thrust(controls)], axis=-1)
        return in_chunks(
            lambda chunk: _fly_many(craft, start, chunk, table),
            torque,
            key=("fly", torque.shape[1:], table.stages.gradient.shape),
        )

    def fly_pulses(self, pulses: Pulses, coarse: bool = False) -> Trajectory:
        """Fly openings of valves at their exact times on the full model, then coast.

        coarse : with few Runge-Kutta steps, for iterations; at least 20 an interval otherwise.
        """
        flown = _fly_pulses(
            self.craft,
            self.start,
            jnp.asarray(pulses.wheel_torque),
            jnp.asarray(pulses.opens),
            jnp.asarray(pulses.shuts),
            self.table,
            _COARSE_PIECES if coarse else MINIMUM_SUBSTEPS,
        )
        return jax.tree.map(np.asarray, flown)

    @property
    def tolerances(self) -> dict[str, float]:
        """Allowed errors at the end: "attitude" [rad] and "rate" [rad/s]."""
        return {"attitude": self.aim.attitude_tolerance, "rate": self.aim.rate_tolerance}

    def end_errors(self, q_ob: Floats | Array, omega_ob: Floats | Array) -> dict[str, Floats]:
        """Errors (S,) of flights (S, nodes, ...) at the end of the horizon, as `tolerances`."""
        end = self.intervals
        return {
            "attitude": _compared(self.aim.q_ob, q_ob[:, end])[0],
            "rate": np.linalg.norm(omega_ob[:, end] - self.aim.omega_ob, axis=-1),
        }

    def judge(self, flown: Trajectory, controls: Floats) -> Verdict:
        """Errors of a flight at the end of the horizon and at the waypoint."""
        end = self.intervals
        found, tolerances = self.end_errors(flown.q_ob, flown.omega_ob), self.tolerances
        if self.passage is not None:
            q = flown.q_ob[:, self.passage.node]
            found["waypoint"] = _compared(self.passage.q_ob, q)[0]
            tolerances["waypoint"] = self.passage.tolerance
        wheels, thrusters = self.craft.wheels, self.craft.thrusters
        wheel, thrust = self.wheel_torque(controls), self.thrust(controls)
        excess = np.concatenate(
            [
                np.abs(wheel) - np.asarray(wheels.torque_limit),
                np.maximum(thrust - np.asarray(thrusters.torque_limit), -thrust),
            ],
            axis=-1,
        )
        speed = np.abs(flown.omega_bw[:, : end + 1]) / np.asarray(wheels.speed_limit) - 1.0
        return Verdict(
            found,
            tolerances,
            np.maximum(0.0, excess.max(axis=(1, 2))),
            np.maximum(0.0, speed.max(axis=(1, 2), initial=-1.0)),
        )

    def verify(self, controls: Floats) -> tuple[Verdict, dict[str, Floats]]:
        """Fly the torques again on the full model and judge the flights."""
        flown = self.fly(controls)
        return self.judge(flown, controls), self.cost(flown, controls)

    def effort(self, controls: Floats) -> Floats:
        """Sum over intervals and body axes of |tau| h, (S,) [N m s]."""
        wheels = np.abs(self.body_torque(controls)).sum(axis=(-2, -1))
        pushes = np.abs(self.mounting.to_external).sum(axis=0)
        return np.asarray((wheels + (np.abs(controls) @ pushes).sum(axis=-1)) * self.step)

    def cost(self, flown: Trajectory, controls: Floats) -> dict[str, Floats]:
        """Parts of the printed cost, (5.3a), (5.5a), (5.7a), (5.9) or (5.14a), each (S,)."""
        w, end = self.goal.weights, self.intervals
        rate = flown.omega_ob[:, end] - self.aim.omega_ob
        parts = {
            "rate": w.rate * np.sum(rate**2, axis=-1),
            "attitude": w.attitude * _compared(self.aim.q_ob, flown.q_ob[:, end])[1],
        }
        if self.passage is not None:
            q = flown.q_ob[:, self.passage.node]
            parts["waypoint"] = w.waypoint * _compared(self.passage.q_ob, q)[1]
        if self.goal.kind == "l1":
            parts["l1"] = w.sparsity * self.slack_sum(controls)
        else:
            parts["sparsity"] = w.sparsity * self._support_cost(controls)
        if self.form.propelled and w.on_off > 0.0:
            parts["on_off"] = w.on_off * self._partly_open(controls)
        return parts

    def _partly_open(self, controls: Floats) -> Floats:
        """Sum of t (limit - t) over the thrusters of active intervals, or of idle ones, (S,).

        Kristiansen and Gravdahl (2023), eq. 11.  As printed the factor is xi, which is zero
        wherever a thruster fires; the text describes 1 - xi.
        """
        thrust = self.thrust(controls)
        xi = sparsity.complementarity_vector(controls, self.goal.epsilon, True)
        factor = xi if self.goal.weights.on_off_idle else 1.0 - xi
        partly = thrust * (np.asarray(self.craft.thrusters.torque_limit) - thrust)
        return np.asarray((factor * partly.sum(axis=-1)).sum(axis=-1))

    def _support_cost(self, controls: Floats) -> Floats:
        xi = sparsity.complementarity_vector(controls, self.goal.epsilon, self.shared)
        weight = np.asarray(self.arguments.weight)
        if not self.shared:
            weight = weight[:, None]
        support = weight * (1.0 - xi)
        cost = support.reshape(len(controls), -1).sum(axis=1)
        # Design 3 (5.15) counts 1 - (xi_1 + xi_2 + xi_3), less than design 2 by 2 an interval.
        return cost - 2.0 * self.intervals if self.goal.design == 3 else cost

    def long_way_probability(self) -> float:
        """From the rate changes that the two ways round ask for about the axis between attitudes.

        Half where both ask for the same, as for half a turn from rest; falling with the fourth
        power of their ratio.
        """
        turn = np.asarray(_turn(self.start.q_ob, self.aim.q_ob))
        angle = float(np.linalg.norm(turn))
        if angle == 0.0:
            return 0.0
        rate = float(self.departure.omega_ob @ turn) / angle
        duration = self.intervals * self.step
        short, long = angle / duration, (2.0 * np.pi - angle) / duration
        short_way, long_way = abs(short - rate) + short, abs(long + rate) + long
        return float(short_way**4 / (short_way**4 + long_way**4))
