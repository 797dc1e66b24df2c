"""Rows of derivatives by z, the error state and the controls of an interval."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels.algebra import matrix_product
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
    """Rows by z of a form, and the directions along which its intervals are differentiated."""

    def __init__(self, form: WheelsForm):
        self.form = form
        self.directions = Directions(form)

    @property
    def width(self) -> int:
        """Number of coordinates of z."""
        return self.form.error_size + self.form.controls

    def row(
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
        """One row (z,); parts that are None are zero."""
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
        return jnp.concatenate(
            [jnp.zeros(size) if part is None else part for part, size in parts if size]
        )

    def by_z(self, tangent: Array, p: WheelsParameters, to_slope: Array) -> Array:
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
        return self.row(
            turn=of("turn") if "turn" in first else None,
            stored=through("lost", p.to_rate) if form.each else of("lost"),
            torques=through("slope", to_slope),
            total=p.momentum_scale * of("total") if form.torqued else None,
            dipoles=dipoles,
        )

    def carried(self, q: Components, p: WheelsParameters) -> Components:
        """Momentum in body axes by the total one where that is carried, three rows in z."""
        own = p.momentum_scale * jnp.eye(3)
        return to_body(q, tuple(self.row(total=own[i]) for i in range(3)))

    def to_slope(self, p: WheelsParameters) -> Array:
        """Slope of the lost rate by the scaled torques, (3, n)."""
        return matrix_product(p.to_rate, p.to_stored) if self.form.each else p.to_stored
