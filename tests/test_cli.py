"""The command line: what it prints, writes and returns."""

import importlib
import json
import re
import subprocess
import sys
from importlib import resources
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

import handmade_results
import numpy as np
import pytest
from typer.testing import CliRunner

from jaxatt import scenarios
from jaxatt.cli import app
from jaxatt.problems.front import Front, Quantity
from jaxatt.report.archive import open_archive
from jaxatt.report.result import Result
from jaxatt.scenarios.bundled import KINDS
from jaxatt.studies.pareto_front import ParetoFront


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def plain(found):
    """Output without the wrapping and frames of a terminal."""
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", found.output).split())


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_scenarios_are_listed_with_a_line_each():
    found = run("scenarios")
    assert found.exit_code == 0
    lines = found.output.splitlines()
    bundled = [name for kind in KINDS for name in scenarios.names(kind)]
    assert [line.split()[0] for line in lines] == bundled
    assert "Multiple-axis slew to (90, 45, 15) deg" in found.output


def test_a_shown_scenario_is_changed_and_solved(here):
    shown = run("scenarios", "show", "double-integrator")
    assert shown.exit_code == 0
    first, rest = shown.output.split("\n", 1)
    schema = Path(url2pathname(urlparse(first.removeprefix("#:schema ")).path))
    assert json.loads(schema.read_text())["title"] == "jaxatt manoeuvre"
    assert rest == scenarios.text("double-integrator")
    document = shown.output.replace("state = [1.0, 1.0]", "state = [0.5, 0.5]")
    document = document.replace("intervals = 100", "intervals = 40")
    (here / "mine.toml").write_text(document.replace("double-integrator", "mine", 1))
    found = run("solve", "mine.toml", "--objective", "l1", "--starts", 2, "--seed", 3)
    assert found.exit_code == 0, found.output
    assert "reached the target" in found.output
    assert "Written to results/mine" in found.output
    summary = json.loads((here / "results/mine/summary.json").read_text())
    assert summary["scenario"] == "mine"
    assert summary["status"] == "reached"
    assert summary["starts"]["requested"] == 2
    assert summary["seed"] == 3
    archive = open_archive(here / "results/mine/result.nc")
    assert archive.attrs["objective"] == "l1"
    assert archive.sizes["interval"] == 40
    assert (here / "results/mine/overview.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("solve", "hypso1-90-45-1"), ("did you mean 'hypso1-90-45-15'", "van-der-pol")),
        (("solve", "nowhere.toml"), ("nowhere.toml: cannot be read",)),
        (("solve", "double-integrator", "--terminal", "penalty"), ('use terminal = "reach"',)),
        (("solve", "hypso1-90-0-0", "--starts", 0), ("--starts",)),
        (("solve", "hypso1-90-0-0", "--objective", "l3"), ("--objective", "moving-l0")),
        (("compare", "doubl-integrator"), ("did you mean 'double-integrator'",)),
        (("scenarios", "show", "hypso"), ("no bundled scenario",)),
        (("pareto", "hypso1-netpower", "--over", "money"), ("--over", "time")),
        (("pareto", "hypso1-netpower", "--points", 1), ("points = 1", "at least two")),
        (("pareto", "hypso1-netpower", "--values", "5,-1"), ("must be positive",)),
        (("pareto", "double-integrator"), ("gains no energy", '"net-power"')),
        (("solve", "broken.toml"), ("broken.toml", "did you mean 'horizon_s'?")),
        (("plan", "hypso1-90-0-0"), ("has no [[tasks]] to plan; use jaxatt solve",)),
        (("plan", "hypso2-orbit", "--dates", "2022-01-01"), ("such as 2023-01-01:2023-12-31:7",)),
        (("solve", "hypso1-90-0-0", "--out", "taken/below"), ("nothing can be written there",)),
        (("solve", "hypso1-pointing"), ("is a bundled flight; use jaxatt simulate",)),
        (("simulate", "mrp-k4"), ("is a bundled manoeuvre; use jaxatt solve",)),
        (("solve", "body.toml"), ("describes a vehicle, not a manoeuvre; name it in one",)),
        (("solve", "folder"), ("is a folder; name a file in it",)),
        (("show", "folder"), ("holds a result and no store",)),
        (("solv", "mrp-k4"), ("Did you mean 'solve'?",)),
        (("new", "mine", "--inertia", "1,1,3"), ("vehicle.toml: inertia_kgm2", "triangle")),
    ],
)
def test_bad_input_ends_with_2_and_leaves_nothing(here, arguments, words):
    (here / "taken").write_text("a file")
    document = scenarios.text("hypso1-90-0-0").replace("horizon_s =", "horizon =")
    (here / "broken.toml").write_text(document)
    hypso1 = resources.files("jaxatt.spacecraft") / "vehicles" / "hypso1.toml"
    (here / "body.toml").write_text(hypso1.read_text(encoding="utf-8"))
    (here / "folder").mkdir()
    (here / "folder" / "summary.json").write_text("{}")
    before = sorted(here.iterdir())
    found = run(*arguments)
    assert found.exit_code == 2
    assert all(word in plain(found) for word in words), found.output
    assert "Traceback" not in found.output
    assert sorted(here.iterdir()) == before


