"""Closed-form settling of the gain-scheduled min-norm law on one axis."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Eigenaxis:
    """Motion about one axis under the low gains: theta'' + kd theta' + kp/2 theta = 0, from rest.

    gamma here belongs to theta, as in section IV; the laws' coupling belongs to q = theta / 2 and
    is twice that.
    proportional : [1/s^2] and derivative : [1/s], in units of the moment of inertia; underdamped.
    Source: Horri, Palmer and Roberts, eqs. (21) to (24), with phi of (24) as the cosine form needs.
    """

    proportional: float
    derivative: float

    @property
    def frequency(self) -> float:
        """Natural frequency omega_n [rad/s]."""
        return math.sqrt(0.5 * self.proportional)

    @property
    def damping(self) -> float:
        """Damping ratio zeta."""
        return 0.5 * self.derivative / self.frequency

    def derivative_for(self, proportional: float) -> float:
        """The derivative gain [1/s] that keeps the damping ratio; text below (23)."""
        return 2.0 * self.damping * math.sqrt(0.5 * proportional)

    def switching_time(self, gamma: float) -> float:
        """Time t_s [s] at which theta' + gamma theta first vanishes and the torque goes off."""
        decay = self.damping * self.frequency
        turn = self.frequency * math.sqrt(1.0 - self.damping**2)
        phase = math.atan2(decay, turn)
        return (math.atan2(gamma - decay, turn) + phase) / turn

    def settling_limit(self, gamma: float) -> float:
        """Settling time [s] with infinite high gains: t_s, then coasting home; eq. (31)."""
        return self.switching_time(gamma) + 1.0 / gamma

    def gamma_for(self, limit: float) -> float:
        """The smaller gamma [1/s] whose settling limit is `limit` [s].

        Two have it, as the limit is not monotone: the smaller one turns the torque off earlier and
        spends less.  Raises `ValueError` where no gamma is that fast.
        """
        fastest = self.fastest()
        if limit < self.settling_limit(fastest):
            raise ValueError(
                f"limit = {limit:g} s: no gamma settles faster than "
                f"{self.settling_limit(fastest):.4g} s with these low gains; give a larger limit "
                "or higher low gains"
            )
        low, high = 1e-6 * fastest, fastest
        for _ in range(200):
            middle = math.sqrt(low * high)
            low, high = (low, middle) if self.settling_limit(middle) < limit else (middle, high)
        return high

    def fastest(self) -> float:
        """The gamma [1/s] with the shortest settling limit.

        The derivative of (31) vanishes where gamma^2 = omega_n^2 - kd gamma + gamma^2, that is at
        omega_n^2 / kd.
        """
        return 0.5 * self.proportional / self.derivative
