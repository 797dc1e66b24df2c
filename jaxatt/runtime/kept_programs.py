"""Files of compiled programs: written, read again, and never taken for another program.

A file begins with the digest of what follows, because half a program, or a changed one, would end
the process that runs it.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.monitoring
from jax.experimental import serialize_executable
from jax.stages import Compiled, Lowered

from jaxatt.runtime.compile_cache import machine
from jaxatt.runtime.source import source_digest


def folder() -> str | None:
    """Folder of JAX's persistent cache, where programs are kept, too; None where it is off."""
    found: str | None = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    return found


def circumstances() -> str:
    """Text of everything else that a program depends on: code, JAX, its settings, machine."""
    passing = ("cache", "log")
    settings = {
        name: value
        for name, value in sorted(jax.config.values.items())
        if not any(word in name for word in passing)
    }
    flags = os.environ.get("XLA_FLAGS", "")
    return repr((source_digest(), _device(), machine(), flags, settings))


def compiled(lowered: Lowered, file: Path) -> Compiled:
    """Compile a program and keep it in a file.

    Not kept is what calls a library, which tracing sets up, and what JAX's own cache had: XLA
    writes such a program without its machine code.
    """
    _listen_to_the_cache()
    _this_thread.found = False
    program = lowered.compile()
    if not _this_thread.found and "custom_call" not in lowered.as_text():
        _write(file, program)
    return program


def read(file: Path) -> bytes | None:
    """Content of a program's file; None where there is none.  A damaged file is removed."""
    try:
        found = file.read_bytes()
    except FileNotFoundError:
        return None
    digest, content = found[:32], found[32:]
    if hashlib.sha256(content).digest() == digest:
        return content
    warnings.warn(f"{file} is not a compiled program and is removed", stacklevel=2)
    file.unlink(missing_ok=True)
    return None


def load(content: bytes) -> Callable[..., Any]:
    """The program that `read` found."""
    payload, takes, gives = pickle.loads(content)
    device = jax.config.jax_default_device or jax.local_devices()[0]  # type: ignore[attr-defined]
    return serialize_executable.deserialize_and_load(
        payload, takes, gives, execution_devices=[device]
    )


@functools.cache
def _device() -> str:
    """Kind and number of the device: of several processes each has programs for its own."""
    device = jax.local_devices()[0]
    return f"{device.platform} {device.device_kind} {device.id}"


def _write(file: Path, program: Compiled) -> None:
    """Write a program; where that cannot be done, warn."""
    partial = file.with_suffix(f".{os.getpid()}")  # Never half a file under the real name.
    try:
        content = pickle.dumps(serialize_executable.serialize(program))
        file.parent.mkdir(parents=True, exist_ok=True)
        partial.write_bytes(hashlib.sha256(content).digest() + content)
        partial.replace(file)
    except (OSError, ValueError, jax.errors.JaxRuntimeError) as error:
        partial.unlink(missing_ok=True)
        warnings.warn(f"a compiled program cannot be kept: {error}", stacklevel=2)


_this_thread = threading.local()
"""`found` : whether JAX's own cache had the program that was compiled last."""


@functools.cache
def _listen_to_the_cache() -> None:
    def listen(event: str, **about: str | int) -> None:
        if event == "/jax/compilation_cache/cache_hits":
            _this_thread.found = True

    jax.monitoring.register_event_listener(listen)
