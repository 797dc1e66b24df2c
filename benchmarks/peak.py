"""What the machine could do at best, and what a roll-out asks of it."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
from jax import Array, lax

_CHAINS, _ROUNDS, _WIDTH = 8, 2000, 64
_COUNTED = {"add", "sub", "mul", "div", "neg", "rsqrt", "sqrt", "max", "min", "integer_pow"}


def _chains(x: Array) -> Array:
    """Independent multiply-adds on vectors that stay in the first-level cache."""

    def again(_: int, y: Array) -> Array:
        for _ in range(4):
            y = y * 0.999 + 1e-3
        return y

    return lax.fori_loop(0, _ROUNDS, again, x)


def fused_peak(repeats: int = 15) -> float:
    """Float64 operations a second of fused multiply-adds on all cores at once."""
    cores = len(os.sched_getaffinity(0))
    x = jnp.ones((_CHAINS, _WIDTH))
    run = jax.jit(_chains)
    jax.block_until_ready(run(x))
    operations = 2 * 4 * _ROUNDS * _CHAINS * _WIDTH
    with ThreadPoolExecutor(cores) as pool:
        seconds = []
        for _ in range(repeats):
            began = time.perf_counter()
            list(pool.map(lambda _: jax.block_until_ready(run(x)), range(8 * cores)))
            seconds.append((time.perf_counter() - began) / (8 * cores))
    return operations / statistics.median(seconds)


def operations(function: Callable[..., object], *arguments: object) -> int:
    """Scalar floating-point operations of one call, loops counted as often as they run."""
    return _operations(jax.make_jaxpr(function)(*arguments).jaxpr)


def _operations(jaxpr: jax.extend.core.Jaxpr) -> int:
    total = 0
    for equation in jaxpr.eqns:
        inner = [p for p in equation.params.values() if hasattr(p, "jaxpr") or hasattr(p, "eqns")]
        times = equation.params.get("length", 1) if equation.primitive.name == "scan" else 1
        for body in inner:
            total += times * _operations(getattr(body, "jaxpr", body))
        if equation.primitive.name in _COUNTED:
            total += equation.outvars[0].aval.size
        if equation.primitive.name == "dot_general":
            (contracted, _), _ = equation.params["dimension_numbers"]
            depth = 1
            for axis in contracted:
                depth *= equation.invars[0].aval.shape[axis]
            total += 2 * depth * equation.outvars[0].aval.size
    return total
