"""Motion under the Earth's oblateness, J2, integrated on the host."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment.ephemeris import States
from jaxatt.environment.epoch import SECONDS_PER_DAY
from jaxatt.environment.orbit import MU_EARTH
from jaxatt.environment.precession import precession
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from scipy.integrate import OdeSolution

J2 = 1.08262668e-3
"""Second zonal harmonic of the Earth's field, EGM96, for `RADIUS`."""
RADIUS = 6378136.3
"""Equatorial radius [m] that goes with J2."""

_RELATIVE, _ABSOLUTE = 1e-12, 1e-6
"""Tolerances of the integration; lengths in metres, velocities in metres a second."""
_FURTHER, _ROOM = 1.3, 600.0
"""How far beyond what is asked it goes, so that what is asked next is there: a factor, and [s]."""


def acceleration(r: Floats, pole: Floats, mu: float = MU_EARTH) -> Floats:
    """Acceleration (..., 3) [m/s^2] of an oblate Earth.

    The gradient of mu / r (1 - J2 (R / r)^2 (3 s^2 - 1) / 2), with s the sine of the latitude.
    r : (..., 3) [m].  pole : (3,), unit vector of the Earth's axis.
    """
    radius = np.linalg.norm(r, axis=-1)[..., None]
    up = r / radius
    sine = (up @ pole)[..., None]
    oblate = 1.5 * J2 * (RADIUS / radius) ** 2
    return -mu / radius**2 * (up + oblate * ((1.0 - 5.0 * sine**2) * up + 2.0 * sine * pole))


class Propagation:
    """Motion from a state, integrated as far as it is asked for.

    By Dormand and Prince's method of order 8, with its interpolant.
    r : (3,) [m], v : (3,) [m/s], at time zero.  pole : (3,).  mu : [m^3/s^2].
    """

    def __init__(self, r: Floats, v: Floats, pole: Floats, mu: float = MU_EARTH):
        self._start = np.concatenate([r, v])
        self._pole, self._mu = pole.tolist(), mu
        self._ahead: OdeSolution | None = None
        self._behind: OdeSolution | None = None
        self._last = self._first = 0.0

    def __call__(self, times: Floats) -> tuple[Floats, Floats]:
        """Positions (n, 3) [m] and velocities (n, 3) [m/s] at times (n,) [s] of either sign."""
        states = np.tile(self._start, (len(times), 1))
        ahead, behind = times > 0.0, times < 0.0
        if ahead.any():
            if self._ahead is None or times.max() > self._last:
                self._last = _FURTHER * float(times.max()) + _ROOM
                self._ahead = self._integrated(self._last)
            states[ahead] = self._ahead(times[ahead]).T
        if behind.any():
            if self._behind is None or times.min() < self._first:
                self._first = _FURTHER * float(times.min()) - _ROOM
                self._behind = self._integrated(self._first)
            states[behind] = self._behind(times[behind]).T
        return states[:, :3], states[:, 3:]

    def _integrated(self, end: float) -> OdeSolution:
        from scipy.integrate import solve_ivp

        found = solve_ivp(
            self._slope,
            (0.0, end),
            self._start,
            method="DOP853",
            rtol=_RELATIVE,
            atol=_ABSOLUTE,
            dense_output=True,
        )
        return found.sol

    def _slope(self, _: float, state: Floats) -> list[float]:
        """Velocity and acceleration; as `acceleration`, ten times as fast for one instant."""
        x, y, z, *velocity = state.tolist()
        i, j, k = self._pole
        squared = x * x + y * y + z * z
        radius = math.sqrt(squared)
        along = x * i + y * j + z * k
        pull = -self._mu / (squared * radius)
        oblate = 1.5 * J2 * RADIUS**2 / squared
        out = pull * (1.0 + oblate * (1.0 - 5.0 * along * along / squared))
        up = pull * oblate * 2.0 * along
        return [*velocity, out * x + up * i, out * y + up * j, out * z + up * k]


def pole_of_date(days: float | None) -> Floats:
    """Unit vector (3,) of the Earth's mean axis at a date; that of J2000 without one."""
    with jax.enable_x64(True):
        return np.asarray(precession(jnp.asarray(days or 0.0)))[2]


@dataclass(frozen=True, eq=False)
class OblatePath:
    """An orbit about an oblate Earth; an `OrbitPath`.

    r : (3,) [m] and v : (3,) [m/s] at `days` since J2000.  pole : (3,).  mu : [m^3/s^2].
    """

    r: Floats
    v: Floats
    days: float
    pole: Floats
    mu: float

    def over(self, days: float, first: float, last: float) -> States:
        """Known at all times."""
        later = (days - self.days) * SECONDS_PER_DAY
        motion = Propagation(self.r, self.v, self.pole, self.mu)
        return lambda times: motion(later + times)
