"""First and second derivatives of one interval with wheels.

What an interval does to the attitude, q+ = q (x) dq, is differentiated forwards by the turn of the
body where momentum or external torques make it matter, by the rate that the wheels have taken, by
its slope, and by the total momentum and the dipole where they vary.  First derivatives are exact.
Second ones are those of two turns in succession, of the Magnus expansion's leading terms, and of
the panels and the wheels' power; those of external torques, which are small, are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.interval import Course, motion
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.sunlight import by_turn, collected
from jaxatt.problems.net_power.wheels.turn import added, multiplied, times
from jaxatt.simulation.momentum_model import Components, cross, matvec, to_body


class Kept(NamedTuple):
    """What the Hessian of an interval uses again; z is error state, then controls.

    turn : (3,), rotation vector of the interval, nearly.  chart : (3, 3), of the gap.
    back : (3, 3), R(dq)'.  turning : (3, z), turn at the end of the interval by z, other than that
    of the body itself.  sunlit : (6,), Hessian of the sunlight by the turn.
    spins : (2 r, z) [rad/s], wheel speeds of the power by z at both ends, or none.
    dipole : (3,) and by_dipole : (3, z) [A m^2], or none.
    """

    turn: Array
    chart: Array
    back: Array
    turning: Array
    sunlit: Array
    spins: Array
    rates: Array
    dipole: Array
    by_dipole: Array


def _chart(s: Components) -> list[list[Array]]:
    """Derivative (3, 3) of four times MRP s with respect to a small turn in body axes."""
    squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    none = jnp.zeros_like(squared)
    skew = [[none, -s[2], s[1]], [s[2], none, -s[0]], [-s[1], s[0], none]]
    return [
        [(1.0 - squared) * (i == j) + 2.0 * skew[i][j] + 2.0 * s[i] * s[j] for j in range(3)]
        for i in range(3)
    ]


def _back(q: Components) -> list[list[Array]]:
    """Rotation matrix R(q)'."""
    w, x, y, z = q
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


def _conjugate(q: Components) -> Components:
    return q[0], -q[1], -q[2], -q[3]


class _Directions:
    """Where the directions of differentiation stand: turn, lost rate, its slope, momentum, dipole.

    Each is there only where it matters.
    """

    def __init__(self, form: WheelsForm):
        self.form = form
        names = ["turn"] * (form.momentum != "zero") + ["lost", "slope"]
        names += ["total"] * form.torqued + ["dipole"] * (form.magnetorquers == "decided")
        self.first = {name: 3 * k for k, name in enumerate(names)}
        self.size = 3 * len(names)

    def moved(self, start: Course, by: Array) -> Course:
        """A course that is moved to first order, by (size,)."""

        def of(name: str) -> Components | None:
            first = self.first.get(name)
            return None if first is None else (by[first], by[first + 1], by[first + 2])

        momentum, attitude, dipole = start.momentum, start.attitude, start.dipole
        total, turn, decided = of("total"), of("turn"), of("dipole")
        if total is not None:
            momentum = added(momentum, to_body(attitude, total))
        if turn is not None:
            momentum = added(momentum, cross(momentum, turn))
            half = times(0.5, turn)
            none = jnp.zeros_like(half[0])
            change = multiplied(attitude, (none, *half))
            attitude = tuple(a + b for a, b in zip(attitude, change, strict=True))
        if decided is not None:
            dipole = added(dipole, decided)
        lost, slope = of("lost"), of("slope")
        assert lost is not None and slope is not None
        return Course(
            attitude, momentum, added(start.lost, lost), added(start.slope, slope), dipole
        )


