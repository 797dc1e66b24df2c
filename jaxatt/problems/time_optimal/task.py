"""Task of a reorientation in free time: arguments for the solver, judgement of answers."""

from __future__ import annotations

import copy
import functools
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.attitude import errors, mrp
from jaxatt.attitude.host_turns import conjugate, product
from jaxatt.environment.table import EnvironmentTable, Surroundings, environment_at, tabulate
from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.motor_torques import in_shares, motor_excess
from jaxatt.problems.pointing.case import FREE, Pointing
from jaxatt.problems.pointing.cones import PointingLimits, cone_angles
from jaxatt.problems.pointing.watch import ObservedPath
from jaxatt.problems.time_optimal.actuation import actuation
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.problems.time_optimal.reorientation import ReorientationForm, reorientation
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import overstay, speed_excess, speed_range
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import in_chunks, rows_of_flights
from jaxatt.runtime.settings import QUICK_TO_COMPILE
from jaxatt.simulation.flight import MINIMUM_SUBSTEPS, Trajectory, advance, fly_torque
from jaxatt.simulation.flight_error import fly_in_pieces, judging_steps
from jaxatt.simulation.free_body import BodyForm, FreeBody
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.scale import inertia_unit, least_torque_limit
from jaxatt.spacecraft.vehicle import Spacecraft, total_momentum
from jaxatt.spacecraft.wheel_bias import bias_of, null_momenta

_LARGEST_MRP = 3.0
"""Norm beyond which the solver's MRP change sets: 286 deg from where they are zero."""
_AT_REST = 1e-12
"""[rad, rad/s] Turn and rates that count as none, and the total momentum over the inertia."""


@dataclass(frozen=True)
class TimeGoal:
    """Objective and transcription of a reorientation.

    effort_weight : rho [1/(N m)^2]; 0 for the least time.
    attitude : "quaternion" or "mrp".  integration : "rk4" or "euler".
    substeps : an interval; None where their number follows from what turns.
    shortest, longest : [s], limits of the final time.
    """

    effort_weight: float
    attitude: str = "quaternion"
    integration: str = "rk4"
    substeps: int | None = None
    shortest: float = 0.0
    longest: float = np.inf


@functools.partial(jax.jit, compiler_options=QUICK_TO_COMPILE)
def _fly_many(
    craft: Spacecraft, start: AttitudeState, torque: Array, table: EnvironmentTable, h: Array
) -> Trajectory:
    def one(torque: Array, h: Array) -> Trajectory:
        return fly_torque(craft, start, torque, replace(table, substep=h))

    return jax.vmap(one)(torque, h)


@functools.partial(jax.jit, static_argnames=("steps",))
def _fly_on(
    craft: Spacecraft, state: AttitudeState, torque: Array, h: Array, steps: int
) -> AttitudeState:
    here = environment_at(_INERTIAL, jnp.zeros(4))

    def one(state: AttitudeState, _: None) -> tuple[AttitudeState, None]:
        return advance(craft, state, lambda *_: torque, here, h)[0], None

    return lax.scan(one, state, None, length=steps)[0]


_angle = jax.jit(errors.angle)
_angles = jax.jit(cone_angles)


