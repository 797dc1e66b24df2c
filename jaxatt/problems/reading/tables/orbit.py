"""Keys of the tables [orbit] and [light]."""

from __future__ import annotations

from jaxatt.problems.reading.keys import Choice, Either, Number, Numbers, TableKey, Text, Texts

SOURCES = ("tle", "tle_file", "omm_file", "oem_file")
"""Keys that take the place of Keplerian elements."""

EPOCH = Text(
    "moment (UTC) at which the motion starts",
    otherwise="none, or that of the file of the orbit",
    example='"2026-06-21T12:00:00Z"',
)

ORBIT = TableKey(
    "orbit: Keplerian elements, or one of a TLE, an OMM or an OEM",
    {
        "tle": Texts("the two lines of a TLE", size=2, example='["1 ...", "2 ..."]'),
        "tle_file": Text("file of a TLE"),
        "omm_file": Text("file of an OMM, XML or KVN"),
        "oem_file": Text("file of an OEM, XML or KVN"),
        "object": Text("name or number of the satellite in a file of several"),
        "perturbations": Choice(
            "what perturbs an orbit given by its elements", options=("none", "J2"), default="none"
        ),
        "elements": Choice(
            "kind of the elements; mean ones need J2",
            options=("osculating", "mean"),
            default="osculating",
        ),
        "semi_major_axis_km": Number(
            "semi-major axis, from the Earth's centre",
            above=0.0,
            required=True,
            unless=SOURCES,
            example="6852.2",
        ),
        "eccentricity": Number(
            "eccentricity of a closed orbit",
            at_least=0.0,
            below=1.0,
            required=True,
            unless=SOURCES,
            example="0.002",
        ),
        "inclination_deg": Number(
            "inclination",
            at_least=0.0,
            at_most=180.0,
            required=True,
            unless=SOURCES,
            example="97.0",
        ),
        "raan_deg": Number(
            "right ascension of the ascending node", required=True, unless=SOURCES, example="0.0"
        ),
        "argument_of_periapsis_deg": Number(
            "argument of the periapsis", required=True, unless=SOURCES, example="0.0"
        ),
        "true_anomaly_deg": Number(
            "true anomaly at the start", required=True, unless=SOURCES, example="0.0"
        ),
        "gravitational_parameter_m3_s2": Number(
            "gravitational parameter of the Earth", default=3.986e14, above=0.0
        ),
        "epoch": EPOCH,
    },
)

LIGHT = TableKey(
    "sun and shadow along the orbit",
    {
        "irradiance_W_m2": Number(
            "power of sunlight on an area across it", default=1361.0, above=0.0
        ),
        "sun_inertial": Numbers(
            "direction to a sun that rests, in inertial axes",
            size=3,
            otherwise="the sun of the date",
        ),
        "sun_distance_m": Number(
            "distance of that sun", above=1e9, otherwise="one astronomical unit"
        ),
        "shadow": Choice(
            "shadow of the Earth",
            options=("none", "conical"),
            otherwise='"conical" with an [orbit], "none" without',
        ),
        "penumbra": Either(
            "share of the light that reaches the penumbra, or the sun's disk that is seen",
            forms=(Number(at_least=0.0, at_most=1.0), Choice(options=("disk",))),
            default=0.2,
        ),
        "earth_radius_m": Number(
            "radius of the Earth that casts the shadow", above=1e6, default=6.371e6
        ),
        "sun_radius_m": Number("radius of the sun", above=0.0, default=6.9634e8),
    },
)
