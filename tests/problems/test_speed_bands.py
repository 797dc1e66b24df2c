"""Bands of speed that wheels avoid: ranges and stays against plain counting, and refusals."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.wheel_speeds import (
    band_records,
    broken_speeds,
    longest_stays,
    overstay,
    speed_excess,
    speed_range,
)
from jaxatt.spacecraft import reaction_wheels


def wheels_with(bands, limit=np.inf):
    return reaction_wheels(np.eye(3), 1e-5, 1e-3, limit, avoid=bands)


def random_bands(rng, count):
    """Bands that do not touch each other, the first of them around zero."""
    edges = np.sort(rng.uniform(5.0, 300.0, 2 * count - 1))
    return [(0.0, edges[0], 0.0)] + [(edges[2 * k - 1], edges[2 * k], 0.0) for k in range(1, count)]


def test_a_range_is_what_can_be_reached_without_a_forbidden_speed():
    rng = np.random.default_rng(8)
    for _ in range(20):
        bands, limit = random_bands(rng, 3), rng.uniform(310.0, 400.0)
        free = np.arange(-500.0, 500.0, 0.25)
        size = np.abs(free)
        allowed = size <= limit
        for low, high, _ in bands:
            allowed &= ~((size < high) & ((size > low) | (low == 0.0)))
        begins = rng.choice(free[allowed], 3)
        lower, upper = speed_range(wheels_with(bands, limit), begins)
        for first, least, most in zip(begins, lower, upper, strict=True):
            at = int(np.flatnonzero(free == first)[0])
            down = at - int(np.argmin(allowed[at::-1])) + 1
            up = at + int(np.argmin(allowed[at:])) - 1
            assert free[down] - 0.25 < least <= free[down]
            assert free[up] <= most < free[up] + 0.25


def test_a_crossing_is_found_however_fast():
    wheels = wheels_with([(0.0, 20.0, 0.0)])
    speeds = np.array([[[25.0, 25.0, -25.0], [-25.0, 21.0, -19.0]]])
    excess = speed_excess(wheels, speeds)
    np.testing.assert_allclose(excess, [[2.25, -0.05, 0.05]])
    (record,) = band_records(wheels, speeds[0], 1.0)
    assert not record.satisfied and "wheel 1" in record.outcome
    np.testing.assert_allclose(record.clearance, [-45.0, 1.0, -1.0])
    assert broken_speeds(wheels, speeds[0], 1.0) == [
        "the wheels do not avoid 0 to 20 rad/s: wheel 1 comes nearest, 45 rad/s inside"
    ]


def test_stays_are_those_of_a_dense_count():
    rng = np.random.default_rng(9)
    bands = [(0.0, 12.0, 2.0), (30.0, 45.0, 2.0)]
    wheels, step, fine = wheels_with(bands), 0.7, 4000
    speeds = np.cumsum(rng.normal(scale=12.0, size=(6, 25, 3)), axis=1)
    found = longest_stays(wheels, speeds, step)
    assert (found > 0.1).mean() > 0.5
    at = np.linspace(0.0, 24.0, 24 * fine + 1)
    for s in range(len(speeds)):
        for i in range(3):
            dense = np.interp(at, np.arange(25), speeds[s, :, i])
            for k, (low, high, _) in enumerate(bands):
                inside = (np.abs(dense) < high) & ((np.abs(dense) > low) | (low == 0.0))
                # A change of sense of rotation leaves one side of a band, and is no stay.
                edges = np.flatnonzero(np.diff(np.concatenate([[0], inside, [0]]).astype(int)))
                longest = max(np.diff(edges)[::2], default=0) * step / fine
                assert found[s, k, i] == pytest.approx(longest, abs=3.0 * step / fine)
    np.testing.assert_allclose(
        overstay(wheels, speeds, step), np.maximum(0.0, found.max(axis=(1, 2)) / 2.0 - 1.0)
    )


def test_a_wheel_that_rests_at_an_edge_is_not_inside():
    wheels = wheels_with([(0.0, 20.0, 1.0)])
    speeds = np.full((1, 50, 3), 20.0 * (1.0 - 1e-9))
    assert longest_stays(wheels, speeds, 1.0).max() == 0.0


def test_bands_that_may_be_crossed_are_barred_only_where_a_wheel_begins_outside():
    wheels = wheels_with([(0.0, 20.0, 1.0)])
    begins = np.array([30.0, 5.0, -20.0])
    for end in speed_range(wheels, begins):
        assert np.isinf(end).all()
    lower, upper = speed_range(wheels, begins, every_band=True)
    np.testing.assert_array_equal(lower, [20.0, -np.inf, -np.inf])
    np.testing.assert_array_equal(upper, [np.inf, np.inf, -20.0])


@pytest.mark.parametrize(
    ("bands", "speeds", "words"),
    [
        (
            [{"to_rad_s": 20.0}],
            [0.0, 30.0, 30.0, 30.0],
            "wheel 1 is at 0 rad/s, within the 0 to 20",
        ),
        ([{"from_rad_s": -20.0, "to_rad_s": 20.0}], [30.0] * 4, "one around zero is from 0"),
        ([{"from_rad_s": 30.0, "to_rad_s": 20.0}], [40.0] * 4, "give the slower edge first"),
        ([{"from_rad_s": 30.0}], [40.0] * 4, "to_rad_s: missing"),
        ([{"to_rad_s": 9.0, "leave_within_s": 0.0}], [40.0] * 4, "leave_within_s"),
        ([{"to_rad_s": 9.0, "leaves_s": 1.0}], [40.0] * 4, "leaves_s"),
        ({"to_rad_s": 9.0}, [40.0] * 4, "double brackets"),
    ],
)
def test_what_makes_no_sense_is_refused_with_its_mend(bands, speeds, words):
    document = {
        "name": "refused",
        "vehicle": {"use": "hypso1", "wheels": {"avoid": bands}},
        "initial": {"attitude_deg": [0.0, 0.0, 0.0], "wheel_speed_rad_s": speeds},
        "target": {"axis": [1.0, 0.0, 0.0], "angle_deg": 30.0},
        "horizon": {"intervals": 10},
        "objective": {"kind": "minimum-time"},
    }
    with pytest.raises(ScenarioError, match=r"avoid") as refused:
        scenarios.from_mapping(document)
    assert words in str(refused.value)
