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
WAIT = {
    "jaxatt.cli.common": "commands that compute nothing load no JAX",
    "jaxatt.drawing.figure": "matplotlib is loaded by whoever draws",
}
"""Files that import within functions, and why."""


def imported(node: ast.Import | ast.ImportFrom, files: dict[str, Path]) -> set[str]:
    """Those of the package's files that a statement imports."""
    if isinstance(node, ast.Import):
        return {name.name for name in node.names} & set(files)
    assert node.level == 0, "the package imports by full names, but for stubs"
    inner = {f"{node.module}.{name.name}" for name in node.names}
    rest = {node.module} if inner - set(files) else set()
    return (inner | rest) & set(files)


def imports(source: str, files: dict[str, Path]) -> tuple[set[str], set[str]]:
    """What a file imports of the package at its top, and what anywhere else."""
    tree = ast.parse(source)
    every = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    for_types = [n for n in tree.body if isinstance(n, ast.If) and names_types(n.test)]
    head = [*tree.body, *(n for block in for_types for n in block.body)]
    top = [n for n in every if n in head]
    within = [n for n in every if n not in head]
    first, second = (set().union(*(imported(n, files) for n in some)) for some in (top, within))
    return first, second


def names_types(test: ast.expr) -> bool:
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"


def text_of(name: str, file: Path) -> str:
    """Source of a file; of a package whose names are loaded later, its stub with full names."""
    stub = file.with_suffix(".pyi")
    if not stub.exists():
        return file.read_text(encoding="utf-8")
    stubbed = stub.read_text(encoding="utf-8")
    return stubbed.replace("from . import", f"from {name} import").replace(
        "from .", f"from {name}."
    )


@pytest.fixture(scope="module")
def found() -> dict[str, tuple[set[str], set[str]]]:
    return {name: imports(text_of(name, file), FILES) for name, file in FILES.items()}


def test_statements_are_told_apart() -> None:
    files = dict.fromkeys(("jaxatt", "jaxatt.a", "jaxatt.a.b", "jaxatt.c", "jaxatt.d"), ROOT)
    source = """
import numpy, jaxatt.c
from jaxatt.a import b, name
if TYPE_CHECKING:
    from jaxatt import c
if other:
    import jaxatt.d
def function():
    from jaxatt.d import other
"""
    assert imports(source, files) == (
        {"jaxatt.c", "jaxatt.a", "jaxatt.a.b"},
        {"jaxatt.d"},
    )


def test_imports_stand_at_the_top(found: dict[str, tuple[set[str], set[str]]]) -> None:
    assert {name for name, (_, later) in found.items() if later} == set(WAIT)


def test_no_circle_among_files(found: dict[str, tuple[set[str], set[str]]]) -> None:
    tops = {name: top for name, (top, _) in found.items()}
    TopologicalSorter(tops).prepare()  # raises CycleError, with the circle
    assert "jaxatt.pipeline.solve" in tops["jaxatt"]
    with pytest.raises(CycleError):
        TopologicalSorter({**tops, "jaxatt.pipeline.solve": {"jaxatt"}}).prepare()
