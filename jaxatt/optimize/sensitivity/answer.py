"""A converged answer, polished and examined, with everything that its derivatives need."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.flatten_util import ravel_pytree

from jaxatt.optimize.sensitivity.conditions import Condensed, Conditions
from jaxatt.optimize.sensitivity.implicit import newton
from jaxatt.optimize.sensitivity.regularity import Degeneracy, Flag, Holding, flags_of
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.settings import QUICK_TO_COMPILE, RUNS_ONCE

_MOST_CHANGES = 8
"""Of the active limits, until they fit the point."""
_OFF = 1e-9
"""Margin below zero, and multiplier as a share of the largest, that changes what is active."""
_MOST_BRANCHES = 64
"""Sets of weakly active limits that are tried for one-sided derivatives."""


class Moves(NamedTuple):
    """Derivatives along directions of the parameters; leading axis P.

    objective : (P,).  point : tangents of the point.  margins, multipliers : of all limits.
    """

    objective: Array
    point: Any
    margins: Array
    multipliers: Array


Function = TypeVar("Function", bound=Callable[..., Any])


def _compiled(run: Function) -> Function:
    """Compile a function of conditions, as fast as they ask for."""
    fast, slow = (
        jax.jit(run, static_argnums=0, compiler_options=options)
        for options in (QUICK_TO_COMPILE, RUNS_ONCE)
    )

    @functools.wraps(run)
    def chosen(conditions: Conditions, *args: Any) -> Any:
        return (slow if conditions.runs_once else fast)(conditions, *args)

    return cast(Function, chosen)


@_compiled
def _settle(conditions: Conditions, point: Any, args: Any, active: Any) -> Any:
    return newton(conditions, conditions.released(point, active), args, active)


@_compiled
def _system(conditions: Conditions, point: Any, args: Any) -> Any:
    return conditions.system(point, args)


@_compiled
def _margins(conditions: Conditions, point: Any, args: Any) -> Any:
    return conditions.margins(point, args)


@_compiled
def _objective(conditions: Conditions, point: Any, args: Any) -> Any:
    return conditions.objective(point, args)


@_compiled
def _moves(
    conditions: Conditions, system: Any, point: Any, args: Any, active: Any, along: Any
) -> Moves:
    rest = conditions.zero(point)

    def one(along: Any) -> Moves:
        step = conditions.solve(system, active, conditions.pull(point, args, active, along))
        tangent = jax.jvp(lambda s: conditions.moved(point, s), (rest,), (step,))[1]

        def worth(args: Any) -> Array:
            return conditions.lagrangian(point, rest, args, active)

        def margins(step: Any, args: Any) -> Array:
            left = conditions.margins(conditions.moved(point, step), args)
            return ravel_pytree(jax.tree.map(lambda m: jnp.where(jnp.isfinite(m), m, 0.0), left))[0]

        return Moves(
            jax.jvp(worth, (args,), (along,))[1],
            tangent,
            jax.jvp(margins, (rest, args), (step, along))[1],
            ravel_pytree(conditions.multipliers(step))[0],
        )

    return jax.vmap(one)(along)


@dataclass(frozen=True, eq=False)
class Answer:
    """A point at which the first-order conditions of a programme hold, and how regular it is.

    args : pytree of parameters.  point : polished.  active : limits that hold there, a pytree.
    system : derivatives at the point.  condensed : the answer to second order.
    holding : its limits.  flags : what is not regular.
    """

    conditions: Conditions
    args: Any
    point: Any
    active: Any
    system: Any
    condensed: Condensed
    holding: Holding
    flags: tuple[Flag, ...]

    @property
    def regular(self) -> bool:
        """Whether the answer moves smoothly with all parameters."""
        return not self.flags

    @functools.cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of all limits."""
        return self.conditions.labels(self.point)

    @functools.cached_property
    def objective(self) -> float:
        """Objective at the polished point."""
        return float(_objective(self.conditions, self.point, self.args))

    def moves(self, along: Any, active: Any = None) -> Moves:
        """Derivatives along directions of the parameters (P, ...), with given limits active."""
        holds = self.active if active is None else active
        return _moves(self.conditions, self.system, self.point, self.args, holds, along)

    def one_sided(self, along: Any) -> tuple[Moves, Any]:
        """Derivatives towards +direction, where weakly active limits make branches.

        Every set of weakly active limits that may hold beside the others is tried; a branch is the
        derivative where the multipliers of those that hold grow and the margins of the others do.
        Returns the moves, NaN where no branch fits, and (P,) whether one does.
        """
        weak = np.flatnonzero(self.holding.weak)
        count = len(jax.tree.leaves(along)[0])
        flat = self.holding.active.copy()
        chosen: Moves | None = None
        settled = np.zeros(count, bool)
        sets = itertools.product((True, False), repeat=len(weak))
        for holds in itertools.islice(sets, _MOST_BRANCHES):
            flat[weak] = holds
            tried = jax.tree.map(np.asarray, self.moves(along, self._unflat(flat)))
            pulled = np.where(holds, tried.multipliers[:, weak], tried.margins[:, weak])
            least = -_OFF * np.maximum(1.0, np.abs(pulled).max(axis=1, initial=0.0))
            fits = np.isfinite(pulled).all(axis=1) & (pulled >= least[:, None]).all(axis=1)
            fits &= np.isfinite(tried.objective) & ~settled
            if chosen is None:
                chosen = jax.tree.map(lambda leaf: np.full_like(leaf, np.nan), tried)
            chosen = jax.tree.map(lambda old, new, f=fits: _put(old, new, f), chosen, tried)
            settled |= fits
        assert chosen is not None
        return chosen, settled

    def _unflat(self, flat: Flags) -> Any:
        return unflattened(self.active, flat)


