"""Every page runs from top to bottom, and what it says of verdicts is what comes out."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import jax
import pytest
from pages_of_docs import PAGES, ROOT, pages, title

LANGUAGES = {"bash", "python", "toml", "text"}

NOT_RUN = {
    "README.md": [
        "pip takes what it installs from the network",
        "the tests themselves",
    ],
    "docs/design.md": ["minutes each; tests/studies/test_design.py has smaller ones of both kinds"],
    "docs/scale.md": ["several machines; tests/multistart/test_processes.py joins two processes"],
    "docs/start.md": ["pip takes what it installs from the network"],
    "docs/tutorials/net-power.md": [
        "several minutes and 3 GiB; tests/problems/net_power/plan has a short one"
    ],
}
"""Reasons for blocks that are not run, by page."""

QUICK = {
    "docs/concepts/frames.md",
    "docs/files.md",
    "docs/how-to/own-problem.md",
    "docs/minimize.md",
    "docs/own-programmes.md",
    "docs/power.md",
    "docs/tutorials/satellite.md",
}
"""Pages that run within five seconds of processor time; the others are among the long studies."""

VERDICT = re.compile(
    r"^  (status|active intervals|final time(?: \[s\])?|objective) +(.+)$"
    r"|^(\d+) settled|^Minimal, ",
    re.MULTILINE,
)

DOCUMENTS = [page for page in PAGES if page.is_relative_to(ROOT / "docs")] + [ROOT / "README.md"]
RUN = [page for page in DOCUMENTS if any(b.runs for b in pages.blocks(page.read_text("utf-8")))]


def verdicts(text: str) -> list[str]:
    """What a report says was reached; numbers to four digits."""
    found = [" ".join(filter(None, row.groups())) for row in VERDICT.finditer(text)]
    return [re.sub(r"\d+\.\d+", lambda n: f"{float(n[0]):.4g}", row) for row in found]


@pytest.fixture
def own_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a job array would set; the settings of JAX stay those of the tests."""
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("SLURM_ARRAY_TASK_ID", "0")
    monkeypatch.setenv("SCRATCH", str(tmp_path))
    kept = jax.config.jax_compilation_cache_dir
    yield
    jax.config.update("jax_compilation_cache_dir", kept)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[] if title(page) in QUICK else pytest.mark.slow, id=title(page))
        for page in RUN
    ],
)
def test_page_runs_as_printed(page: Path, own_settings: None) -> None:
    text = page.read_text(encoding="utf-8")
    every = pages.blocks(text)
    runs = 0
    with pages.folder_of(text):
        for block, printed in pages.run(text, less=True):
            after = every[every.index(block) + 1 :][:1]
            if after and after[0].language == "text" and not block.mark:
                told = verdicts(after[0].text)  # A page may show a part of what is printed.
                assert [row for row in verdicts(printed) if row in told] == told
            runs += 1
    assert runs == sum(block.runs for block in every)


@pytest.mark.parametrize("page", DOCUMENTS, ids=title)
def test_every_block_is_run_or_says_why_not(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    every = pages.blocks(text)
    opened = re.findall(r"^ *```(\S*)\n.*?^ *```$", text, flags=re.MULTILINE | re.DOTALL)
    assert [name for name in opened if name != "{eval-rst}"] == [b.language for b in every]
    assert {block.language for block in every} <= LANGUAGES
    assert [b.said for b in every if b.mark == "not run"] == NOT_RUN.get(title(page), [])


def test_quick_pages_are_pages_that_run() -> None:
    assert set(map(title, RUN)) >= QUICK
    assert len(RUN) > 25
