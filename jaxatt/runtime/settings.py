"""Settings of JAX for a whole process; `import jaxatt` changes none of them."""

from __future__ import annotations

import os
from pathlib import Path

import jax
import jax.numpy as jnp

CPU_OPTIONS = {
    # Loops whose buffers are smaller become one machine function instead of many small calls.
    "xla_cpu_small_while_loop_byte_threshold": "16777216",
    # Results that share subexpressions are not fused apart and computed again for each.
    "xla_cpu_use_multi_output_fusion": "true",
}
"""What makes the roll-outs and solvers of this package several times faster on a CPU."""

_FLAGS = {
    "--xla_backend_extra_options": ",".join(f"{key}={value}" for key, value in CPU_OPTIONS.items()),
    # The pass that the second option also turns on gains nothing here, and what it makes of some
    # loops, those of L-BFGS among them, ends the process when it is compiled.
    "--xla_disable_hlo_passes": "cpu_multi_output_fusion",
}


def _unless_set(options: dict[str, int | bool]) -> dict[str, int | bool]:
    """Those that the environment variable XLA_FLAGS does not set; what it sets holds everywhere."""
    flags = os.environ.get("XLA_FLAGS", "")
    return {name: value for name, value in options.items() if f"--{name}=" not in flags}


QUICK_TO_COMPILE = _unless_set(
    {"xla_backend_optimization_level": 1, "xla_cpu_use_fusion_emitters": False}
)
"""Compiler options for the large programs of a search, which run no slower for them."""

RUNS_ONCE = _unless_set({"xla_backend_optimization_level": 0, "xla_cpu_use_fusion_emitters": False})
"""Compiler options for what takes longer to compile than to run."""


def configure(*, cache: str | Path | None = None, keep: bool = True) -> None:
    """Set double precision, all cores, XLA's options for small loops and, if asked, a compile
    cache.

    Call it before the first computation: XLA reads its options once.  Options that the
    environment variable XLA_FLAGS already sets stay as they are.

    cache : folder in which compiled programs are kept for the next process; the environment
    variable JAX_COMPILATION_CACHE_DIR does the same.  keep : False to keep none all the same.
    """
    flags = os.environ.get("XLA_FLAGS", "")
    added = (f"{flag}={value}" for flag, value in _FLAGS.items() if f"{flag}=" not in flags)
    os.environ["XLA_FLAGS"] = " ".join([flags, *added]).strip()
    jax.config.update("jax_enable_x64", True)  # type: ignore[no-untyped-call]
    # Programs run in the thread that calls them, so that chunks of starts run one a core.
    jax.config.update("jax_cpu_enable_async_dispatch", False)  # type: ignore[no-untyped-call]
    if not keep:
        jax.config.update("jax_compilation_cache_dir", None)  # type: ignore[no-untyped-call]
    elif cache is not None:
        jax.config.update("jax_compilation_cache_dir", str(cache))  # type: ignore[no-untyped-call]
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)  # type: ignore[no-untyped-call]


def check_precision() -> None:
    """Raise an error in single precision, which cannot meet the tolerances."""
    if jnp.result_type(float) != jnp.float64:
        raise ValueError(
            "jax_enable_x64 is off: the solver's tolerances need 64-bit floats; call "
            'jax.config.update("jax_enable_x64", True) before the first use of JAX'
        )
