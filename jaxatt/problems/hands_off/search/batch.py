"""Entry of a start into the programmes of sparse control: static part and own data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.problems.hands_off.sparse_program import (
    SparseArguments,
    SparseSystem,
    slack_program,
    sparse_effort,
    sparse_program,
    sparse_roots,
    with_slacks,
)
from jaxatt.problems.hands_off.sparse_stages import sparse_stage_roots, sparse_stages
from jaxatt.runtime.arrays import Floats


class Lanes(NamedTuple):
    """Data that differ from start to start; leading axis S.

    u : (S, N, b).  free : (S, N, b).  row_weight : (S, m).  sign : (S,).  price : (S, N).
    aim : (S, 4), target of each start, where it has one of its own; None otherwise.
    """

    u: Any
    free: Any
    row_weight: Any
    sign: Any
    price: Any
    aim: Any = None


@dataclass(frozen=True)
class Form:
    """Static part of a sparse problem, as `run_starts` needs it.

    system : the controlled system.  shared : whether an interval's controls count as one.
    kind : which programme the solver gets: "sparse" without dynamics, "slacks" the L1 problem with
        slacks, "roots" of the rows, "effort" for the least one at a root; or interval by interval,
        "stages" as "sparse" and "stage roots" as "roots".
    size : number of controls.
    """

    system: SparseSystem
    shared: bool
    kind: str
    size: int

    @property
    def program(self) -> Any:
        """Programme for the solver."""
        if self.kind == "stages":
            return sparse_stages(self.system, self.size, self.shared)
        if self.kind == "stage roots":
            return sparse_stage_roots(self.system, self.size, self.shared)
        build: dict[str, Callable[[SparseSystem, bool], Any]] = {
            "slacks": slack_program,
            "sparse": sparse_program,
            "roots": sparse_roots,
            "effort": sparse_effort,
        }
        return build[self.kind](self.system, self.shared)

    @property
    def label(self) -> str | None:
        """Label for `jaxatt.runtime.compilation`; None for systems that have none."""
        if self.system.label is None:
            return None
        return repr((self.system.label, self.shared, self.kind, self.size))

    def enter(self, lane: Lanes, arguments: SparseArguments) -> tuple[Array, SparseArguments]:
        """Initial variables for the solver, and the arguments of one lane."""
        u = jnp.asarray(lane.u)
        plant = arguments.plant
        if lane.aim is not None:
            plant = self.system.aimed(plant, jnp.asarray(lane.aim))
        own = replace(
            arguments,
            plant=self.system.turned(plant, lane.sign),
            free=lane.free,
            row_weight=lane.row_weight,
            price=lane.price,
        )
        return with_slacks(u, self.shared) if self.kind == "slacks" else u, own


def broadcast_lanes(
    u: Floats,
    free: Array | Floats,
    row_weight: Array | Floats,
    sign: Floats,
    price: Floats | float = 1.0,
) -> Lanes:
    """Lanes from starts (S, N, b) and data that all of them may share."""
    count = len(u)
    return Lanes(
        u,
        np.broadcast_to(np.asarray(free), u.shape),
        np.broadcast_to(np.asarray(row_weight), (count, np.shape(row_weight)[-1])),
        np.broadcast_to(np.asarray(sign, float), (count,)),
        np.broadcast_to(np.asarray(price, float), u.shape[:2]),
    )
