"""Read and check scenarios that minimise time, or time plus effort."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.reading import manoeuvre
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.heading import Heading
from jaxatt.problems.reading.moments import moments_of
from jaxatt.problems.reading.pointing import check_moments, read_pointing
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.time_optimal.reading_parts import read_parts
from jaxatt.spacecraft import Spacecraft
from jaxatt.spacecraft.checks import Float64
from jaxatt.spacecraft.wheels import storage_share


def read_time_optimal(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    notes: list[str] = []
    parts = read_parts(document, origin, folder, notes, faults)
    vehicle, horizon = parts.vehicle, parts.horizon
    faults.of(_check_printed, parts.heading, origin)
    sky = Sky(
        folder=folder,
        without_orbit=f"kind = {document['objective']['kind']} is solved without an orbit, in the "
        "inertial frame: give direction_inertial or right_ascension_deg",
    )
    targets = faults.of(
        manoeuvre.read_targets, document, origin, notes, sky, horizon, vehicle.wheels
    )
    speeds = faults.or_else(parts.speeds, np.zeros(0))
    initial = faults.of(
        manoeuvre.read_initial, faults.table(document, "initial"), origin, notes, sky, speeds
    )
    if speeds is parts.speeds:
        faults.of(_check_storable, origin, vehicle, initial, targets)
    pointing = faults.of(
        read_pointing, document, origin, notes, sky, horizon.shortest, horizon.longest
    )
    faults.refuse()
    scenario = Scenario(
        **vars(parts.heading),
        family="time-optimal",
        vehicle=vehicle,
        initial=initial,
        targets=targets,
        horizon=horizon,
        control=parts.control,
        objective=parts.objective,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
        transcription=parts.transcription,
        pointing=pointing,
    )
    if scenario.pointing:
        check_moments(scenario.pointing, moments_of(scenario), origin)
    return scenario


def _check_printed(heading: Heading, origin: str) -> None:
    if "other_target" in heading.printed:
        manoeuvre.read_target(
            heading.printed["other_target"], origin, "[printed.other_target]", [], Sky()
        )


def _check_storable(
    origin: str, vehicle: Spacecraft, initial: InitialState, targets: tuple[Target, ...]
) -> None:
    """Refuse wheel speed limits that cannot hold the momentum that is left at the target.

    Without external torques the total momentum stays as it is in the inertial frame, and with the
    target's attitude and rate what the wheels must hold then is known.  Raises `ScenarioError`.
    """
    wheels, (target, *_) = vehicle.wheels, targets
    known = target.boresight is None  # otherwise what is left depends on the roll that is found
    if vehicle.thrusters.count or not known or not np.isfinite(wheels.speed_limit).any():
        return
    inertia = np.asarray(vehicle.inertia)
    begin = inertia @ initial.omega_ob + wheels.axes @ (wheels.inertia * initial.omega_bw)
    inverse = target.q_ob * np.array([1.0, -1.0, -1.0, -1.0])
    left = _rotated(inverse, _rotated(initial.q_ob, np.asarray(begin))) - inertia @ target.omega_ob
    share = storage_share(wheels, left)
    if share > 1.0 + 1e-9:
        held = ", ".join(f"{component:.4g}" for component in left)
        raise ScenarioError(
            f"{origin}: [vehicle.wheels] speed_limit_rad_s: at the target the wheels must hold the "
            f"momentum ({held}) N m s in body axes, {share:.4g} times what their speed limits "
            "allow; raise the limits, start with slower wheels or choose another target"
        )


def _rotated(q: Float64, v: Float64) -> Float64:
    """Rotate a vector, R(q) v, in NumPy: exact whatever precision JAX is set to."""
    twice = 2.0 * np.cross(q[1:], v)
    return np.asarray(v + q[0] * twice + np.cross(q[1:], twice))
