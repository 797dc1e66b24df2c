"""A converged answer as a differentiable function of its parameters, and its sensitivities."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.sensitivity.answer import Answer, Moves
from jaxatt.optimize.sensitivity.implicit import settled, value
from jaxatt.optimize.sensitivity.record import OneSided, Sensitivities
from jaxatt.optimize.sensitivity.regularity import Degeneracy, Flag
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import QUICK_TO_COMPILE

Read = Callable[[Any, Any], Mapping[str, Array]]
"""(point, args) -> name of a variable -> its value, in the user's units."""

Worth = Callable[[Array, Any], Array]
"""(objective (), args) -> the objective as the user counts it, in a unit and with a sign of its
own."""

_SMOOTH = {Degeneracy.WEAK_LIMIT}


def _as_it_is(objective: Array, args: Any) -> Array:
    return objective


@functools.partial(jax.jit, static_argnums=(0, 1, 2))
def _evaluated(conditions: Any, read: Read, worth: Worth, args: Any, near: Any, active: Any) -> Any:
    point = settled(conditions, args, near, active)
    return worth(value(conditions, args, near, active), args), read(point, args)


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def _worth_along(worth: Worth, objective: Array, args: Any, moved: Array, along: Any) -> Any:
    """Worth (), its slope by the objective, and its derivatives (P,) along some directions."""

    def one(moved: Array, along: Any) -> Array:
        return jax.jvp(worth, (objective, args), (moved, along))[1]

    slope = jax.grad(worth)(objective, args)
    return worth(objective, args), slope, jax.vmap(one)(moved, along)


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def _read_along(read: Read, point: Any, args: Any, moved: Any, along: Any) -> Any:
    def one(moved: Any, along: Any) -> Any:
        return jax.jvp(read, (point, args), (moved, along))[1]

    return jax.vmap(one)(moved, along)


@dataclass(frozen=True, eq=False)
class Optimum:
    """A converged answer as a differentiable function of its parameters.

    answer : polished and examined.  read : variables of a point; static, compared by identity.
    enter : the user's parameters -> all that the answer depends on.
    worth : what the programme's objective is to the user; static, too.
    """

    answer: Answer
    read: Read
    enter: Callable[[Any], Any] = lambda parameters: parameters
    worth: Worth = _as_it_is

    @property
    def flags(self) -> tuple[Flag, ...]:
        """What is not regular about the answer."""
        return self.answer.flags

    def __call__(self, parameters: Any) -> tuple[Array, Mapping[str, Array]]:
        """Objective () and variables of the answer for parameters near those of the solve.

        Composes with `jax.grad`, `jax.jvp`, `jax.vmap` and `jax.jit`.  The limits that hold are
        taken to stay the same: where they would not, the value is that of the same set of limits.
        """
        a = self.answer
        args = self.enter(parameters)
        found: tuple[Array, Mapping[str, Array]]
        found = _evaluated(a.conditions, self.read, self.worth, args, a.point, a.active)
        return found

    def sensitivities(self, names: Sequence[str] | None = None) -> Sensitivities:
        """Derivatives by every number among the parameters, or by those that are named.

        names : of numbers, or of arrays and groups that hold them, as the result spells them.

        Raises ValueError for a name that is none.
        """
        every, values, along = directions(self.answer.args)
        chosen = _chosen(every, names)
        along = jax.tree.map(lambda leaf: leaf[chosen], along)
        return self.along(tuple(every[i] for i in chosen), values[chosen], along)

    def along(self, names: tuple[str, ...], values: Floats, along: Any) -> Sensitivities:
        """Derivatives by parameters whose directions (P, ...) in `answer.args` are given."""
        a = self.answer
        moves = a.moves(along)
        variables = self._variables(moves, along)
        one_sided = None
        kinds = {flag.kind for flag in a.flags}
        if kinds and kinds <= _SMOOTH:
            ahead = self._variables(a.one_sided(along)[0], along)
            back = jax.tree.map(_reversed, along)
            behind = self._variables(a.one_sided(back)[0], back)
            one_sided = OneSided(ahead, {name: -leaf for name, leaf in behind.items()})
        if kinds:
            variables = {name: np.full_like(leaf, np.nan) for name, leaf in variables.items()}
        objective = jnp.asarray(a.objective)
        worth, slope, by = _worth_along(self.worth, objective, a.args, moves.objective, along)
        by_parameter = np.array(by)
        if not kinds <= _SMOOTH:
            by_parameter[:] = np.nan
        prices = abs(float(slope)) * a.holding.multipliers
        active = {a.labels[i]: float(prices[i]) for i in np.flatnonzero(a.holding.active)}
        return Sensitivities(
            names, values, float(worth), by_parameter, variables, active, a.flags, one_sided
        )

    def _variables(self, moves: Moves, along: Any) -> dict[str, Floats]:
        found = _read_along(self.read, self.answer.point, self.answer.args, moves.point, along)
        return {name: np.asarray(leaf) for name, leaf in found.items()}


def _reversed(along: Any) -> Any:
    return along if along.dtype == jax.dtypes.float0 else -along


def directions(args: Any) -> tuple[list[str], Floats, Any]:
    """Names and values (P,) of all finite numbers in a pytree, and their unit directions.

    Arrays of integers, flags and keys are no parameters.
    """
    names: list[str] = []
    values: list[float] = []
    places: list[tuple[int, int]] = []
    paths, tree = jax.tree.flatten_with_path(args)
    for number, (path, leaf) in enumerate(paths):
        flat = np.asarray(leaf)
        if not np.issubdtype(flat.dtype, np.floating):
            continue
        name = jax.tree_util.keystr(path, simple=True, separator=".")
        for index, entry in np.ndenumerate(flat):
            if np.isfinite(entry):
                names.append(name + "".join(f"[{i}]" for i in index))
                values.append(float(entry))
                places.append((number, int(np.ravel_multi_index(index, flat.shape))))
    along = []
    for number, (_, leaf) in enumerate(paths):
        shape, kind = np.shape(leaf), np.asarray(leaf).dtype
        real = np.issubdtype(kind, np.floating)
        unit = np.zeros((len(names), int(np.prod(shape))), kind if real else jax.dtypes.float0)
        for row, (owner, place) in enumerate(places):
            if owner == number:
                unit[row, place] = 1.0
        along.append(unit.reshape(len(names), *shape))
    return names, np.array(values), jax.tree.unflatten(tree, along)


def _chosen(every: Sequence[str], names: Sequence[str] | None) -> list[int]:
    if names is None:
        return list(range(len(every)))
    found: list[int] = []
    for name in names:
        own = [i for i, other in enumerate(every) if _belongs(other, name)]
        if not own:
            raise ValueError(f"{name}: no parameter has this name; there are {', '.join(every)}")
        found += [i for i in own if i not in found]
    return found


def _belongs(name: str, asked: str) -> bool:
    return name == asked or name.startswith((f"{asked}.", f"{asked}["))
