"""Many small programmes as one, chosen by an index, so that they compile together.

Missing variables are held at zero, missing equalities are 0 = 0, missing inequalities 1 >= 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from references.nonlinear_programs import NonlinearProgram


def rows(function: Callable[..., Any] | None, x: Array) -> Array:
    """A list of constraints as a vector."""
    if function is None:
        return jnp.zeros((0,), x.dtype)
    return jnp.stack([jnp.asarray(value, x.dtype) for value in function(x, jnp)])


def _count(function: Callable[..., Any] | None, n: int) -> int:
    return int(jax.eval_shape(lambda x: rows(function, x), jnp.zeros(n)).shape[0])


@dataclass(frozen=True, eq=False)
class Switchboard:
    """Programmes padded to one shape; n, m, p : the largest numbers of each."""

    programs: Sequence[NonlinearProgram]

    def __post_init__(self) -> None:
        sizes = [len(q.x0) for q in self.programs]
        equal = [_count(q.equality, n) for q, n in zip(self.programs, sizes, strict=True)]
        above = [_count(q.inequality, n) for q, n in zip(self.programs, sizes, strict=True)]
        object.__setattr__(self, "n", max(sizes))
        object.__setattr__(self, "counts", tuple(zip(sizes, equal, above, strict=True)))
        m, p = max(equal), max(above)

        def padded(index: int, kind: str, length: int, filling: float) -> Callable[[Array], Array]:
            program, size = self.programs[index], sizes[index]

            def function(x: Array) -> Array:
                values = rows(getattr(program, kind), x[:size])
                return jnp.concatenate([values, jnp.full(length - values.shape[0], filling)])

            return function

        def value(index: int) -> Callable[[Array], Array]:
            program, size = self.programs[index], sizes[index]
            return lambda x: jnp.asarray(program.objective(x[:size], jnp), x.dtype)

        every = range(len(sizes))
        values = [value(i) for i in every]
        equalities = [padded(i, "equality", m, 0.0) for i in every]
        inequalities = [padded(i, "inequality", p, 1.0) for i in every]
        functions = {
            "objective": lambda x, i: lax.switch(i, values, x),
            "equality": (lambda x, i: lax.switch(i, equalities, x)) if m else None,
            "inequality": (lambda x, i: lax.switch(i, inequalities, x)) if p else None,
        }
        object.__setattr__(self, "functions", functions)

    def solve(self, minimize: Callable[..., Any], index: int, **options: Any) -> Any:
        """`minimize` the programme of that index from its own start."""
        program = self.programs[index]

        def pad(values: Any, otherwise: float) -> Any:
            full = np.zeros(self.n)
            full[: len(program.x0)] = otherwise if values is None else values
            return full

        functions = dict(self.functions)
        return minimize(
            functions.pop("objective"),
            pad(program.x0, 0.0),
            (np.int32(index),),
            lower=pad(program.lower, -np.inf),
            upper=pad(program.upper, np.inf),
            **functions,
            **options,
        )


def by_size(programs: Sequence[NonlinearProgram]) -> list[Switchboard]:
    """Switchboards of programmes with similar numbers of variables."""
    small = [q for q in programs if len(q.x0) <= 2]
    middle = [q for q in programs if 2 < len(q.x0) <= 4]
    large = [q for q in programs if len(q.x0) > 4]
    return [Switchboard(part) for part in (small, middle, large) if part]
