"""What a sampled feedback law is given, and what it gives."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from jaxatt.attitude.components import Quaternion, Scalar, Vector


class Measured(NamedTuple):
    """What a law sees at a sampling instant, all vectors in body axes.

    time : [s].  error : attitude relative to the reference, eta >= 0 (short way round).
    rate_error : omega_ob minus its reference [rad/s].  omega : omega_ib [rad/s].
    wheel_momentum : A Jw omega_bw [N m s].
    feedforward : torque on the wheels that the reference itself needs [N m].
    """

    time: Scalar
    error: Quaternion
    rate_error: Vector
    omega: Vector
    wheel_momentum: Vector
    feedforward: Vector


class FeedbackLaw(Protocol):
    """A law is a pytree of its gains; what it remembers from sample to sample is handed through.

    Torques are those on the wheels in body axes [N m]: the body receives the negative.
    """

    def initial(self) -> Any:
        """What the law remembers before the first sample; () for nothing."""

    def __call__(self, measured: Measured, memory: Any, period: Scalar) -> tuple[Vector, Any]:
        """Torque, held over `period` [s], and what to remember."""
