"""Interface of a sampled feedback law: its measurements, its torque and its memory."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from jaxatt.attitude.components import Quaternion, Scalar, Vector


class Measured(NamedTuple):
    """Measurements that a feedback law receives at a sampling instant, all vectors in body axes.

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
    """A feedback law as a pytree of its gains; its memory is passed from sample to sample.

    Torques are those on the wheels in body axes [N m]: the body receives the negative.
    """

    def initial(self) -> Any:
        """Memory before the first sample; () for a law without memory."""

    def __call__(self, measured: Measured, memory: Any, period: Scalar) -> tuple[Vector, Any]:
        """Torque to hold over `period` [s], and the memory for the next sample."""