def _put(old: Floats, new: Floats, rows: Flags) -> Floats:
    changed = old.copy()
    changed[rows] = new[rows]
    return changed


def flattened(tree: Any) -> Any:
    """Leaves of a pytree as one vector on the host."""
    leaves = [np.asarray(leaf).ravel() for leaf in jax.tree.leaves(tree)]
    return np.concatenate(leaves) if leaves else np.zeros(0)


def unflattened(like: Any, flat: Flags) -> Any:
    """The inverse of `flattened`."""
    leaves, tree = jax.tree.flatten(like)
    sizes = np.cumsum([np.size(leaf) for leaf in leaves])[:-1]
    parts = np.split(flat, sizes)
    shaped = [part.reshape(np.shape(leaf)) for part, leaf in zip(parts, leaves, strict=True)]
    return jax.tree.unflatten(tree, [jnp.asarray(part) for part in shaped])


def answer_at(conditions: Conditions, args: Any, near: Any) -> Answer:
    """Polish a converged point by Newton steps on its active limits, and examine it.

    near : a point with its multipliers, accurate to a solver's tolerance.
    """
    like = conditions.multipliers(near)
    margins = flattened(_margins(conditions, near, args))
    multipliers = flattened(like)
    pinned = flattened(conditions.pinned(near, args))
    active = (multipliers > margins) | pinned
    point, seen = near, set()
    for _ in range(_MOST_CHANGES):
        seen.add(active.tobytes())
        found = _settle(conditions, point, args, unflattened(like, active))
        margins = flattened(_margins(conditions, found.point, args))
        multipliers = flattened(conditions.multipliers(found.point))
        size = max(1.0, float(np.abs(multipliers).max(initial=0.0)))
        wrong = np.where(active, multipliers < -_OFF * size, margins < -_OFF) & ~pinned
        settled = np.isfinite(float(found.residual))
        point = found.point if settled else point
        if not wrong.any() or (active ^ wrong).tobytes() in seen:
            break
        active = active ^ wrong
    holding = Holding(
        active, margins, multipliers, pinned, float(found.residual), int(found.passes)
    )
    # Compiled again only where there is no other way.
    system = found.system if settled else _system(conditions, point, args)
    at = conditions.condensed(system, point)
    flags = flags_of(at, holding, conditions.labels(point))
    return Answer(conditions, args, point, unflattened(like, active), system, at, holding, flags)


__all__ = ["Answer", "Degeneracy", "Flag", "Moves", "answer_at"]
