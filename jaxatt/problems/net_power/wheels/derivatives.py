"""First and second derivatives of one interval with wheels.

What an interval does to the attitude, q+ = q (x) dq, is differentiated forwards by the turn of the
body where momentum or external torques make it matter, by the rate that the wheels have taken, by
its slope, and by the total momentum and the dipole where they vary.  First derivatives are exact.
Second ones are those of two turns in succession, of the Magnus expansion's leading terms, and of
the panels and the wheels' power; those of external torques, which are small, are left out.
"""

from __future__ import annotations

from collections.abc import Callable
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
    spins : (r, z) [rad/s], wheel speeds of the power by z, or none.
    dipole : (3,) and by_dipole : (3, z) [A m^2], or none.
    """

    turn: Array
    chart: Array
    back: Array
    turning: Array
    sunlit: Array
    spins: Array
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
        form, h, dtype = self.form, p.step, x.dtype
        controls = at.split(u, form)
        start = at.course(x, u, p, form)
        nothing = jnp.zeros(self.directions.size, dtype)

        def moved(by: Array) -> tuple[Array, Array]:
            found = motion(self.directions.moved(start, by), h, stage.along, p, form)
            small = (*found.mean_rate, *found.push, *found.dipole)
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
        to_slope = p.to_stored if not form.each else _matrix_product(p.to_rate, p.to_stored)
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
            pushed = small[3:6] / p.momentum_scale
            gap.append(x[first : first + 3] + pushed - x_next[first : first + 3])
            kept_total, idle = jnp.eye(3, dtype=dtype), jnp.zeros(form.wheels, dtype)
            rows += [
                self._by_z(changed[:, 3 + i] / p.momentum_scale, p, to_slope)
                + self._row(flat, still, idle, total=kept_total[i])
                for i in range(3)
            ]
        by_dipole = jnp.zeros((0, form.error_size + form.controls), dtype)
        if form.magnetorquers == "managing":
            by_dipole = jnp.stack([self._by_z(changed[:, 6 + i], p, to_slope) for i in range(3)])
        cost, by_cost, sunlit = self._cost(x, controls, stage, p, small[6:9], by_dipole)
        if form.charge:
            # The load only empties the battery.
            spent = cost + h * p.load / p.energy_scale
            gap.append((x[-1] - spent - x_next[-1])[None])
            idle = jnp.zeros(form.wheels, dtype)
            rows.append(self._row(flat, still, idle, charge=jnp.ones(1, dtype)) - by_cost)
        effort = 2.0 * h * p.effort / p.energy_scale * controls.scaled
        priced = by_cost + self._row(flat, still, effort)
        margins, slope, spins = self._margins(x, controls, small, changed, p, to_slope)
        scale = 4.0 / jnp.maximum(1.0 + dq[0], 1e-6)
        kept = Kept(
            scale * dq[1:],
            jnp.stack([jnp.stack(row) for row in chart]),
            jnp.stack([jnp.stack(row) for row in back]),
            jnp.stack(turning),
            sunlit,
            spins,
            small[6:9],
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
        form, h, dtype = self.form, p.step, x.dtype
        sun = to_body(at.quaternion(x), at.parts(stage.sun))
        found = collected(p.panels, sun, p.smoothing)
        gradient, hessian = by_turn(found, sun)
        weight = -stage.shone / p.energy_scale
        cost = weight * found.area
        none = jnp.zeros(form.wheels, dtype)
        powers = dipoles = None
        if form.powers:
            price = h * p.power_scale / p.energy_scale
            cost = cost + price * jnp.sum(controls.powers)
            powers = jnp.full(form.powers, 1.0, dtype) * price
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
        small: Array,
        changed: Array,
        p: WheelsParameters,
        to_slope: Array,
    ) -> tuple[Array, Array, Array]:
        """Path inequalities, their slopes, and the slopes of the wheel speeds in them."""
        form, h, dtype = self.form, p.step, x.dtype
        width = form.error_size + form.controls
        margins, slopes = [], []
        spins = jnp.zeros((0, width), dtype)
        if form.powers:
            half = 0.5 * h
            y = at.stored(x, form) + half * at.product(p.to_stored, controls.scaled)
            mean = at.parts(small)
            power = at.wheel_power(y, mean, controls.scaled, p, form)
            by_rate = [self._by_z(changed[:, i], p, to_slope) for i in range(3)]
            own = jnp.eye(form.stored, dtype=dtype)
            flat = jnp.zeros(3, dtype)
            by_y = jnp.stack(
                [self._row(flat, own[i], half * p.to_stored[i]) for i in range(form.stored)]
            )
            by_z = jax.vmap(
                lambda dy, a, b, c: at.wheel_speeds(dy, (a, b, c), p, form),
                in_axes=(1, 0, 0, 0),
                out_axes=1,
            )(by_y, *by_rate)
            spins = by_z
            speeds = at.wheel_speeds(y, mean, p, form)
            torque = p.torque_limit * controls.scaled
            still = jnp.zeros(form.stored, dtype)
            which = jnp.eye(form.powers, dtype=dtype)
            each = jnp.eye(form.wheels, dtype=dtype)
            for i in range(form.powers):
                if form.power == "body":
                    pushed = at.product(p.axes, torque)
                    by = sum(pushed[k] * by_z[k] for k in range(3))
                    own_torque = at.product(p.axes.T, speeds) * p.torque_limit
                else:
                    by = torque[i] * by_z[i]
                    own_torque = p.torque_limit[i] * speeds[i] * each[i]
                by = (by + self._row(flat, still, own_torque)) / p.power_scale
                paid = self._row(flat, still, 0.0 * torque, powers=which[i])
                margins += [
                    controls.powers[i] - p.taken * power[i],
                    controls.powers[i] + p.returned * power[i],
                ]
                slopes += [paid - p.taken * by, paid + p.returned * by]
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
        """See `OptimalControlProgram.lagrangian_hessian`."""
        form, h = self.form, p.step
        none = jnp.zeros_like(h)
        # What is paid: the charge's costate pays for the cost once more.
        paid = 1.0 - costate[form.error_size - 1] if form.charge else 1.0 + none
        chart = kept.chart
        force = tuple(sum(costate[k] * chart[k, i] for k in range(3)) for i in range(3))
        found: dict[tuple[int, int], Array] = {}

        def add(i: int, j: int, value: Array) -> None:
            key = (min(i, j), max(i, j))
            found[key] = found[key] + value if key in found else value

        pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        for k, (i, j) in enumerate(pairs):
            add(i, j, paid * kept.sunlit[k])
        # Two turns in succession: to second order their vectors add, and half their product.
        width = form.error_size + form.controls
        first = form.error_size
        columns = [*range(3)] if form.momentum != "zero" else []
        columns += [*range(3, 3 + form.stored), *range(first, first + form.wheels)]
        for j in columns:
            moved = at.parts(kept.turning[:, j])
            crossed = cross(moved, force)
            for i in range(3):
                back = at.parts(kept.back[:, i])
                value = 0.5 * (back[0] * crossed[0] + back[1] * crossed[1] + back[2] * crossed[2])
                add(i, j, 2.0 * value if i == j else value)
        if form.momentum != "zero":
            self._add_momentum(add, x, force, p)
        # The turn's own bending, and the expansion's leading product of rate and slope.
        turn = at.parts(kept.turn)
        along = sum(f * t for f, t in zip(force, turn, strict=True))
        bend = [
            [
                (2.0 * along * (i == j) - force[i] * turn[j] - turn[i] * force[j]) / 12.0
                for j in range(3)
            ]
            for i in range(3)
        ]
        wound = h * h * h / 12.0
        # force . (lost x slope) wound, as a matrix between lost and slope.
        swirl = [
            [none, wound * force[2], -wound * force[1]],
            [-wound * force[2], none, wound * force[0]],
            [wound * force[1], -wound * force[0], none],
        ]
        to_slope = p.to_stored if not form.each else _matrix_product(p.to_rate, p.to_stored)
        ways = {3 + i: ("lost", i) for i in range(form.stored)}
        ways |= {first + j: ("slope", j) for j in range(form.wheels)}
        for a, (kind_a, i) in ways.items():
            for b, (kind_b, j) in ways.items():
                if b < a:
                    continue
                left = self._way(kind_a, i, p, to_slope)
                right = self._way(kind_b, j, p, to_slope)
                factor = (h if kind_a == "lost" else 0.5 * h * h) * (
                    h if kind_b == "lost" else 0.5 * h * h
                )
                mixed = kind_a != kind_b
                value = none
                for r in range(3):
                    for s in range(3):
                        if left[r] is None or right[s] is None:
                            continue
                        entry = factor * bend[r][s]
                        if mixed:
                            entry = entry + swirl[r][s]
                        value = value + left[r] * entry * right[s]
                add(a, b, value)
        for j in range(form.wheels):
            add(first + j, first + j, 2.0 * h * p.effort / p.energy_scale + none)
        if form.magnetorquers == "managing":
            size = jnp.sqrt(kept.dipole**2 + p.rounding**2)
            price = p.dipole_price * p.rounding**2 / (size * size * size)
            curved = paid * h / p.energy_scale * (price + 2.0 * p.dipole_loss)
            by = kept.by_dipole
            used = [*range(6), *range(3 + form.stored, first + form.wheels)]
            for i in used:
                for j in used:
                    if j >= i:
                        add(i, j, sum(curved[k] * by[k, i] * by[k, j] for k in range(3)))
        for i in range(3 * (form.dipoles > 0)):
            lost = 2.0 * paid * h * p.dipole_loss[i] * p.dipole_limit[i] ** 2 / p.energy_scale
            plus = first + form.wheels + form.powers + i
            add(plus, plus, lost)
            add(plus, plus + 3, -lost)
            add(plus + 3, plus + 3, lost)
        entries = [
            found.get((min(i, j), max(i, j)), none) for i in range(width) for j in range(width)
        ]
        return jnp.stack(entries).reshape(width, width)

    def _add_momentum(
        self,
        add: Callable[[int, int, Array], None],
        x: Array,
        force: Components,
        p: WheelsParameters,
    ) -> None:
        """Add what the total momentum bends: seen from a turned body it is another vector."""
        form, h = self.form, p.step
        q = at.quaternion(x)
        total = to_body(q, at.total_momentum(x, p, form))
        pull = matvec(p.inverse.T, times(h, force))
        along = sum(f * t for f, t in zip(pull, total, strict=True))
        for i in range(3):
            for j in range(i, 3):
                value = 0.5 * (pull[i] * total[j] + total[i] * pull[j])
                add(i, j, value - along if i == j else value)
        # The change of the rate, half of h^2 J^-1 (H x omega), by a turn and by the lost rate.
        late = times(0.5 * h, pull)
        to_rate = None if not form.each else p.to_rate
        for j in range(form.stored):
            lost = tuple(
                -(to_rate[r, j] if to_rate is not None else jnp.asarray(float(r == j)))
                for r in range(3)
            )
            # late . ((H x phi) x lost) = phi . ((lost x late) x H)
            row = cross(cross(lost, late), total)
            for i in range(3):
                add(i, 3 + j, row[i])
        if form.torqued:
            for j in range(3):
                none = jnp.zeros_like(h)
                unit = tuple(none + float(r == j) * p.momentum_scale for r in range(3))
                row = cross(pull, to_body(q, unit))
                for i in range(3):
                    add(i, 3 + form.stored + j, row[i])

    def _way(self, kind: str, i: int, p: WheelsParameters, to_slope: Array) -> list[Any]:
        """Column of a coordinate in the rate that is lost, or in its slope; None for zero."""
        if kind == "slope":
            return [to_slope[r, i] for r in range(3)]
        if self.form.each:
            return [p.to_rate[r, i] for r in range(3)]
        return [1.0 if r == i else None for r in range(3)]

    def path_hessian(
        self, x: Array, u: Array, stage: WheelStage, p: WheelsParameters, dual: Array, kept: Any
    ) -> Array:
        """See `OptimalControlProgram.path_hessian`: of the wheels' power, bilinear in torques
        and speeds.
        """
        form = self.form
        width = form.error_size + form.controls
        first = form.error_size
        none = jnp.zeros_like(p.step)
        found: dict[tuple[int, int], Array] = {}
        for i in range(form.powers):
            weight = (dual[2 * i + 1] * p.returned - dual[2 * i] * p.taken) / p.power_scale
            used = [*range(3 + form.stored), *range(first, first + form.wheels)]
            for j in range(form.wheels):
                if form.power == "body":
                    row = sum(p.axes[k, j] * kept.spins[k] for k in range(3))
                elif j == i:
                    row = kept.spins[i]
                else:
                    continue
                row = weight * p.torque_limit[j] * row
                for m in used:
                    key = (min(first + j, m), max(first + j, m))
                    value = 2.0 * row[m] if m == first + j else row[m]
                    found[key] = found[key] + value if key in found else value
        entries = [
            found.get((min(i, j), max(i, j)), none) for i in range(width) for j in range(width)
        ]
        return jnp.stack(entries).reshape(width, width)


def _matrix_product(a: Array, b: Array) -> Array:
    """Product of small matrices as a sum of rank-one products."""
    total = a[:, :1] * b[:1]
    for k in range(1, a.shape[1]):
        total = total + a[:, k : k + 1] * b[k : k + 1]
    return total
