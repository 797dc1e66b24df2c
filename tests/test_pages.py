"""What pages show is possible: files load, commands exist, tables are those of the code."""

from __future__ import annotations

import ast
import json
import re
import shlex
import tomllib
from pathlib import Path

import pytest
from pages_of_docs import DOCS, PAGES, TUTORIALS, module, pages, title

import jaxatt
from jaxatt import scenarios
from jaxatt.cli.commands import COMMANDS, loaded
from jaxatt.scenarios.bundled import kind_of
from jaxatt.scenarios.bundled import text as bundled_text
from jaxatt.studies.sweep.reading import load_study

SOURCES = sorted((DOCS / "sources").glob("*.md"))


def shell_lines(page: str) -> list[str]:
    """The calls of `jaxatt` in all blocks of a page, continued lines joined."""
    blocks = [block for block in pages.blocks(page) if block.language == "bash"]
    return [line for block in blocks for line in block.lines if line.startswith("jaxatt ")]


@pytest.mark.parametrize("page", PAGES, ids=title)
def test_commands_and_their_options_exist(page: Path) -> None:
    for line in shell_lines(page.read_text(encoding="utf-8")):
        words = shlex.split(line.partition(" | ")[0].partition(" > ")[0], comments=True)[1:]
        name, *rest = words
        if "..." in rest or not re.fullmatch(r"[a-z]+", name):
            continue
        assert name in COMMANDS, line
        command = loaded(name)
        if hasattr(command, "commands"):
            assert not rest or rest[0] in command.commands or rest[0].startswith("-"), line
            continue
        command.make_context(name, rest)  # raises where an option or a value is none


@pytest.mark.parametrize("page", PAGES, ids=title)
def test_python_compiles_and_names_exist(page: Path) -> None:
    for block in pages.blocks(page.read_text(encoding="utf-8")):
        if block.language != "python":
            continue
        for node in ast.walk(ast.parse(block.text)):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "jaxatt":
                assert hasattr(jaxatt, node.attr), node.attr


@pytest.mark.parametrize("page", PAGES, ids=title)
def test_toml_is_toml(page: Path) -> None:
    for block in pages.blocks(page.read_text(encoding="utf-8")):
        if block.language == "toml":
            tomllib.loads(block.text)


@pytest.mark.parametrize("page", [*TUTORIALS, *sorted((DOCS / "how-to").glob("*.md"))], ids=title)
def test_files_load(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    with pages.folder_of(text):
        for name, content in pages.files(text).items():
            held = tomllib.loads(content)
            if "laws" in held:
                scenarios.load_flight(name)
            elif "vary" in held:
                load_study(name)
            elif "objective" in held:
                assert scenarios.load(name).vehicle is not None


@pytest.mark.parametrize("page", TUTORIALS, ids=title)
def test_commands_of_tutorials_name_files_that_the_page_shows(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    shown = pages.files(text)
    named = {word for line in shell_lines(text) for word in line.split() if word.endswith(".toml")}
    assert named <= set(shown)
    assert shown and (named or page.name == "satellite.md")


@pytest.mark.parametrize("page", SOURCES, ids=title)
def test_tables_of_sources_are_those_of_their_files(page: Path) -> None:
    printed = module("benchmarks/printed.py")
    text = page.read_text(encoding="utf-8")
    cases = printed.SOURCES[page.stem]
    assert printed.with_tables(text, cases) == text
    for case in cases:
        assert f"<!-- printed: {case} -->" in text


@pytest.mark.parametrize(
    "file", sorted((DOCS / "sources" / "obtained").glob("*.json")), ids=lambda file: file.stem
)
def test_printed_values_are_those_of_the_scenario(file: Path) -> None:
    """Each printed number of a table stands in the scenario's file, or is derived from it."""
    record = json.loads(file.read_text(encoding="utf-8"))
    assert kind_of(record["case"]) is not None and record["rows"]
    known = {
        f"{number:.4g}"
        for number in map(
            float, re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", bundled_text(record["case"]))
        )
    }
    for row in record["rows"]:
        if row["figure"].startswith("cost"):  # of four printed numbers
            continue
        for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", row["printed"]):
            assert f"{float(number):.4g}" in known, (row, number)


def test_the_list_of_errors_is_that_of_the_code() -> None:
    errors = module("docs/list_errors.py")
    page = errors.PAGE.read_text(encoding="utf-8")
    assert errors.listed(page) == page, "run python docs/list_errors.py"
    assert page.count("\n| ") > 300


def test_drawings_are_those_of_their_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = module("docs/draw_frames.py")
    drawn = frames.PICTURES
    monkeypatch.setattr(frames, "PICTURES", tmp_path)
    frames.orbit_and_inertial()
    frames.body_in_orbit()
    frames.wheel_and_body()
    for file in tmp_path.iterdir():
        assert file.read_text() == (drawn / file.name).read_text(), "run python docs/draw_frames.py"
