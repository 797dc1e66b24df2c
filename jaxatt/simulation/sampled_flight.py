"""Data that all runs of a sampled flight share, and the record that each run leaves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import jax
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.along_orbit import Nodes
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.simulation.settling import Band, Figures
from jaxatt.spacecraft.vehicle import Spacecraft

FLYING, TUMBLING, NOT_FINITE = 0, 1, 2
"""What became of a run."""


class Reference(NamedTuple):
    """Reference attitude, rate and torque at every sample; leading axis (samples,).

    attitude : q_d, relative to the frame of reference.  rate : omega_d [rad/s], body axes.
    held : 1 where the attitude is to be held, 0 where only the rate is.
    feedforward : torque on the wheels in body axes [N m].
    """

    attitude: Quaternion
    rate: Vector
    held: Array
    feedforward: Vector


class Noise(NamedTuple):
    """Standard deviations of the measurement noise on rate [rad/s] and wheel speed [rad/s]."""

    rate: Array | float
    wheel_speed: Array | float


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Flight:
    """Data that all runs of a flight share.

    nominal : the vehicle as the controller knows it.  torques : that act from outside.
    along : leading axes (records, samples, steps, 4).  nodes, reference : (records, samples).
    ends : nodes and reference at the end of each record, (records,).
    period : () [s], of sampling; the torque is held over it (zero-order hold).
    dumping : None where the magnetorquers rest.
    tumbling : () [rad/s], rate above which a run counts as diverged.
    signal : "attitude" or "rate" (static), which error `band` watches.
    noisy : whether noise is drawn at all (static).
    """

    nominal: Spacecraft
    torques: ExternalTorques
    along: Along
    nodes: Nodes
    reference: Reference
    ends: tuple[Nodes, Reference]
    period: Array
    band: Band
    noise: Noise
    dumping: MomentumDumping | None
    tumbling: Array | float = 10.0
    signal: str = field(default="attitude", metadata={"static": True})
    noisy: bool = field(default=False, metadata={"static": True})


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Recorded:
    """A run at the end of each recording period, with the torques held then; axes (..., records).

    q_ob : (..., 4).  error : (..., 3), vector part of the error quaternion, eta >= 0.
    rate_error, omega_ob : (..., 3) [rad/s].  omega_bw : (..., n) [rad/s].
    wheel_torque : (..., n) [N m], on each wheel.  dipole : (..., 3) [A m^2].
    """

    q_ob: Array
    error: Array
    rate_error: Array
    omega_ob: Array
    omega_bw: Array
    wheel_torque: Array
    dipole: Array


class Flown(NamedTuple):
    """Result of a run: its figures, its history and how it ended.

    what : FLYING, TUMBLING or NOT_FINITE.  ended : [s], when it failed.
    """

    figures: Figures
    what: Array
    ended: Array
    recorded: Recorded
