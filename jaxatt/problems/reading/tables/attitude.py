"""Keys that say an attitude, a direction or a rate."""

from __future__ import annotations

from dataclasses import replace

from jaxatt.problems.reading.keys import Choice, Key, Keys, Number, Numbers, TableKey, Text
from jaxatt.problems.reading.tables.orbit import ORBIT

ATTITUDE_KEYS: Keys = {
    "attitude_deg": Numbers(
        "roll, pitch and yaw: R = Rz(yaw) Ry(pitch) Rx(roll), from body to orbit or inertial axes",
        size=3,
    ),
    "attitude_quaternion": Numbers("the same as a quaternion, scalar first", size=4, any_size=True),
    "attitude_mrp": Numbers("the same as modified Rodrigues parameters", size=3),
    "axis": Numbers("the same as a turn about this axis", size=3, any_size=True),
    "angle_deg": Number("angle of that turn", example="90.0"),
    "angle_rad": Number("angle of that turn", example="1.57"),
}
"""Three angles, a quaternion, modified Rodrigues parameters, or an axis with an angle."""

TOWARD_KEYS: Keys = {
    "toward": Choice(
        "direction in words",
        options=("nadir", "velocity", "sun", "field", "site", "satellite"),
    ),
    "direction_inertial": Numbers("direction in inertial axes, of any length", size=3),
    "direction_orbit": Numbers("direction in orbit axes, of any length", size=3),
    "right_ascension_deg": Number("right ascension of a direction among the stars"),
    "declination_deg": Number(
        "declination of that direction", at_least=-90.0, at_most=90.0, example="20.0"
    ),
    "latitude_deg": Number(
        'geodetic latitude of toward = "site"', at_least=-90.0, at_most=90.0, example="63.42"
    ),
    "longitude_deg": Number(
        'longitude of toward = "site", east positive',
        at_least=-360.0,
        at_most=360.0,
        example="10.39",
    ),
    "height_m": Number(
        "height of that site above the ellipsoid", default=0.0, at_least=-1e4, at_most=1e5
    ),
    "satellite": replace(
        ORBIT,
        meaning='orbit of the satellite of toward = "satellite"',
        inline=True,
        example='{ tle_file = "other.tle" }',
    ),
}
"""A direction in words, by components, or by angles."""
GIVEN = ("toward", "direction_inertial", "direction_orbit", "right_ascension_deg")
"""Keys, of which exactly one says a direction."""

DIRECTION_KEYS = TableKey(
    "a body axis and the direction that it is to have",
    {
        "body": Numbers(
            "axis in the body, of any length", size=3, required=True, example="[0.0, 0.0, 1.0]"
        ),
        **TOWARD_KEYS,
    },
    inline=True,
    apart=(GIVEN,),
)

AIM_KEYS: Keys = {
    "align": replace(DIRECTION_KEYS, meaning="a body axis that points along a direction"),
    "constrain": replace(
        DIRECTION_KEYS,
        meaning="a second body axis, turned towards another direction as far as it goes",
    ),
}
"""A body axis that points along a direction, and one that is turned towards another."""

POSE_KEYS: Keys = {**ATTITUDE_KEYS, **AIM_KEYS}
FILE_KEYS: Keys = {
    "aem_file": Text("CCSDS attitude file that says the attitude and its rate"),
    "at": Text(
        "moment (UTC) in that file at which the scenario starts",
        otherwise="the epoch",
        example='"2026-06-21T12:00:00Z"',
    ),
}
"""A CCSDS attitude file, and the moment (UTC) in it at which the scenario starts."""

FORMS = (
    ("attitude_deg", "attitude_quaternion", "attitude_mrp", "axis", "align"),
    ("attitude_deg", "attitude_quaternion", "attitude_mrp", "axis", "constrain"),
    ("angle_deg", "angle_rad"),
)
"""Of each of these, at most one is given."""

RATE_KEYS: Keys = {
    "rate_rad_s": Numbers(
        "rate relative to the frame of the attitude, in body axes",
        size=3,
        default=[0.0, 0.0, 0.0],
    ),
    "rate": Choice(
        "rate in words: resting in the orbit frame, resting among the stars, or following the "
        "directions of align and constrain",
        options=("orbit", "inertial", "track"),
    ),
}
RATE_FORMS = ("rate_rad_s", "rate")

FRAME: Keys = {
    "frame": Choice(
        "frame that attitude and rate are relative to",
        options=("inertial", "orbit"),
        default="inertial",
    )
}


def tolerances(degrees: float, rate: float) -> dict[str, Key]:
    """Keys of how far an attitude and a rate may be missed, with these defaults."""
    return {
        "attitude_tolerance_deg": Number(
            "largest error of the attitude", default=degrees, above=0.0, at_most=180.0
        ),
        "rate_tolerance_rad_s": Number("largest error of the rate", default=rate, above=0.0),
    }
