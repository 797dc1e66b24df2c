"""Charge of a battery: conserved until it is full, step by step by hand, refusals."""

import jax
import numpy as np
import pytest

from jaxatt.spacecraft import Battery, FieldError, battery, charge_along


def along_of(cell, gained, drawn):
    return charge_along(cell.net(gained, drawn), cell.charge, cell.capacity)


def test_charge_is_what_went_in_less_what_went_out():
    rng = np.random.default_rng(0)
    gained, drawn = rng.uniform(0.0, 30.0, 500), rng.uniform(0.0, 30.0, 500)
    cell = battery(1e6, 5e5, 0.92, 0.9)
    along = np.asarray(along_of(cell, gained, drawn))
    assert along.shape == (501,) and along[0] == 5e5
    assert along[-1] == pytest.approx(5e5 + 0.92 * gained.sum() - drawn.sum() / 0.9, rel=1e-13)


@pytest.mark.parametrize("seed", range(5))
def test_full_battery_takes_no_more(seed):
    rng = np.random.default_rng(seed)
    gained, drawn = rng.uniform(0.0, 30.0, 300), rng.uniform(0.0, 24.0, 300)
    cell = battery(100.0, 60.0, 0.95, 0.9)
    along = np.asarray(along_of(cell, gained, drawn))
    charge, expected = 60.0, [60.0]
    for into, out in zip(gained, drawn, strict=True):
        charge = min(charge + 0.95 * into - out / 0.9, 100.0)
        expected.append(charge)
    assert max(expected) == 100.0
    np.testing.assert_allclose(along, expected, atol=1e-9)
    other = np.asarray(charge_along(cell.net(gained, drawn), 100.0, cell.capacity))
    assert other[0] == 100.0 and other.max() == 100.0


def test_several_batteries_stand_side_by_side():
    changes = np.random.default_rng(9).normal(size=(3, 40))
    start, most = np.array([0.0, 1.0, 5.0]), np.array([np.inf, 1.5, 5.0])
    together = np.asarray(charge_along(changes, start, most))
    for k in range(3):
        np.testing.assert_array_equal(together[k], charge_along(changes[k], start[k], most[k]))
    assert together[1].max() == pytest.approx(1.5)
    np.testing.assert_allclose(together[0, 1:], changes[0].cumsum())


def test_an_empty_battery_says_how_much_is_missing():
    along = np.asarray(along_of(battery(100.0, 10.0), np.zeros(3), np.full(3, 5.0)))
    np.testing.assert_allclose(along, [10.0, 5.0, 0.0, -5.0])


def test_charge_can_be_batched_and_differentiated():
    cells = Battery(np.full(4, 100.0), np.linspace(10.0, 90.0, 4), np.ones(4), np.ones(4))
    gained, drawn = np.full(20, 3.0), np.full(20, 1.0)
    ends, slopes = jax.jit(
        jax.vmap(jax.value_and_grad(lambda cell: along_of(cell, gained, drawn)[-1]))
    )(cells)
    np.testing.assert_allclose(ends, [50.0, 10.0 + 80.0 / 3.0 + 40.0, 100.0, 100.0])
    np.testing.assert_allclose(slopes.charge, [1.0, 1.0, 0.0, 0.0])
    np.testing.assert_allclose(slopes.capacity, [0.0, 0.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"capacity": 100.0, "charge": 101.0},
            r"charge: starts at 101 J, above .* of 100 J; lower",
        ),
        ({"capacity": 0.0}, r"capacity: is 0 J; .*greater than 0"),
        ({"capacity": 100.0, "charge": -1.0}, r"charge: is -1 J; .*at least 0"),
        ({"input_efficiency": 1.1}, r"input_efficiency: is 1.1; .*at most 1"),
        ({"output_efficiency": 0.0}, r"output_efficiency: is 0; .*greater than 0"),
        ({"capacity": [1.0, 2.0]}, r"capacity: has shape \(2,\); give one number"),
    ],
)
def test_bad_batteries_are_refused(given, words):
    with pytest.raises(FieldError, match=words):
        battery(**given)
