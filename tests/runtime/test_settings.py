"""Importing changes nothing; `configure` changes what it says."""

import os
import subprocess
import sys


def run(code, **environment):
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "XLA_"))}
    return subprocess.run(
        [sys.executable, "-c", code], env=clean | environment, capture_output=True, text=True
    )


def test_importing_changes_no_setting_and_starts_no_backend():
    """Or `configure` would come too late for XLA's flags: searches would run three times slower."""
    code = """
import os, jax
before = dict(jax.config.values)
import jaxatt, jaxatt.cli, jaxatt.problems.time_optimal.phase
from jax._src import xla_bridge
assert before == jax.config.values
assert "XLA_FLAGS" not in os.environ
assert not xla_bridge.backends_are_initialized()
"""
    ended = run(code)
    assert ended.returncode == 0, ended.stderr


def test_configure_sets_precision_cores_cache_and_keeps_flags_that_are_there(tmp_path):
    code = f"""
import os, jax, jaxatt, jax.numpy as jnp
from jaxatt.runtime import settings
from jaxatt.runtime.chunks import workers
assert workers() == 1
jaxatt.configure(cache={str(tmp_path)!r})
assert jnp.ones(2).dtype == jnp.float64
assert workers() == len(os.sched_getaffinity(0))
assert "--xla_cpu_enable_fast_math=false" in os.environ["XLA_FLAGS"]
assert "multi_output_fusion" in os.environ["XLA_FLAGS"]
for options in (settings.RUNS_ONCE, settings.QUICK_TO_COMPILE):
    assert options == {{"xla_cpu_use_fusion_emitters": False}}
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
assert jax.jit(lambda x: 2.0 * x)(1.5) == 3.0
"""
    given = "--xla_cpu_enable_fast_math=false --xla_backend_optimization_level=2"
    ended = run(code, XLA_FLAGS=given)
    assert ended.returncode == 0, ended.stderr
    assert any(tmp_path.iterdir())


def test_loops_of_lbfgs_compile_with_what_configure_sets():
    code = """
import jax, jaxatt, jax.numpy as jnp, optax
jaxatt.configure()
solver = optax.lbfgs()

@jax.jit
@jax.vmap
def steps(x):
    def cost(y):
        return jnp.sum((y - 1.0) ** 2) + jnp.sum(y[:-1] * y[1:]) ** 2
    def one(_, carry):
        y, state = carry
        value, grad = optax.value_and_grad_from_state(cost)(y, state=state)
        updates, state = solver.update(
            grad, state, y, value=value, grad=grad, value_fn=cost
        )
        return optax.apply_updates(y, updates), state
    return jax.lax.fori_loop(0, 30, one, (x, solver.init(x)))[0]

found = steps(jnp.linspace(-1.0, 1.0, 12).reshape(3, 4))
assert jnp.isfinite(found).all()
"""
    ended = run(code)
    assert ended.returncode == 0, ended.stderr
