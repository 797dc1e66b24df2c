import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from jaxatt.environment import MU_EARTH, KeplerianElements, kepler, orbit

propagate = jax.jit(orbit.propagate)
mean_motion = jax.jit(orbit.mean_motion)
seeds = st.integers(0, 2**31)


@jax.jit
def state(a, e, angles):
    return kepler.to_state(KeplerianElements(a, e, *angles))


def random_state(seed, e):
    rng = np.random.default_rng(seed)
    angles = rng.uniform(0, [np.pi, 2 * np.pi, 2 * np.pi, 2 * np.pi])
    return [np.asarray(x) for x in state(rng.uniform(6.8e6, 5e7), e, angles)]


@pytest.mark.parametrize("e", [0.0, 1e-9, 0.01, 0.7, 0.97])
def test_propagation_agrees_with_an_integrated_orbit(e):
    r, v = random_state(11, e)
    period = 2 * np.pi / mean_motion(1 / (2 / np.linalg.norm(r) - np.dot(v, v) / MU_EARTH))
    times = np.linspace(0, 1.3 * float(period), 7)
    length, speed = float(np.linalg.norm(r)), float(np.linalg.norm(v))
    scale = np.repeat([length, speed], 3)

    def rate(_, x):
        r, v = x[:3] * length, x[3:] * speed
        return np.concatenate([v, -MU_EARTH * r / np.linalg.norm(r) ** 3]) / scale

    start = np.concatenate([r, v]) / scale
    solution = solve_ivp(
        rate, times[[0, -1]], start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-14
    )
    expected = solution.y.T * scale
    r_t, v_t = propagate(r, v, times)
    # An error in time shows as speed at perigee, so eccentric orbits are less well determined.
    tolerance = 1e-9 / (1 - e) ** 2
    np.testing.assert_allclose(r_t, expected[:, :3], rtol=0, atol=tolerance * length)
    np.testing.assert_allclose(v_t, expected[:, 3:], rtol=0, atol=tolerance * speed)


def test_rk4_on_the_two_body_acceleration_arrives_at_the_same_place():
    r, v = random_state(3, 0.1)
    steps, dt = 400, 5.0

    @jax.jit
    def integrate(r, v):
        def rate(x):
            return jnp.stack([x[1], orbit.two_body_acceleration(x[0])])

        def step(_, x):
            k1 = rate(x)
            k2 = rate(x + dt / 2 * k1)
            k3 = rate(x + dt / 2 * k2)
            return x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + dt * k3))

        return jax.lax.fori_loop(0, steps, step, jnp.stack([r, v]))

    r_t, v_t = integrate(r, v)
    expected_r, expected_v = propagate(r, v, steps * dt)
    np.testing.assert_allclose(r_t, expected_r, rtol=0, atol=1e-2)
    np.testing.assert_allclose(v_t, expected_v, rtol=0, atol=1e-5)


@settings(deadline=None, max_examples=150)
@given(seed=seeds, e=st.floats(0, 0.995), turns=st.floats(-20, 20), part=st.floats(0, 1))
def test_flow_composes_and_conserves_energy_and_momentum(seed, e, turns, part):
    r, v = random_state(seed, e)
    energy = v @ v / 2 - MU_EARTH / np.linalg.norm(r)
    dt = turns * 2 * np.pi / mean_motion(-MU_EARTH / (2 * energy))
    r_end, v_end = map(np.asarray, propagate(r, v, dt))
    tolerance = 1e-12 * (1 + abs(turns)) / (1 - e) ** 2
    np.testing.assert_allclose(np.cross(r_end, v_end), np.cross(r, v), rtol=0,
                               atol=tolerance * np.linalg.norm(np.cross(r, v)))  # fmt: skip
    kinetic_scale = float(MU_EARTH / np.linalg.norm(r_end))
    assert abs(v_end @ v_end / 2 - kinetic_scale - energy) < tolerance * kinetic_scale
    r_two, v_two = propagate(*propagate(r, v, part * dt), (1 - part) * dt)
    np.testing.assert_allclose(r_two, r_end, rtol=0, atol=tolerance * np.linalg.norm(r) / (1 - e))
    np.testing.assert_allclose(v_two, v_end, rtol=0, atol=tolerance * 2e5 / (1 - e))


def flow(x, dt):
    return jnp.concatenate(orbit.propagate(x[:3], x[3:], dt))


def rate(x):
    return jnp.concatenate([x[3:], orbit.two_body_acceleration(x[:3])])


@jax.jit
def linearised(x, dt):
    transition, change = jax.jvp(lambda t: jax.jacfwd(flow)(x, t), (dt,), (1.0,))
    end, velocity = jax.jvp(lambda t: flow(x, t), (dt,), (1.0,))
    reverse = jax.jacrev(flow)(x, dt)
    return transition, reverse, change, velocity, rate(end), jax.jacfwd(rate)(end)


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9])
def test_derivatives_are_those_of_a_hamiltonian_flow(e):
    """Transition matrices are symplectic; in time they obey the variational equation.

    The second needs second derivatives to be right: d(Phi)/dt = A Phi.
    """
    r, v = random_state(5, e)
    dt = 4000.0
    x = np.concatenate([r, v])

    transition, reverse, change, velocity, expected_velocity, generator = map(
        np.asarray, linearised(x, dt)
    )
    # In units of the orbit every entry is of order one.
    length = float(np.linalg.norm(r))
    time = float(np.sqrt(length**3 / MU_EARTH))
    unit = np.repeat([length, length / time], 3)
    scaled = unit[None, :] / unit[:, None]
    transition, reverse = transition * scaled, reverse * scaled
    change, generator = change * scaled * time, generator * scaled * time
    size = np.max(np.abs(transition))
    omega = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    np.testing.assert_allclose(reverse, transition, rtol=0, atol=1e-11 * size)
    np.testing.assert_allclose(transition.T @ omega @ transition, omega, atol=1e-11 * size**2)
    np.testing.assert_allclose(velocity / unit, expected_velocity / unit, rtol=1e-9, atol=1e-14)
    product = generator @ transition
    np.testing.assert_allclose(change, product, rtol=0, atol=1e-10 * np.max(np.abs(product)))


def test_single_precision_stays_single_and_broadcasts():
    r, v = random_state(7, 0.2)
    times = np.linspace(0, 6000, 4)
    mu = MU_EARTH * np.array([[1.0], [0.9]])
    expected = propagate(r, v, times, mu)
    assert expected[0].shape == (2, 4, 3)
    single = propagate(*(np.asarray(x, np.float32) for x in (r, v, times, mu)))
    for got, want in zip(single, expected, strict=True):
        assert got.dtype == np.float32
        np.testing.assert_allclose(got, want, rtol=0, atol=3e-5 * np.max(np.abs(want)))


def test_an_orbit_that_is_not_elliptic_is_not_a_number():
    r, v = np.array([7e6, 0, 0]), np.array([0, 1.2e4, 0])
    assert np.isnan(propagate(r, v, 10.0)[0]).all()