def answer(make, result: Result):
    def solve(*_, report, **__):
        report("polishing", 4)
        return result

    make.setattr(importlib.import_module("jaxatt.cli.solve"), "find", solve)


def test_progress_is_told_in_lines_where_there_is_no_terminal(here, monkeypatch):
    answer(monkeypatch, handmade_results.handmade("double-integrator"))
    found = run("solve", "double-integrator", "--starts", 8, "--out", "there")
    assert found.exit_code == 0
    assert "polishing: 4 of 8" in found.output
    assert (here / "there/summary.json").is_file()


def test_quiet_says_one_line(here, monkeypatch):
    answer(monkeypatch, handmade_results.handmade("double-integrator"))
    found = run("solve", "double-integrator", "--quiet")
    assert found.output.splitlines() == [
        "Result(double-integrator: reached, 10 active intervals: 0-9); results/double-integrator"
    ]


def test_a_front_is_printed_and_written(here, monkeypatch):
    (phase,) = handmade_results.handmade("double-integrator").phases
    time, energy = Quantity("final time", "final_time_s", "s"), Quantity("net energy", "net_J", "J")
    times, gains, own = np.array([1.0, 2.0, 3.0]), np.array([4.0, 6.0, 5.0]), np.zeros(3, bool)
    front = Front(time, times, time, times, energy, gains, (phase, phase, phase), own)
    found = ParetoFront(scenarios.load("hypso1-netpower"), "time", front)
    monkeypatch.setattr(
        importlib.import_module("jaxatt.cli.pareto"), "find", lambda *_, **__: found
    )
    told = run("pareto", "hypso1-netpower", "--over", "time")
    assert told.exit_code == 0, told.output
    assert "2 of 3 points on the front" in told.output
    assert "dominated" in told.output
    assert "Written to results/hypso1-netpower: pareto.csv, pareto.json" in told.output
    points = json.loads((here / "results/hypso1-netpower/pareto.json").read_text())["points"]
    assert [point["on_front"] for point in points] == [True, True, False]
    assert [point["price_J_per_s"] for point in points] == [None, 2.0, None]


def test_nothing_that_reaches_ends_with_3_and_says_what_was_in_the_way(here, monkeypatch):
    answer(
        monkeypatch,
        handmade_results.handmade(reached=False, failure_reason="the target rate is missed"),
    )
    found = run("solve", "hypso1-90-45-15")
    assert found.exit_code == 3
    assert "No start reached the target; of the closest, the target rate is missed." in plain(found)
    assert (here / "results/hypso1-90-45-15/summary.json").is_file()


def test_the_lowest_cost_that_does_not_reach_ends_with_3(here, monkeypatch):
    answer(monkeypatch, handmade_results.resting())
    found = run("solve", "hypso1-45-0-0", "--terminal", "penalty")
    assert found.exit_code == 3
    assert "prefers not moving: J = 7.612 against 20" in plain(found)
    assert "best that reaches" in plain(found)


def test_an_interruption_ends_with_130_and_leaves_nothing(here, monkeypatch):
    def solve(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(importlib.import_module("jaxatt.cli.solve"), "find", solve)
    found = run("solve", "hypso1-90-45-15")
    assert found.exit_code == 130
    assert "Interrupted" in found.output
    assert list(here.iterdir()) == []


def test_the_installed_command_enables_double_precision_by_itself():
    code = (
        "import jax, jaxatt.cli.common as common; assert not jax.config.jax_enable_x64; "
        "common.computing(no_cache=True).__enter__(); assert jax.config.jax_enable_x64"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
