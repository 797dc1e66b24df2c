"""Run a study that grows a store, and say what it holds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import typer

from jaxatt.cli.common import INTERRUPTED, complain, finish, say
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.stored_study import StoredStudy

Found = TypeVar("Found", bound=StoredStudy)


def grown(
    run: Callable[[Report], Found],
    samples: int,
    path: Path,
    share: tuple[int, int],
    quiet: bool,
) -> Found:
    """Run a study with progress; print and draw it, unless it is one task of several.

    run : grows the store at `path`, reporting every sample.  samples : of task i of n = `share`.
    """
    try:
        with Reporter(samples, quiet) as report:
            found = run(report)
    except KeyboardInterrupt:
        if path.exists():
            complain(
                f"Interrupted; what is done stays in {path}, and the same command goes on from it."
            )
        else:
            complain("Interrupted before anything was done; nothing was written.")
        raise typer.Exit(INTERRUPTED) from None
    task, of = share
    if of > 1:
        say(f"Task {task}/{of}: {found!r}; jaxatt merge joins the stores of all tasks")
    else:
        folder = path.parent
        finish(repr(found), lambda: [path, *found.save(folder)], folder, quiet, found.table())
    return found
