"""Both models of the package against each other and against SciPy, for random vehicles."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import adapters, random_vehicles, wheeled_body

from jaxatt.attitude import quaternion
from jaxatt.environment.table import coarsen, tabulate
from jaxatt.simulation import momentum_model
from jaxatt.simulation.flight import fly, fly_torque
from jaxatt.simulation.momentum_model import BodyParameters
from jaxatt.spacecraft.dynamics import at_relative_rate
from jaxatt.spacecraft.vehicle import total_momentum

INTERVALS, COAST, STEP, START = 8, 3, 1.4, 300.0
SUBSTEPS = 24
VEHICLES = 3


def stack(trees):
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *trees)


@dataclasses.dataclass(frozen=True)
class Case:
    """One random manoeuvre in the references' terms and in the package's."""

    body: wheeled_body.Body
    space: wheeled_body.Space
    q: np.ndarray
    omega_ob: np.ndarray
    speeds: np.ndarray
    torque: np.ndarray

    def inputs(self):
        craft = adapters.craft(self.body)
        table = tabulate(
            adapters.surroundings(self.space), START, STEP, INTERVALS + COAST, SUBSTEPS
        )
        first = jax.tree.map(lambda leaf: leaf[0], table.nodes)
        start = at_relative_rate(self.q, self.omega_ob, self.speeds, first)
        return craft, start, jnp.asarray(self.torque), table


def draw(rng, wheels):
    return Case(
        random_vehicles.body(rng, wheels),
        random_vehicles.space(rng),
        random_vehicles.unit(rng, 4),
        0.03 * rng.normal(size=3),
        rng.uniform(-60.0, 60.0, wheels),
        rng.uniform(-2e-3, 2e-3, (INTERVALS, wheels)),
    )


def momentum_inputs(craft, start, wheel_torque, table, substeps):
    """The same manoeuvre for the momentum model."""
    q_ib = quaternion.multiply(table.nodes.orbit_attitude[0], start.q_ob)
    momentum = quaternion.rotate(q_ib, total_momentum(craft, start.omega_ib, start.omega_bw))
    state = (*q_ib, *start.omega_ib)
    body = BodyParameters(
        jnp.asarray(craft.inertia), jnp.linalg.inv(jnp.asarray(craft.inertia_without_spin))
    )
    torque = wheel_torque @ craft.wheels.axes.T
    return state, (*momentum,), torque, coarsen(table, INTERVALS, substeps), body


@functools.partial(jax.jit, static_argnames="disturbed")
def rollout(state, momentum, torque, table, body, disturbed=True):
    """Nodes (N, 7) of the momentum model, its attitude turned to be relative to the orbit frame."""
    end, nodes = momentum_model.rollout(state, momentum, torque, table, body, disturbed)
    orbit = quaternion.conjugate(table.nodes.orbit_attitude[1:])
    return jnp.concatenate([quaternion.multiply(orbit, nodes[:, :4]), nodes[:, 4:7]], axis=1), end


_flights = jax.jit(jax.vmap(fly_torque))
_rollouts = jax.jit(jax.vmap(rollout))


@pytest.fixture(scope="module", params=[3, 4, 5], ids="{} wheels".format)
def flown(request):
    """Cases, the package's two flights of them (batched) and SciPy's."""
    rng = np.random.default_rng(100 + request.param)
    cases = [draw(rng, request.param) for _ in range(VEHICLES)]
    inputs = [case.inputs() for case in cases]
    full = jax.tree.map(np.asarray, _flights(*stack(inputs)))
    short, _ = _rollouts(*stack([momentum_inputs(*each, SUBSTEPS) for each in inputs]))
    short = np.asarray(short)
    coasting = np.zeros((COAST, request.param))
    truth = [
        wheeled_body.fly(
            c.body,
            c.space,
            c.q,
            c.omega_ob,
            c.speeds,
            np.concatenate([c.torque, coasting]),
            STEP,
            START,
        )
        for c in cases
    ]
    return cases, inputs, full, short, truth


def test_the_full_model_agrees_with_scipy(flown):
    _, _, full, _, truth = flown
    for i, reference in enumerate(truth):
        turned = [
            wheeled_body.angle_between(a, b) for a, b in zip(full.q_ob[i], reference.q, strict=True)
        ]
        assert max(turned) < 2e-9
        np.testing.assert_allclose(full.omega_ib[i], reference.omega, atol=1e-9)
        np.testing.assert_allclose(full.omega_ob[i], reference.relative, atol=1e-9)
        np.testing.assert_allclose(full.omega_bw[i], reference.speeds, rtol=1e-9, atol=1e-7)


def test_the_momentum_model_agrees_with_scipy(flown):
    _, _, _, short, truth = flown
    for i, reference in enumerate(truth):
        turned = [
            wheeled_body.angle_between(a, b)
            for a, b in zip(short[i, :, :4], reference.q[1:], strict=False)
        ]
        assert len(turned) == INTERVALS
        assert max(turned) < 2e-9
        np.testing.assert_allclose(short[i, :, 4:7], reference.omega[1 : INTERVALS + 1], atol=1e-9)


def test_the_two_models_agree_with_each_other(flown):
    _, _, full, short, _ = flown
    nodes = np.concatenate([full.q_ob, full.omega_ib], axis=-1)[:, 1 : INTERVALS + 1]
    same = np.sign(np.sum(nodes[..., :4] * short[..., :4], axis=-1, keepdims=True))
    np.testing.assert_allclose(same * short[..., :4], nodes[..., :4], atol=1e-9)
    np.testing.assert_allclose(short[..., 4:], nodes[..., 4:], atol=1e-9)


def test_mean_wheel_torque_of_a_flight_is_what_was_commanded_and_zero_in_the_tail(flown):
    cases, _, full, _, _ = flown
    for i, case in enumerate(cases):
        np.testing.assert_allclose(full.wheel_torque[i, :INTERVALS], case.torque, atol=1e-15)
        assert not full.wheel_torque[i, INTERVALS:].any()
        assert full.q_ob[i].shape == (INTERVALS + COAST + 1, 4)


def test_one_flight_alone_is_the_same_as_in_a_batch(flown):
    _, inputs, full, short, _ = flown
    alone = jax.jit(fly_torque)(*inputs[1])
    for name in ("q_ob", "omega_ob", "omega_bw", "omega_ib", "wheel_torque"):
        expected = getattr(full, name)[1]
        np.testing.assert_allclose(getattr(alone, name), expected, rtol=1e-11, atol=1e-13)
    single, end = rollout(*momentum_inputs(*inputs[1], SUBSTEPS))
    np.testing.assert_array_equal(jnp.stack(end)[4:7], single[-1, 4:])
    np.testing.assert_allclose(single, short[1], rtol=1e-11, atol=1e-13)


def test_runge_kutta_converges_with_order_four():
    rng = np.random.default_rng(7)
    case = draw(rng, 4)
    # Fast enough that the discretisation, not rounding, is what is seen.
    case = dataclasses.replace(case, omega_ob=0.4 * random_vehicles.unit(rng, 3))
    inputs = case.inputs()
    truth = wheeled_body.fly(
        case.body, case.space, case.q, case.omega_ob, case.speeds, case.torque, STEP, START
    )
    counts = np.array([2, 4, 8, 24])
    errors = []
    for substeps in counts:
        end = np.asarray(rollout(*momentum_inputs(*inputs, int(substeps)))[0][-1])
        angle = wheeled_body.angle_between(end[:4], truth.q[-1])
        errors.append([angle, np.linalg.norm(end[4:7] - truth.omega[-1])])
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    orders = np.log(ratios) / np.log(counts[1:] / counts[:-1])[:, None]
    assert errors[-1][0] > 1e-11  # still above rounding, so the order means something
    np.testing.assert_allclose(orders[1:], 4.0, atol=0.2)


def undisturbed(rng):
    case = draw(rng, 4)
    return dataclasses.replace(
        case, space=dataclasses.replace(case.space, gravity_gradient=False, sine_amplitude=0.0)
    )


def test_inertial_momentum_is_conserved_without_external_torque():
    case = undisturbed(np.random.default_rng(11))
    craft, start, torque, table = case.inputs()
    flight = jax.tree.map(np.asarray, jax.jit(fly_torque)(craft, start, torque, table))
    orbit = wheeled_body.fly(
        case.body,
        case.space,
        case.q,
        case.omega_ob,
        case.speeds,
        np.zeros((INTERVALS + COAST, 4)),
        STEP,
        START,
    )
    spin = case.body.axes * case.body.spin
    inertial = np.array(
        [
            wheeled_body.orbit_frame(r, v)
            @ wheeled_body.rotation(q)
            @ (case.body.inertia @ omega + spin @ speeds)
            for r, v, q, omega, speeds in zip(
                orbit.r, orbit.v, flight.q_ob, flight.omega_ib, flight.omega_bw, strict=True
            )
        ]
    )
    assert np.linalg.norm(inertial[0]) > 1e-3
    np.testing.assert_allclose(inertial, np.broadcast_to(inertial[0], inertial.shape), atol=1e-11)


def energy(body, flight):
    """Kinetic energy of body and wheels, turning each with its own inertial rate."""
    spin = body.axes * body.spin
    return (
        0.5 * np.einsum("ki,ij,kj->k", flight.omega_ib, body.inertia, flight.omega_ib)
        + np.einsum("ki,ij,kj->k", flight.omega_ib, spin, flight.omega_bw)
        + 0.5 * (flight.omega_bw**2 @ body.spin)
    )


def test_energy_changes_by_the_work_of_the_wheel_motors_only():
    case = undisturbed(np.random.default_rng(13))
    craft, start, _, _ = case.inputs()
    steps, step = 64, 0.1
    table = tabulate(adapters.surroundings(case.space), START, step, steps, 2)
    constant = jnp.asarray(case.torque[0])
    for law_torque in (0.0 * constant, constant):
        flight = jax.tree.map(
            np.asarray,
            jax.jit(fly, static_argnums=2)(
                craft, start, lambda interval, state, env, tau=law_torque: tau, table
            ),
        )
        power = flight.omega_bw @ np.asarray(law_torque)
        work = step / 3.0 * (power[0] + 4 * power[1::2].sum() + 2 * power[2:-1:2].sum() + power[-1])
        gained = energy(case.body, flight)
        np.testing.assert_allclose(gained[-1] - gained[0], work, rtol=1e-7, atol=1e-10)
    assert abs(work) > 1e-3


def test_coasting_keeps_flying_the_same_motion():
    case = draw(np.random.default_rng(17), 4)
    craft, start, torque, table = case.inputs()
    padded = jnp.concatenate([torque, jnp.zeros((COAST, 4))])
    with_tail = jax.jit(fly_torque)(craft, start, torque, table)
    without = jax.jit(fly_torque)(craft, start, padded, table)
    np.testing.assert_array_equal(with_tail.q_ob, without.q_ob)
    np.testing.assert_array_equal(with_tail.omega_bw, without.omega_bw)


def test_without_external_torque_the_shorter_state_flies_the_same():
    inputs = undisturbed(np.random.default_rng(23)).inputs()
    state, momentum, torque, table, body = momentum_inputs(*inputs, 2)
    seven, ten = (
        rollout(state, momentum, torque, table, body, disturbed=each)[0] for each in (False, True)
    )
    np.testing.assert_allclose(seven, ten, atol=1e-12)


def test_gradient_of_the_rollout_against_finite_differences():
    rng = np.random.default_rng(19)
    state, momentum, torque, table, body = momentum_inputs(*draw(rng, 4).inputs(), 2)
    weights = jnp.asarray(rng.normal(size=(INTERVALS, 7)))

    @jax.jit
    def figure(state, momentum, torque, body):
        return jnp.sum(weights * rollout(state, momentum, torque, table, body)[0])

    arguments = (jnp.stack(state), jnp.stack(momentum), torque, body)

    def of(x):
        return figure((*x[0],), (*x[1],), x[2], x[3])

    slope = jax.jit(jax.grad(of))(arguments)
    assert all(bool(jnp.isfinite(leaf).all()) for leaf in jax.tree.leaves(slope))
    for _ in range(3):
        way = jax.tree.map(
            lambda leaf: 0.1 * jnp.asarray(rng.normal(size=leaf.shape)) * jnp.abs(leaf).max(),
            arguments,
        )
        h = 1e-5
        ahead = of(jax.tree.map(lambda x, d: x + 1e-5 * d, arguments, way))
        behind = of(jax.tree.map(lambda x, d: x - 1e-5 * d, arguments, way))
        along = sum(
            float(jnp.vdot(a, b))
            for a, b in zip(jax.tree.leaves(slope), jax.tree.leaves(way), strict=True)
        )
        np.testing.assert_allclose((ahead - behind) / (2 * h), along, rtol=1e-6)
