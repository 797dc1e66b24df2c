"""Keys of a vehicle and of its parts."""

from __future__ import annotations

from dataclasses import replace

from jaxatt.problems.reading.keys import (
    Choice,
    Each,
    Keys,
    Matrix,
    Number,
    Rows,
    TableKey,
    Text,
    Texts,
    Whole,
)

_AVOID = TableKey(
    "bands of speed that wheels avoid",
    {
        "from_rad_s": Each("slowest speed of the band, in magnitude", default=0.0, signed=True),
        "to_rad_s": Each("fastest speed of the band", required=True, example="20.0"),
        "leave_within_s": Number(
            "longest stay in the band", above=0.0, otherwise="the band must never be entered"
        ),
    },
    many=True,
)
AVOID_KEYS = _AVOID
"""Edges of a band of speeds that wheels avoid, and how soon they must leave it."""

_MOUNTING = ("azimuth_deg", "elevation_deg")

WHEELS = TableKey(
    "reaction wheels",
    {
        "axes": Rows("spin axes in the body", of="wheel", required=True, unless=_MOUNTING),
        "azimuth_deg": Each(
            "spin axes by their azimuth, from x towards y, in place of axes; one number a wheel",
            signed=True,
        ),
        "elevation_deg": Each("elevation of those axes above the xy plane", signed=True),
        "inertia_kgm2": Each("inertia about the spin axis", required=True, example="2.1e-4"),
        "torque_limit_Nm": Each("largest torque", required=True, example="3e-3"),
        "speed_limit_rad_s": Each("fastest speed", infinite=True, otherwise="no limit"),
        "efficiency": Number("efficiency of the drives", default=1.0, above=0.0, at_most=1.0),
        "regeneration": Number(
            "share of the braking power that the drives recover",
            default=0.0,
            at_least=0.0,
            at_most=1.0,
        ),
        "names": Texts("names of the wheels", otherwise='"wheel 1", "wheel 2", ...'),
        "failed": Texts("names of the wheels that do not work", otherwise="none"),
        "coulomb_friction_Nm": Each("dry friction", default=0.0, zero=True),
        "viscous_friction_Nms": Each("friction for each rad/s", default=0.0, zero=True),
        "full_torque_speed_rad_s": Each(
            "speed up to which the motor gives all of its torque",
            zero=True,
            infinite=True,
            otherwise="any",
        ),
        "no_torque_speed_rad_s": Each(
            "speed from which it gives none", zero=True, infinite=True, otherwise="none"
        ),
        "avoid": _AVOID,
    },
    apart=tuple(("axes", angle) for angle in _MOUNTING),
    example="{ axes = [...], ... }",
)

THRUSTERS = TableKey(
    "thrusters",
    {
        "torque_directions": Rows(
            "direction of the torque of each thruster in the body, one row a thruster",
            of="thruster",
            required=True,
        ),
        "torque_limit_Nm": Each("torque of an open thruster", required=True, example="0.195"),
        "minimum_on_time_s": Each("shortest opening of a valve", default=0.0, zero=True),
        "minimum_impulse_Nms": Each("least angular impulse of a pulse", default=0.0, zero=True),
    },
)

MAGNETORQUERS = TableKey(
    "magnetorquers along the body axes",
    {
        "dipole_limit_Am2": Each("largest dipole of each axis", required=True, example="0.5"),
        "full_power_W": Number("power with all three at their limits", above=0.0),
        "turns": Each("turns of each coil"),
        "coil_area_m2": Each("area of each coil"),
        "resistance_ohm": Each("resistance of each coil"),
        "duty": Number("share of a period in which they act", default=1.0, above=0.0, at_most=1.0),
    },
)

PANELS = TableKey(
    "solar panels",
    {
        "normals": Rows("outward normals in the body, one row a panel", of="panel", required=True),
        "area_m2": Each(
            "area of each panel", zero=True, required=True, example="[0.03, 0.06, 0.02]"
        ),
        "efficiency": Each("efficiency of the cells", required=True, at_most=1.0, example="0.2"),
        "shades": Whole(
            "number of the deployed panel, counted from 1, that shades all others", otherwise="none"
        ),
        "incidence": Choice(
            "how the power falls with the angle of incidence",
            options=("cosine", "cosine-squared"),
            default="cosine",
        ),
    },
)

_CAPACITY = ("capacity_Wh", "capacity_J")
_CHARGE = ("charge_percent", "charge_Wh", "charge_J")
BATTERY = TableKey(
    "battery",
    {
        "capacity_Wh": Number("what it holds", at_least=0.0, otherwise="no limit"),
        "capacity_J": Number("the same", at_least=0.0),
        "charge_percent": Number("what it holds at the start", at_least=0.0, otherwise="full"),
        "charge_Wh": Number("the same", at_least=0.0),
        "charge_J": Number("the same", at_least=0.0),
        "input_efficiency": Number(
            "share of the power that arrives in it", default=1.0, above=0.0, at_most=1.0
        ),
        "output_efficiency": Number(
            "share of its power that arrives at what it feeds", default=1.0, above=0.0, at_most=1.0
        ),
    },
    apart=(_CAPACITY, _CHARGE),
)

LOADS = TableKey(
    "power of all else, by mode of operation",
    {
        "harvest_W": Number("while energy is earned", default=0.0, at_least=0.0),
        "image_W": Number("while images are taken", default=0.0, at_least=0.0),
        "communicate_W": Number("while pointing at a ground station", default=0.0, at_least=0.0),
        "idle_W": Number("while waiting", default=0.0, at_least=0.0),
    },
)

VEHICLE_PARTS: dict[str, TableKey] = {
    "wheels": WHEELS,
    "thrusters": THRUSTERS,
    "magnetorquers": MAGNETORQUERS,
    "panels": PANELS,
    "battery": BATTERY,
    "loads": LOADS,
}
"""Tables inside [vehicle]."""

_INERTIA = Matrix(
    "inertia of the whole vehicle in body axes, wheels included",
    required=True,
    example="[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]",
)
_NAMES: Keys = {
    "name": Text("name in reports", otherwise='"spacecraft"'),
    "title": Text("one line about it", otherwise="none"),
    "source": Text("where its numbers are from", otherwise="none"),
}

VEHICLE_FILE_KEYS = TableKey(
    "vehicle in a file of its own",
    {**_NAMES, "inertia_kgm2": _INERTIA, **VEHICLE_PARTS},
)

_BASE = ("use", "file")


def _partial(part: TableKey) -> TableKey:
    """A part of which another file may have what is not given here."""
    return replace(part, keys_={k: replace(v, required=False) for k, v in part.items()})


VEHICLE = TableKey(
    "spacecraft, in place or taken from a file with changes on top",
    {
        "use": Text("name of a bundled vehicle"),
        "file": Text("file of a vehicle, relative to this one"),
        **_NAMES,
        "inertia_kgm2": replace(_INERTIA, unless=_BASE),
        **{name: _partial(part) for name, part in VEHICLE_PARTS.items()},
    },
    apart=(_BASE,),
    required=True,
)
