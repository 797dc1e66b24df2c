"""Programs compiled ahead compile once; kept ones are found again, and only where they fit."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.runtime import compilation, kept_programs
from jaxatt.runtime.clock import covered
from jaxatt.runtime.compilation import Routine


@dataclass(frozen=True)
class Power:
    exponent: int
    label: str | None


TRACED = []


def fresh():
    """The same function, as another process would see it: JAX knows nothing of it yet."""

    def raised(power, x, scale):
        TRACED.append(power)
        return scale * x**power.exponent

    return Routine(raised, statics=1)


@pytest.fixture
def pool():
    """Threads, and nothing kept from before."""
    TRACED.clear()
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", None)
    with ThreadPoolExecutor(2) as threads:
        yield threads
    jax.config.update("jax_compilation_cache_dir", before)


@pytest.fixture
def folder(pool, tmp_path):
    """Where programs are kept now; JAX's own cache keeps none that are so small."""
    setting = "jax_persistent_cache_min_compile_time_secs"
    before = jax.config.values[setting]
    jax.config.update(setting, 60.0)
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "jaxatt"
    jax.config.update(setting, before)


def ahead(routine, pool, *args):
    """The value of a routine that was begun and has ended in a pool."""
    routine.begin(pool, *args)
    return routine(*args)


CUBE = Power(3, "cube")
X = np.linspace(-1.0, 2.0, 7)


def test_a_program_compiled_ahead_is_not_compiled_again(pool, compilations):
    routine = fresh()
    routine.begin(pool, CUBE, X, 2.0)
    np.testing.assert_array_equal(routine(CUBE, X + 1.0, 3.0), 3.0 * (X + 1.0) ** 3)
    assert len(TRACED) == len(compilations) == 1
    # Other shapes, and other values of what is compiled in, are other programs.
    np.testing.assert_array_equal(routine(CUBE, X[:3], 2.0), 2.0 * X[:3] ** 3)
    np.testing.assert_array_equal(routine(Power(2, "square"), X, 2.0), 2.0 * X**2)
    assert len(TRACED) == len(compilations) == 3


def test_what_goes_wrong_in_the_thread_is_raised_by_the_call(pool, monkeypatch):
    def fail(lowered):
        raise RuntimeError("out of memory")

    monkeypatch.setattr(compilation, "_compile", fail)
    routine = fresh()
    routine.begin(pool, CUBE, X, 2.0)
    with pytest.raises(RuntimeError, match="out of memory"):
        routine(CUBE, X, 2.0)
    np.testing.assert_array_equal(routine(CUBE, X, 2.0), 2.0 * X**3)
    with pytest.raises(TypeError):
        routine.begin(pool, CUBE, X, "two")


def test_a_kept_program_is_loaded_without_tracing_and_gives_the_same_bits(pool, folder):
    first = fresh()(CUBE, X, 2.0)  # not begun: kept all the same
    assert len(TRACED) == len(list(folder.iterdir())) == 1
    again = ahead(fresh(), pool, CUBE, X, 2.0)
    assert len(TRACED) == 1
    np.testing.assert_array_equal(again, first)
    # A value that is not known in words is never taken for another one.
    np.testing.assert_allclose(ahead(fresh(), pool, Power(5, "five"), X, 2.0), 2 * X**5)
    assert len(list(folder.iterdir())) == 2
    np.testing.assert_allclose(ahead(fresh(), pool, Power(4, None), X, 2.0), 2 * X**4)
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("change", ["code", "machine", "setting", "types"])
def test_a_program_kept_under_other_circumstances_is_left_alone(pool, folder, change, monkeypatch):
    ahead(fresh(), pool, CUBE, X, 2.0)
    x = X
    if change == "code":
        monkeypatch.setattr(kept_programs, "source_digest", lambda: "edited")
    elif change == "machine":
        monkeypatch.setattr(kept_programs, "machine", lambda: "another")
    elif change == "types":
        x = X.astype(np.float32)
    before = jax.config.jax_default_matmul_precision
    if change == "setting":
        jax.config.update("jax_default_matmul_precision", "highest")
    ahead(fresh(), pool, CUBE, x, 2.0)
    jax.config.update("jax_default_matmul_precision", before)
    assert len(TRACED) == 2
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("one_bit", [False, True])
def test_a_damaged_file_is_replaced(pool, folder, one_bit):
    ahead(fresh(), pool, CUBE, X, 2.0)
    (file,) = folder.iterdir()
    content = bytearray(file.read_bytes())
    content[int(np.random.default_rng(8).integers(len(content)))] ^= 1
    file.write_bytes(content if one_bit else content[:100])
    with pytest.warns(UserWarning, match="not a compiled program"):
        found = ahead(fresh(), pool, CUBE, X, 2.0)
    np.testing.assert_array_equal(found, 2.0 * X**3)
    assert len(TRACED) == 2
    again = ahead(fresh(), pool, CUBE, X, 2.0)
    np.testing.assert_array_equal(again, found)
    assert len(TRACED) == 2


def test_calls_into_lapack_are_not_kept(pool, folder):
    routine = Routine(jnp.linalg.eigvalsh)
    np.testing.assert_allclose(ahead(routine, pool, np.diag(X)), np.sort(X))
    assert not folder.exists()


def test_kept_programs_serve_the_next_process(tmp_path):
    code = f"""
import jax, jaxatt
from concurrent.futures import ThreadPoolExecutor
from jaxatt.runtime.compilation import Routine
jaxatt.configure(cache={str(tmp_path)!r})
from jaxatt.problems.hands_off.slew.model import SlewForm
from jaxatt.problems.hands_off.slew.system import slew_system

def rows(system, x):
    print("traced", end=" ")
    return jax.numpy.sin(x).sum()

routine, x = Routine(rows, statics=1), jax.numpy.arange(5.0)
with ThreadPoolExecutor(1) as pool:
    routine.begin(pool, slew_system(SlewForm(disturbed=True)), x)
print(float(routine(slew_system(SlewForm(disturbed=True)), x)).hex())
"""
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "XLA_"))}
    said = [
        subprocess.run([sys.executable, "-c", code], env=clean, capture_output=True, text=True)
        for _ in range(2)
    ]
    assert said[1].stderr == ""
    assert said[0].stdout.split() == ["traced", said[1].stdout.strip()]


def test_side_by_side_counts_once():
    rng = np.random.default_rng(3)
    for _ in range(20):
        begin = rng.integers(0, 40, size=rng.integers(0, 9))
        end = begin + rng.integers(0, 10, size=begin.shape)
        seconds = {s for b, e in zip(begin, end, strict=True) for s in range(b, e)}
        assert covered(list(zip(begin.tolist(), end.tolist(), strict=True))) == len(seconds)


def test_what_cannot_be_traced_is_raised_again_and_again(folder):
    """A call that fails must not leave another one, or another thread, waiting for it."""

    def refuses(power, x):
        raise ZeroDivisionError("not today")

    routine = Routine(refuses, statics=1)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError, match="not today"):
            routine(Power(2, "square"), jnp.ones(3))
