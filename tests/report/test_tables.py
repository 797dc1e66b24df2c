"""What a terminal and a notebook show."""

import pytest

from jaxatt.records.wording import indices_text


def test_a_result_prints_its_numbers_units_and_tolerances(make):
    text = str(make())
    for words in (
        "reached the target",
        "attitude error [deg]",
        "0.005 (< 0.01)",
        "0, 20, 49",
        "3 of 6 reached, 2 converged, 2 distinct minima",
        "Note: a note",
    ):
        assert words in text
    assert repr(make()) == "Result(hypso1-90-45-15: reached, 3 active intervals: 0, 20, 49)"
    assert "reached the target" in make()._repr_html_()


def test_legs_stand_side_by_side(make):
    text = str(make("hypso1-path-two"))
    assert "leg 1" in text and "leg 2" in text and "together" in text


def test_doing_nothing_is_said_plainly(resting):
    text = " ".join(str(resting).split())
    assert "best that reaches" in text
    assert "The printed objective prefers not moving: J = 7.612 against 20" in text
    assert "45 (> 0.01)" not in text and "NOT reached" in text


def test_arrays_stay_out_of_short_forms(make):
    phase = make().phases[0]
    assert repr(phase) == "Phase(reached, 3 active intervals: 0, 20, 49)"
    assert repr(phase.starts) == "StartsRecord(3 of 6 reached)"


@pytest.mark.parametrize(
    ("indices", "text"),
    [
        ([], ""),
        ([3], "3"),
        ([0, 20, 21, 22, 23, 49], "0, 20-23, 49"),
        (list(range(0, 40, 2)), "0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22 and 8 more"),
    ],
)
def test_indices(indices, text):
    assert indices_text(indices) == text
