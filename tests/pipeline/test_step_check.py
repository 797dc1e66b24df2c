"""Steps of closed-loop flights that are too long for law or wheels are named."""

import numpy as np
from references import short_flights
from references.short_flights import ConstantTorque

from jaxatt.pipeline.simulate import simulate
from jaxatt.scenarios import load_flight, replace_in_flight

PUBLISHED = "microsatellite-rest-to-rest"


def flown(changes, law="pd"):
    return simulate(replace_in_flight(load_flight(PUBLISHED), changes), law)


def test_a_step_that_is_short_enough_is_measured_and_left_alone():
    result = flown({})
    numbers = result.summary()
    assert numbers["flight_error_deg"] < 1e-6 and numbers["flight_error_rad_s"] < 1e-8
    assert not result.notes


def test_a_sampling_period_too_long_for_the_law_is_named():
    timing = {"duration_s": 240.0, "sampling_s": 60.0, "step_s": 0.5, "records": 4}
    result = flown({f"simulation.{key}": value for key, value in timing.items()})
    assert result.summary()["settled"] == 0
    assert any("sampling_s = 60 is too long for the law" in note for note in result.notes)


def test_a_step_too_long_for_the_wheels_momentum_is_named_and_the_advice_holds():
    law = ConstantTorque(np.zeros(3))

    def run(step):
        document = {
            "simulation": {
                "duration_s": 240.0,
                "sampling_s": 24.0,
                "step_s": step,
                "hold": "zero-order",
                "records": 10,
            },
            "initial": {
                "wheel_speed_rad_s": [400.0, 0.0, 0.0, 0.0],
                "rate_rad_s": [0.05, 0.05, 0.05],
            },
        }
        return simulate(short_flights.flight(**document), law)

    diverged = run(6.0)
    assert diverged.flight_error is None and "diverges" in diverged.notes[0]
    coarse = run(1.0)
    (note,) = [note for note in coarse.notes if "step_s" in note]
    assert "momentum of the wheels" in note
    advised = float(note.split("take ")[1])
    count = round(24.0 / advised)
    assert not [note for note in run(24.0 / count).notes if "step_s" in note]
