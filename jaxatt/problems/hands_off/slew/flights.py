"""Flights of a slew's torques and valve openings on the full model, with any number of steps."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.environment.table import EnvironmentTable, Surroundings, tabulate
from jaxatt.problems.manoeuvre import Grid
from jaxatt.problems.pointing.watch import PathMonitor
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import in_chunks, rows_of_flights
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.lengths import held_on, rounded_up
from jaxatt.simulation.flight import MINIMUM_SUBSTEPS, Trajectory, at_nodes, fly_torque
from jaxatt.simulation.flight_error import fly_in_pieces
from jaxatt.simulation.pulse_flight import fly_pulses
from jaxatt.simulation.pulses import Pulses, split
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft

_APART = 16
"""Intervals that lie between the lengths of flights that share a program."""
_COARSE_PIECES = 4
"""Runge-Kutta steps an interval, at least, while pulse widths are being found."""


@Routine
def _fly_many(
    craft: Spacecraft, start: AttitudeState, torque: Array, table: EnvironmentTable
) -> Trajectory:
    return jax.vmap(lambda one: fly_torque(craft, start, one, table))(torque)


_fly_pulses = jax.jit(fly_pulses, static_argnums=6)


@dataclass(frozen=True, eq=False)
class SlewFlights:
    """What all flights of a slew share.

    start : state at the first node.  grid : intervals and the coast after them.
    monitor : its table has the steps that flights take.  search_steps : those of the search.
    shared : whether flights coast on until they are as long as those that share their program.
    """

    craft: Spacecraft
    start: AttitudeState
    surroundings: Surroundings
    grid: Grid
    monitor: PathMonitor
    search_steps: int
    shared: bool = False

    @property
    def steps(self) -> int:
        """Runge-Kutta steps an interval."""
        return self.monitor.every

    def torques(self, torque: Floats, watched: bool, times: int = 1) -> Trajectory:
        """Fly torques (S, N, n + m) [N m], held over each interval, then coast.

        watched : whether the flights at every step are wanted too, as `Trajectory.fine`.
        times : how many times as many steps are taken, for a single flight.
        """
        held = np.pad(torque, ((0, 0), (0, self.grid.coast), (0, 0)))
        if watched:
            held = np.repeat(held, self.steps, axis=1)
        if times == 1:
            flown = self._fly(self.start, held, self._table(watched))
        else:
            flown = fly_in_pieces(
                lambda state, rows, number: self._fly(
                    state, rows[None], self._piece(watched, number, times)
                ),
                self.start,
                np.repeat(held[0], times, axis=0),
                times,
            )
        return at_nodes(flown, self.steps) if watched else flown

    def begin(self, pool: Executor, watched: bool, most: int) -> None:
        """Compile ahead what `torques` runs for one flight and for `most`."""
        count = (self.grid.intervals + self.grid.coast) * (self.steps if watched else 1)
        for rows in dict.fromkeys((rows_of_flights(most), rows_of_flights(1))):
            torque = np.zeros((rows, count, self.craft.actuators))
            _fly_many.begin(
                pool, self.craft, self.start, *self._longer(torque, self._table(watched))
            )

    def pulses(
        self, pulses: Pulses, watched: bool, coarse: bool = False, times: int = 1
    ) -> Trajectory:
        """Fly openings of valves at their exact times, then coast; (1, nodes, ...).

        coarse : with the steps of the search, for iterations.  Others as in `torques`.
        """
        watched = watched and not coarse
        every = self.steps if watched else 1
        least = _COARSE_PIECES if coarse else MINIMUM_SUBSTEPS
        steps = self.search_steps if coarse else self.steps
        cuts = 1 if watched else max(least, steps)
        cut = split(pulses, every * times)
        rows = tuple(
            np.pad(part, ((0, self.grid.coast * every * times), (0, 0)))
            for part in (cut.wheel_torque, cut.opens, cut.shuts)
        )

        def fly(state: AttitudeState, rows: Any, number: int) -> Trajectory:
            wheel, opens, shuts = (jnp.asarray(part) for part in rows)
            table = self._piece(watched, number, times) if times > 1 else self._table(watched)
            flown = _fly_pulses(self.craft, state, wheel, opens, shuts, table, cuts)
            return jax.tree.map(lambda leaf: np.asarray(leaf)[None], flown)

        if times == 1:
            flown = fly(self.start, rows, 0)
        else:
            flown = fly_in_pieces(fly, self.start, rows, times)
        return at_nodes(flown, self.steps) if watched else flown

    def _fly(self, start: AttitudeState, torque: Floats, table: EnvironmentTable) -> Trajectory:
        craft, count = self.craft, torque.shape[1]
        longer, table = self._longer(torque, table)
        flown: Trajectory = in_chunks(
            lambda chunk: _fly_many(craft, start, chunk, table),
            longer,
            rows_of_flights(len(torque)),
            key=("fly", longer.shape[1:], table.stages.gradient.shape),
        )
        more = longer.shape[1] - count
        return jax.tree.map(lambda leaf: leaf[:, : leaf.shape[1] - more], flown) if more else flown

    def _longer(self, torque: Floats, table: EnvironmentTable) -> tuple[Floats, EnvironmentTable]:
        """Torques and environment of a flight as long as those that share its program."""
        if not self.shared:
            return torque, table
        nodes = self.grid.intervals + self.grid.coast
        more = (rounded_up(nodes, _APART) - nodes) * (torque.shape[1] // nodes)
        return np.pad(torque, ((0, 0), (0, more), (0, 0))), replace(
            table, stages=held_on(table.stages, more), nodes=held_on(table.nodes, more)
        )

    def _table(self, watched: bool) -> EnvironmentTable:
        return self.monitor.fine if watched else self.monitor.table

    def _piece(self, watched: bool, number: int, times: int) -> EnvironmentTable:
        """Environment of one of `times` pieces, with as many steps as that of a whole flight."""
        intervals, steps = self._table(watched).stages.gradient.shape[:2]
        length = float(self._table(watched).substep) * steps / times
        begin = self.grid.start_time + number * intervals * length
        return tabulate(self.surroundings, begin, length, intervals, steps)
