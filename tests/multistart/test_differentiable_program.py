"""Answers of `solve_program` as functions of their parameters, against solving again."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

import jaxatt


def dynamics(x, u, p):
    return jnp.stack([x[1], u[0] / p["mass"] - p["drag"] * x[1]])


@pytest.fixture(scope="module")
def solved():
    program = jaxatt.transcribe(
        dynamics,
        states=2,
        controls=1,
        intervals=10,
        initial_state=lambda p: p["start"],
        final_time=(0.5, 20.0),
        running_cost=lambda x, u, p: 0.1 * u[0] ** 2,
        terminal_cost=lambda x, p, final_time: final_time,
        terminal_equality=lambda x, p: x - p["target"],
        control_bounds=lambda p: (-p["most"], p["most"]),
        path_inequality=lambda x, u, p: p["fastest"] - x[1],
    )
    rng = np.random.default_rng(5)
    parameters = {
        "mass": jnp.asarray(rng.uniform(0.9, 1.3)),
        "drag": jnp.asarray(rng.uniform(0.05, 0.15)),
        "start": jnp.asarray([0.0, rng.uniform(0.0, 0.1)]),
        "target": jnp.asarray([rng.uniform(1.8, 2.2), 0.0]),
        "most": jnp.asarray([1.5]),
        "fastest": jnp.asarray(0.8),
    }

    def solve(p, **guess):
        return jaxatt.solve_program(program, p, starts=2, tolerance=1e-10, **guess)

    found = solve(parameters)
    return parameters, found, solve, jaxatt.differentiable_program(program, found, parameters)


def test_derivatives_are_those_of_solving_again(solved):
    parameters, found, solve, optimum = solved
    record = optimum.sensitivities()
    assert record.regular and len(record.active) >= 4
    np.testing.assert_allclose(record.objective, found.objective, rtol=1e-9)
    flat, unflat = ravel_pytree(parameters)
    assert len(record.names) == len(flat)
    guess = {"controls": found.controls, "states": found.states, "final_time": found.final_time}
    for k in range(len(flat)):
        ends = [solve(unflat(flat.at[k].add(s * 1e-5)), **guess) for s in (1.0, -1.0)]
        slope = (ends[0].objective - ends[1].objective) / 2e-5
        np.testing.assert_allclose(record.by_parameter[k], slope, rtol=1e-5)
        for name in ("controls", "states", "final_time"):
            moved = (getattr(ends[0], name) - getattr(ends[1], name)) / 2e-5
            scale = np.abs(moved).max()
            got = record.variables[name][k]
            np.testing.assert_allclose(got, moved, rtol=1e-5, atol=1e-5 * scale)


def test_it_composes_with_a_cost_of_the_parameters(solved):
    parameters, _, _, optimum = solved
    record = optimum.sensitivities(["mass"])

    def whole(mass):
        value, variables = optimum({**parameters, "mass": mass})
        return value + mass * variables["final_time"] ** 2

    slope = jax.jit(jax.jvp, static_argnums=0)(whole, (parameters["mass"],), (1.0,))[1]
    time = optimum(parameters)[1]["final_time"]
    want = record["mass"] + time**2
    want = want + 2.0 * parameters["mass"] * time * record.variables["final_time"][0]
    np.testing.assert_allclose(slope, want, rtol=1e-8)
