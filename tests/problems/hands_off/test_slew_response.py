"""What controls do to the end of a slew: in one pass and exactly, against automatic derivatives."""

import functools
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.attitude import quaternion
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew.model import SlewForm, fly_nodes, terminal_rows
from jaxatt.problems.hands_off.slew.pulse_equations import pulse_equations
from jaxatt.problems.hands_off.slew.response import response_rows, slew_response
from jaxatt.problems.terminal_rows import RATE_SCALE
from jaxatt.runtime.settings import RUNS_ONCE

CASES = {
    "hypso1-90-45-15": SlewForm(),
    "hypso1-path": SlewForm(has_waypoint=True),
    "hypso1-90-45-15-perturbed": SlewForm(disturbed=True),
}


@functools.cache
def prepared(name, axes="body"):
    scenario = scenarios.replace(scenarios.load(name), {"control.axes": axes})
    task = build_slew(scenario)
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


exact = jax.jit(slew_response, static_argnums=2, compiler_options=RUNS_ONCE)


@functools.partial(jax.jit, static_argnums=(4, 5), compiler_options=RUNS_ONCE)
def swept(u, weights, moved, p, form, accurate):
    """Everything that the equations have to say, with the derivatives row by row."""
    found = pulse_equations(u, weights, moved, jnp.asarray(accurate), p, form)
    rows = jax.vmap(found.pullback)(jnp.eye(len(found.rows)))
    return found.rows, found.matrix, found.reached, rows


@pytest.mark.parametrize("name", CASES)
def test_the_derivatives_are_those_of_the_rows(name):
    form, u, p = prepared(name)
    rows, found = exact(u, p, form)
    np.testing.assert_allclose(rows, response_rows(u, p, form), atol=1e-14)
    jacobian = jax.jit(jax.jacrev(response_rows), static_argnums=2, compiler_options=RUNS_ONCE)
    expected = jacobian(u, p, form)
    np.testing.assert_allclose(found, np.swapaxes(expected, 0, 1), atol=1e-10)


@pytest.mark.parametrize("axes", ["body", "wheels"])
@pytest.mark.parametrize("name", CASES)
def test_one_pass_at_the_target_is_right_to_a_few_per_cent(name, axes):
    form, u, p = prepared(name, axes)
    p = aimed_at_its_end(u, p, form)
    expected, slopes = exact(u, p, form)
    rows, _, _, found = swept(u, jnp.ones_like(u), u, p, form, True)
    np.testing.assert_allclose(rows, expected, atol=1e-13)
    for first in range(0, len(rows), 3):
        block = slice(first, first + 3)
        want = np.swapaxes(slopes[:, block], 0, 1)
        np.testing.assert_allclose(found[block], want, atol=0.1 * np.abs(want).max())


@pytest.mark.parametrize("name", CASES)
def test_sums_of_one_pass_are_those_of_its_derivatives(name):
    form, u, p = prepared(name, "wheels")
    rng = np.random.default_rng(8)
    for _ in range(3):
        weights, moved = rng.uniform(0.0, 1.0, u.shape), rng.normal(size=u.shape)
        _, matrix, reached, jacobian = swept(u, weights, moved, p, form, False)
        want = np.einsum("ikc,kc,jkc->ij", jacobian, weights, jacobian)
        # The sums are taken in single precision.
        np.testing.assert_allclose(matrix, want, atol=1e-6 * np.abs(want).max())
        terms = np.einsum("ikc,kc->ik", jacobian, moved)
        np.testing.assert_allclose(
            reached, terms.sum(axis=1), atol=1e-6 * np.abs(terms).sum(axis=1).max()
        )


def test_rough_rows_differ_from_exact_ones_by_the_order_of_the_step():
    form, u, p = prepared("hypso1-90-45-15")
    errors = []
    for size in (1.0, 0.5):
        rough, accurate = (swept(size * u, u, u, p, form, flag)[0] for flag in (False, True))
        errors.append(np.abs(rough - accurate).max())
    assert 0.0 < errors[0] < 1e-3
    assert errors[1] < 0.6 * errors[0]


def test_rows_vanish_where_the_terminal_rows_do_and_measure_the_same_error_nearby():
    for name in CASES:
        form, u, p = prepared(name)
        p = aimed_at_its_end(u, p, form)
        near = u.at[3, 0].add(1e-4)
        angle = np.asarray(jax.jit(terminal_rows, static_argnums=2)(near, p, form))
        rows, _ = exact(near, p, form)
        for first in range(0, len(angle), 3):
            size = np.linalg.norm(angle[first : first + 3])
            np.testing.assert_allclose(np.linalg.norm(rows[first : first + 3]), size, rtol=1e-3)


def test_an_impulse_at_rest_changes_the_rate_by_its_size_over_the_inertia():
    form, u, p = prepared("hypso1-90-45-15")
    _, _, _, found = swept(0.0 * u, u, u, p, form, True)
    expected = -RATE_SCALE * p.step * p.body.inverse_inertia @ p.to_body
    for interval in np.moveaxis(found[3:6], 1, 0):
        np.testing.assert_allclose(interval, expected, atol=1e-15)


def test_a_spacecraft_with_much_momentum_searches_with_exact_derivatives():
    spinning = {"initial.wheel_speed_rad_s": [300.0, 300.0, 300.0, 300.0]}
    scenario = scenarios.replace(scenarios.load("hypso1-90-45-15"), spinning)
    task = build_slew(scenario)
    assert task.system.equations is None and task.system.response is not None
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
