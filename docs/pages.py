"""Run a page from top to bottom and put what it prints, and its figures, into it.

    python docs/pages.py docs/tutorials/minimum-time.md   # these pages
    python docs/pages.py                                  # every tutorial

What a page may hold, besides words:

- a block of `toml` whose first line is `# NAME.toml` is that file;
- the lines of a block of `bash` that begin with `jaxatt` are called one after the other, and a
  block of `text` right after it holds what they print;
- blocks of `python` run in one namespace;
- `<!-- not run: REASON -->` before a block leaves it alone;
- `<!-- figure: FILE -->` before a picture says which file of the run it is.

All run in one empty folder, with the files of the page on the tutorials' satellite.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

DOCS = Path(__file__).parent
SATELLITE = DOCS / "tutorials" / "satellite.md"

BLOCK = re.compile(
    r"^(?:<!-- not run: (?P<reason>.+?) -->\n+)?```(?P<language>\w*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
FIGURE = re.compile(r"<!-- figure: (\S+) -->\n+!\[[^\]]*\]\(([^)]+)\)")


@dataclass(frozen=True)
class Block:
    """A block of code of a page.

    reason : why it is not run; empty where it is.  where : its text, as a range of the page.
    """

    language: str
    text: str
    reason: str
    where: tuple[int, int]

    @property
    def file(self) -> str:
        """The name of the file that it is; empty for any other block."""
        first = re.match(r"# (\S+\.toml)$", self.text.partition("\n")[0])
        return first[1] if first and self.language == "toml" else ""

    @property
    def commands(self) -> list[list[str]]:
        """The words of each call of `jaxatt`, without comments."""
        lines = (line.partition(" > ")[0] for line in self.text.splitlines())
        words = (shlex.split(line, comments=True) for line in lines)
        return [found for found in words if found[:1] == ["jaxatt"]]


def blocks(page: str) -> list[Block]:
    """All blocks of code of a page, in their order."""
    return [
        Block(found["language"], found["text"], found["reason"] or "", found.span("text"))
        for found in BLOCK.finditer(page)
    ]


def files(page: str) -> dict[str, str]:
    """Name -> text of the files that a page shows in full."""
    return {block.file: block.text for block in blocks(page) if block.file}


@contextlib.contextmanager
def folder_of(page: str) -> Iterator[Path]:
    """Stand in an empty folder that has the files of a page and of the tutorials' satellite."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="page-") as folder:
        for name, text in (files(SATELLITE.read_text(encoding="utf-8")) | files(page)).items():
            Path(folder, name).write_text(text, encoding="utf-8")
        os.chdir(folder)
        try:
            yield Path(folder)
        finally:
            os.chdir(before)


def run(page: str) -> Iterator[tuple[Block, str]]:
    """Run the blocks of a page in the current folder; yield each with what it printed.

    Raises `RuntimeError` where a command ends with another code than 0.
    """
    names: dict[str, Any] = {}
    for block in blocks(page):
        if block.reason or block.language not in ("bash", "python"):
            continue
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            if block.language == "python":
                exec(compile(block.text, "page", "exec"), names)
            else:
                for words in block.commands:
                    call(words)
        yield block, printed.getvalue()


def call(words: list[str]) -> None:
    """Call the command line in this process."""
    from jaxatt.cli import main

    with mock.patch.object(sys, "argv", words), mock.patch.dict(os.environ, COLUMNS="96"):
        try:
            main()
        except SystemExit as ended:
            if ended.code:
                raise RuntimeError(f"{' '.join(words)}: exit code {ended.code}") from None


def refreshed(path: Path) -> str:
    """Run a page; return it with what was printed, and copy its figures."""
    page = path.read_text(encoding="utf-8")
    changes: list[tuple[tuple[int, int], str]] = []
    with folder_of(page) as folder:
        every = blocks(page)
        for block, printed in run(page):
            after = every[every.index(block) + 1 :][:1]
            if after and after[0].language == "text":
                changes.append((after[0].where, tidied(printed)))
        for name, picture in FIGURE.findall(page):
            shrink(folder / name, path.parent / picture)
    for (start, end), text in reversed(changes):
        page = page[:start] + text + page[end:]
    return page


def tidied(printed: str) -> str:
    """What a command printed, without the lines about times and versions that follow the answer."""
    text = re.split(r"^compile ", printed, maxsplit=1, flags=re.MULTILINE)[0]
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines()).rstrip() + "\n"


def shrink(picture: Path, to: Path, width: int = 900) -> None:
    """Copy a picture, no wider than a page and with a palette, so that it stays small."""
    from PIL import Image

    with Image.open(picture) as image:
        size = (width, round(image.height * width / image.width))
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        to.parent.mkdir(exist_ok=True)
        small.quantize(64).save(to, optimize=True)


def main() -> None:
    """Refresh the pages that are named, or all tutorials."""
    tutorials = sorted((DOCS / "tutorials").glob("*.md"))
    for path in [Path(name).resolve() for name in sys.argv[1:]] or tutorials:
        path.write_text(refreshed(path), encoding="utf-8")
        print(path.name, flush=True)


if __name__ == "__main__":
    import jaxatt

    jaxatt.configure()
    main()
