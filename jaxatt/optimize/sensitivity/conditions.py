"""First-order conditions of a programme, with given limits active, as one symmetric system.

With the limits that hold as equations, and the multipliers of the others zero, an answer makes the
gradient of

    L = objective + costates . gaps + multipliers . equalities
        - sum of active multipliers . margins - sum of the other multipliers^2 / 2

vanish with respect to the variables and all multipliers at once.  Its second derivatives are the
KKT matrix, which is symmetric; an answer moves with the parameters as the implicit function theorem
says: matrix . step = - change of the gradient.

Source: Fiacco (1983), "Introduction to sensitivity and stability analysis in nonlinear
programming".
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.runtime.arrays import Floats


class Condensed(NamedTuple):
    """An answer to second order in n independent variables, for tests of regularity on the host.

    hessian : (n, n), of the Lagrangian.  equality : (m, n) and margins : (p, n), derivatives of
    the equalities and of all limits, these in the order of `Conditions.labels`.
    """

    hessian: Floats
    equality: Floats
    margins: Floats


class Conditions(ABC):
    """First-order conditions of one kind of programme; static, hashable, and without parameters.

    A point is a pytree of variables and multipliers.  A step has the shape of a point in error
    coordinates and is zero at the point.  Flags and margins are pytrees of one array for every kind
    of limit.
    """

    runs_once = False
    """Whether compiling takes so much longer than running that XLA is to leave its passes out."""

    @abstractmethod
    def lagrangian(self, point: Any, step: Any, args: Any, active: Any) -> Array:
        """L (), a step away from a point."""

    @abstractmethod
    def objective(self, point: Any, args: Any) -> Array:
        """Objective () at a point."""

    @abstractmethod
    def margins(self, point: Any, args: Any) -> Any:
        """What is left to every limit; infinite where there is none."""

    @abstractmethod
    def multipliers(self, point: Any) -> Any:
        """Multiplier of every limit."""

    @abstractmethod
    def released(self, point: Any, active: Any) -> Any:
        """The point with multipliers of zero at limits that are not active."""

    @abstractmethod
    def zero(self, point: Any) -> Any:
        """The step that leads nowhere."""

    @abstractmethod
    def moved(self, point: Any, step: Any) -> Any:
        """The point after a step."""

    @abstractmethod
    def system(self, point: Any, args: Any) -> Any:
        """The derivatives of first and second order at a point that the next three need."""

    @abstractmethod
    def residual(self, system: Any, point: Any, active: Any) -> Any:
        """Gradient of L at a point."""

    @abstractmethod
    def solve(self, system: Any, active: Any, right: Any) -> Any:
        """Step with KKT matrix . step = right."""

    @abstractmethod
    def condensed(self, system: Any, point: Any) -> Condensed:
        """The answer to second order, on the host."""

    @abstractmethod
    def labels(self, point: Any) -> tuple[str, ...]:
        """Name of every limit, in the order in which the leaves of the margins are flattened."""

    def pinned(self, point: Any, args: Any) -> Any:
        """Limits that are equations, whose multipliers may have any sign."""
        return jax.tree.map(lambda margin: jnp.zeros(margin.shape, bool), self.multipliers(point))

    def gradient(self, point: Any, args: Any, active: Any) -> Any:
        """Gradient of L, which vanishes at an answer; differentiable."""
        return jax.grad(lambda step: self.lagrangian(point, step, args, active))(self.zero(point))

    def pull(self, point: Any, args: Any, active: Any, along: Any) -> Any:
        """KKT matrix times the step of the answer along a tangent of `args`."""
        change = jax.jvp(lambda args: self.gradient(point, args, active), (args,), (along,))[1]
        return jax.tree.map(jnp.negative, change)
