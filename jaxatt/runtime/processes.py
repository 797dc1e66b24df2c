"""Several processes that run one computation: joining them, and sharing rows among them.

Every process runs the same programme on the host.  Rows of a batch, such as starts, are split among
the processes where they are solved or flown, and all results are gathered by all, so that what
follows is the same everywhere.  JAX's runtime connects the processes and notices when one is lost.
"""

from __future__ import annotations

import hashlib
import os
import sys
import threading
from collections.abc import Callable
from typing import Any, NoReturn

import jax
import numpy as np
import numpy.typing as npt
from jax.experimental.multihost_utils import process_allgather

Told = Callable[[int], None] | None
"""Called by the host with the number of rows that have just ended, if anybody listens."""

AUTOMATIC = "auto"
"""Coordinator that the cluster's scheduler tells."""

JOIN_S = 300.0
"""[s] Within which all processes must have started."""

_HEARTBEAT_S = 30
"""[s] After which a process that gives no sign of life counts as lost, and ends all others."""

_FILES_S = 3600
"""[s] For which processes that have ended wait for the one that writes."""

_DIGEST = 32
"""Bytes of the digest by which processes tell whether they do the same."""


class JoinError(ValueError):
    """Processes that cannot be joined: the message says why and how to mend it."""


class LostProcessError(RuntimeError):
    """Another process has ended early, or does something else than this one."""


def join(
    coordinator: str | None,
    processes: int | None,
    process: int | None,
    timeout_s: float = JOIN_S,
) -> None:
    """Join the processes of one computation; call it before the first computation.

    coordinator : "host:port" of process 0, "auto" where SLURM, Open MPI or another scheduler that
        JAX knows has started the processes, or None for one process alone.
    processes : how many.  process : which of them this is, from 0; both are the scheduler's where
        the coordinator is "auto".
    timeout_s : [s] within which all must have started.

    Raises `JoinError` where the arguments contradict each other or the others do not answer.
    """
    check(coordinator, processes, process)
    if coordinator is None:
        return
    known = {} if coordinator == AUTOMATIC else {"coordinator_address": coordinator}
    failed: list[Exception] = []

    def connect() -> None:
        try:
            jax.distributed.initialize(
                **known,
                num_processes=processes,
                process_id=process,
                # The runtime ends the whole process when its own time is over.
                initialization_timeout=int(timeout_s) + 3600,
                heartbeat_timeout_seconds=_HEARTBEAT_S,
                shutdown_timeout_seconds=_FILES_S,
            )
        except Exception as error:  # whatever a scheduler's variables or a host's name lead to
            failed.append(error)

    connecting = threading.Thread(target=connect, daemon=True)
    connecting.start()
    connecting.join(timeout_s)
    if connecting.is_alive():
        raise JoinError(_unanswered(coordinator, process, timeout_s))
    if failed:
        raise JoinError(_refused(coordinator, failed[0])) from failed[0]


def check(coordinator: str | None, processes: int | None, process: int | None) -> None:
    """Raise `JoinError` where the arguments of `join` contradict each other."""
    if coordinator is None:
        if processes is not None or process is not None:
            raise JoinError(
                "--processes and --process need --coordinator HOST:PORT, the address of process 0"
            )
        return
    if coordinator == AUTOMATIC:
        if processes is not None or process is not None:
            raise JoinError(
                "--coordinator auto takes --processes and --process from the scheduler; leave them "
                "out, or give HOST:PORT"
            )
        return
    host, _, port = coordinator.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise JoinError(
            f"--coordinator {coordinator}: HOST:PORT of process 0 is expected, or {AUTOMATIC}"
        )
    if processes is None or process is None:
        raise JoinError(
            f"--coordinator {coordinator} needs --processes, how many there are, and --process, "
            "which of them this is"
        )
    if processes < 1 or not 0 <= process < processes:
        raise JoinError(
            f"--process {process} of --processes {processes}: they are numbered from 0 to "
            f"{max(0, processes - 1)}"
        )