class ReorientationTask:
    """Turn from one attitude to another in free time, relative to the inertial frame.

    craft : vehicle.  initial_state, target : where it begins and ends.  intervals : N.
    unit : [kg m^2], in which the programme counts inertias, and with them torques and momenta.
    """

    def __init__(
        self,
        craft: Spacecraft,
        initial_state: InitialState,
        target: Target,
        intervals: int,
        goal: TimeGoal,
        pointing: Pointing = FREE,
    ):
        # Of q and -q the one whose MRP are the shorter turn; ways round are told apart from there.
        q = np.asarray(initial_state.q_ob)
        initial_state = replace(initial_state, q_ob=-q if q[0] < 0.0 else q)
        # Where the roll is free, the one that is nearest is what rolls are told from.
        target = target.facing(initial_state.q_ob)
        self.craft, self.initial_state, self.target = craft, initial_state, target
        self.intervals, self.goal = intervals, goal
        self.pointing = pointing
        self.directions = pointing.directions(np.zeros(1))[0]
        self.actuation, self.unit = actuation(craft), inertia_unit(craft)
        wheels = craft.wheels
        self.start = AttitudeState(
            jnp.asarray(initial_state.q_ob),
            jnp.asarray(initial_state.omega_ob),
            jnp.asarray(initial_state.omega_bw),
        )
        momentum = np.asarray(total_momentum(craft, initial_state.omega_ob, initial_state.omega_bw))
        self.form = ReorientationForm(
            BodyForm(
                goal.attitude,
                goal.integration,
                "own" if not wheels.count else self._momentum_form(momentum),
                goal.substeps or 1,
                _LARGEST_MRP,
            ),
            shortest_limited=goal.shortest > 0.0,
            longest_limited=bool(np.isfinite(goal.longest)),
            speed_limited=wheels.has_speed_limits,
            motor_limited=not wheels.motors.ideal,
            biased=target.wheel_bias is not None,
            cones=len(pointing.cones),
            rate_limited=pointing.rate_limit is not None,
        )
        self.program = reorientation(self.form, self.actuation.size)
        self.momentum = momentum
        self.parameters = self._parameters()

    def _momentum_form(self, momentum: Floats) -> str:
        still = self._moves_by(momentum) <= _AT_REST and not self.craft.thrusters.count
        return "zero" if still else "carried"

    def _moves_by(self, momentum: Floats) -> float:
        """Rate [rad/s] that a momentum (3,) [N m s] would be of a mean axis."""
        return float(np.linalg.norm(momentum)) / self.unit

    def _parameters(self) -> ReorientationParameters:
        craft, wheels, a = self.craft, self.craft.wheels, self.actuation
        q = np.asarray(self.initial_state.q_ob)
        attitude = np.asarray(mrp.from_quaternion(q)) if self.form.body.attitude == "mrp" else q
        begin = [attitude, self.initial_state.omega_ob]
        if self.form.body.momentum == "carried":
            begin.append(self.momentum / self.unit)
        goal, unit, bias = self.goal, self.unit, self.target.wheel_bias
        slowest, fastest = speed_range(wheels, self.initial_state.omega_bw)
        return ReorientationParameters(
            body=FreeBody(
                jnp.asarray(craft.inertia / unit),
                jnp.asarray(unit * np.linalg.inv(np.asarray(craft.inertia_without_spin))),
            ),
            start=jnp.asarray(np.concatenate(begin)),
            step=jnp.asarray(1.0),
            share=jnp.ones(self.intervals),
            reference=jnp.asarray(self.reference(1.0)),
            reference_rate=jnp.asarray(self.target.omega_ob),
            held=jnp.asarray(self.target.held),
            to_body=jnp.asarray(a.to_body / unit),
            to_external=jnp.asarray(a.to_external / unit),
            lower=jnp.asarray(a.lower),
            upper=jnp.asarray(a.upper),
            scale=jnp.asarray(a.scale),
            effort_weight=jnp.asarray(goal.effort_weight),
            shortest=jnp.asarray(goal.shortest),
            longest=jnp.asarray(goal.longest),
            limits=self.limits(np.zeros(len(self.pointing.cones) + 1)),
            directions=jnp.asarray(self.directions),
            wheel_speed=jnp.asarray(self.initial_state.omega_bw),
            wheel_axes=jnp.asarray(wheels.axes),
            wheel_inertia=jnp.asarray(wheels.inertia / unit),
            to_wheels=jnp.asarray(a.to_wheels / unit),
            speed_lower=jnp.asarray(slowest),
            speed_upper=jnp.asarray(fastest),
            null_momenta=jnp.asarray(null_momenta(wheels).T if wheels.count else np.zeros((0, 0))),
            wheel_bias=jnp.zeros(wheels.count) if bias is None else jnp.asarray(bias),
            wheel_limit=jnp.asarray(wheels.torque_limit / unit),
            motors=in_shares(wheels),
            motor_limit=jnp.ones(wheels.count),
        )

    @property
    def measures_substeps(self) -> bool:
        """Whether the number of steps an interval is free; Euler steps stay as they are printed."""
        return self.goal.substeps is None and self.goal.integration == "rk4"

    def with_substeps(self, substeps: int) -> ReorientationTask:
        """The same turn with so many steps of the integration an interval."""
        other = copy.copy(self)
        other.form = replace(self.form, body=replace(self.form.body, substeps=substeps))
        other.program = reorientation(other.form, self.actuation.size)
        return other

    def aiming_at(self, targets: Floats) -> ReorientationTask:
        """The same turn to another target q_ob (4,), or a batch whose rows have their own (S, 4).

        Starts and what judges answers follow; the programme takes its target from the start.
        """
        other = copy.copy(self)
        other.__dict__.pop("_relative", None)
        other.target = replace(self.target, q_ob=targets)
        return other

    def weighing(self, effort_weight: float) -> ReorientationTask:
        """The same turn with another weight of effort, rho [1/(N m)^2]."""
        other = copy.copy(self)
        other.goal = replace(self.goal, effort_weight=effort_weight)
        other.parameters = replace(self.parameters, effort_weight=jnp.asarray(effort_weight))
        return other

    def limits(self, constraint_margin: Floats) -> PointingLimits:
        """Cones and rates for the solver, tightened by the margin; see `Pointing.path`."""
        return self.pointing.path(self.directions[None], constraint_margin).limits

    @functools.cached_property
    def _relative(self) -> Floats:
        """Attitude (4,) of the target relative to the start."""
        begin, end = np.asarray(self.initial_state.q_ob), np.asarray(self.target.q_ob)
        return product(conjugate(begin), end)

    def turn(self, sign: float) -> Floats:
        """MRP (3,) of the target relative to the start, the short (1) or the long way (-1)."""
        relative = self._relative * (sign if self._relative[0] >= 0.0 else -sign)
        if 1.0 + relative[0] < _AT_REST:
            return np.zeros(3)  # a whole turn, which no MRP holds and nobody wants
        return np.asarray(relative[1:] / (1.0 + relative[0]))

    def reference(self, sign: float) -> Floats:
        """The target attitude in the programme's coordinates, for the short or the long way."""
        sigma = self.turn(sign)
        squared = float(sigma @ sigma)
        relative = np.concatenate([[1.0 - squared], 2.0 * sigma]) / (1.0 + squared)
        end = product(np.asarray(self.initial_state.q_ob), relative)
        if self.form.body.attitude == "mrp":
            return np.asarray(mrp.from_quaternion(end, short=False))
        return end

    @property
    def in_motion(self) -> bool:
        """Whether the body turns at the start or the target, or its wheels store momentum."""
        rates = np.concatenate([self.initial_state.omega_ob, self.target.omega_ob])
        return bool(np.any(rates != 0.0) or self._moves_by(self.momentum) > _AT_REST)

    @property
    def at_target(self) -> bool:
        """Whether the start is already the target, to rounding."""
        turned = float(np.linalg.norm(self.turn(1.0)))
        moved = np.abs(
            np.asarray(self.target.omega_ob) - np.asarray(self.initial_state.omega_ob)
        ).max()
        return turned < _AT_REST and float(moved) < _AT_REST

    def torques(self, u: Floats) -> Floats:
        """Torques of wheels and thrusters, (S, N, n + m) [N m], of scaled controls."""
        return self.actuation.torques(u)

    @property
    def flight_steps(self) -> int:
        """Runge-Kutta steps an interval of a flight."""
        return judging_steps(self.form.body.substeps)

    @property
    def watches(self) -> bool:
        """Whether the way has limits, so that flights are judged between the nodes."""
        limited = self.form.speed_limited or self.form.motor_limited
        return bool(self.pointing) or limited

    @property
    def nodes_between(self) -> int:
        """Nodes an interval at which flights are judged: many where the way has limits."""
        return MINIMUM_SUBSTEPS if self.watches else 1

    def fly(
        self, torque: Floats, step: Floats, between: int | None = None, times: int = 1
    ) -> Trajectory:
        """Fly torques (S, N, n + m) [N m] held for steps (S,) [s], at least 20 RK4 steps each.

        between : nodes of the flight an interval; `nodes_between` by default.
        times : how many times as many RK4 steps; a single flight then runs the same program, in
        pieces.
        """
        between = between or self.nodes_between
        pieces = times if len(torque) == 1 else 1
        substeps = -(-self.flight_steps // between) * (times // pieces)
        fine = np.repeat(torque, between, axis=1)
        table = tabulate(_INERTIAL, 0.0, 1.0, fine.shape[1], substeps)
        h = np.broadcast_to(np.asarray(step, float), (len(torque),)) / (between * substeps * pieces)
        craft = self.craft

        def run(start: AttitudeState, rows: Floats) -> Trajectory:
            flown: Trajectory = in_chunks(
                lambda chunk: _fly_many(craft, start, chunk[0], table, chunk[1]),
                (rows, h),
                rows_of_flights(len(rows)),
                key=("fly reorientation", rows.shape[1:], substeps),
            )
            return flown

        if pieces == 1:
            return run(self.start, fine)
        parts = np.repeat(fine[0], pieces, axis=0)
        return fly_in_pieces(lambda x, rows, _: run(x, rows[None]), self.start, parts, pieces)

    def fly_on(
        self, state: AttitudeState, torque: Floats, duration: float, steps: int
    ) -> AttitudeState:
        """State after torques (n + m,) [N m] held for a duration [s], in `steps` RK4 steps."""
        return _fly_on(self.craft, state, torque, duration / steps, steps)

    def angle_to_target(self, q: Floats) -> float:
        """Angle [rad] between an attitude (4,) and the target."""
        return float(_angle(self.target.facing(q).q_ob, q))

    @property
    def tolerances(self) -> dict[str, float]:
        """Allowed errors at the end: "attitude" [rad], "rate" [rad/s], "wheel bias" [rad/s]."""
        allowed = {"attitude": self.target.attitude_tolerance, "rate": self.target.rate_tolerance}
        if self.form.biased:
            allowed["wheel bias"] = self.target.bias_tolerance
        return allowed

    def between_nodes(self, step: Floats | float) -> Floats:
        """Time [s] between two nodes of flights with intervals of `step` [s]."""
        return np.asarray(step) / self.nodes_between

    def judge(self, flown: Trajectory, torque: Floats, step: Floats) -> Verdict:
        """Judge the errors of flights at their end, and the limits at all of their nodes.

        flown, torque, step : as `fly` has them.
        """
        wheels, thrusters, n = self.craft.wheels, self.craft.thrusters, self.craft.wheels.count
        q = np.asarray(flown.q_ob)
        target = self.target.facing(q[:, -1])
        found = {
            "attitude": np.asarray(_angle(target.q_ob, q[:, -1])),
            "rate": np.linalg.norm(np.asarray(flown.omega_ob)[:, -1] - target.omega_ob, axis=-1),
        }
        if self.target.wheel_bias is not None:
            ended = np.asarray(flown.omega_bw)[:, -1]
            missed = [bias_of(wheels, one) - self.target.wheel_bias for one in ended]
            found["wheel bias"] = np.abs(missed).max(axis=1)
        wheel, thrust = torque[..., :n], torque[..., n:]
        excess = np.concatenate(
            [
                np.abs(wheel) - np.asarray(wheels.torque_limit),
                np.maximum(thrust - np.asarray(thrusters.torque_limit), -thrust),
            ],
            axis=-1,
        )
        worst = [np.zeros(len(q))]
        worst.append(speed_excess(wheels, flown.omega_bw).max(axis=1, initial=-1.0))
        worst.append(motor_excess(wheels, wheel, flown.omega_bw).max(axis=1, initial=0.0))
        worst.append(overstay(wheels, flown.omega_bw, self.between_nodes(step)))
        if self.pointing:
            worst.append(self.watch(flown).violation)
        return Verdict(
            found,
            self.tolerances,
            np.maximum(0.0, excess.max(axis=(1, 2), initial=0.0)),
            np.max(worst, axis=0),
            least_torque_limit(self.craft),
        )

    def watch(self, flown: Trajectory) -> ObservedPath:
        """Angles of all cones and rates at the nodes of flights."""
        q = np.asarray(flown.q_ob)
        shape = (*q.shape[:2], *self.directions.shape)
        boresights = np.reshape([cone.boresight for cone in self.pointing.cones], (-1, 3))
        angles = in_chunks(
            lambda chunk: _angles(
                chunk, np.broadcast_to(self.directions, (len(chunk), *shape[1:])), boresights
            ),
            q,
            key=("cone angles", shape[1:]),
        )
        return ObservedPath(self.pointing, angles, np.abs(np.asarray(flown.omega_ib)))

    def quadratic_effort(self, torque: Floats, step: Floats) -> Floats:
        """Integral of the sum of squared torques, (S,) [(N m)^2 s]."""
        return np.asarray((torque**2).sum(axis=(-2, -1)) * step)

    def cost(self, torque: Floats, step: Floats) -> Floats:
        """Final time and weighted effort, (S,) [s]; eq. (22) of the source with all N terms."""
        return self.intervals * step + self.goal.effort_weight * self.quadratic_effort(torque, step)


# NumPy, not JAX: an array made at import would start the backend before `configure` has set it up.
_INERTIAL = Surroundings(None, *(np.asarray(x) for x in (0.0, 0.0, 0.0)))  # type: ignore[arg-type]
