"""Imports inside the package: at the top of a file, and without a circle.

That they lead downward from floor to floor is what `lint-imports` checks (pyproject.toml).
"""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import jaxatt

ROOT = Path(jaxatt.__file__).parent
FILES = {
    ".".join(("jaxatt", *file.relative_to(ROOT).with_suffix("").parts)).removesuffix(
        ".__init__"
    ): file
    for file in sorted(ROOT.rglob("*.py"))
}


def imported(node: ast.Import | ast.ImportFrom, files: dict[str, Path]) -> set[str]:
    """Those of the package's files that a statement imports."""
    if isinstance(node, ast.Import):
        return {name.name for name in node.names} & set(files)
    assert node.level == 0, "the package imports by full names"
    inner = {f"{node.module}.{name.name}" for name in node.names}
    rest = {node.module} if inner - set(files) else set()
    return (inner | rest) & set(files)


def imports(source: str, files: dict[str, Path]) -> tuple[set[str], set[str]]:
    """What a file imports of the package at its top, and what anywhere else."""
    tree = ast.parse(source)
    every = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    top = [n for n in every if n in tree.body]
    within = [n for n in every if n not in tree.body]
    first, second = (set().union(*(imported(n, files) for n in some)) for some in (top, within))
    return first, second


@pytest.fixture(scope="module")
def found() -> dict[str, tuple[set[str], set[str]]]:
    return {name: imports(file.read_text(encoding="utf-8"), FILES) for name, file in FILES.items()}


def test_statements_are_told_apart() -> None:
    files = dict.fromkeys(("jaxatt", "jaxatt.a", "jaxatt.a.b", "jaxatt.c", "jaxatt.d"), ROOT)
    source = """
import numpy, jaxatt.c
from jaxatt.a import b, name
if TYPE_CHECKING:
    from jaxatt import c
def function():
    from jaxatt.d import other
"""
    assert imports(source, files) == (
        {"jaxatt.c", "jaxatt.a", "jaxatt.a.b"},
        {"jaxatt.c", "jaxatt.d"},
    )


def test_imports_stand_at_the_top(found: dict[str, tuple[set[str], set[str]]]) -> None:
    assert not [name for name, (_, later) in found.items() if later]


def test_no_circle_among_files(found: dict[str, tuple[set[str], set[str]]]) -> None:
    tops = {name: top for name, (top, _) in found.items()}
    TopologicalSorter(tops).prepare()  # raises CycleError, with the circle
    assert "jaxatt.pipeline.solve" in tops["jaxatt"]
    with pytest.raises(CycleError):
        TopologicalSorter({**tops, "jaxatt.pipeline.solve": {"jaxatt"}}).prepare()
