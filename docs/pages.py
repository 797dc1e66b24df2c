"""Run a page from top to bottom and put what it prints, and its figures, into it.

    python docs/pages.py docs/tutorials/minimum-time.md   # these pages
    python docs/pages.py                                  # every tutorial

What a page may hold, besides words:

- a block of `toml` whose first line is `# NAME.toml` is that file, and so is any other block after
  `<!-- file: NAME -->`;
- the calls of `jaxatt` in a block of `bash` are made one after the other, and a block of `text`
  right after it holds what they print;
- blocks of `python` run in one namespace;
- `<!-- not run: REASON -->` before a block leaves it alone;
- `<!-- ends with: 3 -->` before it says how its calls end;
- `<!-- in tests: COMMAND --option value; ... -->` before it makes tests call a command with less
  to do;
- `<!-- figure: FILE -->` before a picture says which file of the run it is.

All run in one empty folder, with the files of the page on the tutorials' satellite.
"""

from __future__ import annotations

import contextlib
import glob
import io
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

DOCS = Path(__file__).parent
SATELLITE = DOCS / "tutorials" / "satellite.md"

BLOCK = re.compile(
    r"^(?:<!-- (?P<mark>not run|ends with|in tests|file): (?P<said>.+?) -->\n+)?"
    r"```(?P<language>\w*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
FIGURE = re.compile(r"<!-- figure: (\S+) -->\n+!\[[^\]]*\]\(([^)]+)\)")


@dataclass(frozen=True)
class Block:
    """A block of code of a page.

    mark, said : the comment before it, such as "not run" and why; empty without one.
    where : its text, as a range of the page.
    """

    language: str
    text: str
    mark: str
    said: str
    where: tuple[int, int]

    @property
    def runs(self) -> bool:
        """Whether it is run, with what stands before it on the page."""
        return self.language in ("bash", "python") and self.mark != "not run"

    @property
    def file(self) -> str:
        """The name of the file that it is; empty for any other block."""
        if self.mark == "file":
            return self.said
        first = re.match(r"# (\S+\.toml)$", self.text.partition("\n")[0])
        return first[1] if first and self.language == "toml" else ""

    @property
    def lines(self) -> list[str]:
        """Lines that say something, continued ones joined."""
        lines = (line.strip() for line in self.text.replace("\\\n", " ").splitlines())
        return [line for line in lines if line and not line.startswith("#")]

    @property
    def code(self) -> int:
        """The exit code of its calls."""
        return int(self.said) if self.mark == "ends with" else 0

    def less(self, command: str) -> list[str]:
        """The words that tests add to calls of a command."""
        added = self.said.split("; ") if self.mark == "in tests" else []
        return [word for each in map(str.split, added) if each[0] == command for word in each[1:]]


def blocks(page: str) -> list[Block]:
    """All blocks of code of a page, in their order."""
    return [
        Block(
            *(found[name] or "" for name in ("language", "text", "mark", "said")),
            found.span("text"),
        )
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


def run(page: str, less: bool = False) -> Iterator[tuple[Block, str]]:
    """Run the blocks of a page in the current folder; yield each with what it printed.

    less : do only what tests need.

    Raises `RuntimeError` where a command ends with another code than 0, or than the page says.
    """
    names: dict[str, Any] = {}
    for block in blocks(page):
        if not block.runs:
            continue
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            if block.language == "python":
                exec(compile(block.text, "page", "exec"), names)
            else:
                for line in block.lines:
                    call(line, block.code, block.less if less else lambda command: [])
        yield block, printed.getvalue()


def call(line: str, code: int, more: Callable[[str], list[str]]) -> None:
    """Call the command line in this process, as a shell would with a line of a page.

    code : with which it ends.  more : the words that are added to those of a command.
    """
    from jaxatt.cli import main

    line, _, file = line.partition(" > ")
    words = shlex.split(os.path.expandvars(line), comments=True)
    if words[:1] != ["jaxatt"]:
        raise RuntimeError(f"{line}: only calls of jaxatt are run; mark the block as not run")
    words = [name for word in words for name in sorted(glob.glob(word)) or [word]]
    words += more(words[1])
    with (
        mock.patch.object(sys, "argv", words),
        mock.patch.dict(os.environ, COLUMNS="96"),
        open(file.split()[0], "w", encoding="utf-8") if file else contextlib.nullcontext() as to,
        contextlib.redirect_stdout(to) if to else contextlib.nullcontext(),
    ):
        try:
            main()
        except SystemExit as ended:
            if (ended.code or 0) != code:
                raise RuntimeError(f"{line}: exit code {ended.code}") from None


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
