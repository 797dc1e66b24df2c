"""The closed loop against the full model, against its own records, and run by run."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import short_flights, wheeled_body

from jaxatt import simulate
from jaxatt.attitude.components import Vector
from jaxatt.control.proportional_derivative import ProportionalDerivative
from jaxatt.environment.table import Surroundings, tabulate
from jaxatt.problems.surroundings import motion_of
from jaxatt.simulation.campaign import Spread
from jaxatt.simulation.closed_loop import FLYING, NOT_FINITE, TUMBLING
from jaxatt.simulation.flight import fly_torque
from jaxatt.spacecraft.dynamics import at_relative_rate

FINE = {"simulation": {"step_s": 0.05}}
"""Of all flights without a law, so that they compile once."""


@pytest.fixture(scope="module")
def flight():
    return short_flights.flight()


@pytest.fixture(scope="module")
def campaign(flight):
    return simulate(flight, runs=20, seed=5)


def test_open_loop_agrees_with_the_full_model():
    flight = short_flights.flight(**FINE)
    torque = np.array([2e-4, -1e-4, 1.5e-4])
    flown = simulate(flight, short_flights.ConstantTorque(jnp.asarray(torque))).flown.recorded
    craft, orbit = flight.vehicle, flight.surroundings.orbit
    around = Surroundings(
        motion_of(orbit),
        *(jnp.asarray(v) for v in (1.0, 0.0, 1.0)),
    )
    table = tabulate(around, 0.0, 0.1, 600, 2)
    first = jax.tree.map(lambda leaf: leaf[0], table.nodes)
    initial = flight.initial
    start = at_relative_rate(initial.q_ob, initial.omega_ob, initial.omega_bw, first)
    wheels = np.broadcast_to(np.asarray(craft.wheels.allocation) @ torque, (600, 4))
    truth = jax.jit(fly_torque)(craft, start, jnp.asarray(wheels), table)
    turned = [
        wheeled_body.angle_between(a, b) for a, b in zip(flown.q_ob[0], truth.q_ob[1:], strict=True)
    ]
    assert max(turned) < 1e-8
    np.testing.assert_allclose(flown.omega_ob[0], truth.omega_ob[1:], atol=1e-9)
    np.testing.assert_allclose(flown.omega_bw[0], truth.omega_bw[1:], rtol=1e-8)


def test_figures_are_those_of_the_records(flight):
    # One record a sample: everything can be computed again from them.
    result = simulate(flight)
    error = np.asarray(result.flown.recorded.error)[0]
    band = np.sin(0.5 * flight.band)
    time = result.record_times
    for axis in range(3):
        outside = np.flatnonzero(np.abs(error[:, axis]) > band)
        last = outside[-1]
        before, after = np.abs(error[last : last + 2, axis])
        crossing = time[last] + 0.1 * (before - band) / (before - after)
        assert result.flown.figures.settling[0, axis] == pytest.approx(crossing, abs=1e-9)
        final = np.degrees(2.0 * np.arcsin(error[-1, axis]))
        assert np.degrees(result.flown.figures.final[0, axis]) == pytest.approx(final, abs=1e-12)
    axes = np.asarray(flight.vehicle.wheels.axes)
    torque = np.asarray(result.flown.recorded.wheel_torque)[0] @ axes.T
    integral = 0.1 * np.linalg.norm(torque, axis=1).sum()
    assert result.flown.figures.integral[0] == pytest.approx(integral, rel=1e-9)
    rows = np.abs(torque).argmax(axis=0)
    peaks = -torque[rows, np.arange(3)]
    np.testing.assert_allclose(result.flown.figures.peak[0], peaks, rtol=1e-12)


def test_run_i_depends_on_the_seed_and_on_i_only(flight, campaign):
    fewer, longer = simulate(flight, runs=3, seed=5), simulate(flight, runs=70, seed=5)
    for other in (fewer, longer):
        count = min(other.runs, campaign.runs)
        for a, b in zip(
            jax.tree.leaves(other.flown.figures),
            jax.tree.leaves(campaign.flown.figures),
            strict=True,
        ):
            np.testing.assert_allclose(a[:count], b[:count], rtol=1e-9, atol=1e-12)
    other_seed = simulate(flight, runs=20, seed=6)
    assert not np.allclose(other_seed.flown.figures.integral, campaign.flown.figures.integral)
    settling = np.asarray(campaign.flown.figures.settling)
    assert len(np.unique(settling[:, 3])) == 20


def test_torques_stay_within_the_wheels(campaign):
    torque = np.abs(np.asarray(campaign.flown.recorded.wheel_torque))
    assert torque.max() <= 3e-3 * (1 + 1e-12)
    assert torque.max() > 2.9e-3


def test_a_wheel_at_its_speed_limit_is_not_driven_further():
    fast = short_flights.flight(vehicle={"wheels": {"speed_limit_rad_s": 120.0}}, **FINE)
    push = short_flights.ConstantTorque(jnp.asarray([1e-3, 0.0, 0.0]))
    speeds = np.asarray(simulate(fast, push).flown.recorded.omega_bw)[0]
    # The body's own acceleration carries a wheel over by what one sample adds.
    assert np.abs(speeds[:, 0]).max() < 120.0 + 0.5
    assert np.abs(speeds[-1, 0]) > 119.0


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Poisoned:
    """A PD law that gives no number once its run is far enough off on one axis."""

    law: ProportionalDerivative
    bound: jax.Array

    def initial(self):
        return ()

    def __call__(self, measured, memory, period):
        torque, memory = self.law(measured, memory, period)
        far = (measured.time > 1.0) & (measured.error.eps.x > self.bound)
        return torque.map(lambda part: jnp.where(far, jnp.nan, part)), memory


def test_a_law_that_gives_no_number_spoils_its_own_run_only(flight, campaign):
    bound = jnp.median(campaign.flown.recorded.error[:, 10, 0])
    result = simulate(flight, Poisoned(flight.laws["pd"], bound), runs=20, seed=5)
    what = np.asarray(result.flown.what)
    bad = what == NOT_FINITE
    assert 0 < bad.sum() < 20
    good = ~bad
    np.testing.assert_allclose(
        np.asarray(result.flown.figures.settling)[good],
        np.asarray(campaign.flown.figures.settling)[good],
        rtol=1e-9,
    )
    assert np.isfinite(np.asarray(result.flown.recorded.q_ob)).all()
    numbers = result.summary()
    (block,) = numbers["failed"].values()
    assert block["runs"] == np.flatnonzero(bad).tolist()
    assert all(1.0 < time < 60.0 for time in block["times_s"])
    assert numbers["integral_Nms"]["count"] == good.sum()
    assert str(int(np.flatnonzero(bad)[0])) in str(result)


def test_a_run_that_tumbles_is_named(flight):
    law, fine = flight.laws["pd"], short_flights.flight(**FINE)
    wild = dataclasses.replace(fine, timing=dataclasses.replace(fine.timing, tumbling=0.05))
    pushed = short_flights.ConstantTorque(jnp.asarray([-3e-3, 0.0, 0.0]))
    result = simulate(wild, pushed)
    assert np.asarray(result.flown.what)[0] == TUMBLING
    assert not result.sound.any() and not result.settled.any()
    assert result.summary()["integral_Nms"] == {"count": 0}
    assert np.asarray(simulate(flight, law).flown.what)[0] == FLYING


def test_misalignment_and_inertia_stay_physical(flight):
    wide = Spread(attitude=0.1, rate=0.01, inertia=0.3, misalignment=0.2, gain=0.1)
    result = simulate(flight, runs=70, seed=1, spread=wide)
    assert result.sound.all()


def test_noise_is_what_was_asked_for(flight):
    noisy = short_flights.flight(noise={"rate_rad_s": 1e-4})
    result = simulate(noisy, runs=20, spread=Spread())
    torque = np.asarray(result.flown.recorded.wheel_torque)
    spread = torque[:, 400:].std(axis=0).mean(axis=0)
    law = noisy.laws["pd"]
    gain = law.derivative * np.asarray(noisy.vehicle.wheels.allocation) @ np.asarray(law.inertia)
    # The loop feeds earlier noise back, which adds a few per cent.
    np.testing.assert_allclose(spread, 1e-4 * np.linalg.norm(gain, axis=1), rtol=0.15)


def test_users_law_may_use_arrays(flight):
    @jax.tree_util.register_dataclass
    @dataclasses.dataclass(frozen=True)
    class Mine:
        gain: jax.Array

        def initial(self):
            return jnp.zeros(3)

        def __call__(self, measured, memory, period):
            torque = self.gain @ (measured.rate_error.array + measured.error.eps.array)
            return Vector.of(torque), memory + period * torque

    result = simulate(flight, Mine(jnp.asarray(flight.laws["pd"].inertia)))
    assert result.law == "Mine"
    assert result.settled.all()
