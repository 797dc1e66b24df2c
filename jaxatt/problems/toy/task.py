"""Small systems for sparse control: the double integrator and the Van der Pol oscillator.

They share the solver with the spacecraft and nothing else.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.problems.hands_off.printed_cost import support_cost
from jaxatt.problems.hands_off.sparse_program import DecidedBy, SparseArguments, SparseSystem
from jaxatt.problems.hands_off.task import Goal, SparseTask
from jaxatt.problems.verdict import Verdict
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.chunks import in_chunks

_VERIFICATION_FACTOR = 20


@dataclass(frozen=True)
class ToySystem:
    """System x' = derivative(x, u) with |u| <= limit and, if given, margin(x) >= 0 at all nodes."""

    derivative: Callable[[Array, Array], Array]
    margin: Callable[[Array], Array] | None = None


def _double_integrator(x: Array, u: Array) -> Array:
    return jnp.stack([x[1], u])


def _van_der_pol(x: Array, u: Array) -> Array:
    return jnp.stack([(1.0 - x[1] ** 2) * x[0] - x[1] + u, x[0]])


SYSTEMS = {
    # Schaanning (2021), eq. (3.33).
    "double-integrator": ToySystem(_double_integrator),
    # Schaanning (2021), eq. (3.34); the bound on x2 is of section 3.7.2.
    "van-der-pol": ToySystem(_van_der_pol, lambda x: x[..., 1] + 0.25),
}


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ToyParameters:
    """Parameters of a toy system.

    start, target : (2,).  step : () [s].  limit : (), largest |control|.
    """

    start: Array
    target: Array
    step: Array
    limit: Array


def simulate(system: ToySystem, control: Array, p: ToyParameters, substeps: int) -> Array:
    """States at all nodes, (N + 1, 2), under a piecewise constant control (N,)."""
    h = p.step / substeps

    def substep(x: Array, u: Array) -> Array:
        f = system.derivative
        k1 = f(x, u)
        k2 = f(x + h / 2 * k1, u)
        k3 = f(x + h / 2 * k2, u)
        k4 = f(x + h * k3, u)
        return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def interval(x: Array, u: Array) -> tuple[Array, Array]:
        x = lax.fori_loop(0, substeps, lambda _, y: substep(y, u), x)
        return x, x

    _, nodes = lax.scan(interval, p.start, control)
    return jnp.concatenate([p.start[None], nodes])


@functools.cache
def toy_system(name: str, substeps: int) -> SparseSystem:
    """Toy system of this name for sparse control, with controls in units of the limit."""
    system = SYSTEMS[name]

    def nodes(u: Array, p: ToyParameters) -> Array:
        return simulate(system, u[:, 0] * p.limit, p, substeps)

    def margins(u: Array, p: ToyParameters) -> Array:
        if system.margin is None:
            return jnp.zeros((0,), u.dtype)
        return system.margin(nodes(u, p)[1:])

    def rows(u: Array, p: ToyParameters) -> Array:
        return nodes(u, p)[-1] - p.target

    def response(u: Array, p: ToyParameters) -> tuple[Array, Array]:
        return rows(u, p), jnp.swapaxes(jax.jacrev(rows)(u, p), 0, 1)

    return SparseSystem(
        rows=rows,
        margins=margins,
        response=response if system.margin is None else None,
        limits=lambda p: jnp.ones((1, 1)),
        stage_margins=lambda u, p: jnp.concatenate([1.0 - u, 1.0 + u], axis=1),
        decided_by=DecidedBy.CONDENSED if system.margin is None else DecidedBy.LAGRANGIAN,
    )


@functools.partial(jax.jit, static_argnames=("name", "substeps"))
def _fly_many(name: str, controls: Array, p: ToyParameters, substeps: int) -> Array:
    return jax.vmap(lambda u: simulate(SYSTEMS[name], u[:, 0], p, substeps))(controls)


