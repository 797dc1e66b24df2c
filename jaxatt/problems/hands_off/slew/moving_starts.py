"""Starts of slews of a body in motion: torques that nearly lead to the target.

Pulses at random places suit a body that stays where it is without them.  One that turns, or whose
wheels hold momentum, is somewhere else by the end, many turns away, where no linearisation reaches.
So its starts follow smooth paths (`smooth_paths`) that brake a spin at once or let it coast on.
"""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.host_turns import conjugate, product, to_body
from jaxatt.problems.hands_off.slew.model import SlewParameters
from jaxatt.problems.hands_off.slew.mounting import Mounting
from jaxatt.problems.manoeuvre import Target
from jaxatt.problems.smooth_paths import DRAWS, Ends, follow, shapes
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.vehicle import Spacecraft

_ROOM = 1.2
"""Time to brake, in units of the shortest that the wheels need."""


def moving_starts(
    craft: Spacecraft,
    mounting: Mounting,
    plant: SlewParameters,
    target: Target,
    count: int,
    seed: int,
) -> tuple[Floats, Floats]:
    """Scaled controls (S, N, b), within their limits, and ways round (S,).

    target : with a roll of its own for every start where it leaves the roll free.
    Start i depends on the seed and on i only.
    """
    intervals = plant.table.nodes.gradient.shape[0] - 1
    duration, ends = intervals * float(plant.step), _ends(craft, plant, target.of_starts(count))
    allocation = np.linalg.pinv(mounting.to_body * mounting.scale)
    to_wheels = np.asarray(plant.to_wheels)

    def part(rate: Floats) -> float:
        """Part of the time in which the wheels can take over the body's momentum, (..., 3)."""
        time = np.abs(rate @ ends.inertia @ (to_wheels @ allocation).T).max()
        return float(np.clip(_ROOM * time / duration, 1.0 / intervals, 1.0))

    drawn = np.stack([np.random.default_rng((seed, i)).random(DRAWS) for i in range(count)])
    shape = shapes(drawn, part(ends.rate), part(ends.end_rate))
    path = follow(ends, shape, np.full(count, duration), intervals)
    u = -path.torque @ allocation.T
    over = np.abs(u @ to_wheels.T).max(axis=-1, keepdims=True)
    reference = product(conjugate(ends.q), ends.end)[:, 0]
    way = np.where(np.sum(path.q[:, -1] * reference, axis=1) >= 0.0, 1.0, -1.0)
    return u / np.maximum(1.0, over), way


def _ends(craft: Spacecraft, p: SlewParameters, target: Target) -> Ends:
    """Where a slew begins and ends relative to the inertial frame; target : of S starts."""
    q, nodes = np.asarray(p.start[:4]), p.table.nodes
    near = np.where(target.q_ob @ np.asarray(p.reference) < 0.0, -1.0, 1.0)
    orbit, reference = np.asarray(nodes.orbit_attitude[-1]), near[:, None] * target.q_ob
    # The orbit's rate stands in the orbit's own axes.
    carried = to_body(reference, np.asarray(nodes.orbit_rate[-1]))
    return Ends(
        q=q,
        rate=np.asarray(p.start[4:7]),
        end=product(orbit, reference)[:, None],
        end_rate=(carried + target.omega_ob)[:, None],
        momentum=to_body(q, np.asarray(p.momentum)),
        inertia=np.asarray(craft.inertia),
        without_spin=np.asarray(craft.inertia_without_spin),
    )
