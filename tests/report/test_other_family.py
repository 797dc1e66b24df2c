"""A family from outside the package gives no section at all and has a complete report."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from handmade_results import assemble, starts_record

import jaxatt.report.family
from jaxatt import scenarios
from jaxatt.problems.hands_off.record import sparse_section
from jaxatt.problems.sections import Rows, Sections
from jaxatt.problems.time_optimal.record import time_optimum
from jaxatt.records.phase import Phase
from jaxatt.report.summary import NAMES

SERIES = {"angle": np.linspace(0.0, 1.0, 11), "push": np.linspace(-1.0, 1.0, 20).reshape(10, 2)}


def pendulum(**changes):
    """A phase of ten intervals with series that the package has never heard of."""
    phase = Phase(
        family="pendulum",
        start_time=0.0,
        step=0.5,
        controls=SERIES["push"],
        series=SERIES,
        reference={"angle": np.array(1.0)},
        errors={"swing": 0.25},
        tolerances={"swing": 0.5},
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"time": 5.0, "push": 2.0},
        l1_effort=3.0,
        reached=True,
        failure_reason="",
        active=np.ones(10, bool),
        starts=dataclasses.replace(starts_record(), long_way=None),
    )
    return dataclasses.replace(phase, **changes)


@pytest.fixture
def known(monkeypatch):
    """The family's sections by name: none for the pendulum, but one row for the metronome."""
    ticking = Sections(
        rows=lambda answer: Rows(answer=(("beats", lambda block: str(block["beats"])),)),
        names=lambda phase: {"beats": 4},
        together=lambda blocks: {"beats": sum(block["beats"] for block in blocks)},
    )
    given = {"pendulum": Sections(), "metronome": ticking}
    monkeypatch.setattr(
        jaxatt.report.family, "family_named", lambda name: SimpleNamespace(sections=given[name])
    )


@pytest.fixture
def scenario():
    return dataclasses.replace(scenarios.load("double-integrator"), name="swing", title="A swing")


def test_summary_has_every_stable_name_and_the_errors_of_its_own(known, scenario):
    found = assemble(scenario, pendulum()).summary()
    assert list(found)[1 : 2 + len(NAMES)] == [*NAMES, "swing_error"]
    assert found["swing_error"] == 0.25 and found["final_time_s"] == 5.0
    assert found["objective"] == {"total": 7.0, "time": 5.0, "push": 2.0}
    assert found["control_effort"] == pytest.approx(0.5 * np.sum(SERIES["push"] ** 2))
    for name in ("weighted_active_intervals", "time_optimum", "quantised", "final_times"):
        assert found[name] is None


def test_table_tells_time_cost_and_errors(known, scenario):
    result = assemble(scenario, pendulum())
    text = " ".join(str(result).split())
    for words in ("A swing (L0, reach)", "final time [s] 5", "swing error 0.25 (< 0.5)", "push 2"):
        assert words in text
    assert repr(result) == "Result(swing: reached, 5 s)"


def test_archive_holds_every_series(known, scenario, tmp_path):
    found = assemble(scenario, pendulum()).to_dataset()
    assert found.angle.dims == ("time",)
    assert found.push.dims == ("interval", "push_1")
    assert float(found.angle_reference) == 1.0
    assert "start_long_way" not in found and "start_effort" in found


def test_everything_is_drawn_and_written(known, scenario, tmp_path):
    second = pendulum(start_time=5.0, alternative=pendulum(), reached=False, failure_reason="bent")
    files = {path.name for path in assemble(scenario, pendulum(), second).save(tmp_path)}
    drawn = {"overview.png", "angle.png", "push.png", "starts.png"}
    assert files == drawn | {"summary.json", "result.nc"}


def test_its_own_names_and_rows_come_beside(known, scenario):
    first, second = (pendulum(family="metronome", start_time=t) for t in (0.0, 5.0))
    result = assemble(scenario, first, second)
    assert [block["beats"] for block in result.summary()["legs"]] == [4, 4]
    assert result.summary()["beats"] == 8
    assert "beats" in str(result) and "final time" not in str(result)


def test_sections_of_one_family_are_refused_for_another():
    for section_of in (sparse_section, time_optimum):
        with pytest.raises(TypeError, match="'pendulum'"):
            section_of(pendulum())
