"""Check of pointing limits along a fine flight: angles, worst instants, violations."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import jax
import numpy as np
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.environment.table import EnvironmentTable, refined
from jaxatt.problems.pointing.case import Pointing
from jaxatt.problems.pointing.cones import cone_angles
from jaxatt.problems.verdict import Verdict
from jaxatt.records.pointing import Extreme
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import in_chunks
from jaxatt.simulation.flight import Trajectory


@dataclass(frozen=True, eq=False)
class ObservedPath:
    """Angles and rates of S flights at all their T fine instants.

    angles : (S, T, m) [rad].  rates : (S, T, 3) [rad/s], |omega_ib| by body axis.
    """

    pointing: Pointing
    angles: Floats
    rates: Floats

    @property
    def excess(self) -> Floats:
        """Violation of each cone [rad], then of the rates as a share, (S, m + 1).

        Negative where a limit holds with something to spare; -1 where rates have no limit.
        """
        cones = self.pointing.cones
        sense = np.array([cone.sense for cone in cones])
        half = np.array([cone.half_angle for cone in cones])
        worst = np.max(sense * (self.angles - half), axis=1, initial=-np.inf)
        limit = self.pointing.rate_limit
        share = -1.0 if limit is None else np.max(self.rates / limit, axis=(1, 2)) - 1.0
        return np.concatenate([worst, np.broadcast_to(share, len(worst))[:, None]], axis=1)

    def extremes(self, times: Floats) -> tuple[Extreme, ...]:
        """Worst instant of the first flight for every cone, then for the body rate.

        times : (T,) [s].
        """
        found = []
        for i, cone in enumerate(self.pointing.cones):
            k = int(np.argmax(cone.sense * self.angles[0, :, i]))
            value, allowed = float(self.angles[0, k, i]), cone.half_angle
            excess = cone.sense * (value - allowed) / allowed
            found.append((cone.name, cone.kind, value, allowed, k, excess))
        if self.pointing.rate_limit is not None:
            share = self.rates[0] / self.pointing.rate_limit
            k, axis = (int(j) for j in np.unravel_index(np.argmax(share), share.shape))
            value, allowed = float(self.rates[0, k, axis]), float(self.pointing.rate_limit[axis])
            found.append(("body rate", "body-rate", value, allowed, k, float(share[k, axis]) - 1.0))
        return tuple(
            Extreme(name, kind, value, allowed, float(times[k]), excess <= Verdict.MARGIN_TOLERANCE)
            for name, kind, value, allowed, k, excess in found
        )

    @property
    def violation(self) -> Floats:
        """Largest excess relative to its limit, (S,); zero where all hold."""
        half = np.array([cone.half_angle for cone in self.pointing.cones])
        relative = self.excess / np.append(half, 1.0)
        # A flight that is not a number must not pass for one that holds.
        worst = np.nan_to_num(relative, nan=np.inf).max(axis=1)
        return np.asarray(np.maximum(0.0, worst))


@jax.jit
def _angles(q_ob: Array, q_io: Array, directions: Array, boresights: Array) -> Array:
    """Angles (S, T, m) [rad] of cones along flights (S, T, 4)."""

    def one(q_ob: Array) -> Array:
        return cone_angles(quaternion.multiply(q_io, q_ob), directions, boresights)

    return jax.vmap(one)(q_ob)


class PathMonitor:
    """Computes cone angles and rates of flights at every Runge-Kutta step.

    table : environment of the flights.  start : [s], time of its first node.
    """

    def __init__(self, table: EnvironmentTable, pointing: Pointing, start: float):
        self.table, self.pointing, self.start = table, pointing, start
        self.every = int(table.stages.gradient.shape[1])

    @functools.cached_property
    def fine(self) -> EnvironmentTable:
        """The table with one interval a Runge-Kutta step."""
        return refined(self.table)

    @functools.cached_property
    def elapsed(self) -> Floats:
        """Times (T,) [s] of the instants since the table's first node, the coast included."""
        count = self.fine.nodes.gradient.shape[0]
        return np.asarray(float(self.fine.substep) * np.arange(count))

    @functools.cached_property
    def directions(self) -> Floats:
        """Directions (T, m, 3) of the cones then, in inertial axes."""
        return self.pointing.directions(self.start + self.elapsed)

    def at_nodes(self, intervals: int) -> Floats:
        """Directions (intervals + 1, m, 3) at the first nodes."""
        return self.directions[: intervals * self.every + 1 : self.every]

    def boresights(self, flown: Trajectory) -> Floats:
        """Directions (T, m, 3) of the cones' boresights along the first flight, inertial."""
        assert flown.fine is not None
        q_ib = quaternion.multiply(self.fine.nodes.orbit_attitude, flown.fine.q_ob[0])
        shape = self.directions.shape
        fixed = np.reshape([cone.boresight for cone in self.pointing.cones], (1, *shape[1:]))
        return np.asarray(quaternion.rotate(q_ib[:, None], np.broadcast_to(fixed, shape)))

    def watch(self, flown: Trajectory, intervals: int | None = None) -> ObservedPath:
        """Angles and rates of flights (S, ...), for so many intervals or all there are."""
        fine = flown.fine
        assert fine is not None
        last = None if intervals is None else intervals * self.every + 1
        q_ob, directions = fine.q_ob[:, :last], self.directions[:last]
        q_io = self.fine.nodes.orbit_attitude[:last]
        boresights = np.reshape([cone.boresight for cone in self.pointing.cones], (-1, 3))
        angles = in_chunks(
            lambda chunk: _angles(chunk, q_io, directions, boresights),
            q_ob,
            key=("angles", q_ob.shape[1:], directions.shape),
        )
        return ObservedPath(self.pointing, angles, np.abs(fine.omega_ib[:, :last]))
