"""Read the initial state, the waypoint and the targets of a scenario."""

from __future__ import annotations

import math
from typing import Any

from jaxatt.problems.manoeuvre import InitialState, Target, Waypoint
from jaxatt.problems.reading.aims import read_goal, read_state
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.free_time import nearest_whole, refuse_seconds
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.wheel_bias import TOLERANCE, read_bias
from jaxatt.problems.scenario import Horizon
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import ReactionWheels


def read_initial(
    data: Any, origin: str, notes: list[str], sky: Sky, speeds: Floats
) -> InitialState:
    """Read the initial state of a spacecraft.

    sky : what its attitude may be told by.  speeds : (n,) [rad/s], of the wheels.
    """
    table = Table(data, origin, "[initial]", SPACECRAFT_TABLES["initial"])
    state = read_state(table, notes, sky, 0.0)
    return InitialState(*state, speeds)


def read_targets(
    document: dict[str, Any],
    origin: str,
    notes: list[str],
    sky: Sky,
    horizon: Horizon,
    wheels: ReactionWheels,
) -> tuple[Target, ...]:
    """Read the target, or one target for each of the [[legs]], each at the end of a horizon."""
    first = horizon.shortest if horizon.free else horizon.duration
    last = horizon.longest if horizon.free else horizon.duration
    if "target" in document and "legs" in document:
        raise ScenarioError(
            f"{origin}: [target] and [[legs]] are both given; keep [target] for one manoeuvre or "
            "[[legs]] for successive ones"
        )
    if "legs" not in document:
        only = document.get("target")
        return (read_target(only, origin, "[target]", notes, sky, first, last, wheels),)
    phases = document["legs"]
    if not isinstance(phases, list) or not phases:
        raise ScenarioError(
            f"{origin}: legs: must be a list of tables; write [[legs]] with double brackets"
        )
    faults = Faults()
    targets = tuple(
        faults.of(
            read_target,
            phase,
            origin,
            f"[[legs]] no. {leg}",
            notes,
            sky,
            leg * first,
            leg * last,
            wheels,
        )
        for leg, phase in enumerate(phases, 1)
    )
    faults.refuse()
    return targets


def read_target(
    data: Any,
    origin: str,
    label: str,
    notes: list[str],
    sky: Sky,
    first: float = 0.0,
    last: float = 0.0,
    wheels: ReactionWheels | None = None,
) -> Target:
    """Read one target, from a table that messages call `label`.

    first, last : [s] between which it is reached.  wheels : whose bias may be asked for.
    """
    if data is None:
        raise ScenarioError(
            f"{origin}: [target] is missing; add it with attitude_deg = [phi, theta, psi]"
        )
    table = Table(data, origin, label, SPACECRAFT_TABLES["target"])
    tolerance = table.number("attitude_tolerance_deg")
    attitude, rate, boresight = read_goal(table, notes, sky, first, last)
    return Target(
        q_ob=attitude,
        omega_ob=rate,
        boresight=boresight,
        attitude_tolerance=math.radians(tolerance),
        rate_tolerance=table.number("rate_tolerance_rad_s"),
        wheel_bias=read_bias(table, wheels),
        bias_tolerance=table.number(TOLERANCE),
    )


def read_waypoint(data: Any, origin: str, horizon: Horizon, notes: list[str], sky: Sky) -> Waypoint:
    """Read the waypoint; its time moves to the nearest node, with a note if it moved."""
    table = Table(data, origin, "[waypoint]", SPACECRAFT_TABLES["waypoint"])
    node = _node_by_number(table, horizon) if "node" in table else _node(table, horizon, notes)
    tolerance = table.number("tolerance_deg")
    first = node * (horizon.shortest / horizon.intervals if horizon.free else horizon.step)
    last = node * (horizon.longest / horizon.intervals if horizon.free else horizon.step)
    attitude, _ = read_state(table, notes, sky, first, last)
    return Waypoint(attitude, node * horizon.step, node, math.radians(tolerance))


def _node_by_number(table: Table, horizon: Horizon) -> int:
    node = table.integer("node")
    if node >= horizon.intervals:
        table.fail(
            "node",
            f"outside the horizon of {horizon.intervals} intervals",
            f"allowed: 1 to {horizon.intervals - 1} (node k follows k intervals)",
        )
    return node


def _node(table: Table, horizon: Horizon, notes: list[str]) -> int:
    if horizon.free:
        refuse_seconds(table, "time_s", "node = ...")
    time = table.number("time_s")
    if not 0.0 < time < horizon.duration:
        table.fail(
            "time_s",
            "outside the horizon",
            f"give a time between 0 and {horizon.duration:g} seconds",
        )
    node = nearest_whole(time / horizon.step)
    if not 0 < node < horizon.intervals:
        table.fail(
            "time_s",
            f"falls on the {'start' if node == 0 else 'end'} of the horizon, the nearest node "
            f"of the {horizon.intervals} intervals",
            f"give a time between {horizon.step:g} and {horizon.duration - horizon.step:g} "
            "seconds, or more intervals",
        )
    on_node = node * horizon.step
    if abs(on_node - time) > 1e-9 * horizon.duration:
        notes.append(
            f"[waypoint] time_s = {time:g} lies between nodes: moved to node {node}, {on_node:g} s"
        )
    return node
