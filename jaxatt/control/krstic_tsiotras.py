"""Inverse optimal feedback law of Krstic and Tsiotras."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Scalar, Vector, matvec
from jaxatt.attitude.vectors import inverse
from jaxatt.control.feedback import Measured


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class KrsticTsiotras:
    """Backstepping law in Rodrigues parameters p = eps / eta.

    inertia : (3, 3) [kg m^2].  first, second : () [1/s], k_1 and k_2.
    factor : of k_1 in the first term: 1.5 reproduces the figures of table I, 1 is printed.
    Source: Krstic and Tsiotras (1999), as Horri, Palmer and Roberts give it in eq. (18).
    The law is singular at half a turn, where p is infinite.
    """

    inertia: Array
    first: Array | float
    second: Array | float
    factor: Array | float = 1.5

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        omega = measured.rate_error
        p = measured.error.eps / measured.error.eta
        v = omega + self.first * p
        linear = (2.0 * self.second + self.factor * self.first) * v
        outer = self.first * p * p.dot(v)
        # J^-1 S(w)' J^2 S(w) J^-1 v, from the right.
        back = inverse(self.inertia)
        inner = omega.cross(matvec(back, v))
        inner = matvec(self.inertia, matvec(self.inertia, inner))
        gyroscopic = (4.0 / self.first) * matvec(back, -omega.cross(inner))
        return matvec(self.inertia, linear + outer + gyroscopic), memory
