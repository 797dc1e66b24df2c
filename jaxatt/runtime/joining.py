"""Join processes that run one computation, and end one without leaving the others waiting.

JAX's runtime connects the processes, keeps in touch and ends all when one is lost.
"""

from __future__ import annotations

import os
import sys
import threading
from dataclasses import dataclass
from typing import NoReturn

AUTOMATIC = "auto"
"""Coordinator that the cluster's scheduler tells."""

JOIN_S = 300.0
"""[s] Within which all processes must have started."""

_HEARTBEAT_S = 30
"""[s] After which a process that gives no sign of life counts as lost, and ends all others."""

_FILES_S = 3600
"""[s] For which processes that have ended wait for the one that writes."""


class JoinError(ValueError):
    """Processes that cannot work together: the message says why and how to mend it."""


class LostProcessError(RuntimeError):
    """Another process has ended before this one got what it computes."""


@dataclass(frozen=True)
class Joining:
    """Where and as which of them a process joins others.

    coordinator : "host:port" of process 0, "auto" where SLURM, Open MPI or another scheduler that
        JAX knows has started the processes, or None for one process alone.
    processes : how many.  process : which of them this is, from 0; both are the scheduler's where
        the coordinator is "auto".
    timeout_s : [s] within which all must have started.
    """

    coordinator: str | None = None
    processes: int | None = None
    process: int | None = None
    timeout_s: float = JOIN_S

    def check(self) -> None:
        """Raise `JoinError` where the fields contradict each other."""
        some = self.processes is not None or self.process is not None
        if self.coordinator is None:
            if some:
                raise JoinError(
                    "--processes and --process need --coordinator HOST:PORT, the address of "
                    "process 0"
                )
        elif self.coordinator == AUTOMATIC:
            if some:
                raise JoinError(
                    f"--coordinator {AUTOMATIC} takes --processes and --process from the "
                    "scheduler; leave them out, or give HOST:PORT"
                )
        else:
            self._check_explicit(self.coordinator)

    def _check_explicit(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or not 0 < int(port) < 65536:
            raise JoinError(
                f"--coordinator {address}: HOST:PORT of process 0 is expected, or {AUTOMATIC}"
            )
        if self.processes is None or self.process is None:
            raise JoinError(
                f"--coordinator {address} needs --processes, how many there are, and --process, "
                "which of them this is"
            )
        if not 0 <= self.process < self.processes:
            raise JoinError(
                f"--process {self.process} of --processes {self.processes}: they are numbered from "
                "0 to processes - 1"
            )

    def join(self) -> None:
        """Join the others; call it before the first computation.

        Raises `JoinError` where fields contradict each other or the others do not answer.
        """
        self.check()
        if self.coordinator is None:
            return
        import jax  # who joins nobody waits for no JAX

        failed: list[Exception] = []

        def connect() -> None:
            try:
                jax.distributed.initialize(
                    None if self.coordinator == AUTOMATIC else self.coordinator,
                    self.processes,
                    self.process,
                    # When the time for this is over, the runtime ends the process by itself, and
                    # less kindly.
                    initialization_timeout=int(self.timeout_s) + 3600,
                    heartbeat_timeout_seconds=_HEARTBEAT_S,
                    shutdown_timeout_seconds=_FILES_S,
                )
            except Exception as error:  # whatever a scheduler's variables or a name lead to
                failed.append(error)

        connecting = threading.Thread(target=connect, daemon=True)
        connecting.start()
        connecting.join(self.timeout_s)
        if connecting.is_alive():
            raise JoinError(self._unanswered())
        if failed:
            raise JoinError(self._refused(failed[0])) from failed[0]

    def _unanswered(self) -> str:
        within = f"within {self.timeout_s:g} s"
        if self.process == 0:
            return (
                f"not all other processes have joined {self.coordinator} {within}; start them with "
                "the same --coordinator and --processes, or allow more with --join-timeout"
            )
        return (
            f"no answer from the coordinator {self.coordinator}, or not from all processes, "
            f"{within}; see that process 0 runs there and that its port is open, or allow more "
            "with --join-timeout"
        )

    def _refused(self, error: Exception) -> str:
        if self.coordinator == AUTOMATIC:
            return (
                f"--coordinator {AUTOMATIC}: no scheduler has started this process ({error}); "
                "start it with srun or mpirun, or give HOST:PORT, --processes and --process"
            )
        return f"--coordinator {self.coordinator}: {error}"


def several() -> bool:
    """Whether this process has joined others, or tried to."""
    jax = sys.modules.get("jax")  # whoever has joined others has loaded it
    return jax is not None and bool(jax.distributed.is_initialized())


def writes() -> bool:
    """Whether this process writes and prints: process 0 does."""
    return not several() or bool(sys.modules["jax"].process_index() == 0)


def leave(code: int) -> NoReturn:
    """End this process at once: JAX's orderly end would wait for processes that are gone."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