def _unanswered(coordinator: str, process: int | None, timeout_s: float) -> str:
    if process == 0:
        return (
            f"not all other processes have joined {coordinator} within {timeout_s:g} s; start them "
            "with the same --coordinator and --processes, or allow more with --join-timeout"
        )
    return (
        f"no answer from the coordinator, {coordinator}, or from another process, within "
        f"{timeout_s:g} s; see that process 0 runs there and that its port is open, or allow more "
        "with --join-timeout"
    )


def _refused(coordinator: str, error: Exception) -> str:
    if coordinator == AUTOMATIC:
        return (
            f"--coordinator {AUTOMATIC}: no scheduler that JAX knows has started this process "
            f"({error}); start it with srun or mpirun, or give HOST:PORT, --processes and --process"
        )
    return f"--coordinator {coordinator}: {error}"


def writes() -> bool:
    """Whether this process writes and prints: process 0 does."""
    return jax.process_index() == 0


def agree(on: Any, what: str) -> None:
    """Raise `LostProcessError` where processes do not hold the same; what : as messages call it."""
    if jax.process_count() == 1:
        return
    every = _gathered(np.frombuffer(_digest(on), np.uint8))
    other = np.flatnonzero((every != every[0]).any(axis=1))
    if len(other):
        raise LostProcessError(
            f"process {other[0]} has other {what} than process 0; start all processes with the "
            "same command, code and kind of machine"
        )


def shared(run: Callable[[Any, Told], Any], batch: Any, progress: Told = None) -> Any:
    """Apply `run` to the rows of a batch, each process to its share, and gather all results.

    run : from a pytree with leading axis rows, and a progress of its own, to another pytree; the
        result of a row depends on this row alone.
    batch : with leading axis S, the same in all processes.  Row i is in the share of process
        i // ceil(S / processes); shares are filled up with copies of row 0.
    progress : told of the own share as it ends, and of the others' when they are gathered.

    Raises `LostProcessError` where another process does something else or has ended.
    """
    several = jax.process_count()
    if several == 1:
        return run(batch, progress)
    agree(batch, "starts")
    count = len(jax.tree.leaves(batch)[0])
    size = -(-count // several)
    rows = np.arange(size) + size * jax.process_index()
    left = int((rows < count).sum())
    rows = np.where(rows < count, rows, 0)
    told = 0

    def ended(some: int) -> None:
        nonlocal told
        if progress is not None:
            some = min(some, left - told)  # copies do not count
            told += some
            progress(some)

    found = run(jax.tree.map(lambda leaf: np.asarray(leaf)[rows], batch), ended)
    leaves, tree = jax.tree.flatten(found)
    leaves = [np.ascontiguousarray(leaf) for leaf in leaves]
    every = _gathered(np.concatenate([leaf.reshape(-1).view(np.uint8) for leaf in leaves]))
    ends = np.cumsum([leaf.nbytes for leaf in leaves])
    parts = np.split(every, ends[:-1], axis=1)
    if progress is not None:
        progress(count - told)
    return jax.tree.unflatten(
        tree,
        [
            np.ascontiguousarray(part).view(leaf.dtype).reshape(-1, *leaf.shape[1:])[:count]
            for part, leaf in zip(parts, leaves, strict=True)
        ],
    )


def _gathered(content: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Bytes of every process, (processes, bytes); all have as many."""
    # Lengths are powers of two, so that few programs are compiled.
    padded = np.zeros(max(_DIGEST, 1 << (len(content) - 1).bit_length()), np.uint8)
    padded[: len(content)] = content
    try:
        found: npt.NDArray[np.uint8] = np.asarray(process_allgather(padded))
    except (RuntimeError, ValueError) as error:  # what a broken connection is to JAX
        raise LostProcessError(f"another process has ended early ({error})") from error
    return found[:, : len(content)]


def _digest(of: Any) -> bytes:
    content = hashlib.blake2b(digest_size=_DIGEST)
    for leaf in map(np.asarray, jax.tree.leaves(of)):
        content.update(f"{leaf.dtype}{leaf.shape}".encode())
        content.update(np.ascontiguousarray(leaf).tobytes())
    return content.digest()


def leave(code: int) -> NoReturn:
    """End this process at once: JAX's orderly end would wait for processes that are gone."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
