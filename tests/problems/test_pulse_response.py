"""The roll-out's by-product against differentiation, with little momentum and with much."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.attitude import quaternion
from jaxatt.problems.pulse_response import exact_response, pulse_response
from jaxatt.problems.slew import RATE_SCALE, SlewForm, fly_nodes, terminal_rows
from jaxatt.scenarios.build import build_task

CASES = {"hypso1-90-45-15": SlewForm(), "hypso1-path": SlewForm(has_waypoint=True)}


def prepared(name, axes="body"):
    scenario = scenarios.replace(scenarios.load(name), {"control.axes": axes})
    task = build_task(scenario)
    rng = np.random.default_rng(5)
    u = 0.02 * rng.normal(size=(task.intervals, task.size))
    return CASES[name], jnp.asarray(u), task.arguments.plant


def aimed_at_its_end(u, p, form):
    """The same slew, with target and waypoint where the roll-out happens to be."""
    end, nodes = fly_nodes(u, p, form)
    orbit = p.table.nodes.orbit_attitude

    def seen(q, node):
        return quaternion.multiply(quaternion.conjugate(orbit[node]), q)

    passed = nodes[p.waypoint_node - 1, :4]
    return replace(
        p,
        reference=seen(jnp.stack(end[:4]), -1),
        waypoint=seen(passed, p.waypoint_node),
    )


@pytest.mark.parametrize("axes", ["body", "wheels"])
@pytest.mark.parametrize("name", CASES)
def test_derivatives_at_the_target_are_right_to_a_few_per_cent(name, axes):
    form, u, p = prepared(name, axes)
    p = aimed_at_its_end(u, p, form)
    rows, found = jax.jit(pulse_response, static_argnums=2)(u, p, form)
    exact, expected = jax.jit(exact_response, static_argnums=2)(u, p, form)
    np.testing.assert_array_equal(rows, exact)
    for first in range(0, len(rows), 3):
        block = slice(first, first + 3)
        scale = np.abs(expected[:, block]).max()
        np.testing.assert_allclose(found[:, block], expected[:, block], atol=0.1 * scale)


def test_rows_vanish_where_the_terminal_rows_do_and_measure_the_same_error_nearby():
    for name in CASES:
        form, u, p = prepared(name)
        p = aimed_at_its_end(u, p, form)
        near = u.at[3, 0].add(1e-4)
        angle = np.asarray(jax.jit(terminal_rows, static_argnums=2)(near, p, form))
        rows, _ = jax.jit(pulse_response, static_argnums=2)(near, p, form)
        for first in range(0, len(angle), 3):
            size = np.linalg.norm(angle[first : first + 3])
            np.testing.assert_allclose(np.linalg.norm(rows[first : first + 3]), size, rtol=1e-3)


def test_an_impulse_at_rest_changes_the_rate_by_its_size_over_the_inertia():
    form, u, p = prepared("hypso1-90-45-15")
    _, found = pulse_response(0.0 * u, p, form)
    expected = -RATE_SCALE * p.step * p.body.inverse_inertia @ p.to_body
    np.testing.assert_allclose(found[:, 3:6], np.broadcast_to(expected, found[:, 3:6].shape))


def test_a_spacecraft_with_much_momentum_is_differentiated():
    spinning = {"initial.wheel_speed_rad_s": [300.0, 300.0, 300.0, 300.0]}
    scenario = scenarios.replace(scenarios.load("hypso1-90-45-15"), spinning)
    task = build_task(scenario)
    rng = np.random.default_rng(6)
    u = jnp.asarray(0.02 * rng.normal(size=(task.intervals, task.size)))
    rows, derivatives = jax.jit(task.system.response)(u, task.arguments.plant)
    way = rng.normal(size=u.shape)
    step = 1e-5
    ahead, behind = (
        jax.jit(task.system.response)(u + s * step * way, task.arguments.plant)[0] for s in (1, -1)
    )
    along = np.einsum("kmc,kc->m", derivatives, way)
    np.testing.assert_allclose((ahead - behind) / (2 * step), along, rtol=1e-4, atol=1e-6)
    assert len(rows) == 6
