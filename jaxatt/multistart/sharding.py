"""A chunk of starts over the devices of one process, each with an equal part of the rows.

Every device runs its part by itself: a start depends on itself alone, so nothing is exchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding
from jax.sharding import PartitionSpec as P

ROWS = P("starts")  # type: ignore[no-untyped-call]
"""Of arrays whose leading axis is the rows."""

WHOLE = P()  # type: ignore[no-untyped-call]
"""Of what every device has."""


def own_devices() -> Mesh | None:
    """The devices of this process as a mesh; None where there is but one."""
    devices = jax.local_devices()
    return Mesh(np.array(devices), ("starts",)) if len(devices) > 1 else None


def rows_along(axis: int, of: Any) -> Any:
    """Specification of every leaf of a pytree whose axis of rows is the first or the last."""
    if axis == 0:
        return jax.tree.map(lambda leaf: ROWS, of)

    def last(leaf: Any) -> P:
        return P(*[None] * (np.ndim(leaf) - 1), "starts")  # type: ignore[no-untyped-call]

    return jax.tree.map(last, of)


def parted(
    mesh: Mesh | None, run: Callable[..., Any], takes: Any, gives: Any
) -> Callable[..., Any]:
    """`run` on every device with its part of the rows; takes, gives : specifications."""
    if mesh is None:
        return run
    # Loops begin with constants, which are the same on all devices; what follows is not.
    return jax.shard_map(run, mesh=mesh, in_specs=takes, out_specs=gives, check_vma=False)


def placed(mesh: Mesh | None, of: Any, where: Any) -> Any:
    """A pytree on the devices of a chunk, where `parted` expects it."""
    if mesh is None:
        return of  # The call hands NumPy's arrays over faster.
    return jax.device_put(of, jax.tree.map(lambda spec: NamedSharding(mesh, spec), where))
