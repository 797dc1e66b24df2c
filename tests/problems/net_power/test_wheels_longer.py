"""Search of long manoeuvres on longer intervals first, and starts from torques."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import flown_again, phase_manoeuvre
from jaxatt.problems.net_power.flight import fly
from jaxatt.problems.net_power.wheels.from_flight import states_of
from jaxatt.problems.net_power.wheels.longer import at_nodes, averaged, longer_intervals
from jaxatt.problems.net_power.wheels.programme import wheels_programme
from jaxatt.problems.net_power.wheels.rolled_out import rolled_out
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.scenarios import load

RANDOM = np.random.default_rng(81)


@pytest.fixture(scope="module")
def manoeuvre():
    return phase_manoeuvre(load("hypso1-netpower"), PhaseStart())


@pytest.mark.parametrize("intervals", [int(n) for n in RANDOM.integers(400, 20000, 12)])
def test_longer_intervals_are_short_at_both_ends_and_make_up_the_whole(intervals):
    most = int(RANDOM.integers(150, 400))
    held = longer_intervals(intervals, most)
    assert held.sum() == intervals
    assert len(held) <= most
    assert held.min() >= 1
    assert held[0] == held[-1] == 1
    side = held[: len(held) // 2]
    assert (np.diff(side[:-1]) >= 0).all()  # The last one before the middle takes what is left.


def test_weights_and_means_on_longer_intervals_keep_what_is_linear():
    held = longer_intervals(700, 200)
    nodes = np.concatenate([[0], np.cumsum(held)])
    weights = RANDOM.random(701)
    slope, level = RANDOM.normal(size=2)
    line = level + slope * np.arange(701)
    coarse = at_nodes(weights, nodes)
    assert coarse @ line[nodes] == pytest.approx(weights @ line, rel=1e-12)
    values = RANDOM.normal(size=(3, 700, 2))
    total = (averaged(values, held) * held[:, None]).sum(axis=1)
    np.testing.assert_allclose(total, values.sum(axis=1), rtol=1e-12, atol=1e-12)


def test_a_start_from_torques_obeys_the_dynamics_and_the_margins(manoeuvre):
    manoeuvre = replace(manoeuvre, satellite=replace(manoeuvre.satellite, wheel_power="wheels"))
    task = wheels_task(manoeuvre)
    program, p = wheels_programme(task.form), task.parameters
    limit = np.asarray(manoeuvre.satellite.craft.wheels.torque_limit)
    torque = 0.9 * limit * RANDOM.uniform(-1.0, 1.0, (2, manoeuvre.intervals, len(limit)))
    starts = rolled_out(task, torque)

    @jax.jit
    def missed(u, x):
        def at(x, following, u, stage):
            gap = program.difference(program.dynamics(x, u, stage, p), following)
            return gap, program.inequalities(x, u, stage, p)

        return jax.vmap(at)(x[:-1], x[1:], u, program.stages(p))

    for u, x in zip(starts.u, starts.x, strict=True):
        gap, margin = missed(u, x)
        assert np.abs(gap).max() < 1e-12
        assert margin.min() > 0.0
    np.testing.assert_allclose(starts.u[..., :3] * limit, torque, rtol=1e-12)
    # The states are those of a fine flight, but for the steps of the programme.
    flown = fly(manoeuvre, torque)
    states = states_of(p, task.form, flown.q_ib, flown.omega_ib, flown.omega_bw)
    np.testing.assert_allclose(starts.x, states, atol=1e-6)


@pytest.mark.slow
@pytest.mark.optimised
def test_a_long_manoeuvre_earns_as_much_as_its_shorter_one(manoeuvre):
    long = replace(manoeuvre, intervals=8 * manoeuvre.intervals)
    found = [flown_again(m, search_wheels([m], 3, 0)[0]) for m in (manoeuvre, long)]
    energy = [f.flight.energy.net_J[f.best] for f in found]
    assert found[1].reached[found[1].best]
    assert found[1].solved.torque.shape == (3, 640, 3)
    # Torques held for a shorter time can do all that the others can.
    assert energy[1] > energy[0] - 0.01
    assert np.isfinite(found[1].solved.claimed).all()
