"""Progress of a solve, shown on the standard error stream."""

from __future__ import annotations

import time
from contextlib import suppress
from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

_SECONDS_BETWEEN_LINES = 2.0
"""Between lines of the same stage, where there is no terminal that could show a bar."""

SAMPLES = "samples"
"""Stage of a sweep; its first report says how many were there before."""

_COUNTED = ("deciding", "polishing", "flying", SAMPLES)
"""Stages that treat every start once; how much others will have to do is not known."""


class _Listened(Console):
    """A console that falls silent, rather than end the process, when nobody listens any more."""

    def on_broken_pipe(self) -> None:
        self.quiet = True


class Reporter:
    """Callable (stage, starts ended) for `solve`: a bar in a terminal, plain lines elsewhere.

    Use it as a context, so that the terminal is left as it was whatever happens.
    """

    def __init__(self, starts: int, silent: bool = False):
        console = _Listened(stderr=True)
        self._starts, self._console, self._silent = starts, console, silent
        self._stage, self._done = "", 0
        self._told = -_SECONDS_BETWEEN_LINES
        self._sampling = False
        self._paced: tuple[float, int] | None = None
        self._task: TaskID | None = None
        self._bar = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[count]}"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
            disable=silent or not console.is_terminal,
        )

    def __enter__(self) -> Reporter:
        self._bar.start()
        self._task = self._bar.add_task("compiling", total=None, count="")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def __call__(self, stage: str, done: int) -> None:
        again = self._total(stage) is not None and self._done >= self._starts
        fresh = stage != self._stage or again
        if fresh:
            self._stage, self._done = stage, 0
        self._done += done
        total = self._total(stage)
        count = str(self._done) if total is None else f"{self._done} of {total}"
        count += self._time_left(stage)
        if self._console.is_terminal and self._task is not None:
            self._bar.update(
                self._task, description=stage, total=total, completed=self._done, count=count
            )
        elif not self._silent and (fresh or self._done == total or self._overdue()):
            self._told = time.monotonic()
            with suppress(OSError):  # a full disk
                self._console.print(
                    f"{stage}: {count}", highlight=False, markup=False, soft_wrap=True
                )

    def _time_left(self, stage: str) -> str:
        """Time that a sweep still takes, from its pace since the first sample, which compiles."""
        if stage != SAMPLES or self._done == self._starts:
            return ""
        if not self._sampling:
            self._sampling = True
        elif self._paced is None:
            self._paced = (time.monotonic(), self._done)
        elif self._done > self._paced[1]:
            began, first = self._paced
            left = (self._starts - self._done) * (time.monotonic() - began) / (self._done - first)
            return f", about {_words(left)} left"
        return ""

    def _overdue(self) -> bool:
        return time.monotonic() - self._told >= _SECONDS_BETWEEN_LINES

    def _total(self, stage: str) -> int | None:
        return self._starts if stage.startswith(_COUNTED) else None


def _words(seconds: float) -> str:
    """Return a duration in the unit that suits it."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"
