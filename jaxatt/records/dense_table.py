"""Empty table of many columns, for the terminal and for notebooks."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text


def dense_table(title: str, caption: Text | None = None) -> Table:
    """Table without columns, whose cells stand close together."""
    return Table(
        title=Text(title, style="bold"),
        caption=caption,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        padding=(0, 1, 0, 0),
        pad_edge=False,
    )
