"""Tables and keys that are allowed in a scenario file, and suggestions for misspelt ones."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from jaxatt.problems.reading.keys import Choice, TableKey
from jaxatt.problems.reading.tables import manoeuvre
from jaxatt.problems.reading.tables.objective import OBJECTIVE
from jaxatt.problems.reading.tables.orbit import ORBIT
from jaxatt.problems.reading.tables.vehicle import VEHICLE, VEHICLE_PARTS

SPACECRAFT = "spacecraft"
"""Value of `system` for a satellite, the default."""
SYSTEM = Choice("what is moved", default=SPACECRAFT)

Tables = Mapping[str, TableKey]
"""Name of a table in a file -> what it may hold."""

SPACECRAFT_TABLES: Tables = {
    "vehicle": VEHICLE,
    "orbit": ORBIT,
    "initial": manoeuvre.INITIAL,
    "target": manoeuvre.TARGET,
    "legs": manoeuvre.LEGS,
    "waypoint": manoeuvre.WAYPOINT,
    "horizon": manoeuvre.HORIZON,
    "disturbances": manoeuvre.DISTURBANCES,
    "control": manoeuvre.CONTROL,
    "objective": OBJECTIVE,
    "transcription": manoeuvre.TRANSCRIPTION,
    "windows": manoeuvre.WINDOWS,
    "keep_out": manoeuvre.KEEP_OUT,
    "keep_in": manoeuvre.KEEP_IN,
    "limits": manoeuvre.LIMITS,
    "solver": manoeuvre.SOLVER,
    "printed": manoeuvre.PRINTED,
}

# Longest suffix first: rate_rad_s ends in both "_rad_s" and "_s".
UNITS = {
    "_m3_s2": "m^3/s^2",
    "_rad_s": "rad/s",
    "_kgm2": "kg m^2",
    "_W_m2": "W/m^2",
    "_deg_s": "degrees a second",
    "_deg": "degrees",
    "_rad": "radians",
    "_km": "kilometres",
    "_Am2": "A m^2",
    "_m2": "m^2",
    "_percent": "percent",
    "_ohm": "ohms",
    "_Wh": "watt hours",
    "_Nms": "newton metre seconds",
    "_Nm": "newton metres",
    "_s2": "s^2",
    "_1_s": "1/s",
    "_W": "watts",
    "_J": "joules",
    "_m": "metres",
    "_s": "seconds",
}


def scenario_keys(tables: Tables, systems: tuple[str, ...] = (SPACECRAFT,)) -> TableKey:
    """Return what is declared at the top of a scenario file with these tables."""
    system = replace(SYSTEM, options=systems)
    return TableKey("scenario", {**manoeuvre.HEADING, "system": system, **tables})


def unit_of(key: str) -> str | None:
    """Return the unit that a key's name carries, in words, or None."""
    return next((unit for suffix, unit in UNITS.items() if key.endswith(suffix)), None)


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that was most likely meant by `name`, or None.

    A candidate that is `name` with a unit added comes first: a forgotten unit is the commonest
    slip, and plain similarity would prefer a shorter key.
    """
    names = {candidate.lower(): candidate for candidate in candidates}
    low = name.lower()
    meant = _with_unit(low, names.values())
    if meant is not None:
        return meant
    close = difflib.get_close_matches(low, names, n=1, cutoff=0.6)
    return names[close[0]] if close else None


def _with_unit(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that is `name`, in lower case, with a unit added, or None."""
    for candidate in candidates:
        for suffix in UNITS:
            if candidate.endswith(suffix) and name == candidate[: -len(suffix)].lower():
                return candidate
    return None


def unknown_key_mend(table: str, key: str, allowed: Collection[str]) -> str:
    """Return the sentence that helps with an unknown key: a close name, or all allowed ones."""
    # A key that exists in another table was misplaced rather than misspelt.
    elsewhere: Mapping[str, TableKey] = {
        **{f"vehicle.{part}": keys for part, keys in VEHICLE_PARTS.items()},
        **SPACECRAFT_TABLES,
    }
    for other, keys in elsewhere.items():
        if other != table and key in keys and _with_unit(key.lower(), allowed) is None:
            return f"did you mean to put it into [{other}]?"
    near = nearest(key, allowed)
    if near is not None:
        unit = " (units are part of the name)" if unit_of(near) else ""
        return f"did you mean '{near}'?{unit}"
    return f"allowed here: {', '.join(allowed)}"
