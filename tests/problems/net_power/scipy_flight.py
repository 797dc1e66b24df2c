"""A flight with its energies by SciPy, written from the source, without the package's code.

The light's edges and the intervals' ends split the integration; the field and the directions to
Earth and sun come in as splines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass
class Body:
    """Numbers of a satellite: J, A (3, n), Jw, eta_rw, the model of the wheels' power, panels."""

    inertia: np.ndarray
    axes: np.ndarray
    wheel_inertia: float
    efficiency: float
    power: str
    normals: np.ndarray
    yields: np.ndarray  # c_s A eta_in [W]
    exponent: int
    shades: int | None
    residual: np.ndarray
    eddy: float
    gain: float
    reference: np.ndarray
    dipole_limit: float
    coil_power: Callable[[np.ndarray], float]
    regeneration: float = 0.0


def rotation(q: np.ndarray) -> np.ndarray:
    """R(q_ib), body to inertial."""
    q = q / np.linalg.norm(q)
    s = np.array([[0, -q[3], q[2]], [q[3], 0, -q[1]], [-q[2], q[1], 0]])
    return np.eye(3) + 2 * q[0] * s + 2 * s @ s


def solar(body: Body, sun_b: np.ndarray) -> float:
    """Power in full light [W], (5.4)."""
    c = body.normals.T @ sun_b
    lit = np.maximum(c, 0.0)
    part = body.yields * lit * (c if body.exponent == 2 else 1.0)
    if body.shades is None:
        return float(part.sum())
    others = np.delete(part, body.shades).sum()
    return float((1.0 - lit[body.shades]) * others + part[body.shades])


def fly(body, state, step, torque, dipole, field, down, gradient, sun, light, edges, start=0.0):
    """States after every interval and the energies (solar, wheels, magnetorquers) [J].

    state : q, omega, wheel speeds.  field, down, gradient, sun, light : functions of time.
    """
    n = body.axes.shape[1]
    spin = body.axes @ (body.wheel_inertia * body.axes.T)
    inverse = np.linalg.inv(body.inertia - spin)

    def drive(power):
        """Shares of braking power: what comes back, once more through the drive, and the rest."""
        back = body.regeneration * body.efficiency**2
        braking = (1.0 - body.regeneration) - back
        return np.where(power > 0.0, power, -braking * power).sum()

    def rates(t, x, tau, held):
        q, w, speed = x[:4], x[4:7], x[7 : 7 + n]
        r = rotation(q)
        b, d = r.T @ field(t), r.T @ down(t)
        m = held
        if body.gain:
            error = body.wheel_inertia * body.axes @ (speed - body.reference)
            m = body.gain * np.cross(error, b) / np.linalg.norm(b)
            m = np.clip(m, -body.dipole_limit, body.dipole_limit)
        external = (
            gradient(t) * np.cross(d, body.inertia @ d)
            + np.cross(body.residual + m, b)
            + body.eddy * np.cross(np.cross(w, b), b)
        )
        momentum = body.inertia @ w + body.wheel_inertia * body.axes @ speed
        dw = inverse @ (-np.cross(w, momentum) - body.axes @ tau + external)
        dq = 0.5 * np.r_[-q[1:] @ w, q[0] * w + np.cross(q[1:], w)]
        spent = {
            "signed": lambda: tau @ speed,
            "body": lambda: abs((body.axes @ tau) @ (body.axes @ speed)),
            "wheels": lambda: drive(tau * speed),
        }[body.power]() / body.efficiency
        earned = light(t) * solar(body, r.T @ sun(t))
        dspeed = tau / body.wheel_inertia - body.axes.T @ dw
        return np.r_[dq, dw, dspeed, earned, spent, body.coil_power(m)]

    x, rows = np.r_[state, np.zeros(3)], []
    for k in range(len(torque)):
        first, last = start + k * step, start + (k + 1) * step
        inside = [e for e in edges if first < e < last]
        for a, b in zip([first, *inside], [*inside, last], strict=True):
            # Not onto an edge itself, where the light jumps.
            away = 1e-9
            found = solve_ivp(
                rates,
                (a + away, b - away),
                x,
                "DOP853",
                rtol=1e-10,
                atol=1e-12,
                args=(torque[k], dipole[k]),
                max_step=0.4,
            )
            x = found.y[:, -1]
        rows.append(x.copy())
    return np.array(rows)


def edges_of(light, first, last, count=4001):
    """Times at which the light changes abruptly, to a nanosecond."""
    grid = np.linspace(first, last, count)
    seen = light(grid)
    found = []
    for k in np.flatnonzero(np.abs(np.diff(seen)) > 0.05):
        a, b, before = grid[k], grid[k + 1], seen[k]
        while b - a > 1e-10 * max(1.0, abs(b)):
            middle = 0.5 * (a + b)
            if abs(light(np.array([middle]))[0] - before) < 1e-9:
                a = middle
            else:
                b = middle
        found.append(b)
    return found
