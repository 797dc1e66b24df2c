"""The table is the environment at the stage times, nothing else."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import adapters, random_vehicles, wheeled_body

from jaxatt.environment.table import coarsen, environment_at, tabulate

START, STEP, INTERVALS = 120.0, 1.4, 5

at = jax.jit(environment_at)


@pytest.fixture(scope="module")
def space():
    return random_vehicles.space(np.random.default_rng(3))


@pytest.mark.parametrize("substeps", [1, 3, 4])
def test_entries_are_the_environment_at_the_stage_times(space, substeps):
    surroundings = adapters.surroundings(space)
    table = tabulate(surroundings, START, STEP, INTERVALS, substeps)
    h = STEP / substeps
    np.testing.assert_allclose(table.substep, h, rtol=1e-14)
    assert table.stages.orbit_rate.shape == (INTERVALS, substeps, 4, 3)
    for k in range(INTERVALS):
        for s in range(substeps):
            for stage, ahead in enumerate((0.0, 0.5, 0.5, 1.0)):
                time = START + k * STEP + (s + ahead) * h
                expected = at(surroundings, jnp.asarray(time))
                for name in table.stages._fields:
                    entry = getattr(table.stages, name)[k, s, stage]
                    np.testing.assert_allclose(
                        entry, getattr(expected, name), rtol=1e-12, atol=1e-15
                    )
    times = START + STEP * np.arange(INTERVALS + 1)
    expected = at(surroundings, jnp.asarray(times))
    jax.tree.map(
        lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-15),
        table.nodes,
        expected,
    )


def test_the_environment_agrees_with_an_integrated_orbit(space):
    body = random_vehicles.body(np.random.default_rng(4), 3)
    flight = wheeled_body.fly(
        body, space, [1.0, 0, 0, 0], np.zeros(3), np.zeros(3), np.zeros((4, 3)), 100.0, START
    )
    times = START + 100.0 * np.arange(5)
    values = at(adapters.surroundings(space), jnp.asarray(times))
    rate = [wheeled_body.orbit_rate(r, v) for r, v in zip(flight.r, flight.v, strict=True)]
    np.testing.assert_allclose(values.orbit_rate, rate, rtol=1e-9, atol=1e-16)
    gradient = 3.0 * space.mu / np.linalg.norm(flight.r, axis=1) ** 3
    np.testing.assert_allclose(values.gradient, gradient, rtol=1e-9)
    wave = space.sine_amplitude * np.sin(space.sine_frequency * times)
    np.testing.assert_allclose(values.disturbance, np.tile(wave[:, None], 3), atol=1e-15)


def test_the_gravity_gradient_can_be_switched_off(space):
    on = adapters.surroundings(space)
    off = at(dataclasses.replace(on, gravity_gradient=jnp.asarray(0.0)), jnp.asarray(10.0))
    assert float(off.gradient) == 0.0
    assert float(at(on, jnp.asarray(10.0)).gradient) > 1e-6


@pytest.mark.parametrize(("fine", "coarse"), [(4, 1), (4, 2), (20, 4), (21, 1), (21, 3), (6, 6)])
def test_coarsening_a_fine_table_gives_the_coarse_one(space, fine, coarse):
    surroundings = adapters.surroundings(space)
    expected = tabulate(surroundings, START, STEP, INTERVALS, coarse)
    found = coarsen(tabulate(surroundings, START, STEP, INTERVALS + 2, fine), INTERVALS, coarse)
    jax.tree.map(
        lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-15), found, expected
    )
