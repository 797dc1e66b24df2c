"""Tutorials run from top to bottom, and their verdicts are those that the pages print."""

from __future__ import annotations

import re

import pytest
from pages_of_docs import DOCS, pages

pytestmark = [pytest.mark.slow, pytest.mark.optimised]

VERDICT = re.compile(r"^  (status|active intervals|final time \[s\]) +(.+)$|^(\d+) settled", re.M)


def verdicts(text: str) -> list[str]:
    """What a report says was reached; numbers to four digits."""
    found = [" ".join(filter(None, row)) for row in VERDICT.findall(text)]
    return [re.sub(r"\d+\.\d+", lambda n: f"{float(n[0]):.4g}", row) for row in found]


@pytest.mark.parametrize("name", ["hands-off", "minimum-time", "feedback"])
def test_tutorial_runs_as_printed(name: str) -> None:
    """The others cost more, and solve as the notebooks of their families do."""
    page = (DOCS / "tutorials" / f"{name}.md").read_text(encoding="utf-8")
    every = pages.blocks(page)
    compared = 0
    with pages.folder_of(page):
        for block, printed in pages.run(page):
            after = every[every.index(block) + 1 :][:1]
            if after and after[0].language == "text" and block.language == "bash":
                assert verdicts(printed) == verdicts(after[0].text) != []
                compared += 1
    assert compared
