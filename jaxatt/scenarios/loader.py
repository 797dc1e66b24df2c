"""Load a checked scenario from a TOML document."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxatt.problems.scenario import SPACECRAFT, TIME_KINDS, TOY_SYSTEMS, Scenario
from jaxatt.scenarios import manoeuvre, settings, time_optimal
from jaxatt.scenarios.attitudes import replaced_by
from jaxatt.scenarios.documents import read_file
from jaxatt.scenarios.fields import ScenarioError, Table
from jaxatt.scenarios.free_time import check_free_time
from jaxatt.scenarios.moments import moments_of
from jaxatt.scenarios.pointing import check_moments, read_pointing
from jaxatt.scenarios.schema import SPACECRAFT_TABLES, TOY_TABLES, top_level_keys
from jaxatt.scenarios.valves import check_thrusters
from jaxatt.scenarios.vehicles import read_vehicle
from jaxatt.scenarios.windows import read_windows

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]*")


def load_file(path: str | Path) -> Scenario:
    """Load and check the scenario of a TOML file.

    Raises
    ------
    ScenarioError
        Names file, table, key, value, what is allowed and how to mend it.
    """
    path = Path(path)
    return from_mapping(read_file(path), origin=str(path), folder=path.parent)


def from_mapping(
    document: Mapping[str, Any], *, origin: str = "scenario", folder: Path | None = None
) -> Scenario:
    """Check a document that has the names and units of a scenario file.

    Parameters
    ----------
    document : mapping
        As a TOML file holds it; NumPy numbers and arrays may stand for numbers and lists.
    origin : str
        What messages call it.
    folder : Path, optional
        Where a vehicle's file is looked up; the working folder by default.
    """
    plain = plain_values(document)
    system_names = (SPACECRAFT, *TOY_SYSTEMS)
    toy = plain.get("system", SPACECRAFT) in TOY_SYSTEMS
    top = Table(plain, origin, "", top_level_keys(SPACECRAFT_TABLES))
    system = top.choice("system", system_names, SPACECRAFT)
    for key in plain:
        if toy and key not in top_level_keys(TOY_TABLES):
            raise ScenarioError(f"{origin}: {key}: has no meaning for system = {system}; drop it")
    for key in ("initial", "horizon") if toy else ("vehicle", "initial", "horizon"):
        if key not in plain:
            raise ScenarioError(
                f"{origin}: [{key}] is missing; `jaxatt scenarios show NAME` prints"
                " a complete file to start from"
            )
    name = top.text("name", Path(origin).stem)
    if not _NAME.fullmatch(name):
        top.fail("name", "must serve as a file name", "use letters, digits, '-', '_' and '.'")
    notes: list[str] = []
    vehicle = None if toy else read_vehicle(plain["vehicle"], origin, folder, notes)
    objective = settings.read_objective(plain.get("objective", {}), origin, toy)
    optimal = objective.kind in TIME_KINDS
    if optimal:
        time_optimal.check_time_optimal(plain, origin, notes)
    horizon = settings.read_horizon(plain["horizon"], origin, optimal)
    targets = manoeuvre.read_targets(plain, origin, toy, notes)
    waypoint = None
    if "waypoint" in plain:
        if len(targets) > 1 or "legs" in plain:
            raise ScenarioError(f"{origin}: [waypoint] and [[legs]] are both given; keep one")
        waypoint = manoeuvre.read_waypoint(plain["waypoint"], origin, horizon, notes)
    check_free_time(plain, origin, horizon, objective)
    windows = read_windows(plain.get("windows", []), origin, horizon)
    if objective.kind == "moving-l0" and all(window.forbidden for window in windows):
        notes.append("moving-l0 without a cheap window is the same as l0; add [[windows]]")
    pushed = vehicle is not None and vehicle.thrusters.count > 0
    if vehicle is not None and "orbit" not in plain and not (pushed or optimal):
        raise ScenarioError(
            f"{origin}: [orbit] is missing; `jaxatt scenarios show NAME` prints a complete file to "
            "start from (only vehicles with thrusters and turns in minimum time may do without, in "
            "the inertial frame)"
        )
    orbit = settings.read_orbit(plain["orbit"], origin) if "orbit" in plain else None
    disturbances = settings.read_disturbances(plain.get("disturbances", {}), origin)
    if disturbances.gravity_gradient and orbit is None:
        raise ScenarioError(
            f"{origin}: [disturbances] gravity_gradient = true: there is no [orbit]; add one or "
            "switch the gravity gradient off"
        )
    read_control = time_optimal.read_separate_torques if optimal else settings.read_control
    control = read_control(plain.get("control", {}), origin, vehicle)
    if vehicle is not None:
        check_thrusters(plain, origin, vehicle, horizon, objective)
    initial = manoeuvre.read_initial(plain["initial"], origin, vehicle, notes)
    if optimal and vehicle is not None:
        time_optimal.check_storable(origin, vehicle, initial, targets[0])
    printed = plain.get("printed", {})
    if not isinstance(printed, dict):
        top.fail("printed", "is not a table", "write [printed] and its keys below")
    scenario = Scenario(
        name=name,
        title=top.text("title", name),
        source=top.text("source", "not stated"),
        system=system,
        vehicle=vehicle,
        orbit=orbit,
        initial=initial,
        targets=targets,
        waypoint=waypoint,
        horizon=horizon,
        disturbances=disturbances,
        control=control,
        objective=objective,
        windows=windows,
        solver=settings.read_solver(plain.get("solver", {}), origin),
        printed=printed,
        notes=tuple(notes),
        document=plain,
        origin=origin,
        folder=folder,
        transcription=time_optimal.read_transcription(
            plain.get("transcription", {}), origin, objective
        ),
        pointing=read_pointing(plain, origin, orbit is not None, orbit.days if orbit else None),
    )
    if scenario.pointing:
        check_moments(scenario.pointing, moments_of(scenario), origin)
    return scenario


def replace(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """Return a changed scenario, checked like a file.

    Parameters
    ----------
    scenario : Scenario
    changes : mapping
        New values by their names in the file, with its units, e.g.
        ``{"target.attitude_deg": [10, 20, 30], "objective.kind": "l1", "legs.0.rate_rad_s": ...}``.
        None removes a key. A new attitude replaces the old one in whichever form it was given.
    """
    document = copy.deepcopy(dict(scenario.document))
    for path, value in changes.items():
        assign(document, path, plain_values(value))
    return from_mapping(document, origin=scenario.origin, folder=scenario.folder)


def assign(document: dict[str, Any], path: str, value: Any) -> None:
    *parents, key = path.split(".")
    place: Any = document
    for part in parents:
        if isinstance(place, list) and part.isdigit() and int(part) < len(place):
            place = place[int(part)]
        elif isinstance(place, dict):
            place = place.setdefault(part, {})
        else:
            raise ScenarioError(f"{path}: there is no '{part}' to change; check the name")
    if isinstance(place, list) and key.isdigit() and int(key) < len(place):
        place[int(key)] = value
        return
    if not isinstance(place, dict):
        raise ScenarioError(f"{path}: there is no '{key}' to change; check the name")
    place.pop(key, None)
    if value is None:
        return
    for other in replaced_by(key):
        place.pop(other, None)
    place[key] = value


def plain_values(value: Any) -> Any:
    """Convert mappings, tuples and arrays to dicts, lists and Python numbers."""
    if isinstance(value, Mapping):
        return {str(key): plain_values(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_values(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
