"""Load a checked flight from a TOML document."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.reading import manoeuvre
from jaxatt.problems.reading.checking import find_faults
from jaxatt.problems.reading.dates import MAGNETIC_FIELD, SUNLIGHT, check_epoch, read_epoch
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.documents import read_file
from jaxatt.problems.reading.faults import UNSOUND, Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.keys import Key, TableKey
from jaxatt.problems.reading.names import check_folder_name, read_name
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.printed import read_printed
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.reading.wheel_speeds import read_initial_speeds
from jaxatt.problems.scenario import Orbit
from jaxatt.scenarios import flight_tables
from jaxatt.scenarios.flight_laws import read_law
from jaxatt.scenarios.flight_model import FlightScenario, Surroundings, Timing
from jaxatt.scenarios.flight_schema import FLIGHT_KEYS, FLIGHT_TABLES, PRINTED_FIGURES
from jaxatt.scenarios.loader import assign, plain_values


def load_flight_file(path: str | Path) -> FlightScenario:
    """Load and check the flight of a TOML file; raises `ScenarioError`."""
    path = Path(path)
    return flight_from_mapping(read_file(path), origin=str(path), folder=path.parent)


def flight_from_mapping(
    document: Mapping[str, Any], *, origin: str = "flight", folder: Path | None = None
) -> FlightScenario:
    """Check a document that has the names and units of a flight's file."""
    data = plain_values(document)
    faults = Faults(find_faults(data, origin, FLIGHT_KEYS))
    flight = faults.of(_read, data, origin, folder, faults)
    faults.refuse()
    return flight


def _read(data: dict[str, Any], origin: str, folder: Path | None, faults: Faults) -> FlightScenario:
    """Read the parts of a flight, then what depends on several of them."""
    top = Table(data, origin, "", TableKey(keys_=FLIGHT_KEYS, free=Key()))  # others are told
    name = faults.of(read_name, top)
    notes: list[str] = []
    vehicle = faults.of(read_vehicle, faults.table(data, "vehicle"), origin, folder, notes)
    surroundings = faults.of(
        Table, data.get("environment", {}), origin, "[environment]", FLIGHT_TABLES["environment"]
    )
    timing = faults.of(flight_tables.read_timing, faults.table(data, "simulation"), origin)
    orbit = faults.of(_read_orbit, data, origin, folder, notes, surroundings)
    orbit = faults.of(_covering, data, origin, orbit, timing)
    around = faults.of(flight_tables.read_environment, data.get("environment", {}), origin, orbit)
    sky = faults.of(_sky, orbit, folder, around)
    start = faults.table(data, "initial")
    speeds = faults.of(read_initial_speeds, start, origin, vehicle.wheels)
    initial = faults.of(
        manoeuvre.read_initial, start, origin, notes, sky, faults.or_else(speeds, np.zeros(0))
    )
    asked = faults.of(
        flight_tables.read_reference, data.get("reference", {}), origin, initial, notes, sky, timing
    )
    settling = faults.of(flight_tables.read_settling, data.get("settling", {}), origin, asked.since)
    dumping = None
    if "dumping" in data:
        dumping = faults.of(flight_tables.read_dumping, data["dumping"], origin, vehicle, around)
    tables = faults.of(_laws, top)
    laws: dict[str, tuple[Any, str]] = {}
    for law, gains in ({} if tables is UNSOUND else tables).items():
        faults.of(check_folder_name, top, "laws", law, "results/NAME/LAW")
        laws[law] = faults.of(read_law, gains, origin, law, vehicle)
    campaign = faults.of(flight_tables.read_campaign, data.get("campaign", {}), origin)
    faults.of(_check_epoch, surroundings, around, timing, dumping)
    noise = faults.of(flight_tables.read_noise, data.get("noise", {}), origin)
    printed = faults.of(_read_printed, data.get("printed", {}), origin, tables)
    faults.refuse()
    signal, band, since = settling
    spread, runs, seed = campaign
    return FlightScenario(
        name=name,
        title=top.text("title", Path(origin).stem),
        source=top.text("source", "not stated"),
        vehicle=vehicle,
        surroundings=around,
        initial=initial,
        asked=asked,
        timing=timing,
        signal=signal,
        band=band,
        since=since,
        noise=noise,
        dumping=dumping,
        laws={name: law for name, (law, _) in laws.items()},
        law_titles={name: title for name, (_, title) in laws.items()},
        spread=spread,
        runs=runs,
        seed=seed,
        printed=printed,
        notes=tuple(notes),
        document=data,
        origin=origin,
        folder=folder,
    )


def _read_orbit(
    data: dict[str, Any],
    origin: str,
    folder: Path | None,
    notes: list[str],
    surroundings: Table,
) -> Orbit | None:
    if "orbit" not in data:
        return None
    orbit = read_orbit(data["orbit"], origin, folder, notes, read_epoch(surroundings))
    if "epoch" in data["orbit"]:
        raise ScenarioError(
            f"{origin}: [orbit] epoch: a flight has it under [environment]; move it"
        )
    return orbit


def _covering(
    data: dict[str, Any], origin: str, orbit: Orbit | None, timing: Timing
) -> Orbit | None:
    return None if orbit is None else covering(orbit, data["orbit"], origin, timing.duration)


def _sky(orbit: Orbit | None, folder: Path | None, around: Surroundings) -> Sky:
    return sky_over(orbit, folder, days=around.days, sun=around.sun)


def _laws(top: Table) -> dict[str, Any]:
    """The tables of the laws, by their names."""
    tables = top.data.get("laws", {})
    if not isinstance(tables, dict) or not tables:
        top.fail("laws", "holds no law", "write [laws.NAME] and its gains below")
    return tables


def _check_epoch(surroundings: Table, around: Surroundings, timing: Timing, dumping: Any) -> None:
    """Refuse a flight without a date, where something asks for it."""
    needs = {}
    if dumping is not None:
        needs[MAGNETIC_FIELD] = "[dumping]"
    if around.torques.magnetic:
        eddy = around.torques.residual_dipole is None
        needs[MAGNETIC_FIELD] = "eddy_coefficient" if eddy else "residual_dipole_Am2"
    if around.torques.solar_pressure is not None and around.sun is None:
        needs[SUNLIGHT] = "solar_pressure without sun_direction"
    check_epoch(surroundings, around.days, timing.duration, needs)


def _read_printed(data: Any, origin: str, laws: Iterable[str]) -> Mapping[str, Any]:
    """Read [printed]: figures by law, and the reasons known for a difference, for all or one."""
    printed = read_printed(data, origin, {**dict.fromkeys(laws, PRINTED_FIGURES), "why": {}})
    for law in laws:
        read_printed(printed.get(law, {}), origin, {"why": {}}, label=f"[printed.{law}]")
    return printed


def replace_in_flight(flight: FlightScenario, changes: Mapping[str, Any]) -> FlightScenario:
    """Return a changed flight, checked like a file; names as in `jaxatt.scenarios.replace`."""
    document = copy.deepcopy(dict(flight.document))
    for path, value in changes.items():
        assign(document, path, plain_values(value))
    return flight_from_mapping(document, origin=flight.origin, folder=flight.folder)
