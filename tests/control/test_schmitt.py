"""The PD law with Schmitt triggers: open or shut, with memory between the thresholds."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.control.schmitt import SchmittLaw
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.pd_flight import flown_controls, fly_pd
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.spacecraft.dynamics import AttitudeState


@pytest.fixture(scope="module")
def task() -> SlewTask:
    task = build_slew(scenarios.load("eseo-3"))
    assert isinstance(task, SlewTask)
    return task


@pytest.mark.parametrize("seed", range(20))
def test_valves_keep_their_state_between_the_thresholds(task: SlewTask, seed: int) -> None:
    rng = np.random.default_rng(seed)
    law = SchmittLaw(task.craft, jnp.asarray([1.0, 0, 0, 0]), jnp.zeros(3))
    state = AttitudeState(
        jnp.asarray([1.0, 0, 0, 0]), jnp.asarray(0.05 * rng.normal(size=3)), jnp.zeros(0)
    )
    opened = jnp.asarray(rng.uniform(size=6) < 0.5)
    environment = jax.tree.map(lambda leaf: leaf[0], task.table.nodes)
    thrust, after = law(jnp.asarray(0), state, environment, opened)
    wanted = -2.3 * np.asarray(state.omega_ib)
    demand = np.concatenate([wanted, -wanted])
    expected = np.where(demand > 0.06, True, np.where(demand > 0.02, np.asarray(opened), False))
    np.testing.assert_array_equal(after, expected)
    np.testing.assert_allclose(thrust, np.where(expected, 0.0975, 0.0))


def test_baseline_brings_the_satellite_near_with_valves_open_or_shut(task: SlewTask) -> None:
    flown = fly_pd(task)
    controls = flown_controls(task, flown)
    share = controls / 0.0975
    np.testing.assert_allclose(share, np.round(share), atol=1e-12)
    assert not ((controls[:, :3] > 0.0) & (controls[:, 3:] > 0.0)).any()
    errors = task.end_errors(flown.q_ob[None], flown.omega_ob[None])
    assert np.degrees(errors["attitude"][0]) < 10.0
    sparse = (controls > 0.0).any(axis=1).sum()
    assert 10 < sparse < 45
