"""Closed-form derivatives of the wheels' programme against automatic ones, for all its forms.

Directional derivatives at random states: the same few directions for every form, so that what JAX
evaluates operation by operation compiles once.
"""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from printed_cases import FIRST, chapter_4, chapter_5, eclipse_entry, hypso2

from jaxatt.environment.external import ExternalTorques
from jaxatt.problems.net_power.manoeuvre import Motion, WheelLimits
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.spacecraft.wheel_motor import wheel_motors

WAYS = 10
STILL, HYPSO2 = chapter_4(), hypso2()
TURNING = dataclasses.replace(
    STILL, start=Motion(STILL.start.q_ib, np.array([0.01, -0.02, 0.015]), np.array([20, -30, 10.0]))
)


def of(manoeuvre, regeneration=0.0, rubbing=False, **satellite):
    """A manoeuvre with other wheels and another satellite."""
    given = manoeuvre.satellite
    wheels = dataclasses.replace(given.craft.wheels, regeneration=regeneration)
    if rubbing:
        motors = wheel_motors(wheels.count, 2e-4, 8e-6, 25.0, 70.0)
        wheels = dataclasses.replace(wheels, motors=motors)
    craft = dataclasses.replace(given.craft, wheels=wheels)
    return dataclasses.replace(
        manoeuvre, satellite=dataclasses.replace(given, craft=craft, **satellite)
    )


def limited(manoeuvre):
    """The manoeuvre with motors that rub and weaken, and wheels that are not to turn too fast."""
    given = of(manoeuvre, 0.5, rubbing=True)
    wheels = given.satellite.craft.wheels
    wheels = dataclasses.replace(wheels, speed_limit=np.full(wheels.count, 400.0))
    craft = dataclasses.replace(given.satellite.craft, wheels=wheels)
    limits = WheelLimits(np.full(wheels.count, 0.1), np.full(wheels.count, 0.05))
    satellite = dataclasses.replace(given.satellite, craft=craft)
    return dataclasses.replace(given, satellite=satellite, limits=limits)


@functools.cache
def manoeuvre_of(name):
    orbit = dataclasses.replace(chapter_5(2, FIRST, HYPSO2), floor=1e5, charge=2e5)
    shadow = dataclasses.replace(orbit, start_time=eclipse_entry(HYPSO2) - 7.0)
    decided = {"momentum": None, "decided_dipole": True, "wheel_power": "wheels"}
    return {
        "at rest, signed": lambda: STILL,
        "at rest, wheel by wheel": lambda: of(STILL, wheel_power="wheels"),
        "turning, signed": lambda: TURNING,
        "turning, body axes": lambda: of(TURNING, wheel_power="body"),
        "turning, regeneration": lambda: of(TURNING, 0.5, wheel_power="wheels"),
        "turning, signed, friction": lambda: of(TURNING, rubbing=True),
        "turning, limits": lambda: limited(of(TURNING, wheel_power="wheels")),
        "turning, body axes, limits": lambda: limited(of(TURNING, wheel_power="body")),
        "gravity gradient": lambda: of(
            orbit, torques=ExternalTorques(), momentum=None, wheel_power="signed"
        ),
        "managed, body axes, eclipse": lambda: shadow,
        "managed, regeneration": lambda: of(orbit, 0.3, wheel_power="wheels"),
        "decided dipole, eclipse": lambda: of(shadow, **decided),
    }[name]()


FREE = ("at rest, signed", "at rest, wheel by wheel", "turning, signed", "turning, body axes")
RUBBING = ("turning, signed, friction", "turning, limits", "turning, body axes, limits")
FREE += ("turning, regeneration", *RUBBING)
TORQUED = ("gravity gradient", "managed, body axes, eclipse", "managed, regeneration")
TORQUED += ("decided dipole, eclipse",)


@dataclasses.dataclass
class Both:
    """Values and derivatives along random directions: closed ones, and automatic ones."""

    first: list
    hessian: tuple
    path: tuple


