"""Rows of derivatives by z, the error state and the controls of an interval."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels.algebra import back, matrix_product, stacked
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.interval import Course
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.turn import added, multiplied, times
from jaxatt.simulation.momentum_model import Components, cross, to_body


class Directions:
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


class Rows:
    """Rows by z of a form, and the directions along which its intervals are differentiated.

    Blocks of rows that only parameters go into are made once for all intervals and starts.
    """

    def __init__(self, form: WheelsForm):
        self.form = form
        self.directions = Directions(form)

    @property
    def width(self) -> int:
        """Number of coordinates of z."""
        return self.form.error_size + self.form.controls

    def block(
        self,
        *,
        turn: Array | None = None,
        stored: Array | None = None,
        total: Array | None = None,
        charge: Array | None = None,
        torques: Array | None = None,
        powers: Array | None = None,
        dipoles: Array | None = None,
    ) -> Array:
        """Rows (r, z), or one row (z,); parts that are None are zero."""
        form = self.form
        parts = (
            (turn, 3),
            (stored, form.stored),
            (total, 3 * form.torqued),
            (charge, int(form.charge)),
            (torques, form.wheels),
            (powers, form.powers),
            (dipoles, form.dipoles),
        )
        above = next(part.shape[:-1] for part, _ in parts if part is not None)
        return jnp.concatenate(
            [jnp.zeros((*above, size)) if part is None else part for part, size in parts if size],
            axis=-1,
        )

    @property
    def turn(self) -> Array:
        """Turn of the body at the beginning by z, (3, z)."""
        return jnp.eye(3, self.width)

    @property
    def stored(self) -> Array:
        """Coordinates of the wheels' momentum at the beginning by z, (k, z)."""
        return self.block(stored=jnp.eye(self.form.stored))

    def driven(self, p: WheelsParameters) -> Array:
        """Derivative of these in time by z, (k, z) [1/s]."""
        return self.block(torques=p.to_stored)

    def directions_by_z(self, p: WheelsParameters) -> Array:
        """What the directions are by z, (directions, z)."""
        form, parts = self.form, []
        if form.momentum != "zero":
            parts.append(self.turn)
        parts.append(self.block(stored=p.to_rate))
        parts.append(self.block(torques=matrix_product(p.to_rate, p.to_stored)))
        if form.torqued:
            parts.append(self.block(total=p.momentum_scale * jnp.eye(3)))
        if form.dipoles:
            limit = jnp.diag(p.dipole_limit)
            parts.append(self.block(dipoles=jnp.concatenate([limit, -limit], axis=1)))
        return jnp.concatenate(parts)

    def carried(self, q: Components, p: WheelsParameters) -> Array:
        """Momentum in body axes by the total one where that is carried, (3, z)."""
        return self.block(total=p.momentum_scale * stacked(back(q)))
