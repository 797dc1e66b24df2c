"""Derivatives through the closed loop, and what descent makes of them."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.scenarios import load_flight, replace_in_flight
from jaxatt.scenarios.flight_build import build_flight
from jaxatt.simulation.slew_metrics import quaternion_accuracy, rmsd
from jaxatt.studies.tuning import _evaluator, tune
from jaxatt.studies.tuning_procedure import tune_as_printed

FREE = ("coupling", "proportional.1", "derivative.1")


@pytest.fixture(scope="module")
def flight():
    return replace_in_flight(
        load_flight("eigenaxis-tuning"),
        {"simulation.duration_s": 200.0, "simulation.sampling_s": 0.05, "simulation.step_s": 0.05},
    )


@pytest.fixture(scope="module")
def procedure(flight):
    return tune_as_printed(flight, "gamma-020", 89.13)


def test_gradients_are_those_of_finite_differences(flight):
    shared, start = build_flight(flight)
    gains = np.array([0.03, 0.05, 0.25])
    evaluate = _evaluator(shared, start, flight.laws["gamma-015"], FREE, gains)
    _, slopes = evaluate(jnp.zeros(3))
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-3
        up, down = (np.asarray(evaluate(jnp.asarray(sign * step))[0]) for sign in (1, -1))
        difference = (up - down) / 2e-3
        np.testing.assert_allclose(slopes[0, k], difference[0], rtol=0.03)
        # One per cent of the integral: its own kinks, where the torque changes sign, are no finer.
        np.testing.assert_allclose(slopes[1, k], difference[1], rtol=0.05, atol=1e-3)


def test_the_printed_procedure_keeps_the_torque_and_nears_the_limit(procedure):
    k = procedure.chosen
    assert procedure.gamma == pytest.approx(0.015, rel=1e-3)
    assert procedure.peak[k] <= procedure.peak[0] * (1 + 1e-9)
    assert procedure.peak[k + 1] > procedure.peak[0]
    assert 89.13 < procedure.settling[k] < 92.0
    assert procedure.settling[-1] < 89.13  # into the band a little before the limit
    assert (np.diff(procedure.peak[k:]) > 0.0).all()


def test_descent_settles_faster_within_the_same_torque(flight, procedure):
    k = procedure.chosen
    begun = dataclasses.replace(flight, laws={"law": procedure.law}, law_titles={"law": "law"})
    # A hair above: where both peaks tie, only one of them has a derivative.
    tuned = tune(begun, "law", FREE, peak_limit=1.002 * float(procedure.peak[k]))
    assert tuned.before["settling"] == pytest.approx(procedure.settling[k], abs=1e-6)
    assert tuned.values["settling"] < procedure.settling[k] - 2.0
    assert tuned.values["peak"] <= 1.0021 * procedure.peak[k]
    assert (np.diff(tuned.history[:, 0]) < 1.0).all()


def test_bad_tunings_are_refused(flight):
    with pytest.raises(ValueError, match="choose one of settling, integral"):
        tune(flight, "gamma-020", FREE, aim="comfort")
    with pytest.raises(ValueError, match="has no gain 'slope'"):
        tune(flight, "gamma-020", ["slope"])
    with pytest.raises(ValueError, match="no latched"):
        tune_as_printed(flight, "pd", 90.0)


def test_slew_measures():
    rng = np.random.default_rng(2)
    values, reference = rng.normal(size=(2, 50, 3))
    expected = np.sqrt(((values - reference) ** 2).mean(axis=0))
    np.testing.assert_allclose(rmsd(values, reference), expected, rtol=1e-12)
    half = 0.5e-3 * np.arange(50)
    q = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)
    q_ref = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (50, 4))
    printed, angle = quaternion_accuracy(q, q_ref)
    assert printed == pytest.approx(np.arccos(np.abs((q * q_ref).sum(axis=1))).mean(), rel=1e-6)
    assert angle == pytest.approx(2 * half.mean(), rel=1e-9)
