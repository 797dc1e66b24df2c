"""Transcribed problems: their derivatives beside JAX's own, and how their intervals are flown."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.optimize.optimal_control import lagrangian_hessian, linearisation
from jaxatt.optimize.scaled_objective import Scaled, scaled_objective
from jaxatt.optimize.transcription.transcribe import transcribe

SIZE, CONTROLS = 4, 2


def rates(x, u, p, time, free):
    pulled = jnp.stack([x[1] * x[2], -x[0] * u[0], jnp.sin(x[3] + time), x[0] * u[1] * free[0]])
    return p["speed"] * pulled - 0.1 * x**3


def a_program(curved=False, steps=1, running=True):
    """Everything at once: time, free parameters and final time, a running cost, a manifold."""

    def retract(x, e):
        moved = x[:3] + e + 0.1 * e**2 * x[3]
        return jnp.concatenate([moved, (x[3] * jnp.exp(0.2 * e[0]))[None]])

    def difference(x, r):
        """Of the same chart, by Newton's method from the plain difference."""
        e = x[:3] - r[:3]
        for _ in range(6):
            e = e - (r[:3] + e + 0.1 * e**2 * r[3] - x[:3]) / (1.0 + 0.2 * e * r[3])
        return e

    manifold = {"retract": retract, "difference": difference, "error_size": 3}
    return transcribe(
        rates,
        states=SIZE,
        controls=CONTROLS,
        intervals=10,
        initial_state=np.array([0.2, -0.1, 0.3, 1.0]),
        final_time=(0.5, 5.0),
        free_parameters=([-1.0], [2.0]),
        running_cost=(lambda x, u, p, final_time: u[0] ** 2 * x[0] + final_time * jnp.cos(x[2]))
        if running
        else None,
        control_bounds=lambda p: (jnp.stack([-p["speed"], -1.0]), jnp.stack([p["speed"], 3.0])),
        steps=steps,
        **(manifold if curved else {}),
    )


PARAMETERS = {"speed": jnp.asarray(0.7)}


@pytest.mark.parametrize(
    ("curved", "steps", "running"), [(False, 1, True), (False, 2, False), (True, 1, True)]
)
def test_derivatives_of_an_interval_are_those_of_jax(curved, steps, running):
    program = a_program(curved, steps, running)
    plain = dataclasses.replace(program, linearisation=None, lagrangian_hessian=None)
    rng = np.random.default_rng(3)
    stage = jax.tree.map(lambda leaf: leaf[4], program.stages(PARAMETERS))

    @jax.jit
    def both(x, u, x_next, costate):
        found = []
        for one in (program, plain):
            first = linearisation(one, x, u, x_next, stage, PARAMETERS)
            second = lagrangian_hessian(one, x, u, x_next, stage, PARAMETERS, costate, first.kept)
            found.append((*first[:3], second))
        return found

    for _ in range(3):
        x = program.start(PARAMETERS) + 0.3 * jnp.asarray(rng.normal(size=SIZE + 2))
        u = jnp.asarray(rng.uniform(-1.0, 1.0, CONTROLS))
        ahead = program.dynamics(x, u, stage, PARAMETERS)
        x_next = program.retract(ahead, 0.05 * jnp.asarray(rng.normal(size=program.error_size)))
        costate = jnp.asarray(rng.normal(size=program.error_size))
        for own, other in zip(*both(x, u, x_next, costate), strict=True):
            np.testing.assert_allclose(own, other, rtol=1e-9, atol=1e-11)


def test_derivatives_with_a_scaled_objective():
    program = a_program()
    scaled, factor = scaled_objective(program), jnp.asarray(40.0)
    plain = dataclasses.replace(scaled, linearisation=None, lagrangian_hessian=None)
    rng = np.random.default_rng(4)
    stage = jax.tree.map(lambda leaf: leaf[4], program.stages(PARAMETERS))
    x = program.start(PARAMETERS) + 0.3 * jnp.asarray(rng.normal(size=SIZE + 2))
    u, costate = jnp.asarray(rng.normal(size=CONTROLS)), jnp.asarray(rng.normal(size=SIZE + 2))

    @jax.jit
    def both(args):
        found = []
        for one in (scaled, plain):
            first = linearisation(one, x, u, x, stage, args)
            second = lagrangian_hessian(one, x, u, x, stage, args, costate, first.kept)
            found.append((*first[:3], second))
        return found

    for own, other in zip(*both(Scaled(PARAMETERS, factor)), strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-9, atol=1e-11)


def test_more_steps_approach_the_solution_at_fourth_order():
    """x' = -x over one interval of half a second: exp(-1/2)."""
    errors = []
    for steps in (2, 4, 8):
        program = transcribe(
            lambda x, u, p: -x,
            states=1,
            controls=1,
            intervals=2,
            initial_state=np.ones(1),
            final_time=1.0,
            steps=steps,
        )
        stage = jax.tree.map(lambda leaf: leaf[0], program.stages(()))
        end = program.dynamics(program.start(()), jnp.zeros(1), stage, ())
        finer = program.flight(program.start(()), jnp.zeros(1), stage, (), 4)
        errors.append(abs(float(end[0]) - np.exp(-0.5)))
        assert abs(float(finer[0]) - np.exp(-0.5)) < errors[-1] / 100.0
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.2)


def test_features_are_those_that_were_asked_for():
    flat, curved = a_program(), a_program(curved=True)
    bounded = {"control bounds", "free initial state", "terminal inequality"}
    assert flat.features == bounded | {"dynamics over stages"}
    assert curved.features - flat.features == {"manifold"}
