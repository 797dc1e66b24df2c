"""A sparse control task: the interface between multi-start search and a problem."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Self

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.problems.hands_off.null_torque import NullTorque
from jaxatt.problems.hands_off.sparse_program import SparseArguments, SparseSystem
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.verdict import Verdict
from jaxatt.records.pointing import PointingRecord
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.flight_error import FlightError

_BINDING = 1e-3


@dataclass(frozen=True)
class Weights:
    """Weights of the printed cost (5.3a), Schaanning (2021), table 5.1; k1 [s^2], k2, k3, a3.

    on_off : k4 [1/(N m)^2] of Kristiansen and Gravdahl (2023), eq. 11, on partially open thrusters;
    on_off_idle : whether the term is multiplied by xi, as printed, which idle intervals have.
    """

    rate: float
    attitude: float
    sparsity: float
    waypoint: float
    on_off: float = 0.0
    on_off_idle: bool = False


@dataclass(frozen=True)
class Goal:
    """Objective of a sparse control task.

    kind : "l0", "moving-l0" or "l1".  terminal : "reach" or "penalty".
    design : 1 for one complementarity vector for all axes, 2 or 3 for one an axis.
    epsilon : relaxation of the complementarity, in units of the controls.
    """

    kind: str
    terminal: str
    design: int
    epsilon: float
    weights: Weights


@dataclass(frozen=True, eq=False)
class Flown:
    """Outcome of an independent flight of one answer.

    verdict, cost : of the one control history.  series : name -> samples.
    reference : name -> target of a series.  end : state at the end of the horizon.
    pointing : None without cones and rate limits.
    flight_error : how wrong the flight can be; None where nothing turns.
    wheel_speeds : (T, n) [rad/s] until the end of the horizon, and the time [s] between two of
        them; None where there are no wheels.
    bias : torques that were added for the wheels' bias; None where none is asked for.
    """

    verdict: Verdict
    cost: dict[str, Floats]
    series: dict[str, Floats]
    reference: dict[str, Floats]
    end: InitialState
    pointing: PointingRecord | None = None
    flight_error: FlightError | None = None
    wheel_speeds: tuple[Floats, float] | None = None
    bias: NullTorque | None = None


class SparseTask(ABC):
    """A sparse control problem over N intervals with b scaled controls each."""

    system: SparseSystem
    goal: Goal
    arguments: SparseArguments
    intervals: int
    size: int
    step: float
    threshold: float
    """Scaled controls at or below this count as zero (Schaanning 2021, definition 5.1.1)."""

    shares_programs: bool = False
    """Whether programs serve tasks of other numbers of intervals, too, where that is supported."""

    substeps: int = 1
    """Runge-Kutta steps an interval of the search."""
    needed_substeps: int = 1
    """The same that keep its error well within the tolerances."""
    sparsity_weight: float = 1.0
    """k3 where the printed cost is minimised."""
    effort_weight: float = 1.0
    """Weight of the L1 effort, in scaled controls, where the printed cost is minimised."""

    aims: Floats | None = None
    """Targets (S, 4) of the rows of a batch that has many; None where all rows have the one."""

    ways: tuple[float, ...] = (1.0,)
    """Ways round to the target: 1 for the short one, -1 for the long one."""

    @property
    def leaves_roll_free(self) -> bool:
        """Whether any roll about a direction will do at the end."""
        return False

    @property
    def limits_speeds(self) -> bool:
        """Whether the programme keeps limits of wheel speeds."""
        return False

    @property
    def watches(self) -> bool:
        """Whether flights are looked at between the nodes, for cones and rate limits."""
        return False

    def keeping_path_limits_of(self, like: SparseTask) -> Self:
        """The same task with cones and rate limits in its programme, as tight as in `like`."""
        return self

    @property
    def path_names(self) -> tuple[str, ...]:
        """Names of the path constraints of the programme, in the order of `system.margins`."""
        return ()

    @property
    def one_sided(self) -> Flags:
        """Whether each of the scaled controls cannot be negative, (b,)."""
        if self.system.bounds is None:
            return np.zeros(self.size, bool)
        return np.asarray(self.system.bounds(self.arguments.plant)[0]) >= 0.0

    @property
    def final_time(self) -> float:
        """Length of the horizon [s]."""
        return self.intervals * self.step

    @property
    def rows(self) -> int:
        """Number of terminal and waypoint rows."""
        return int(np.shape(self.arguments.row_weight)[0])

    @property
    def shared(self) -> bool:
        """Whether all controls of an interval count as one."""
        return self.goal.design == 1

    def reaching(self) -> Self:
        """The same task with the target as a constraint instead of a cost."""
        other = copy.copy(self)
        other.goal = replace(self.goal, terminal="reach")
        other.arguments = replace(self.arguments, row_weight=jnp.full(self.rows, jnp.inf))
        other.sparsity_weight = other.effort_weight = 1.0
        return other

    def sharing_programs(self) -> Self:
        """The same task by programs that tasks of other numbers of intervals share.

        For one solve or a few: filling up costs less than compiling, but costs every start.
        """
        other = copy.copy(self)
        other.shares_programs = True
        return other

    def pick(self, rows: npt.NDArray[np.int64]) -> Self:
        """The task for some rows of a batch, which may have targets of their own."""
        return self

    @abstractmethod
    def to_controls(self, u: Floats | Array) -> Floats:
        """Controls of the system, (S, N, b), from scaled controls: clipped and thresholded."""

    @abstractmethod
    def from_controls(self, controls: Floats) -> Floats:
        """Scaled controls from the system's controls; inverse of `to_controls`."""

    def active(self, controls: Floats) -> Mask:
        """Whether each of the system's controls (..., N, b) counts as more than zero."""
        above: Mask = np.abs(self.from_controls(controls)) > self.threshold
        return above

    @abstractmethod
    def verify(self, controls: Floats) -> tuple[Verdict, dict[str, Floats]]:
        """Fly (S, N, b) controls again with fine steps and judge them.

        Returns the verdict and the named parts of the printed cost, each (S,).
        """

    def begin_verifying(self, pool: Executor, most: int) -> None:  # noqa: B027
        """Compile what `verify` runs for one and for `most` controls ahead, in threads of a pool,
        if it is much."""

    effort_name: str = ""
    """Unit of the effort; empty where it has none."""

    @property
    @abstractmethod
    def control_unit(self) -> Floats:
        """The system's controls for a unit of the scaled ones, (b,)."""

    @property
    def effort_unit(self) -> float:
        """Effort of an interval for a unit of the rows of `arguments.effort_map`."""
        return float(np.max(self.control_unit)) * self.step

    @abstractmethod
    def l1_effort(self, controls: Floats) -> Floats:
        """L1 effort (S,): the sum over intervals and axes of |control| times the step."""

    def slack_sum(self, controls: Floats) -> Floats:
        """Sum of the L1 problem's slacks, (S,): the largest |control| of every interval (5.7a)."""
        size = np.abs(controls)
        slack = size.max(axis=-1, keepdims=True) if self.shared else size
        return np.asarray(slack.sum(axis=(-2, -1)))

    def saturated_intervals(self, controls: Floats) -> int:
        """Number of intervals of one control history (N, b) in which a limit binds."""
        u = jnp.asarray(self.from_controls(controls))
        margins = np.asarray(self.system.stage_margins(u, self.arguments.plant))
        return int((margins.min(axis=1) < _BINDING).sum())

    @property
    def in_motion(self) -> bool:
        """Whether the system moves far without control, so that starts have to allow for it."""
        return False

    def moving_starts(self, count: int, seed: int) -> tuple[Floats, Floats]:
        """Scaled controls (S, N, b) that nearly lead to the target, and ways round (S,)."""
        raise NotImplementedError(f"{type(self).__name__} has no starts in motion")

    @abstractmethod
    def long_way_probability(self) -> float:
        """Probability with which a random start heads for the target the long way."""
