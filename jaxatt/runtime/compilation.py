"""Compile large programs ahead and in parallel, and keep their traces between processes.

XLA leaves the interpreter free while it compiles, so what a search is going to need can be traced
here, one program after another, while other threads compile.  JAX's persistent cache spares the
next process XLA's work but not the tracing, which then takes most of the time; so where that cache
is on, traced programs are kept beside it (`jax.export`) and found again by what they were asked
for, before anything is traced.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import warnings
from collections.abc import Callable, Hashable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import jax
from jax import export
from jax.stages import Lowered

from jaxatt.runtime.settings import QUICK_TO_COMPILE
from jaxatt.runtime.source import source_digest

_FOLDER = "jaxatt"
"""Where programs are kept, inside the folder of JAX's persistent compilation cache."""

Run = Callable[..., Any]


class Routine:
    """A `jax.jit` function that can be compiled ahead and kept on disk; not differentiable.

    statics : how many of the first arguments are compiled in.  Where each of them is a number or
        a string, or has a `label` that is not None, programs can be kept; the label must be the
        same words in every process, and different ones for what compiles to something else.
    options : of the compiler.
    kept : False where that is not wanted, as for programs that call LAPACK: tracing sets it up.
    """

    def __init__(
        self,
        function: Run,
        statics: int = 0,
        kept: bool = True,
        options: dict[str, int | bool] = QUICK_TO_COMPILE,
    ):
        functools.update_wrapper(self, function)
        self._function, self._statics, self._kept = function, statics, kept
        self._options = options
        self._begun: dict[Hashable, Future[Run]] = {}
        self._plain: set[Hashable] = set()
        self._jitted = jax.jit(
            function, static_argnums=tuple(range(statics)), compiler_options=options
        )

    def __call__(self, *args: Any) -> Any:
        """Call the function; wait first for a compilation that has begun for such arguments."""
        kept = self._kept and bool(_folder())
        if not self._begun and not kept:
            return self._jitted(*args)
        key = self._key(args)
        begun = self._begun.get(key)
        if begun is None and kept and key not in self._plain:
            begun = self._begun[key] = Future()
            try:
                begun.set_result(self._program(args)[0])
            except BaseException as error:  # or other threads would wait for ever
                begun.set_exception(error)
        if begun is None:
            return self._jitted(*args)
        try:
            run = begun.result()
        except Exception:
            self._begun.pop(key, None)  # The next call may try again.
            raise
        if run is self._jitted:
            # From now on `jax.jit` finds it by itself, and faster.
            self._plain.add(key)
            self._begun.pop(key, None)
        return run(*args)

    def begin(self, pool: Executor, *args: Any) -> None:
        """Trace for such arguments, unless that is kept, and compile in a thread of `pool`.

        What goes wrong in the thread is raised by the call that needs the program.
        """
        key = self._key(args)
        if key not in self._begun and key not in self._plain:
            run, lower = self._program(args)
            self._begun[key] = pool.submit(_compile, lower(), run)

    def _key(self, args: tuple[Any, ...]) -> Hashable:
        """Key of a program within this process; fast, because every call computes it."""
        leaves, tree = jax.tree.flatten(args[self._statics :])
        types = [(getattr(x, "shape", ()), getattr(x, "dtype", type(x))) for x in leaves]
        return (*args[: self._statics], tree, *types)

    def _program(self, args: tuple[Any, ...]) -> tuple[Run, Callable[[], Lowered]]:
        """The compiled program for such arguments, and the function that lowers it."""
        file = self._file(args)
        found = None if file is None else _read(file) or self._export(file, args)
        if found is None:
            return self._jitted, lambda: self._jitted.lower(*args)
        exported, tree = found
        flat = jax.jit(exported.call, compiler_options=self._options)

        def leaves(some: tuple[Any, ...]) -> list[Any]:
            return jax.tree.leaves(some[self._statics :])

        def run(*some: Any) -> Any:
            return jax.tree.unflatten(tree, flat(*leaves(some)))

        return run, lambda: flat.lower(*leaves(args))

    def _file(self, args: tuple[Any, ...]) -> Path | None:
        """File in which the program for such arguments is kept; None if it is not kept."""
        folder = _folder()
        labels = [
            x if isinstance(x, (bool, int, str)) else getattr(x, "label", None)
            for x in args[: self._statics]
        ]
        if not self._kept or not folder or None in labels:
            return None
        leaves, tree = jax.tree.flatten(args[self._statics :])
        types = [str(tree), *(str(jax.typeof(leaf)) for leaf in leaves)]
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        asked = repr((name, labels, types, _circumstances()))
        return Path(folder) / _FOLDER / hashlib.sha256(asked.encode()).hexdigest()

    def _export(self, file: Path, args: tuple[Any, ...]) -> tuple[export.Exported, Any] | None:
        """Trace the program and write it to a file, with the structure of its results."""
        leaves, tree = jax.tree.flatten(args[self._statics :])
        structure = None

        def flat(*leaves: Any) -> list[Any]:
            nonlocal structure
            found = self._function(*args[: self._statics], *jax.tree.unflatten(tree, leaves))
            results, structure = jax.tree.flatten(found)
            return results

        exported = export.export(jax.jit(flat))(*leaves)
        if "custom_call" in exported.mlir_module():
            return None
        content = pickle.dumps((structure, bytes(exported.serialize())))
        partial = file.with_suffix(f".{os.getpid()}")  # Never half a file under the real name.
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            partial.write_bytes(content)
            partial.replace(file)
        except OSError as error:
            partial.unlink(missing_ok=True)
            warnings.warn(f"a traced program cannot be kept: {error}", stacklevel=2)
        return exported, structure


def _compile(lowered: Lowered, run: Run) -> Run:
    lowered.compile()  # A call of the same `jax.jit` finds it.
    return run


def _read(file: Path) -> tuple[export.Exported, Any] | None:
    """Read a kept program; None where there is none, or none that can be read."""
    if not file.exists():
        return None
    try:
        structure, content = pickle.loads(file.read_bytes())
        return export.deserialize(bytearray(content)), structure
    except Exception as error:  # whatever a damaged file makes of unpickling or of JAX
        warnings.warn(f"{file} is not a traced program and is replaced: {error}", stacklevel=2)
        return None


def _folder() -> str | None:
    folder: str | None = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    return folder


def _circumstances() -> str:
    """Text of everything else that tracing depends on: the code, JAX and its settings."""
    passing = ("cache", "log")
    settings = {
        name: value
        for name, value in sorted(jax.config.values.items())
        if not any(word in name for word in passing)
    }
    return repr((source_digest(), jax.__version__, jax.default_backend(), settings))
