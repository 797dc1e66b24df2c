"""The site: the pages of this folder, the notebooks and the reference from docstrings.

    pip install ".[docs]" && sphinx-build -W --keep-going -c docs . build/site

The folder of the sources is the whole project, so that pages may link to code.
"""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path
from typing import Any

project = "jaxatt"
release = metadata.version("jaxatt")
copyright = "the authors of jaxatt"
root_doc = "docs/README"
include_patterns = [
    "README.md",
    "CHANGELOG.md",
    "benchmarks/README.md",
    "docs/**",
    "notebooks/*.py",
]

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = "off"
exclude_patterns = ["docs/*.py"]  # conf.py, and what makes parts of pages
myst_heading_anchors = 4
myst_enable_extensions = ["amsmath", "dollarmath"]

autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 88
autodoc_member_order = "bysource"
napoleon_google_docstring = False
default_role = "code"

html_theme = "furo"
html_title = f"jaxatt {release}"
html_show_sphinx = False


_CODE = re.compile(r"\[([^]]*)\]\((\.\./(?:jaxatt|tests|benchmarks)/[^)]*\.py)\)")
_ENTRY = re.compile(r"^([A-Za-z_][\w, ]*) : (.*)$")


def read_page(app: Any, name: str, source: list[str]) -> None:
    """Let links to code load files; the tables of the first page are the navigation."""
    source[0] = _CODE.sub(r"{download}`\1 <\2>`", source[0].replace("[`", "[").replace("`](", "]("))
    if name != root_doc:
        return
    parts = re.split(r"^## (.*)$", source[0], flags=re.MULTILINE)[1:]
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        pages = re.findall(r"^\| \[[^]]*\]\(([^)#]*)\)", text, flags=re.MULTILINE)
        lines = "\n".join(page.removesuffix(".md").removesuffix(".py") for page in pages)
        source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n{lines}\n```\n"


def read_docstring(
    app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Make a list of the lines `name : meaning` that the package's docstrings have."""
    made: list[str] = []
    inside = False
    sections = False  # NumPy's, which Napoleon reads
    for line in lines:
        sections = sections or line.startswith("-----")
        entry = None if sections else _ENTRY.match(line)
        if entry:
            made += [*([] if inside else [""]), f"- ``{entry[1]}`` : {_plain(entry[2])}"]
        else:
            made.append(f"  {_plain(line)}" if inside and line else _plain(line))
        inside = bool(entry) or (inside and bool(line))
    lines[:] = made


def _plain(text: str) -> str:
    """Text whose bars and stars outside of code mean themselves."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([|*])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def lead_to_first_page(app: Any, error: Exception | None) -> None:
    """Write the index that browsers and servers look for at the top of a site."""
    if error is None and app.builder.format == "html":
        to = f'<meta http-equiv="refresh" content="0; url={root_doc}.html">'
        page = f"<!doctype html><title>{project}</title>{to}"
        (Path(app.outdir) / "index.html").write_text(page + "\n", encoding="utf-8")


def setup(app: Any) -> None:
    """Connect the steps of this file."""
    app.connect("build-finished", lead_to_first_page)
    app.connect("source-read", read_page)
    app.connect("autodoc-process-docstring", read_docstring, priority=400)
