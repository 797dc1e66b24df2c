"""Cones and rate limits of a spacecraft, on the host."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude.vectors import norm
from jaxatt.environment.toward import Direction
from jaxatt.problems.pointing.cones import KEEP_IN, KEEP_OUT, PointingLimits, PointingPath
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_WIDEST = 1e-9
"""[rad] A guarded half angle stays this far from 0 and pi."""


def _unit(direction: Direction, times: Array) -> Array:
    """Unit vectors (T, 3) in inertial axes at times (T,) [s]."""
    found = jax.vmap(direction.at)(times)
    return found / norm(found)[:, None]


_unit_vectors = jax.jit(_unit, compiler_options=RUNS_ONCE)


@dataclass(frozen=True, eq=False)
class Cone:
    """A keep-out or keep-in cone.

    kind : "keep-out" or "keep-in".  boresight : (3,), unit vector in body axes.
    half_angle : [rad], between 0 and pi.  direction : of its axis, in the course of time.
    """

    name: str
    kind: str
    boresight: Floats
    half_angle: float
    direction: Direction

    @property
    def sense(self) -> float:
        """Sense of the cone, `KEEP_IN` or `KEEP_OUT`."""
        return KEEP_IN if self.kind == "keep-in" else KEEP_OUT


@dataclass(frozen=True, eq=False)
class Pointing:
    """All cones and rate limits of a case.

    rate_limit : (3,) [rad/s] on |omega_ib| by body axis; None without limits.
    """

    cones: tuple[Cone, ...] = ()
    rate_limit: Floats | None = None

    def __bool__(self) -> bool:
        return bool(self.cones) or self.rate_limit is not None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the cones, then "body rate" where it is limited."""
        rate = () if self.rate_limit is None else ("body rate",)
        return (*(cone.name for cone in self.cones), *rate)

    def directions(self, times: Floats) -> Floats:
        """Unit vectors (T, m, 3) to the middles of all cones, in inertial axes.

        times : (T,) [s] after time zero.
        """
        found = np.zeros((len(times), len(self.cones), 3))
        with jax.enable_x64(True):
            for i, cone in enumerate(self.cones):
                found[:, i] = _unit_vectors(cone.direction, jnp.asarray(times, float))
        return found

    def path(self, directions: Floats, constraint_margin: Floats) -> PointingPath:
        """Limits for the solver along nodes with these directions (N + 1, m, 3).

        constraint_margin : (m + 1,), what each cone is narrowed (keep-in) or widened (keep-out) by
        [rad], then what is taken off the rate limits, as a share of them.
        """
        cones = self.cones
        sense = np.array([cone.sense for cone in cones])
        half = np.array([cone.half_angle for cone in cones]) - sense * constraint_margin[:-1]
        half = np.clip(half, _WIDEST, np.pi - _WIDEST)
        rate = (
            np.zeros(0)
            if self.rate_limit is None
            else self.rate_limit * (1.0 - constraint_margin[-1])
        )
        limits = PointingLimits(
            jnp.asarray(np.reshape([cone.boresight for cone in cones], (-1, 3))),
            jnp.asarray(np.cos(half)),
            jnp.asarray(sense),
            jnp.asarray(rate),
        )
        return PointingPath(limits, jnp.asarray(directions))


FREE = Pointing()
"""Anywhere, at any rate."""
