"""Optimal-control programme: stages that are tied by dynamics.

A programme says what it has by the fields that it fills; its `features` name them, so that a solver
can refuse by name what it does not support.

The state may live on a manifold.  Derivatives are taken in an error state of n coordinates around
it, which `retract` and `difference` define; an attitude then has three of them and none of the
solvers meets the singular direction of its quaternion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize import features
from jaxatt.runtime.arrays import Floats


def _plus(x: Array, error: Array) -> Array:
    return x + error


def _minus(x: Array, reference: Array) -> Array:
    return x - reference


class Linearisation(NamedTuple):
    """Dynamics and cost of a stage to first order in z, n error coordinates and b controls.

    gap : (n,), the next state that the dynamics give less the one that there is.
    dynamics : (n, n + b), derivatives of the gap.  cost : (n + b,), those of the cost.
    kept : whatever the second derivatives of the same stage can use again.
    path, path_slope : (p,) and (p, n + b), inequalities of the stage and their derivatives; None
    where they are left to differentiation.
    """

    gap: Array
    dynamics: Array
    cost: Array
    kept: Any = ()
    path: Array | None = None
    path_slope: Array | None = None


@dataclass(frozen=True, eq=False)
class Layout:
    """Meaning of the coordinates of states and controls to the programme's author.

    states : number of the user's own states, which come first.  parameters : number of free
    parameters, which follow.  times : (x, args) -> (N + 1,) [s], times of the nodes; x is any
    state, for a free final time is one of its coordinates.  controls : (u, args) -> in the user's
    units, scaled : the other way.  bounds : lower and upper ones of the states, (states,) each.
    decided : the same of the coordinates of the first state that are free.  free_time : whether the
    last of them is the logarithm of the final time.  check : args -> None; raises ValueError where
    they do not fit.
    """

    states: int
    parameters: int
    times: Callable[[Array, Any], Array]
    controls: Callable[[Array, Any], Array]
    scaled: Callable[[Array, Any], Array]
    bounds: tuple[Floats, Floats]
    decided: tuple[Floats, Floats]
    free_time: bool
    check: Callable[[Any], None]


def _nothing(x: Array) -> Array:
    return jnp.zeros((0,), x.dtype)


def _hard() -> Array:
    return jnp.asarray(jnp.inf)


@dataclass(frozen=True)
class OptimalControlProgram:
    """An optimal-control programme as pure functions of states, controls, stages and `args`.

    The functions take the state x (s,), the controls u (b,), the data of a stage, and a pytree
    `args`.

    Everything that can change from one solve to the next belongs in `args`; what changes from
    stage to stage is a row of `stages`.

    start : args -> (s,), state at the first node.
    stages : args -> pytree with leading axis N.
    dynamics : (x, u, stage, args) -> (s,), state at the next node.
    cost : (x, u, stage, args, smoothing) -> ().
    error_size : n.  control_size : b; None where the controls of a start tell.

    What a programme does not have is None:

    curvature : (x, u, stage, args, smoothing) -> (n + b, n + b), positive semidefinite, in the
        error state, then the controls; it may majorise the cost, whose Hessian it otherwise is.
    terminal_cost : (x, args) -> (), of the last state.
    retract : (x, e) -> (s,), the state at an error e from x; difference : (x, reference) -> e
        such that retract(reference, e) = x, and zero where they agree.
    equality : (x, u, stage, args) -> (q,), zero when satisfied.  equality_weight : (stage, args)
        -> (q,) or (); inf makes a row hard, w costs w/2 row^2, and 0 leaves it out; without it all
        rows are hard.
    inequality : (x, u, stage, args) -> (p,), non-negative when satisfied.
    final_rows, final_weight, final_inequality : the same of the last state; (x, args) or (args).
    free : (stage, args) -> (b,) or (), 1 where a control may move and 0 where it is held.
    limits : (stage, args) -> lower and upper limits of the controls, (b,) or ().
    free_start : number of coordinates, the last ones of the error state, that are decided with the
        controls and stay the same, such as the length of a stage.
    integrals : number of coordinates, the last ones before those, that only add something up, such
        as a charge: nothing depends on them but rows that are linear in them.
    linearisation : (x, u, x_next, stage, args) -> `Linearisation`, exact; lagrangian_hessian : (x,
        u, x_next, stage, args, costate, kept) -> (n + b, n + b), Hessian of cost + costate . gap,
        exact or nearly so, `kept` from the linearisation; without them they are differentiated.
    path_hessian : (x, u, stage, args, dual, kept) -> (n + b, n + b), Hessian of dual . inequality,
        exact or nearly so; without it that is differentiated.
    linearise : (x, u, x_next, stage, args) -> (n, n + b), derivatives of the next error state with
        respect to error state and controls; exact or nearly so.
    moved : (x, u, stage, args) -> `dynamics` and `cost` in one, where that is cheaper.
    flight : (x, u, stage, args, substeps) -> as `dynamics`, with so many times the steps.
    layout : what the coordinates of a state mean to whoever wrote the programme.
    """

    start: Callable[[Any], Array]
    stages: Callable[[Any], Any]
    dynamics: Callable[[Array, Array, Any, Any], Array]
    cost: Callable[[Array, Array, Any, Any, Array], Array]
    error_size: int
    control_size: int | None = None
    curvature: Callable[[Array, Array, Any, Any, Array], Array] | None = None
    terminal_cost: Callable[[Array, Any], Array] | None = None
    retract: Callable[[Array, Array], Array] = _plus
    difference: Callable[[Array, Array], Array] = _minus
    equality: Callable[[Array, Array, Any, Any], Array] | None = None
    equality_weight: Callable[[Any, Any], Array] | None = None
    inequality: Callable[[Array, Array, Any, Any], Array] | None = None
    final_rows: Callable[[Array, Any], Array] | None = None
    final_weight: Callable[[Any], Array] | None = None
    final_inequality: Callable[[Array, Any], Array] | None = None
    free: Callable[[Any, Any], Array] | None = None
    limits: Callable[[Any, Any], tuple[Array, Array]] | None = None
    free_start: int = 0
    integrals: int = 0
    linearisation: Callable[[Array, Array, Array, Any, Any], Linearisation] | None = None
    lagrangian_hessian: Callable[[Array, Array, Array, Any, Any, Array, Any], Array] | None = None
    path_hessian: Callable[[Array, Array, Any, Any, Array, Any], Array] | None = None
    linearise: Callable[[Array, Array, Array, Any, Any], Array] | None = None
    moved: Callable[[Array, Array, Any, Any], tuple[Array, Array]] | None = None
    flight: Callable[[Array, Array, Any, Any, int], Array] | None = None
    layout: Layout | None = None

    @property
    def features(self) -> frozenset[str]:
        """Features that a solver has to support."""
        asked = {
            features.PATH_EQUALITY: self.equality is not None,
            features.SOFT_PATH_ROWS: self.equality_weight is not None,
            features.PATH_INEQUALITY: self.inequality is not None,
            features.TERMINAL_EQUALITY: self.final_rows is not None,
            features.SOFT_TERMINAL_ROWS: self.final_weight is not None,
            features.TERMINAL_INEQUALITY: self.final_inequality is not None,
            features.TERMINAL_COST: self.terminal_cost is not None,
            features.CONTROL_BOUNDS: self.limits is not None,
            features.HELD_CONTROLS: self.free is not None,
            features.FREE_INITIAL_STATE: self.free_start > 0,
            features.MANIFOLD: self.on_manifold,
        }
        return frozenset(name for name, there in asked.items() if there) | {features.DYNAMICS}

    @property
    def on_manifold(self) -> bool:
        """Whether the error state differs from a difference of states."""
        return self.retract is not _plus or self.difference is not _minus

    def equalities(self, x: Array, u: Array, stage: Any, args: Any) -> Array:
        """Equality rows of a stage, (q,)."""
        return _nothing(x) if self.equality is None else self.equality(x, u, stage, args)

    def equality_weights(self, stage: Any, args: Any) -> Array:
        """Weights of the equality rows of a stage, (q,) or ()."""
        return _hard() if self.equality_weight is None else self.equality_weight(stage, args)

    def inequalities(self, x: Array, u: Array, stage: Any, args: Any) -> Array:
        """Inequality rows of a stage, (p,)."""
        return _nothing(x) if self.inequality is None else self.inequality(x, u, stage, args)

    def final_equalities(self, x: Array, args: Any) -> Array:
        """Equality rows of the last state, (r,)."""
        return _nothing(x) if self.final_rows is None else self.final_rows(x, args)

    def final_weights(self, args: Any) -> Array:
        """Weights of the equality rows of the last state, (r,) or ()."""
        return _hard() if self.final_weight is None else self.final_weight(args)

    def final_inequalities(self, x: Array, args: Any) -> Array:
        """Inequality rows of the last state, (t,)."""
        return _nothing(x) if self.final_inequality is None else self.final_inequality(x, args)

    def cost_curvature(self, x: Array, u: Array, stage: Any, args: Any, smoothing: Array) -> Array:
        """`curvature`, or the Hessian of the cost where the programme gives none."""
        if self.curvature is not None:
            return self.curvature(x, u, stage, args, smoothing)
        n = self.error_size

        def at(z: Array) -> Array:
            return self.cost(self.retract(x, z[:n]), u + z[n:], stage, args, smoothing)

        return jnp.asarray(jax.hessian(at)(jnp.zeros(n + u.shape[0], x.dtype)))

    def final_cost(self, x: Array, args: Any) -> Array:
        """Cost of the last state, ()."""
        none = jnp.zeros((), x.dtype)
        return none if self.terminal_cost is None else self.terminal_cost(x, args)

    def free_controls(self, stage: Any, args: Any) -> Array:
        """1 where a control may move, (b,) or ()."""
        return jnp.ones(()) if self.free is None else self.free(stage, args)

    def control_limits(self, stage: Any, args: Any) -> tuple[Array, Array]:
        """Lower and upper limits of the controls, (b,) or ()."""
        if self.limits is None:
            return jnp.asarray(-jnp.inf), jnp.asarray(jnp.inf)
        return self.limits(stage, args)

    def next_and_cost(self, x: Array, u: Array, stage: Any, args: Any) -> tuple[Array, Array]:
        """State at the next node, (s,), and cost of the stage, ()."""
        if self.moved is not None:
            return self.moved(x, u, stage, args)
        cost = self.cost(x, u, stage, args, jnp.zeros((), x.dtype))
        return self.dynamics(x, u, stage, args), cost

    def derivatives(self, x: Array, u: Array, x_next: Array, stage: Any, args: Any) -> Array:
        """Derivatives of the next error state, (n, n + b); see `linearise`."""
        if self.linearise is not None:
            return self.linearise(x, u, x_next, stage, args)
        return exact_derivatives(self, x, u, x_next, stage, args)


def exact_derivatives(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Array:
    """Derivatives (n, n + b) of the next error state, by differentiating the dynamics."""
    n = program.error_size

    def move(z: Array) -> Array:
        x_moved = program.dynamics(program.retract(x, z[:n]), u + z[n:], stage, args)
        return program.difference(x_moved, x_next)

    return jnp.asarray(jax.jacfwd(move)(jnp.zeros(n + u.shape[0], x.dtype)))


def _moved(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Callable[[Array], tuple[Array, Array]]:
    """Function of z that gives the gap (n,) and the cost () of a stage."""
    n = program.error_size

    def at(z: Array) -> tuple[Array, Array]:
        x_moved, u_moved = program.retract(x, z[:n]), u + z[n:]
        ahead, cost = program.next_and_cost(x_moved, u_moved, stage, args)
        return program.difference(ahead, x_next), cost

    return at


def linearisation(
    program: OptimalControlProgram, x: Array, u: Array, x_next: Array, stage: Any, args: Any
) -> Linearisation:
    """Linearise a stage, by the programme's own function or by differentiation."""
    if program.linearisation is not None:
        return program.linearisation(x, u, x_next, stage, args)
    moved = _moved(program, x, u, x_next, stage, args)
    at = jnp.zeros(program.error_size + u.shape[0], x.dtype)
    (dynamics, cost), (gap, _) = jax.jacfwd(lambda z: (moved(z), moved(z)), has_aux=True)(at)
    return Linearisation(gap, dynamics, cost)


