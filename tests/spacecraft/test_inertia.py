"""Plates of data sheets: the largest moment is the sum of the others, up to rounding."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.spacecraft import FieldError
from jaxatt.spacecraft.inertia import checked_inertia


def plate(rng, turned):
    moments = np.sort(rng.uniform(0.3, 1.0, 2))
    matrix = np.diag([*moments, moments.sum()])
    if turned:
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        matrix = axes @ matrix @ axes.T
    return matrix


def excess(matrix):
    moments = np.linalg.eigvalsh(matrix)
    return moments[2] - moments[0] - moments[1]


@pytest.mark.parametrize("turned", [False, True])
def test_plates_rounded_to_three_decimals_are_taken_with_a_note(turned):
    rng = np.random.default_rng(12)
    noted = 0
    for _ in range(200):
        rounded = np.round(plate(rng, turned), 3)
        notes = []
        taken = checked_inertia(rounded.tolist(), notes)
        np.testing.assert_allclose(taken, rounded, atol=1e-16)
        assert bool(notes) == (excess(rounded) > 1e-9 * np.linalg.norm(rounded, 2))
        noted += bool(notes)
    assert noted > 10


@pytest.mark.parametrize("turned", [False, True])
def test_what_rounding_does_not_explain_is_refused(turned):
    rng = np.random.default_rng(13)
    for _ in range(50):
        exact = plate(rng, turned)
        values, axes = np.linalg.eigh(exact)
        values[2] *= 1.02
        wrong = np.round(axes @ np.diag(values) @ axes.T, 3)
        with pytest.raises(FieldError, match="no body can have"):
            checked_inertia(0.5 * (wrong + wrong.T), [])
        with pytest.raises(FieldError, match="no body can have"):
            checked_inertia(np.diag([0.1, 0.1, 0.3]), [])


def test_a_plate_of_a_data_sheet_in_a_file():
    inertia = [[0.333, 0.0, 0.0], [0.0, 0.333, 0.0], [0.0, 0.0, 0.667]]
    changes = {"vehicle.inertia_kgm2": inertia}
    scenario = scenarios.replace(scenarios.load("hypso1-90-45-15"), changes)
    assert any("exceeds the sum of the other two by 0.001, within" in n for n in scenario.notes)
    np.testing.assert_allclose(scenario.vehicle.inertia, inertia)
