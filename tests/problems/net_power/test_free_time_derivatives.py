"""Closed-form derivatives of the programme in free time against automatic differentiation."""

import copy
import tomllib
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.build import free_manoeuvre_of
from jaxatt.problems.net_power.magnetic.program import magnetic_program
from jaxatt.problems.net_power.magnetic.task import MagneticTask

INTERVALS = 100
DOCUMENT = tomllib.loads(scenarios.text("mtq-free-time"))


def task_with(cost, terminal, disturbed=False):
    document = copy.deepcopy(DOCUMENT)
    document["horizon"] |= {"intervals": INTERVALS, "longest_s": 4000.0}
    document["objective"] = {"kind": "net-power", "cost": cost, "terminal": terminal}
    if not disturbed:
        document.pop("disturbances")
    scenario = scenarios.from_mapping(document)
    return MagneticTask(free_manoeuvre_of(scenario, PhaseStart()))


def at_random(program, p, rng):
    """A state, a control, a next state not far from where they lead, a stage and a costate."""
    stage = jax.tree.map(lambda leaf: leaf[rng.integers(INTERVALS)], program.stages(p))
    q = rng.normal(size=4)
    final = np.log(rng.uniform(600.0, 3500.0))
    x = jnp.asarray([*(q / np.linalg.norm(q)), *rng.normal(size=3), final])
    u = jnp.asarray(rng.uniform(-1.0, 1.0, 3))
    aside = jnp.asarray(0.2 * rng.normal(size=7))
    return (x, u, stage, aside), jnp.asarray(rng.normal(size=7))


def own(program, p, point, costate, second=True):
    """Gap, its slope, the cost's gradient and, if asked for, the Hessian, in closed form."""
    x, u, stage, aside = point
    x_next = program.retract(program.dynamics(x, u, stage, p), aside)
    found = program.linearisation(x, u, x_next, stage, p)
    first = found.gap, found.dynamics, found.cost
    if not second:
        return first
    return *first, program.lagrangian_hessian(x, u, x_next, stage, p, costate, found.kept)


def generic(program, p, point, costate, second=True):
    """The same by automatic differentiation."""
    x, u, stage, aside = point
    x_next = program.retract(program.dynamics(x, u, stage, p), aside)

    def moved(z):
        led, cost = program.next_and_cost(program.retract(x, z[:7]), u + z[7:], stage, p)
        return jnp.append(program.difference(led, x_next), cost)

    zero, weights = jnp.zeros(10), jnp.append(costate, 1.0)
    slope = jax.jacfwd(moved)(zero)
    first = moved(zero)[:7], slope[:7], slope[7]
    if not second:
        return first
    return *first, jax.jacfwd(jax.grad(lambda z: weights @ moved(z)))(zero)


def errors(task, substeps, second=True, seeds=4):
    """Errors of gap, slope, gradient and Hessian relative to their sizes, at random points."""
    program = magnetic_program(replace(task.form(True), substeps=substeps))
    p, rng = task.sharper(0.05), np.random.default_rng(7)
    ours, wanted = (jax.jit(lambda *at, f=f: f(program, p, *at, second)) for f in (own, generic))
    rows = []
    for _ in range(seeds):
        at = at_random(program, p, rng)
        pairs = zip(ours(*at), wanted(*at), strict=True)
        rows.append([float(jnp.abs(a - b).max() / jnp.abs(b).max()) for a, b in pairs])
    return np.array(rows)


def test_derivatives_are_those_of_the_programme():
    """Up to the error of the steps: the formula begins from another attitude after a turn."""
    task = task_with("mean-power", "reach")
    coarse, fine = errors(task, 2, second=False), errors(task, 4)
    assert coarse.max() < 1e-5
    assert fine[:, :3].max() < coarse.max() / 8.0
    # The environment's second derivatives in time are those of a table of their own.
    assert fine[:, 3].max() < 1e-4


@pytest.mark.slow
@pytest.mark.optimised
def test_only_second_derivatives_of_small_torques_are_left_out():
    found = errors(task_with("energy", "reach", disturbed=True), 4)
    assert found[:, :3].max() < 1e-5
    assert found[:, 3].max() < 0.05


def test_curvature_of_the_first_passes_is_not_negative():
    task = task_with("mean-power", "reach")
    program, rng = magnetic_program(replace(task.form(False), substeps=2)), np.random.default_rng(3)
    p = task.sharper(0.05)
    ours = jax.jit(lambda *at: own(program, p, *at)[3])
    for _ in range(6):
        hessian = np.asarray(ours(*at_random(program, p, rng)))
        assert np.linalg.eigvalsh(hessian).min() > -1e-9 * np.abs(hessian).max()
