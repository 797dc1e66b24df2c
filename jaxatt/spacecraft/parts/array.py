"""What the parts hold: arrays of NumPy on the host, of JAX inside of computations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jaxatt.spacecraft.checks import Float64

if TYPE_CHECKING:
    import jax

    Array = jax.Array | Float64
else:
    Array = Any
