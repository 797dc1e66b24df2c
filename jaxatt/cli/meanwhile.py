"""Load what a command needs at its end while it computes."""

from __future__ import annotations

import importlib
import threading
from contextlib import suppress

from jaxatt.runtime.chunks import Report


def loading(report: Report, modules: tuple[str, ...]) -> Report:
    """A report of progress whose first call begins to load modules in a thread.

    Where programs are compiled ahead the first report comes when they are traced, after which the
    interpreter is free for most of the time.  Any thread may report.
    """
    first = threading.Lock()

    def told(stage: str, done: int) -> None:
        if first.acquire(blocking=False):
            threading.Thread(target=_load, args=(modules,), daemon=True).start()
        report(stage, done)

    return told


def _load(modules: tuple[str, ...]) -> None:
    for module in modules:
        with suppress(Exception):  # Whoever needs it says so.
            importlib.import_module(module)
