"""A result is printed, then written: neither a reader that has gone nor a full disk loses it."""

import errno
import importlib
import os
import subprocess
import sys
from pathlib import Path

import handmade_results
import pytest
import typer
from typer.testing import CliRunner

from jaxatt.cli import app
from jaxatt.cli.common import BAD_INPUT, clean_exit, finish
from jaxatt.report import folder
from jaxatt.runtime import files

COMMAND = f"""
import importlib, sys
sys.path.insert(0, {str(Path(handmade_results.__file__).parent)!r})
import handmade_results, jaxatt.cli
def solve(*_, report, **__):
    report("polishing", 4)
    return handmade_results.handmade("double-integrator")
importlib.import_module("jaxatt.cli.solve").find = solve
sys.argv = ["jaxatt", "solve", "double-integrator", "--out", "there"]
jaxatt.cli.main()
"""
FULL = Path("/dev/full")


def closed_pipe():
    """The writing end of a pipe that nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    return writer


def run(cwd, stdout, stderr):
    found = subprocess.run(
        [sys.executable, "-c", COMMAND], cwd=cwd, stdout=stdout, stderr=stderr, text=True
    )
    written = {file.name for file in (cwd / "there").iterdir()}
    assert {"summary.json", "result.nc", "overview.png"} <= written
    return found


def test_a_reader_that_has_gone_loses_nothing(tmp_path):
    writer = closed_pipe()
    assert run(tmp_path, writer, subprocess.STDOUT).returncode == 0
    os.close(writer)


@pytest.mark.skipif(not FULL.exists(), reason="there is no full device to print to")
def test_a_full_standard_output_is_named_and_loses_nothing(tmp_path):
    with FULL.open("w") as full:
        found = run(tmp_path, full, subprocess.PIPE)
    assert found.returncode == 2
    assert "standard output: cannot be written (No space left on device)" in found.stderr
    assert "all files are in there" in found.stderr
    assert "Traceback" not in found.stderr and "Exception ignored" not in found.stderr


def test_a_full_disk_is_named_and_leaves_nothing(tmp_path, monkeypatch):
    def write(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        importlib.import_module("jaxatt.cli.solve"),
        "find",
        lambda *_, **__: handmade_results.handmade("double-integrator"),
    )
    monkeypatch.setattr(folder, "write_summary", write)
    found = CliRunner().invoke(app, ["solve", "double-integrator", "--out", "there"])
    assert found.exit_code == 2
    assert "there: nothing can be written there (No space left on device)" in found.output
    assert "reached the target" in found.output
    assert "Written to" not in found.output
    assert list((tmp_path / "there").iterdir()) == []


@pytest.mark.parametrize("quiet", [False, True])
def test_files_are_written_once_the_result_is_printed(quiet, tmp_path, capsys):
    printed = []

    def write():
        printed.append(capsys.readouterr().out)
        return [tmp_path / "summary.json", tmp_path / "overview.png"]

    finish("one line", write, tmp_path, quiet, "a table", ["a sentence"])
    lines = [f"one line; {tmp_path}"] if quiet else ["a table", "a sentence"]
    assert [line.strip() for line in printed[0].splitlines()] == lines
    after = capsys.readouterr().out
    assert after == ("" if quiet else f"Written to {tmp_path}: summary.json and 1 figure\n")


def test_a_write_that_fails_leaves_the_printed_table(tmp_path, capsys):
    def write():
        raise files.OutputError("there: nothing can be written there")

    with pytest.raises(typer.Exit) as ended, clean_exit():
        finish("one line", write, tmp_path, False, "a table")
    assert ended.value.exit_code == BAD_INPUT
    told = capsys.readouterr()
    assert "a table" in told.out and "nothing can be written there" in told.err


def test_folders_with_impossible_names_are_refused():
    for name in ("a\0b", "x" * 300):
        with pytest.raises(files.OutputError, match="nothing can be written there"):
            files.prepare_folder(name)