@functools.cache
def both(name, shorter=1.0, missed=0.0, weaker=1.0, seed=0):
    """shorter, weaker : of the interval and of the external torques.  missed : size of the gap."""
    task = wheels_task(manoeuvre_of(name))
    form, p, program = task.form, task.parameters, wheels_programme(task.form)
    p = jax.tree.map(jnp.asarray, p)
    stage = jax.tree.map(lambda leaf: leaf[3], p.stages)
    along = stage.along
    if along is not None:
        field = None if along.field is None else jax.tree.map(lambda b: b * weaker, along.field)
        along = along._replace(field=field, gradient=along.gradient * weaker)
    stage = stage._replace(step=stage.step / shorter, paid=stage.paid / shorter, along=along)
    rng, n, size = np.random.default_rng(seed), form.error_size, form.error_size + form.controls
    q = rng.normal(size=4)
    parts = [q / np.linalg.norm(q), 0.03 * rng.normal(size=form.stored)]
    parts += [0.03 * rng.normal(size=3)] * form.torqued + [[0.3]] * form.charge
    x, u = jnp.asarray(np.concatenate(parts)), jnp.asarray(rng.uniform(0.05, 1.0, form.controls))
    # Some torques are at their limit.
    u = u.at[: form.wheels].set(jnp.clip(rng.uniform(-1.5, 1.5, form.wheels), -1.0, 1.0))
    ahead = program.dynamics(x, u, stage, p)
    x_next = program.retract(ahead, jnp.asarray(missed * rng.normal(size=n)))
    costate = jnp.asarray(rng.normal(size=n))
    ways, others = (jnp.asarray(rng.normal(size=(WAYS, size))) for _ in range(2))
    limited = program.inequality is not None
    rows = len(program.inequalities(x, u, stage, p)) if limited else 0
    dual = jnp.asarray(rng.uniform(0.0, 1.0, rows))

    def values(z):
        moved = program.retract(x, z[:n]), u + z[n:], stage, p
        ahead, cost = program.next_and_cost(*moved)
        return program.difference(ahead, x_next), cost, program.inequalities(*moved)

    def twice(a, b):
        zero = jnp.zeros(size)
        return jax.jvp(lambda z: jax.jvp(values, (z,), (a,)), (zero,), (b,))

    (given, slopes), (_, bends) = jax.vmap(twice)(ways, others)
    gap, cost, path = (leaf[0] for leaf in given)
    found = program.linearisation(x, u, x_next, stage, p)
    hessian = program.lagrangian_hessian(x, u, x_next, stage, p, costate, found.kept)
    assert np.abs(hessian - hessian.T).max() < 1e-14
    first = [(found.gap, gap), (ways @ found.dynamics.T, slopes[0]), (ways @ found.cost, slopes[1])]
    closed, automatic = np.zeros(WAYS), np.zeros(WAYS)
    if limited:
        first += [(found.path, path), (ways @ found.path_slope.T, slopes[2])]
        bent = program.path_hessian(x, u, stage, p, dual, found.kept)
        closed, automatic = jnp.sum((ways @ bent) * others, axis=1), bends[2] @ dual
    assert np.isfinite(cost)
    return Both(
        first,
        (jnp.sum((ways @ hessian) * others, axis=1), bends[0] @ costate + bends[1]),
        (closed, automatic),
    )


def off(pair):
    """Largest difference, relative to the largest value."""
    closed, automatic = map(np.asarray, pair)
    return np.abs(closed - automatic).max() / np.abs(automatic).max()


@pytest.mark.parametrize("name", FREE + TORQUED)
def test_first_derivatives_are_exact(name):
    for closed, automatic in both(name, missed=0.1).first:
        np.testing.assert_allclose(closed, automatic, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("name", FREE)
def test_hessian_is_exact_but_for_the_fourth_power_of_the_interval(name):
    whole, tenth = off(both(name).hessian), off(both(name, shorter=10.0).hessian)
    assert whole < 5e-3
    # Relative to a Hessian that itself falls with the interval.
    assert tenth < 1e-2 * whole


@pytest.mark.parametrize("name", TORQUED)
def test_hessian_leaves_out_what_external_torques_add_and_that_is_small(name):
    assert off(both(name).hessian) < 0.1
    # What is left without them: the price of a law's dipole, which bends with the attitude.
    weak = both(name, shorter=10.0, weaker=1e-4).hessian
    assert off(weak) < (6e-3 if "managed" in name else 5e-4)


@pytest.mark.parametrize("name", ["turning, signed", "managed, body axes, eclipse"])
def test_a_gap_adds_an_error_of_its_own_size(name):
    exact = both(name, shorter=10.0, weaker=1e-4)
    small, double = (both(name, 10.0, missed, 1e-4) for missed in (1e-3, 2e-3))
    errors = [np.subtract(*one.hessian) - np.subtract(*exact.hessian) for one in (small, double)]
    np.testing.assert_allclose(errors[1], 2.0 * errors[0], rtol=0.02, atol=1e-6)
    assert off(double.hessian) < 0.01


def test_bend_of_the_power_is_exact_at_rest():
    """There the rate is linear in the state."""
    assert off(both("at rest, wheel by wheel").path) < 1e-12


@pytest.mark.parametrize(
    "name", ["turning, regeneration", "managed, body axes, eclipse", *RUBBING[1:]]
)
def test_bend_of_the_power_leaves_out_that_of_the_speeds(name):
    assert 0.0 < off(both(name).path) < 0.02
