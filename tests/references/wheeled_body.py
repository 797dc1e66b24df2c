"""Rigid body with reaction wheels on a Keplerian orbit, in NumPy and SciPy only.

Written out again from Schaanning (2021), eqs. (2.35)-(2.40) and (4.2)-(4.20), with omega_ob
algebraic, the body taking -A tau_w and an orthogonal orbit frame; shares nothing with the package.
The orbit is integrated beside the attitude, so that the package's closed form and its table are on
trial too.
"""

import functools
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Body:
    """inertia : (3, 3), wheels included.  axes : (3, n).  spin : (n,), wheel inertias."""

    inertia: np.ndarray
    axes: np.ndarray
    spin: np.ndarray


@dataclass(frozen=True)
class Space:
    """Keplerian elements (a, e, i, raan, argp, nu) [m, rad] at time zero, mu and disturbances."""

    elements: tuple[float, ...]
    mu: float
    gravity_gradient: bool = False
    sine_amplitude: float = 0.0
    sine_frequency: float = 1.0


def skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(q):
    """R(q) = I + 2 eta S(eps) + 2 S(eps)^2 (2.40), of q scaled to unit norm."""
    q = np.asarray(q) / np.linalg.norm(q)
    s = skew(q[1:])
    return np.eye(3) + 2.0 * q[0] * s + 2.0 * s @ s


def orbit_state(space):
    """Inertial position and velocity of the elements."""
    a, e, i, raan, argp, nu = space.elements
    p = a * (1.0 - e**2)
    r = p / (1.0 + e * np.cos(nu)) * np.array([np.cos(nu), np.sin(nu), 0.0])
    v = np.sqrt(space.mu / p) * np.array([-np.sin(nu), e + np.cos(nu), 0.0])

    def turn(angle, axis):
        return (
            np.cos(angle) * np.eye(3)
            + np.sin(angle) * skew(axis)
            + (1 - np.cos(angle)) * (np.outer(axis, axis))
        )

    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    rot = turn(raan, z) @ turn(i, x) @ turn(argp, z)
    return rot @ r, rot @ v


def orbit_frame(r, v):
    """R_o^i (2.38): z to the Earth, y against the orbit normal, x completes it."""
    z = -r / np.linalg.norm(r)
    y = -np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    return np.column_stack([np.cross(y, z), y, z])


def orbit_rate(r, v):
    """w_io in orbit axes (4.4)."""
    return np.array([0.0, -np.linalg.norm(np.cross(r, v)) / (r @ r), 0.0])


def relative_rate(q, omega, r, v):
    """w_ob = w_ib - R' w_io, the algebraic relation (4.3)."""
    return omega - rotation(q).T @ orbit_rate(r, v)


def external_torque(body, space, t, q, r):
    """Gravity gradient (4.11) and sine (4.12), in body axes."""
    torque = np.full(3, space.sine_amplitude * np.sin(space.sine_frequency * t))
    if space.gravity_gradient:
        c3 = rotation(q).T[:, 2]
        torque = torque + 3.0 * space.mu / np.linalg.norm(r) ** 3 * skew(c3) @ body.inertia @ c3
    return torque


def rates(body, space, t, state, wheel_torque):
    """Right-hand side: state is r (3), v (3), q_ob (4), w_ib (3), w_bw (n)."""
    r, v, q, omega, speeds = np.split(state, [3, 6, 10, 13])
    spin = np.diag(body.spin)
    without_spin = body.inertia - body.axes @ spin @ body.axes.T
    momentum = body.inertia @ omega + body.axes @ spin @ speeds
    omega_dot = np.linalg.solve(
        without_spin,
        external_torque(body, space, t, q, r) - body.axes @ wheel_torque - skew(omega) @ momentum,
    )
    w = relative_rate(q, omega, r, v)
    q_dot = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + skew(q[1:]) @ w])
    speeds_dot = wheel_torque / body.spin - body.axes.T @ omega_dot
    r_dot_dot = -space.mu * r / np.linalg.norm(r) ** 3
    return np.concatenate([v, r_dot_dot, q_dot, omega_dot, speeds_dot])


@dataclass(frozen=True)
class Flight:
    """States at the samples: r, v, q_ob (normalised), w_ib, w_ob, w_bw, each (n + 1, .)."""

    r: np.ndarray
    v: np.ndarray
    q: np.ndarray
    omega: np.ndarray
    relative: np.ndarray
    speeds: np.ndarray

    @functools.cached_property
    def attitudes(self):
        """R_ib at the samples, (n + 1, 3, 3)."""
        each = zip(self.r, self.v, self.q, strict=True)
        return np.array([orbit_frame(r, v) @ rotation(q) for r, v, q in each])


def fly(body, space, q, omega_ob, speeds, wheel_torque, step, start_time=0.0, pieces=1):
    """Fly piecewise constant wheel torques (N, n) with DOP853, restarted at every node.

    pieces : samples an interval.
    """
    r, v = orbit_state(space)
    if start_time:
        kepler = solve_ivp(
            lambda t, y: np.concatenate([y[3:], -space.mu * y[:3] / np.linalg.norm(y[:3]) ** 3]),
            (0.0, start_time),
            np.concatenate([r, v]),
            method="DOP853",
            rtol=1e-12,
            atol=1e-9,
        )
        r, v = np.split(kepler.y[:, -1], 2)
    q = np.asarray(q) / np.linalg.norm(q)
    omega = np.asarray(omega_ob) + rotation(q).T @ orbit_rate(r, v)
    state = np.concatenate([r, v, q, omega, speeds])
    states = state[None]
    for k, torque in enumerate(wheel_torque):
        t = start_time + k * step
        done = solve_ivp(
            lambda t, y, torque=torque: rates(body, space, t, y, torque),
            (t, t + step),
            states[-1],
            t_eval=np.linspace(t, t + step, pieces + 1)[1:],
            method="DOP853",
            rtol=1e-12,
            atol=1e-12,
        )
        assert done.success, done.message
        states = np.concatenate([states, done.y.T])
    r, v, q, omega, speeds = np.split(states, [3, 6, 10, 13], axis=1)
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    relative = np.array([relative_rate(*node) for node in zip(q, omega, r, v, strict=True)])
    return Flight(r, v, q, omega, relative, speeds)


def angle_between(q1, q2):
    """Angle [rad] between attitudes, from their matrices' difference (no quaternion algebra)."""
    chord = np.linalg.norm(rotation(q1) - rotation(q2))
    return 2.0 * np.arcsin(min(1.0, chord / np.sqrt(8.0)))