def lagrangian_hessian(
    program: OptimalControlProgram,
    x: Array,
    u: Array,
    x_next: Array,
    stage: Any,
    args: Any,
    costate: Array,
    kept: Any = (),
) -> Array:
    """Hessian (n + b, n + b) of cost + costate . gap; `kept` from the linearisation."""
    if program.lagrangian_hessian is not None:
        return program.lagrangian_hessian(x, u, x_next, stage, args, costate, kept)
    moved = _moved(program, x, u, x_next, stage, args)

    def lagrangian(z: Array) -> Array:
        gap, cost = moved(z)
        return cost + jnp.sum(costate * gap)

    hessian = jax.hessian(lagrangian)(jnp.zeros(program.error_size + u.shape[0], x.dtype))
    return jnp.asarray(0.5 * (hessian + hessian.T))


def least_squares(
    residual: Callable[[Array, Array, Any, Any], Array],
    error_size: int,
    retract: Callable[[Array, Array], Array] = _plus,
) -> tuple[Callable[..., Array], Callable[..., Array]]:
    """Cost |residual|^2 / 2 of a stage, and its Gauss-Newton Hessian.

    residual : (x, u, stage, args) -> (r,).  error_size, retract : those of the programme.
    """
    n = error_size

    def cost(x: Array, u: Array, stage: Any, args: Any, smoothing: Array) -> Array:
        return 0.5 * jnp.sum(residual(x, u, stage, args) ** 2)

    def curvature(x: Array, u: Array, stage: Any, args: Any, smoothing: Array) -> Array:
        def moved(z: Array) -> Array:
            return residual(retract(x, z[:n]), u + z[n:], stage, args)

        rows = jax.jacfwd(moved)(jnp.zeros(n + u.shape[0], x.dtype))
        return jnp.asarray(rows.T @ rows)

    return cost, curvature


def fly(
    program: OptimalControlProgram, u: Array, args: Any, first: Array | None = None
) -> tuple[Array, Array]:
    """Simulate the dynamics under controls u (N, b): states (N, s), and the last state (s,).

    first : (s,), state at the first node where that is not the programme's own.
    """

    def advance(x: Array, inputs: tuple[Array, Any]) -> tuple[Array, Array]:
        row, stage = inputs
        return program.dynamics(x, row, stage, args), x

    begin = program.start(args) if first is None else first
    end, nodes = lax.scan(advance, begin, (u, program.stages(args)))
    return nodes, end
