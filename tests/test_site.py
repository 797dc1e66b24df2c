"""A newcomer finds each of these tasks within two clicks from the first page of the site."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from pages_of_docs import DOCS, ROOT

START = DOCS / "README.md"
LINK = re.compile(r"\]\((?!https?:)([^)\s#]+)")

TASKS = {
    "my own satellite": ("inertia_kgm2", "[wheels]", 'file = "mine.toml"'),
    "point a camera at a ground site": ('toward = "site"', "latitude_deg", "camera"),
    "cones": ("[[keep_out]]", "half_angle_deg"),
    "a wheel has failed": ("--failed-wheel", "failed = ["),
    "fewest pulses": ('kind = "l0"', "jaxatt solve slew.toml"),
    "minimum time": ('kind = "minimum-time"', "jaxatt solve fast.toml"),
    "most energy": ('kind = "net-power"', "jaxatt solve harvest.toml"),
    "export to STK or AEM": ("jaxatt export", "--format stk", "--format aem"),
    "sweep on a cluster": ("#SBATCH", "--task", "jaxatt merge"),
    "my own feedback law": ("def __call__(self, measured, memory, period)", "jaxatt.simulate("),
    "what reached means": ("**Reached** is said of", "**Converged** is said of"),
    "an error and its mend": ("## Exit codes", "| it says | mend |"),
}
"""Task -> words that one page holds together."""


def linked(page: Path) -> set[Path]:
    """The pages of the project that a page leads to."""
    links = LINK.findall(page.read_text(encoding="utf-8"))
    found = {(page.parent / link).resolve() for link in links}
    return {each for each in found if each.suffix == ".md" and each.is_relative_to(ROOT)}


@pytest.fixture(scope="module")
def within_two_clicks() -> dict[Path, str]:
    """Page -> text of all that two links reach."""
    once = linked(START)
    twice = once | {page for first in once for page in linked(first)}
    return {page: page.read_text(encoding="utf-8") for page in twice}


@pytest.mark.parametrize("task", TASKS)
def test_task_is_found(task: str, within_two_clicks: dict[Path, str]) -> None:
    holds = [
        page
        for page, text in within_two_clicks.items()
        if all(word in text for word in TASKS[task])
    ]
    assert holds, f"no page within two clicks says all of {TASKS[task]}"


def test_every_page_is_within_one_click() -> None:
    every = set(DOCS.rglob("*.md")) - {START}
    assert {page.resolve() for page in every} <= linked(START)


def test_version_is_one() -> None:
    """The version of the package, of the newest heading of the changes, and of the citation."""
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    version = re.search(r'^version = "(.+)"', project, flags=re.MULTILINE)[1]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(r"^## \[(\d.+?)\]", changes, flags=re.MULTILINE)[1] == version
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: \"?([\d.]+)", citation, flags=re.MULTILINE)[1] == version
