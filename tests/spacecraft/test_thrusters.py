"""Thrusters: what they can turn, and what is refused."""

import jax
import numpy as np
import pytest
from scipy.optimize import linprog

from jaxatt.spacecraft import FieldError, create, reaction_wheels, thrusters
from jaxatt.spacecraft.thrusters import missing_senses

PAIRS = np.concatenate([np.eye(3), -np.eye(3)], axis=1)


@pytest.mark.parametrize("seed", range(12))
def test_missing_senses_agree_with_linear_programming(seed: int) -> None:
    rng = np.random.default_rng(seed)
    torques = rng.normal(size=(3, int(rng.integers(1, 7))))
    missing = missing_senses(torques)
    for index, axis in enumerate("xyz"):
        for sign in (1.0, -1.0):
            wanted = sign * np.eye(3)[index]
            composed = linprog(np.zeros(torques.shape[1]), A_eq=torques, b_eq=wanted).success
            assert composed == (f"{'+' if sign > 0 else '-'}{axis}" not in missing)


def test_four_tilted_thrusters_turn_about_everything() -> None:
    tetrahedron = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]).T / np.sqrt(3.0)
    assert missing_senses(tetrahedron) == ()
    assert missing_senses(tetrahedron[:, :3]) != ()


def test_vehicle_without_a_sense_is_refused_by_name() -> None:
    with pytest.raises(FieldError, match=r"turns the body about -y, -z; add or tilt"):
        create(np.eye(3), None, thrusters=thrusters(PAIRS[:, :4], 0.1))


def test_wheels_make_up_for_missing_thrusters() -> None:
    wheels = reaction_wheels(np.eye(3), 1e-4, 1e-3)
    craft = create(np.eye(3), wheels, thrusters=thrusters(PAIRS[:, :2], [0.1, 0.2]))
    assert craft.actuators == 5
    leaves = jax.tree.leaves(craft)
    assert jax.tree.unflatten(jax.tree.structure(craft), leaves).thrusters.count == 2


def test_vehicle_needs_an_actuator() -> None:
    with pytest.raises(FieldError, match="mount one of the three"):
        create(np.eye(3), None)


def test_opposed_thrusters_and_shortest_pulse() -> None:
    built = thrusters(PAIRS * [1, 2, 3, 4, 5, 6], 0.5, 0.01, [0.0, 0.1, 0, 0, 0, 0])
    assert built.opposed == ((0, 3), (1, 4), (2, 5))
    np.testing.assert_allclose(built.shortest_pulse, [0.01, 0.2, 0.01, 0.01, 0.01, 0.01])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"torque_limit": -0.1}, "torque_limit: holds -0.1; every value must be greater than 0"),
        ({"torque_limit": [0.1, 0.1]}, "there are 6 thrusters"),
        ({"minimum_on_time": -1.0}, "minimum_on_time: holds -1; every value must be at least 0"),
        ({"minimum_impulse": np.nan}, "minimum_impulse: holds nan"),
        ({"torque_directions": np.zeros((3, 2))}, "thruster 1 has the torque direction"),
        ({"torque_directions": np.ones((2, 2))}, r"has shape \(2, 2\)"),
    ],
)
def test_bad_values_are_named(changes: dict, words: str) -> None:
    values = {"torque_directions": PAIRS, "torque_limit": 0.1, **changes}
    with pytest.raises(FieldError, match=words):
        thrusters(**values)
