"""Sliding surfaces for pointing and for slewing."""

from __future__ import annotations

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured

SURFACES = ("pointing", "slewing")


def pointing_surface(measured: Measured, slope: Scalar) -> Vector:
    """Surface for pointing, deps_e/dt + K eps_e; Kristiansen (2023), eq. (11.29).

    slope : K [1/s].
    """
    error, rate = measured.error, measured.rate_error
    return error.derivative(rate).eps + slope * error.eps


def slewing_surface(measured: Measured, slope: Scalar) -> Vector:
    """Surface for slewing, omega_e + 2 c_1 sgn(eta_e) eps_e; Kristiansen (2023), eq. (11.31).

    slope : c_1 [1/s].

    The sign is 1: the error comes with eta_e >= 0.
    """
    return measured.rate_error + (2.0 * slope) * measured.error.eps


def surface(kind: str, measured: Measured, slope: Scalar) -> Vector:
    """Sliding surface of the given kind."""
    return (pointing_surface if kind == "pointing" else slewing_surface)(measured, slope)
