"""Flying an optimised manoeuvre: its own torques, and feedback on what it departs from."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured
from jaxatt.control.proportional_derivative import ProportionalDerivative


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Tracking:
    """The reference's feed-forward torque plus a PD law on attitude and rate errors.

    With `feedback` zero it flies the plan open loop.
    """

    feedback: ProportionalDerivative

    def initial(self) -> tuple[()]:
        """Nothing is remembered."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels."""
        correction, memory = self.feedback(measured, memory, period)
        return measured.feedforward + correction, memory
