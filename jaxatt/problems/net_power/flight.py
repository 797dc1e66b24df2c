"""Fine flight of manoeuvres, independent of the optimiser's steps, with their account of energy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from jaxatt.problems.net_power.along_flight import (
    AlongFlight,
    along_flight,
    block_of,
    stacked,
)
from jaxatt.problems.net_power.energy import EnergyAccount
from jaxatt.problems.net_power.flight_lanes import BLOCK, Plant, Row, begin_lanes, fly_block
from jaxatt.problems.net_power.flight_plant import common_intervals, common_plant
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import chunk_for, in_chunks
from jaxatt.simulation.light_quadrature import parts_for
from jaxatt.simulation.steering import GivenTorque, Steering

LEAST_STEPS = 20
"""Runge-Kutta steps an interval, at least."""

LONGEST_STEP = 0.5
"""[s]"""

_SHARE = 0.1
"""Of the tolerance of the attitude, what the steps alone may be wrong by."""
_MOST_TIMES = 64
"""Times the usual steps, at most; a flight that needs more is said to be uncertain."""

_ROWS = 16
"""Flights in one compiled call where each has surroundings of its own."""

AT_NODES = (
    "q_ib",
    "omega_ib",
    "omega_bw",
    "dipole",
    "light",
    "solar_power",
    "wheel_power",
    "magnetorquer_power",
)


@dataclass(frozen=True, eq=False)
class PoweredFlight:
    """Flights of S answers to manoeuvres of N intervals, with their powers and energies.

    At the nodes: q_ib (S, N + 1, 4), omega_ib (S, N + 1, 3) and omega_bw (S, N + 1, n) [rad/s],
    dipole (S, N + 1, 3) [A m^2], light (S, N + 1), visible fraction of the sun, and solar_power,
    wheel_power, magnetorquer_power (S, N + 1) [W] at the battery; where a torque jumps, the power
    after it.
    wheel_torque : (S, N, n) [N m], held over each interval.
    lowest, highest : (S, n) [rad/s], speed of each wheel.  strongest : (S, 3) [A m^2], largest
    dipole, all of them within all steps.  step : (S,) [s], of an interval.
    """

    q_ib: Floats
    omega_ib: Floats
    omega_bw: Floats
    wheel_torque: Floats
    dipole: Floats
    light: Floats
    solar_power: Floats
    wheel_power: Floats
    magnetorquer_power: Floats
    energy: EnergyAccount
    lowest: Floats
    highest: Floats
    strongest: Floats
    step: Floats

    @property
    def speeds_passed(self) -> Floats:
        """First, lowest and highest speed of each wheel, (S, 3, n) [rad/s]."""
        return np.stack([self.omega_bw[:, 0], self.lowest, self.highest], axis=1)


def steps_for(manoeuvre: Manoeuvre) -> int:
    """Runge-Kutta steps an interval of a fine flight.

    More than usual where the stored momentum makes the body nutate, at w = |H| / J or less: a step
    of h is then wrong by (w h)^5 / 120 or less.  By powers of two, for few compiled programs.
    """
    usual = max(LEAST_STEPS, math.ceil(manoeuvre.step / LONGEST_STEP - 1e-9))
    if manoeuvre.end is None:
        return usual
    craft, start = manoeuvre.satellite.craft, manoeuvre.start
    stored = np.asarray(craft.wheels.axes) @ (np.asarray(craft.wheels.inertia) * start.omega_bw)
    with np.errstate(over="ignore"):
        momentum = np.linalg.norm(np.asarray(craft.inertia) @ start.omega_ib + stored)
        nutation = momentum / np.linalg.eigvalsh(np.asarray(craft.inertia_without_spin)).min()
        off = manoeuvre.duration * nutation**5 * (manoeuvre.step / usual) ** 4 / 120.0
    times = (off / (_SHARE * manoeuvre.end.attitude_tolerance)) ** (1.0 / 4.0)
    return usual << math.ceil(math.log2(np.clip(times, 1.0, _MOST_TIMES)) - 1e-9)


def fly_with_twice_the_steps(
    manoeuvre: Manoeuvre, wheel_torque: Floats, dipole: Floats | None, alike: int
) -> PoweredFlight:
    """Fly one answer in intervals of half the length, with as many steps in each.

    wheel_torque : (N, n) [N m].  dipole : (N, 3) [A m^2], or None.  alike : as in `fly_steered`.
    """
    steps = steps_for(manoeuvre)
    halves = replace(manoeuvre, intervals=2 * manoeuvre.intervals)
    rows = tuple(np.repeat(wheel_torque, 2, axis=0).T[:, None])
    held = None if dipole is None else np.repeat(dipole, 2, axis=0)[None]
    parts = parts_for(manoeuvre.step / steps)
    one = np.zeros(1, int)
    return fly_steered([halves], one, GivenTorque(), rows, held, steps, parts, alike)


def fly(
    manoeuvre: Manoeuvre,
    wheel_torque: Any,
    dipole: Any = None,
    steps: int | None = None,
) -> PoweredFlight:
    """Fly answers to one manoeuvre.

    wheel_torque : (S, N, n) [N m], held over each interval.
    dipole : (S, N, 3) [A m^2], held; None where the magnetorquers rest or unload the wheels.
    steps : Runge-Kutta steps an interval, `steps_for` by default.
    """
    return fly_many([manoeuvre], np.zeros(len(wheel_torque), int), wheel_torque, dipole, steps)


def fly_many(
    manoeuvres: Sequence[Manoeuvre],
    of: Any,
    wheel_torque: Any,
    dipole: Any = None,
    steps: int | None = None,
) -> PoweredFlight:
    """Fly answers to several manoeuvres of one satellite and one number of intervals.

    of : (S,), index of the manoeuvre that each answer belongs to.  Others as in `fly`.
    """
    torque = np.asarray(wheel_torque, float)
    rows = tuple(np.moveaxis(torque, -1, 0))
    return fly_steered(manoeuvres, of, GivenTorque(), rows, dipole, steps)


def fly_steered(
    manoeuvres: Sequence[Manoeuvre],
    of: Any,
    steering: Steering,
    rows: Any,
    dipole: Any = None,
    steps: int | None = None,
    parts: int | None = None,
    alike: int | None = None,
) -> PoweredFlight:
    """Fly manoeuvres with torques that `steering` decides at the start of every interval.

    rows : pytree with leading axes (S, N), the steering's own data of each interval.
    parts : of a step, in which light is summed up; `parts_for` by default.
    alike : number of flights in the call whose compiled program this one is to share.
    Others as in `fly_many`.
    """
    of = np.asarray(of)
    steps = steps or max(steps_for(manoeuvre) for manoeuvre in manoeuvres)
    plant, count = common_plant(manoeuvres), common_intervals(manoeuvres)
    parts = parts or parts_for(max(manoeuvre.step for manoeuvre in manoeuvres) / steps)
    padded = BLOCK * (count // BLOCK + 1)  # one interval at least begins at the end
    shared = len(manoeuvres) == 1
    once = {0: along_flight(manoeuvres[0], padded, steps, parts)} if shared else None

    def run(lanes: dict[str, Any]) -> dict[str, Floats]:
        which = [0] if shared else list(lanes["of"])
        around = once or {
            k: along_flight(manoeuvres[k], padded, steps, parts) for k in dict.fromkeys(which)
        }
        step = np.array([manoeuvres[k].step / steps for k in which])
        places = stacked([around[k] for k in which])
        return _flown(plant, steering, lanes, places, step, count)

    lanes = {
        "of": of,
        "start": tuple(
            np.stack([np.asarray(getattr(manoeuvres[k].start, name), float) for k in of])
            for name in ("q_ib", "omega_ib", "omega_bw")
        ),
        "row": _padded(Row(rows, _components(dipole)), padded - count),
    }
    size = chunk_for(alike or len(of))
    size = size if shared else min(_ROWS, size)
    key = (
        "net-power flight",
        steps,
        parts,
        shared,
        str(jax.tree.structure((plant, steering, lanes))),
    )
    return gathered(manoeuvres, of, in_chunks(run, lanes, size, key=key))


def _flown(
    plant: Plant,
    steering: Steering,
    lanes: dict[str, Any],
    around: AlongFlight,
    step: Floats,
    count: int,
) -> dict[str, Floats]:
    """Fly one chunk block by block; `count` intervals and their last node are kept."""
    carried = begin_lanes(plant.powers.craft, *lanes["start"])
    blocks = []
    for first in range(0, count + 1, BLOCK):
        row = jax.tree.map(lambda x, k=first: x[:, k : k + BLOCK], lanes["row"])
        place = block_of(around, first, BLOCK)
        carried, found = fly_block(plant, steering, carried, row, place, step)
        blocks.append(jax.tree.map(np.asarray, found))
    whole = {name: np.concatenate([one[name] for one in blocks], axis=1) for name in blocks[0]}
    return {name: x[:, : count + (name in AT_NODES)] for name, x in whole.items()}


def _components(dipole: Any) -> tuple[Floats, ...]:
    return () if dipole is None else tuple(np.moveaxis(np.asarray(dipole, float), -1, 0))


def _padded(row: Row, more: int) -> Row:
    """The data with so many copies of the last interval behind it."""
    longer: Row = jax.tree.map(lambda x: np.pad(x, ((0, 0), (0, more)), mode="edge"), row)
    return longer


def gathered(
    manoeuvres: Sequence[Manoeuvre], of: np.ndarray, found: dict[str, Floats]
) -> PoweredFlight:
    """Flights with their accounts, the loads included; found : series as of `flight_lanes`."""
    first = manoeuvres[0]
    chosen = [manoeuvres[k] for k in of]
    battery = first.satellite.craft.battery
    output = 1.0 if battery is None else float(battery.output_efficiency)
    loads = np.array([one.load * one.step / output for one in chosen])
    energy = EnergyAccount(
        found["solar"],
        found["wheels"],
        found["magnetorquers"],
        np.broadcast_to(loads[:, None], found["solar"].shape),
        np.array([one.charge for one in chosen]),
        math.inf if battery is None else float(battery.capacity),
    )
    return PoweredFlight(
        **{name: found[name] for name in (*AT_NODES, "wheel_torque")},
        energy=energy,
        lowest=found["lowest"].min(axis=1),
        highest=found["highest"].max(axis=1),
        strongest=found["strongest"].max(axis=1),
        step=np.array([one.step for one in chosen]),
    )
