"""What is wrong with a flight's file is named, with what is allowed and how to mend it."""

import jax.numpy as jnp
import numpy as np
import pytest
from references import short_flights

from jaxatt import scenarios, simulate
from jaxatt.control.proportional_derivative import ProportionalDerivative
from jaxatt.control.sliding_mode import SlidingMode
from jaxatt.scenarios import ScenarioError, replace_in_flight
from jaxatt.spacecraft import FieldError, magnetorquers

PD = {"kind": "pd", "proportional_1_s2": 1.0, "derivative_1_s": 2.0}
SUNLIT = {"area_m2": 0.1, "reflectance": 0.5, "lever_m": [0.0, 0.0, 0.1]}
DUMPING = {"gain_1_s": 0.015}

BAD = {
    "negative gain": ({"laws": {"pd": {**PD, "derivative_1_s": -1.0}}}, "derivative_1_s = -1.0"),
    "text for a gain": ({"laws": {"pd": {**PD, "derivative_1_s": "2"}}}, "not a number"),
    "unknown law": ({"laws": {"pd": {"kind": "pdd"}}}, "did you mean 'pd'"),
    "gain of another law": ({"laws": {"pd": {**PD, "slope_1_s": 1.0}}}, "slope_1_s"),
    "one gain for two modes": (
        {
            "laws": {
                "gs": {
                    "kind": "gain-scheduled",
                    "proportional_1_s2": [1.0],
                    "derivative_1_s": [1.0, 2.0],
                    "coupling_1_s": 0.1,
                    "threshold_Nm": 1.0,
                }
            }
        },
        "has 1 entries; give 2 numbers",
    ),
    "sampling off the step": (
        {"simulation": {"sampling_s": 0.1, "step_s": 0.03}},
        r"sampling_s = 0.1: is no multiple of step_s = 0.03; give 0.09 or 0.12",
    ),
    "step above the sampling": ({"simulation": {"step_s": 0.2}}, "is no multiple of step_s"),
    "duration off the sampling": ({"simulation": {"duration_s": 60.05}}, "no multiple of sampling"),
    "another hold": ({"simulation": {"hold": "first-order"}}, "allowed: zero-order"),
    "epoch after the model": (
        {"environment": {"epoch": "2030-01-01T00:00:01Z", "eddy_coefficient": 1.0}},
        "outside 1900-01-01 to 2030-01-01; eddy_coefficient needs the magnetic field of IGRF-14",
    ),
    "epoch that is none": ({"environment": {"epoch": "soon"}}, "is no moment; write it as"),
    "dipole without an epoch": (
        {"environment": {"residual_dipole_Am2": [0.01, 0.0, 0.0]}},
        "epoch: missing, and residual_dipole_Am2 needs the magnetic field of IGRF-14",
    ),
    "sunlight without an epoch": (
        {"environment": {"solar_pressure": SUNLIT}},
        "epoch: missing, and solar_pressure without sun_direction needs the sun's direction",
    ),
    "dumping without magnetorquers": (
        {"dumping": DUMPING, "vehicle": {"magnetorquers": None}},
        "needs magnetorquers, which the vehicle hypso1 lacks",
    ),
    "dumping without a field": ({"dumping": DUMPING}, "needs the Earth's magnetic field"),
    "band of the wrong kind": ({"settling": {"signal": "rate", "band_deg": 1.0}}, "band_rad_s"),
    "negative spread": ({"campaign": {"attitude_deg": -1.0}}, "must be at least 0"),
    "two references": (
        {"reference": {"manoeuvre": "hypso1-90-45-15"}},
        "given beside an attitude or rate",
    ),
    "a torque without an orbit": ({"orbit": None}, "gravity_gradient = true: needs an orbit"),
    "dipole limit": ({"vehicle": {"magnetorquers": {"dipole_limit_Am2": 0.0}}}, "greater than 0"),
    "a law that names no folder": ({"laws": {"a/b": PD}}, "results/NAME/LAW; use at most 100"),
    "printed that is no table": ({"printed": {"pd": 3}}, r"\[printed.pd\]: 3 is not a table"),
    "printed for two axes": (
        {"printed": {"pd": {"settling_s": [1.0, 2.0]}}},
        r"\[printed.pd\] settling_s .* has 2 entries; give 3",
    ),
    "printed reason": ({"printed": {"pd": {"why": "?"}}}, r"\[printed.pd.why\]: .* not a table"),
    "more steps than memory": ({"simulation": {"duration_s": 1e8}}, "steps, more than 1e[+]07"),
    "misspelt table": ({"simulatoin": {"duration_s": 1.0}}, "did you mean 'simulation'"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_named(case):
    changes, message = BAD[case]
    good = short_flights.flight()
    document = dict(good.document)
    for table, values in changes.items():
        if values is None:
            document.pop(table)
        elif table == "laws":
            document[table] = values
        else:
            merged = {**document.get(table, {}), **values}
            document[table] = {key: value for key, value in merged.items() if value is not None}
    with pytest.raises(ScenarioError, match=message):
        scenarios.flight_from_mapping(document)


@pytest.mark.parametrize("name", scenarios.names("flight"))
def test_every_bundled_flight_loads(name):
    flight = scenarios.load_flight(name)
    assert flight.name == name
    assert "Kristiansen" in flight.source or "Horri" in flight.source
    assert set(flight.printed) <= {*flight.laws, "why"}
    assert flight.laws


def test_an_unknown_flight_suggests_a_near_one():
    with pytest.raises(ScenarioError, match="did you mean 'hypso1-pointing'"):
        scenarios.load_flight("hypso1-pointin")


def test_replacing_checks_again():
    flight = short_flights.flight()
    changed = replace_in_flight(flight, {"laws.pd.derivative_1_s": 3.0})
    assert changed.laws["pd"].derivative == 3.0
    with pytest.raises(ScenarioError):
        replace_in_flight(flight, {"laws.pd.derivative_1_s": float("nan")})


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (ProportionalDerivative(jnp.eye(3), 1.0, -2.0), "derivative: holds -2 in Prop"),
        (ProportionalDerivative(jnp.eye(3), jnp.ones(3), 2.0), "proportional: has shape"),
        (ProportionalDerivative(jnp.eye(2), 1.0, 2.0), "inertia: has shape"),
        (SlidingMode(jnp.zeros(3), 0.1), "gain: holds 0 in SlidingMode"),
        (SlidingMode(jnp.asarray([1.0, np.nan, 1.0]), 0.1), "not a finite number"),
    ],
)
def test_gains_made_in_python_are_checked_too(law, message):
    with pytest.raises(FieldError, match=message):
        simulate(short_flights.flight(), law)


def test_a_law_that_is_not_there_and_no_runs():
    flight = short_flights.flight()
    with pytest.raises(ScenarioError, match="there are: pd"):
        simulate(flight, "lqr")
    for asked in ({"runs": 0}, {"runs": 10**30}, {"seed": -1}, {"seed": 2**31}):
        with pytest.raises(ValueError, match=r"must be at least \d and at most"):
            simulate(flight, **asked)


def test_magnetorquers_are_checked():
    with pytest.raises(FieldError, match="has shape"):
        magnetorquers([0.1, 0.2])
