"""Static choices of a manoeuvre with wheels, which are compiled in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WheelsForm:
    """What a programme has to carry and to pay for.

    wheels : n.
    momentum : total momentum of body and wheels, "zero" where it is zero and stays so, "constant"
        in inertial axes, or "carried" where external torques act.
    power : of the wheels: "signed" (4.6), "body" (5.7), "wheels" for each by itself.
    each : whether the momentum of every wheel is carried, not only their sum in body axes.
    rubbing : whether friction takes some of the motors' torque.  speed_limited : whether the wheels
        keep to speeds, and motor_limited : to torques that depend on their speed.  All of them need
        `each`.
    magnetorquers : "none", "managing" the momentum by a law, or "decided" by the optimiser.
    end : "reach", "rate", "penalty" or "free"; see `Manoeuvre.terminal`.  "point" reaches a
        direction, with any roll about the boresight.
    speeds : whether wheel speeds at the end are asked for.
    charge : whether the battery's charge is carried, for its floor.
    substeps : steps of the motion an interval.
    """

    wheels: int
    momentum: str = "zero"
    power: str = "signed"
    each: bool = False
    rubbing: bool = False
    speed_limited: bool = False
    motor_limited: bool = False
    magnetorquers: str = "none"
    end: str = "reach"
    speeds: bool = False
    charge: bool = False
    substeps: int = 1

    @property
    def torqued(self) -> bool:
        """Whether external torques act."""
        return self.momentum == "carried"

    @property
    def stored(self) -> int:
        """Coordinates of the wheels' momentum."""
        return self.wheels if self.each else 3

    @property
    def powers(self) -> int:
        """Magnitudes of power, at the beginning and at the end, that are controls of their own."""
        return 2 * self.channels

    @property
    def channels(self) -> int:
        """Powers that are magnitudes."""
        return {"signed": 0, "body": 1, "wheels": self.wheels}[self.power]

    @property
    def dipoles(self) -> int:
        """Controls of the magnetorquers: positive and negative parts of three dipoles."""
        return 6 if self.magnetorquers == "decided" else 0

    @property
    def watched(self) -> bool:
        """Whether the speed of every wheel matters, not only its power."""
        return self.rubbing or self.speed_limited or self.motor_limited

    @property
    def pays_friction(self) -> bool:
        """Whether what friction takes is a cost of its own: signed power pays at the end alone."""
        return self.rubbing and self.power == "signed"

    @property
    def error_size(self) -> int:
        """Error coordinates: turn, wheels' momentum, total momentum, charge."""
        return 3 + self.stored + 3 * self.torqued + self.charge

    @property
    def controls(self) -> int:
        """Controls an interval: wheels, powers, dipoles."""
        return self.wheels + self.powers + self.dipoles
