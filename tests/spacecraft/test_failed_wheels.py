"""Wheels that have failed, and what the others can still do."""

import jax
import numpy as np
import pytest
from references.random_vehicles import wheel_axes
from scipy.optimize import linprog

from jaxatt.spacecraft import FieldError, reaction_wheels
from jaxatt.spacecraft.failed_wheels import loss_sentence, without
from jaxatt.spacecraft.wheel_envelope import largest_about_axes

RNG = np.random.default_rng(17)


def wheels(count, **changes):
    axes = wheel_axes(RNG, count)
    each = {
        "inertia": RNG.uniform(1e-4, 3e-4, count),
        "torque_limit": RNG.uniform(1e-3, 4e-3, count),
    }
    return reaction_wheels(axes, **{**each, "speed_limit": RNG.uniform(100, 600, count), **changes})


@pytest.mark.parametrize("count", [3, 4, 5, 6])
def test_the_largest_torque_about_each_axis_is_that_of_a_linear_programme(count):
    mounted = wheels(count)
    for axis, found in enumerate(largest_about_axes(mounted.axes, mounted.torque_limit)):
        about = np.eye(3)[axis]
        answer = linprog(
            np.r_[np.zeros(count), -1.0],
            A_eq=np.c_[mounted.axes, -about],
            b_eq=np.zeros(3),
            bounds=[*zip(-mounted.torque_limit, mounted.torque_limit, strict=True), (None, None)],
        )
        assert found == pytest.approx(-answer.fun, rel=1e-7)


def test_what_is_left_is_a_vehicle_with_the_other_wheels_under_their_names():
    mounted = wheels(5, names=("a", "b", "c", "d", "e"))
    left = without(mounted, ["d"])
    kept = [0, 1, 2, 4]
    built = reaction_wheels(
        mounted.axes[:, kept],
        mounted.inertia[kept],
        mounted.torque_limit[kept],
        mounted.speed_limit[kept],
    )
    for one, other in zip(jax.tree.leaves(left), jax.tree.leaves(built), strict=True):
        np.testing.assert_array_equal(one, other)
    assert left.names == ("a", "b", "c", "e")
    assert left.working == (0, 1, 2, 4)
    assert without(left, ["a"]).names == without(mounted, ["d", "a"]).names == ("b", "c", "e")


def test_names_never_recompile_anything():
    mounted = wheels(5)
    compiled = jax.jit(lambda craft: craft.axes @ craft.torque_limit)
    for name in mounted.names:
        compiled(without(mounted, [name]))
    assert compiled._cache_size() == 1


def test_two_directions_are_refused_with_the_one_that_is_lost():
    inside = RNG.normal(size=(3, 2)) @ RNG.normal(size=(2, 3))
    normal = np.linalg.svd(inside)[0][:, 2]
    mounted = reaction_wheels(np.c_[inside, normal], 1e-4, 1e-3)
    with pytest.raises(FieldError, match="span 2 of the three") as refused:
        without(mounted, ["wheel 4"])
    told = np.array(str(refused.value).partition("about (")[2].partition(")")[0].split(","), float)
    assert abs(told @ normal) == pytest.approx(1.0, abs=5e-3)
    with pytest.raises(FieldError, match="no wheel is called 'wheel 9'"):
        without(mounted, ["wheel 9"])
    with pytest.raises(FieldError, match="of its own"):
        reaction_wheels(np.eye(3), 1e-4, 1e-3, names=("x", "y", "x"))


def test_the_sentence_tells_both_falls():
    mounted = reaction_wheels(np.c_[np.eye(3), np.ones(3) / np.sqrt(3)], 1e-4, 2e-3, 500.0)
    told = loss_sentence(mounted, without(mounted, ["wheel 4"]))
    assert "to (2, 2, 2) mN m" in told and "to (0.05, 0.05, 0.05) N m s" in told
