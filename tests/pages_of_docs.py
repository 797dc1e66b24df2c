"""The modules beside the pages, and every page of the project."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
PAGES = sorted([ROOT / "README.md", *DOCS.rglob("*.md"), ROOT / "benchmarks" / "README.md"])


def module(path: str) -> ModuleType:
    """Load a module of the project that is in no package that tests import."""
    name = Path(path).stem
    specification = importlib.util.spec_from_file_location(name, ROOT / path)
    assert specification is not None and specification.loader is not None
    loaded = importlib.util.module_from_spec(specification)
    sys.modules[name] = loaded
    specification.loader.exec_module(loaded)
    return loaded


pages = module("docs/pages.py")


def title(page: Path) -> str:
    """How a test names a page."""
    return str(page.relative_to(ROOT))
