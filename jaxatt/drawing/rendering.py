"""Conversion of rich tables to plain text and to HTML."""

from __future__ import annotations

import io

from rich.console import Console, RenderableType

_PAGE = "<pre style=\"font-family:Menlo,'DejaVu Sans Mono',monospace;line-height:1.2\">{code}</pre>"


def as_text(renderable: RenderableType, width: int = 100) -> str:
    """Render as plain text without colours."""
    console = Console(file=io.StringIO(), width=width, color_system=None, force_terminal=False)
    with console.capture() as capture:
        console.print(renderable)
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def as_html(renderable: RenderableType, width: int = 110) -> str:
    """Render as a block of HTML that carries its own styles."""
    console = Console(file=io.StringIO(), width=width, record=True, force_jupyter=False)
    console.print(renderable)
    return console.export_html(inline_styles=True, code_format=_PAGE)