class ToyTask(SparseTask):
    """Drive a toy system from one state to another with a sparse control.

    weight : (N,), h_k.  forbidden : (N,), intervals without control.
    """

    threshold = 1e-6
    size = 1

    def __init__(
        self,
        name: str,
        start: Floats,
        target: Floats,
        intervals: int,
        step: float,
        limit: float,
        tolerance: float,
        goal: Goal,
        weight: Floats,
        forbidden: Flags,
        substeps: int = 2,
    ):
        self.name, self.goal, self.intervals, self.step = name, goal, intervals, step
        self.limit, self.tolerance, self.substeps = limit, tolerance, substeps
        self.system = toy_system(name, substeps)
        self.parameters = ToyParameters(
            jnp.asarray(start), jnp.asarray(target), jnp.asarray(step), jnp.asarray(limit)
        )
        self.arguments = SparseArguments(
            plant=self.parameters,
            weight=jnp.asarray(weight),
            free=jnp.where(jnp.asarray(forbidden), 0.0, 1.0)[:, None],
            count_scale=jnp.asarray(1.0),
            effort_scale=jnp.asarray(0.0),
            price=jnp.ones(intervals),
            effort_map=jnp.eye(1),
            row_weight=jnp.full(len(target), jnp.inf),
        )

    @property
    def path_names(self) -> tuple[str, ...]:
        """Names of the bound on a state at nodes 1 to N."""
        bounded = SYSTEMS[self.name].margin is not None
        return tuple(f"state bound, node {k + 1}" for k in range(self.intervals if bounded else 0))

    def to_controls(self, u: Floats | Array) -> Floats:
        """Controls (S, N, 1), clipped to the limit and thresholded."""
        bounded = np.clip(np.asarray(u, float), -1.0, 1.0)
        return np.where(np.abs(bounded) <= self.threshold, 0.0, bounded * self.limit)

    def from_controls(self, controls: Floats) -> Floats:
        """Scaled controls from controls."""
        return np.asarray(controls / self.limit)

    @property
    def control_unit(self) -> Floats:
        """The limit of the control, (1,)."""
        return np.array([self.limit])

    def fly(self, controls: Floats) -> Floats:
        """States (S, N + 1, 2) with twenty times the substeps of the optimisation."""
        steps = self.substeps * _VERIFICATION_FACTOR
        name, parameters = self.name, self.parameters
        return in_chunks(
            lambda chunk: _fly_many(name, chunk, parameters, steps),
            controls,
            key=("fly", name, controls.shape[1:], steps),
        )

    def verify(self, controls: Floats) -> tuple[Verdict, dict[str, Floats]]:
        """Simulate again with fine steps and judge the answers."""
        states = self.fly(controls)
        error = np.linalg.norm(states[:, -1] - np.asarray(self.parameters.target), axis=-1)
        margin = SYSTEMS[self.name].margin
        lowest = (
            np.zeros(len(states))
            if margin is None
            else np.asarray(margin(jnp.asarray(states))).min(axis=1)
        )
        verdict = Verdict(
            {"state": error},
            {"state": self.tolerance},
            np.maximum(0.0, np.abs(controls).max(axis=(1, 2)) - self.limit),
            np.maximum(0.0, -lowest),
            self.limit,
        )
        return verdict, self.cost(controls)

    def l1_effort(self, controls: Floats) -> Floats:
        """L1 effort, the integral of |u|, (S,)."""
        return np.asarray(np.abs(controls).sum(axis=(-2, -1)) * self.step)

    def cost(self, controls: Floats) -> dict[str, Floats]:
        """Printed cost: the L1 norm as an integral, or the relaxed count of section 3.7.5."""
        if self.goal.kind == "l1":
            return {"l1": self.l1_effort(controls)}
        weight = np.asarray(self.arguments.weight)
        return {"sparsity": support_cost(controls, self.goal, weight)}

    def long_way_probability(self) -> float:
        """Zero: there is no other way round."""
        return 0.0
