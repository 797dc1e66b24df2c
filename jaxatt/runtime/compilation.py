"""Compile large programs ahead and in parallel, and keep them for the next process.

XLA leaves the interpreter free while it compiles, so what a search is going to need can be traced
here, one program after another, while other threads compile.  JAX's persistent cache spares the
next process XLA's work but not the tracing, which then takes most of the time; so where that cache
is on, compiled programs are kept beside it under what they were asked for, and found again before
anything is traced (`jaxatt.runtime.kept_programs`).
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Hashable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import jax
from jax.stages import Lowered, Wrapped

from jaxatt.runtime import kept_programs
from jaxatt.runtime.settings import QUICK_TO_COMPILE

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
        self._begun: dict[Hashable, Future[Run | None]] = {}
        self._plain: set[Hashable] = set()
        self._jitted = jax.jit(
            function, static_argnums=tuple(range(statics)), compiler_options=options
        )

    def __call__(self, *args: Any) -> Any:
        """Call the function; wait first for a compilation that has begun for such arguments."""
        kept = self._kept and bool(kept_programs.folder())
        if not (self._begun or kept):
            return self._jitted(*args)
        key = self._key(args)
        begun = self._begun.get(key)
        if begun is None and kept and key not in self._plain:
            begun = self._begun[key] = Future()
            try:
                begun.set_result(self._program(args)())
            except BaseException as error:  # or other threads would wait for ever
                begun.set_exception(error)
        if begun is None:
            return self._jitted(*args)
        try:
            program = begun.result()
        except Exception:
            self._begun.pop(key, None)  # The next call may try again.
            raise
        if program is None:
            # From now on `jax.jit` finds it by itself, and faster.
            self._plain.add(key)
            self._begun.pop(key, None)
            return self._jitted(*args)
        return program(*args[self._statics :])

    def begin(self, pool: Executor, *args: Any) -> None:
        """Trace for such arguments, unless that is kept, and compile in a thread of `pool`.

        What goes wrong in the thread is raised by the call that needs the program.
        """
        key = self._key(args)
        if key not in self._begun and key not in self._plain:
            self._begun[key] = pool.submit(self._program(args))

    def _key(self, args: tuple[Any, ...]) -> Hashable:
        """Key of a program within this process; fast, because every call computes it."""
        leaves, tree = jax.tree.flatten(args[self._statics :])
        types = [(getattr(x, "shape", ()), getattr(x, "dtype", type(x))) for x in leaves]
        return (*args[: self._statics], tree, *types)

    def _program(self, args: tuple[Any, ...]) -> Callable[[], Run | None]:
        """What is left to do, in any thread, to have a program for such arguments.

        It returns None for a program that `jax.jit` finds by itself once it is compiled.
        """
        file = self._file(args)
        content = None if file is None else kept_programs.read(file)
        if content is not None:
            return functools.partial(kept_programs.load, content)
        if file is None:
            return functools.partial(_compile, self._jitted.lower(*args))
        return functools.partial(kept_programs.compiled, self._named(file).lower(*args), file)

    def _named(self, file: Path) -> Wrapped:
        """The function under a name that no other file has: JAX's cache looks at names, too."""

        @functools.wraps(self._function)
        def function(*args: Any) -> Any:
            return self._function(*args)

        function.__name__ = f"{self._function.__name__}_{file.name[:8]}"
        statics = tuple(range(self._statics))
        return jax.jit(function, static_argnums=statics, compiler_options=self._options)

    def _file(self, args: tuple[Any, ...]) -> Path | None:
        """File in which the program for such arguments is kept; None if it is not kept."""
        folder = kept_programs.folder()
        labels = [
            x if isinstance(x, (bool, int, str)) else getattr(x, "label", None)
            for x in args[: self._statics]
        ]
        if not self._kept or not folder or None in labels:
            return None
        leaves, tree = jax.tree.flatten(args[self._statics :])
        types = [str(tree), *(str(jax.typeof(leaf)) for leaf in leaves)]
        options = sorted(self._options.items())
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        asked = repr((name, labels, types, options, kept_programs.circumstances()))
        return Path(folder) / "jaxatt" / hashlib.sha256(asked.encode()).hexdigest()


def _compile(lowered: Lowered) -> None:
    lowered.compile()  # A call of the same `jax.jit` finds it.
