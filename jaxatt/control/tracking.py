"""Tracking of an optimised manoeuvre: feed-forward torque with feedback on the errors."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured
from jaxatt.control.proportional_derivative import ProportionalDerivative


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Tracking:
    """Feed-forward torque of the reference plus a PD law on attitude and rate errors.

    With `feedback` zero it flies the plan open loop.
    """

    feedback: ProportionalDerivative

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        correction, memory = self.feedback(measured, memory, period)
        return measured.feedforward + correction, memory