class IntervalDerivatives:
    """First and second derivatives of the intervals of a form."""

    def __init__(self, form: WheelsForm):
        self.form = form
        self.directions = _Directions(form)

    def _row(
        self,
        turn: Array,
        stored: Array,
        controls: Array,
        *,
        total: Array | None = None,
        charge: Array | None = None,
        powers: Array | None = None,
        dipoles: Array | None = None,
    ) -> Array:
        """One row in z; parts that are None are zero."""
        form, dtype = self.form, turn.dtype
        blocks = [turn, stored]
        if form.torqued:
            blocks.append(jnp.zeros(3, dtype) if total is None else total)
        if form.charge:
            blocks.append(jnp.zeros(1, dtype) if charge is None else charge)
        blocks.append(controls)
        if form.powers:
            blocks.append(jnp.zeros(form.powers, dtype) if powers is None else powers)
        if form.dipoles:
            blocks.append(jnp.zeros(6, dtype) if dipoles is None else dipoles)
        return jnp.concatenate(blocks)

    def _by_z(self, tangent: Array, p: WheelsParameters, to_slope: Array) -> Array:
        """Derivative (z,) from those along the directions, (directions,)."""
        form, first = self.form, self.directions.first

        def of(name: str) -> Array:
            return tangent[first[name] : first[name] + 3]

        def through(name: str, matrix: Array) -> Array:
            found = of(name)
            return found[0] * matrix[0] + found[1] * matrix[1] + found[2] * matrix[2]

        dipoles = None
        if form.dipoles:
            by_dipole = of("dipole") * p.dipole_limit
            dipoles = jnp.concatenate([by_dipole, -by_dipole])
        return self._row(
            of("turn") if "turn" in first else jnp.zeros(3, tangent.dtype),
            through("lost", p.to_rate) if form.each else of("lost"),
            through("slope", to_slope),
            total=p.momentum_scale * of("total") if form.torqued else None,
            dipoles=dipoles,
        )

    def linearisation(
        self, x: Array, u: Array, x_next: Array, stage: WheelStage, p: WheelsParameters
    ) -> Linearisation:
        """See `OptimalControlProgram.linearisation`."""
        form, h, dtype = self.form, stage.step, x.dtype
        controls = at.split(u, form)
        start = at.course(x, u, p, form)
        nothing = jnp.zeros(self.directions.size, dtype)

        def moved(by: Array) -> tuple[Array, Array]:
            found = motion(self.directions.moved(start, by), h, stage.along, p, form)
            small = (*found.rate, *found.end_rate, *found.push, *found.dipole)
            return jnp.stack(found.turn), jnp.stack(small)

        (dq, small), (turned, changed) = jax.vmap(
            lambda way: jax.jvp(moved, (nothing,), (way,)), in_axes=0, out_axes=((None, None), 0)
        )(jnp.eye(self.directions.size, dtype=dtype))
        turn = (dq[0], dq[1], dq[2], dq[3])
        ahead = multiplied(at.quaternion(x), turn)
        missing = multiplied(_conjugate(at.quaternion(x_next)), ahead)
        sigma = times(1.0 / jnp.maximum(1.0 + missing[0], 1e-6), missing[1:])
        chart, back = _chart(sigma), _back(turn)
        rates = multiplied(_conjugate(turn), tuple(turned[:, i] for i in range(4)))[1:]
        to_slope = self._to_slope(p)
        turning = [self._by_z(2.0 * r, p, to_slope) for r in rates]
        k, rows = form.stored, []
        flat, still = jnp.zeros(3, dtype), jnp.zeros(k, dtype)
        whole = [
            turning[i] + self._row(jnp.stack(back[i]), still, jnp.zeros(form.wheels, dtype))
            for i in range(3)
        ]
        rows = [
            chart[i][0] * whole[0] + chart[i][1] * whole[1] + chart[i][2] * whole[2]
            for i in range(3)
        ]
        y, driven = at.stored(x, form), at.product(p.to_stored, controls.scaled)
        gap = [jnp.stack(times(4.0, sigma)), y + h * driven - at.stored(x_next, form)]
        own = jnp.eye(k, dtype=dtype)
        rows += [self._row(flat, own[i], h * p.to_stored[i]) for i in range(k)]
        if form.torqued:
            first = 4 + k
            pushed = small[6:9] / p.momentum_scale
            gap.append(x[first : first + 3] + pushed - x_next[first : first + 3])
            kept_total, idle = jnp.eye(3, dtype=dtype), jnp.zeros(form.wheels, dtype)
            rows += [
                self._by_z(changed[:, 6 + i] / p.momentum_scale, p, to_slope)
                + self._row(flat, still, idle, total=kept_total[i])
                for i in range(3)
            ]
        by_dipole = jnp.zeros((0, form.error_size + form.controls), dtype)
        if form.magnetorquers == "managing":
            by_dipole = jnp.stack([self._by_z(changed[:, 9 + i], p, to_slope) for i in range(3)])
        cost, by_cost, sunlit = self._cost(x, controls, stage, p, small[9:12], by_dipole)
        if form.charge:
            # The load only empties the battery.
            spent = cost + h * p.load / p.energy_scale
            gap.append((x[-1] - spent - x_next[-1])[None])
            idle = jnp.zeros(form.wheels, dtype)
            rows.append(self._row(flat, still, idle, charge=jnp.ones(1, dtype)) - by_cost)
        effort = 2.0 * p.step * p.effort / p.energy_scale * controls.scaled
        priced = by_cost + self._row(flat, still, effort)
        margins, slope, spins = self._margins(x, controls, h, small, changed, p, to_slope)
        scale = 4.0 / jnp.maximum(1.0 + dq[0], 1e-6)
        kept = Kept(
            scale * dq[1:],
            jnp.stack([jnp.stack(row) for row in chart]),
            jnp.stack([jnp.stack(row) for row in back]),
            jnp.stack(turning),
            sunlit,
            spins,
            jnp.stack([self._by_z(changed[:, i], p, to_slope) for i in range(6)]),
            small[9:12],
            by_dipole,
        )
        return Linearisation(jnp.concatenate(gap), jnp.stack(rows), priced, kept, margins, slope)

    def _cost(
        self,
        x: Array,
        controls: at.Controls,
        stage: WheelStage,
        p: WheelsParameters,
        dipole: Array,
        by_dipole: Array,
    ) -> tuple[Array, Array, Array]:
        """Cost of an interval without its effort, its slope (z,), and (6,) that of the sunlight."""
        form, dtype = self.form, x.dtype
        sun = to_body(at.quaternion(x), at.parts(stage.sun))
        found = collected(p.panels, sun, p.smoothing)
        gradient, hessian = by_turn(found, sun)
        weight = -stage.shone / p.energy_scale
        cost = weight * found.area
        none = jnp.zeros(form.wheels, dtype)
        powers = dipoles = None
        if form.powers:
            price = 0.5 * p.step * p.power_scale / p.energy_scale
            cost = cost + price * jnp.sum(controls.powers)
            powers = jnp.full(form.powers, 1.0, dtype) * price
        h = stage.step if form.magnetorquers == "managing" else p.step
        price, loss = h * p.dipole_price / p.energy_scale, h * p.dipole_loss / p.energy_scale
        if form.dipoles:
            each = price * p.dipole_limit
            decided = jnp.stack(at.dipole(controls, p, form))
            cost = cost + jnp.sum(jnp.concatenate([each, each]) * controls.dipoles)
            cost = cost + jnp.sum(loss * decided**2)
            lost = 2.0 * loss * decided * p.dipole_limit
            dipoles = jnp.concatenate([each + lost, each - lost])
        still = jnp.zeros(form.stored, dtype)
        slope = self._row(weight * jnp.stack(gradient), still, none, powers=powers, dipoles=dipoles)
        if form.magnetorquers == "managing":
            size = jnp.sqrt(dipole * dipole + p.rounding * p.rounding)
            cost = cost + jnp.sum(price * (size - p.rounding) + loss * dipole**2)
            share = price * dipole / size + 2.0 * loss * dipole
            slope = slope + share[0] * by_dipole[0] + share[1] * by_dipole[1]
            slope = slope + share[2] * by_dipole[2]
        return cost, slope, weight * jnp.stack(list(hessian.values()))

    def _margins(
        self,
        x: Array,
        controls: at.Controls,
        h: Array,
        small: Array,
        changed: Array,
        p: WheelsParameters,
        to_slope: Array,
    ) -> tuple[Array, Array, Array]:
        """Path inequalities, their slopes, and the slopes of the wheel speeds in them."""
        form, dtype = self.form, x.dtype
        width = form.error_size + form.controls
        margins, slopes = [], []
        spins = jnp.zeros((0, width), dtype)
        if form.powers:
            flat, still = jnp.zeros(3, dtype), jnp.zeros(form.stored, dtype)
            each = jnp.eye(form.wheels, dtype=dtype)
            own = jnp.eye(form.stored, dtype=dtype)
            torque = p.torque_limit * controls.scaled
            pushed = at.product(p.axes, torque)
            powers, by_power, turning = [], [], []
            for late in range(2):
                part = late * h
                y = at.stored(x, form) + part * at.product(p.to_stored, controls.scaled)
                omega = at.parts(small[3 * late : 3 * late + 3])
                speeds = at.wheel_speeds(y, omega, p, form)
                by_rate = [self._by_z(changed[:, 3 * late + i], p, to_slope) for i in range(3)]
                by_y = jnp.stack(
                    [self._row(flat, own[i], part * p.to_stored[i]) for i in range(form.stored)]
                )
                by_z = jax.vmap(
                    lambda dy, a, b, c: at.wheel_speeds(dy, (a, b, c), p, form),
                    in_axes=(1, 0, 0, 0),
                    out_axes=1,
                )(by_y, *by_rate)
                turning.append(by_z)
                powers.append(at.wheel_power(y, omega, controls.scaled, p, form))
                if form.power == "body":
                    by = pushed[0] * by_z[0] + pushed[1] * by_z[1] + pushed[2] * by_z[2]
                    direct = at.product(p.axes.T, speeds) * p.torque_limit
                    by_power.append((by + self._row(flat, still, direct)) / p.power_scale)
                    continue
                for i in range(form.wheels):
                    direct = p.torque_limit[i] * speeds[i] * each[i]
                    by = torque[i] * by_z[i] + self._row(flat, still, direct)
                    by_power.append(by / p.power_scale)
            power, spins = jnp.concatenate(powers), jnp.concatenate(turning)
            which = jnp.eye(form.powers, dtype=dtype)
            for i in range(form.powers):
                paid = self._row(flat, still, 0.0 * torque, powers=which[i])
                margins += [
                    controls.powers[i] - p.taken * power[i],
                    controls.powers[i] + p.returned * power[i],
                ]
                slopes += [paid - p.taken * by_power[i], paid + p.returned * by_power[i]]
        if form.charge:
            margins.append(x[-1] - p.floor)
            idle = jnp.zeros(form.wheels, dtype)
            still = jnp.zeros(form.stored, dtype)
            one = jnp.ones(1, dtype)
            slopes.append(self._row(jnp.zeros(3, dtype), still, idle, charge=one))
        if not margins:
            return jnp.zeros(0, dtype), jnp.zeros((0, width), dtype), spins
        return jnp.stack(margins), jnp.stack(slopes), spins

    def lagrangian_hessian(
        self,
        x: Array,
        u: Array,
        x_next: Array,
        stage: WheelStage,
        p: WheelsParameters,
        costate: Array,
        kept: Any,
    ) -> Array:
        """See `OptimalControlProgram.lagrangian_hessian`.

        Sums of products of two rows in z each, of which the transpose is added: turns a and b in
        succession make a + b + (a x b) / 2; the turn of an interval bends by a twelfth of h^3 omega
        x omega', by the exponential's own curvature, and by what the total momentum adds.
        """
        form, h = self.form, stage.step
        width, first = form.error_size + form.controls, form.error_size
        none = jnp.zeros_like(h)
        # What is paid: the charge's costate pays for the cost once more.
        paid = 1.0 - costate[form.error_size - 1] if form.charge else 1.0 + none
        force = at.parts(at.product(kept.chart.T, costate[:3]))
        turn = at.parts(kept.turn)
        turning = tuple(kept.turning[i] for i in range(3))
        idle = jnp.zeros(form.wheels, costate.dtype)
        still, flat = jnp.zeros(form.stored, costate.dtype), jnp.zeros(3, costate.dtype)
        # Of the exponential: (b x (turn x b)) / 12.
        along = _dot(force, turn) / 6.0
        bend = [
            [along * (i == j) - (force[i] * turn[j] + turn[i] * force[j]) / 12.0 for j in range(3)]
            for i in range(3)
        ]
        half = times(0.5, force)
        by_turn = _times_rows(kept.back.T, cross(turning, half))
        curved = [kept.sunlit[k] * paid for k in range(6)]
        # The rotation vector's own second order, seen from the end of the interval.
        pressed = added(force, cross(turn, half))
        change = tuple(kept.rates[3 + i] - kept.rates[i] for i in range(3))
        if form.momentum != "zero":
            q = at.quaternion(x)
            total = to_body(q, at.total_momentum(x, p, form))
            omega = at.rate_of(x, total, p, form)
            pull = matvec(p.inverse, pressed)
            tilt = added(cross(omega, pull), matvec(p.inverse, cross(pull, total)))
            early = added(times(h, pull), times(0.5 * h * h, tilt))
            middle = added(times(0.5 * h, pull), times(0.125 * h * h, tilt))
            twist = times(h * h / 12.0, matvec(p.inverse, cross(pressed, omega)))
            far = times(h, added(times(2.0 / 3.0, middle), twist))
            first_rate = tuple(kept.rates[i] for i in range(3))
            late = cross(added(first_rate, times(0.5, change)), far)
            # By the momentum that a turned body sees to second order, phi x (phi x H) / 2.
            level = _dot(early, total)
            seen = added(
                times(h / 6.0, cross(first_rate, early)), late, times(0.5 * h, cross(omega, late))
            )
            by_turn = added(by_turn, cross(seen, total))
            if form.torqued:
                carried = self._carried(q, p)
                # A change of the total momentum is seen from a body that turned.
                by_turn = added(by_turn, cross(early, carried))
            stiff = 0.5 * _inverse(h)
            for i in range(3):
                for j in range(3):
                    mixed = far[i] * total[j] + total[i] * far[j]
                    bend[i][j] = bend[i][j] + stiff * (mixed - 2.0 * _dot(far, total) * (i == j))
            for k, (i, j) in enumerate(_PAIRS):
                value = 0.5 * (early[i] * total[j] + total[i] * early[j])
                curved[k] = curved[k] + (value - level if i == j else value)
        wound = times(h / 12.0, cross(change, pressed))
        by_bend = [
            0.5 * (bend[i][0] * turning[0] + bend[i][1] * turning[1] + bend[i][2] * turning[2])
            + wound[i]
            for i in range(3)
        ]
        total_half = _outer(turning, by_bend)
        if form.torqued:
            total_half = total_half + _outer(carried, seen)
        if form.magnetorquers == "managing":
            size = jnp.sqrt(kept.dipole**2 + p.rounding**2)
            price = p.dipole_price * p.rounding**2 / (size * size * size)
            weight = 0.5 * paid * h / p.energy_scale * (price + 2.0 * p.dipole_loss)
            by = tuple(kept.by_dipole[i] for i in range(3))
            total_half = total_half + _outer(by, [weight[i] * by[i] for i in range(3)])
        facing = [[curved[_PLACE[min(i, j), max(i, j)]] * 0.5 for j in range(3)] for i in range(3)]
        rows = [by_turn[i] + self._row(jnp.stack(facing[i]), still, idle) for i in range(3)]
        zeros = jnp.zeros((width - 3, width), costate.dtype)
        total_half = total_half + jnp.concatenate([jnp.stack(rows), zeros])
        priced = self._row(flat, still, idle + p.step * p.effort / p.energy_scale)
        total_half = total_half + jnp.eye(width, dtype=costate.dtype) * priced[None]
        if form.dipoles:
            lost = paid * p.step * p.dipole_loss * p.dipole_limit**2 / p.energy_scale
            place = first + form.wheels + form.powers
            for i in range(3):
                way = jnp.zeros(width, costate.dtype).at[place + i].set(1.0)
                way = way.at[place + 3 + i].set(-1.0)
                total_half = total_half + lost[i] * way[:, None] * way[None, :]
        return total_half + total_half.T

    def _carried(self, q: Components, p: WheelsParameters) -> Components:
        """Momentum in body axes by the total one where that is carried, three rows in z."""
        form, dtype = self.form, q[0].dtype
        flat, still = jnp.zeros(3, dtype), jnp.zeros(form.stored, dtype)
        idle, own = jnp.zeros(form.wheels, dtype), p.momentum_scale * jnp.eye(3, dtype=dtype)
        rows = tuple(self._row(flat, still, idle, total=own[i]) for i in range(3))
        return to_body(q, rows)

    def _to_slope(self, p: WheelsParameters) -> Array:
        """Slope of the lost rate by the scaled torques, (3, n)."""
        return _matrix_product(p.to_rate, p.to_stored) if self.form.each else p.to_stored

    def path_hessian(
        self, x: Array, u: Array, stage: WheelStage, p: WheelsParameters, dual: Array, kept: Any
    ) -> Array:
        """See `OptimalControlProgram.path_hessian`: of the wheels' power, bilinear in torques and
        speeds.
        """
        form, dtype = self.form, dual.dtype
        width = form.error_size + form.controls
        if not form.powers:
            return jnp.zeros((width, width), dtype)
        weight = [
            (dual[2 * i + 1] * p.returned - dual[2 * i] * p.taken) / p.power_scale
            for i in range(form.powers)
        ]
        flat, still = jnp.zeros(3, dtype), jnp.zeros(form.stored, dtype)
        if form.power == "body":
            pushed = [self._row(flat, still, p.axes[k] * p.torque_limit) for k in range(3)]
            felt = [weight[0] * kept.spins[k] + weight[1] * kept.spins[3 + k] for k in range(3)]
        else:
            own, n = jnp.eye(form.wheels, dtype=dtype), form.wheels
            pushed = [self._row(flat, still, own[k] * p.torque_limit[k]) for k in range(n)]
            felt = [weight[k] * kept.spins[k] + weight[n + k] * kept.spins[n + k] for k in range(n)]
        half = _outer(pushed, felt)
        return half + half.T


_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_PLACE = {pair: k for k, pair in enumerate(_PAIRS)}


def _outer(a: Sequence[Array], b: Sequence[Array]) -> Array:
    """Sum of the products of the rows of a and of b, (z, z)."""
    total = a[0][:, None] * b[0][None]
    for left, right in zip(a[1:], b[1:], strict=True):
        total = total + left[:, None] * right[None]
    return total


def _times_rows(matrix: Array, rows: Components) -> Components:
    """Product of a matrix (3, 3) with three rows."""
    return tuple(
        matrix[i, 0] * rows[0] + matrix[i, 1] * rows[1] + matrix[i, 2] * rows[2] for i in range(3)
    )


def _inverse(value: Array) -> Array:
    """Inverse, or 0 of an interval without length."""
    there = value > 0.0
    return jnp.where(there, 1.0 / jnp.where(there, value, 1.0), 0.0)


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _matrix_product(a: Array, b: Array) -> Array:
    """Product of small matrices as a sum of rank-one products."""
    total = a[:, :1] * b[:1]
    for k in range(1, a.shape[1]):
        total = total + a[:, k : k + 1] * b[k : k + 1]
    return total
