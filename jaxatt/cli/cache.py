"""Command `jaxatt cache`."""

from __future__ import annotations

import typer

from jaxatt.cli.common import clean_exit, say
from jaxatt.runtime.compile_cache import MOST_BYTES, Kept, clear, kept, user_cache

cache = typer.Typer(
    help="Say what is kept of compiled programs, or remove it.",
    add_completion=False,
    no_args_is_help=True,
)


@cache.command("info")
def info() -> None:
    """Say where compiled programs are kept, and how much."""
    with clean_exit():
        folder = user_cache()
        say(f"{folder}: {_words(kept(folder))}; at most {MOST_BYTES >> 20} MiB are kept")


@cache.command("clear")
def remove() -> None:
    """Remove all compiled programs that are kept."""
    with clean_exit():
        folder = user_cache()
        say(f"{folder}: {_words(clear(folder))} removed")


def _words(held: Kept) -> str:
    return f"{held.files} files, {held.size / 2**20:.1f} MiB"
