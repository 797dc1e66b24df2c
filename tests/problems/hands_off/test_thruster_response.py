"""The closed-form response of a slew with thrusters against flights and automatic derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.slew.thruster_response import thruster_response, thruster_rows
from jaxatt.runtime.settings import RUNS_ONCE

WHEELS = {"axes": np.eye(3), "inertia_kgm2": 0.01, "torque_limit_Nm": 0.05}
TILTED = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1], [0, 0, 1]]) / np.sqrt(3.0)


def mixed_task() -> SlewTask:
    """Wheels, spinning, beside tilted thrusters, from a tumbling start, at 12 intervals."""
    task = build_slew(
        scenarios.replace(
            scenarios.load("eseo-3"),
            {
                "horizon.intervals": 12,
                "horizon.horizon_s": 8.0,
                "vehicle.wheels": WHEELS,
                "vehicle.thrusters.torque_directions": TILTED,
                "initial.rate_rad_s": [0.02, -0.03, 0.01],
                "initial.wheel_speed_rad_s": [5.0, -3.0, 2.0],
            },
        )
    )
    assert isinstance(task, SlewTask)
    return task


@pytest.fixture(scope="module")
def task() -> SlewTask:
    return mixed_task()


@pytest.mark.parametrize("seed", range(3))
def test_rows_are_those_of_the_flight(task: SlewTask, seed: int) -> None:
    rng = np.random.default_rng(seed)
    u = rng.uniform(task.mounting.lower, task.mounting.upper, (12, task.size))
    rows = np.asarray(thruster_rows(jnp.asarray(u), task.arguments.plant, task.form))
    verdict, _ = task.verify(task.to_controls(u)[None])
    angle = 4.0 * np.arcsin(np.linalg.norm(rows[:3]) / 4.0)
    assert min(angle, 2 * np.pi - angle) == pytest.approx(verdict.errors["attitude"][0], abs=1e-4)
    assert np.linalg.norm(rows[3:]) / 10.0 == pytest.approx(verdict.errors["rate"][0], abs=1e-5)


automatic = jax.jit(jax.jacrev(thruster_rows), static_argnums=2, compiler_options=RUNS_ONCE)


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_agree_with_automatic_ones(task: SlewTask, seed: int) -> None:
    rng = np.random.default_rng(seed)
    u = jnp.asarray(rng.uniform(task.mounting.lower, task.mounting.upper, (12, task.size)))
    p = task.arguments.plant
    _, found = thruster_response(u, p, task.form)
    exact = jnp.swapaxes(automatic(u, p, task.form), 0, 1)
    scale = np.abs(exact).max(axis=(0, 2))
    assert (np.abs(found - exact).max(axis=(0, 2)) < 5e-3 * scale).all()
