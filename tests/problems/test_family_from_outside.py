"""A whole family of problems from outside the package: read, solved, flown, judged and reported.

The family moves a cart along a line against drag, with the least effort in a given time.  Without
drag the optimum is known: u = 6 d / T^2 (1 - 2 t / T), whose squares integrate to 12 d^2 / T^3.
"""

import dataclasses
import json
from dataclasses import dataclass

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.optimize.status import Status
from jaxatt.problems import registry
from jaxatt.problems.family import Family
from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.heading import read_heading
from jaxatt.problems.reading.keys import Choice, Number, Numbers, TableKey
from jaxatt.problems.reading.settings import read_horizon
from jaxatt.problems.reading.tables import manoeuvre
from jaxatt.problems.scenario import Objective, Scenario
from jaxatt.problems.sections import Rows, Sections, plain_rows
from jaxatt.records.phase import Phase, Section
from jaxatt.records.starts import StartsRecord
from jaxatt.report.archive import open_archive
from jaxatt.studies.file_kinds import faults_of

STATE = Numbers("position and speed", size=2, required=True)
TABLES = {
    "initial": TableKey("where it begins", {"state": STATE}, required=True),
    "target": TableKey(
        "where it ends",
        {"state": STATE, "tolerance": Number("largest error", default=1e-6, above=0.0)},
        required=True,
    ),
    "horizon": manoeuvre.HORIZON,
    "objective": TableKey(
        "what is minimised", {"kind": Choice("effort", options=("least-effort",))}
    ),
    "cart": TableKey("cart", {"drag_1_s": Number("drag", default=0.0, at_least=0.0)}),
    "solver": manoeuvre.SOLVER,
    "printed": manoeuvre.PRINTED,
}
NO_ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class CartOptions:
    """What only this family reads; drag [1/s]."""

    drag: float


@dataclass(frozen=True, eq=False)
class CartSection(Section):
    """What only this family's answers have."""

    peak: float


def cart_rows(answer):
    peak = answer.phases[0].section.peak
    common = plain_rows(answer)
    return Rows(answer=common.answer, flown=(("peak", lambda _: f"{peak:.4f}"),), cost=common.cost)


class Cart(Family):
    name = "cart"
    systems = ("cart",)
    kinds = ("least-effort",)
    tables = TABLES
    sections = Sections(rows=cart_rows, names=lambda phase: {"peak": float(phase.section.peak)})

    def read(self, document, origin, folder, faults):
        faults.refuse()
        heading = read_heading(document, origin, TABLES)
        target = Table(document["target"], origin, "[target]", TABLES["target"])
        cart = Table(document.get("cart", {}), origin, "[cart]", TABLES["cart"])
        initial = Table(document["initial"], origin, "[initial]", TABLES["initial"])
        return Scenario(
            **vars(heading),
            family=self.name,
            initial=state_of(initial.vector("state")),
            targets=(
                Target(
                    NO_ATTITUDE,
                    np.zeros(3),
                    np.pi,
                    np.inf,
                    target.vector("state"),
                    target.number("tolerance"),
                ),
            ),
            horizon=read_horizon(document["horizon"], origin),
            objective=Objective(kind="least-effort"),
            document=document,
            origin=origin,
            folder=folder,
            options=CartOptions(cart.number("drag_1_s")),
        )

    def search(self, scenario, start, options, report):
        begin = (start.state or scenario.initial).state
        horizon = scenario.horizon
        program = cart_program(horizon.intervals)
        parameters = {
            "begin": begin,
            "target": scenario.targets[start.index].state,
            "drag": scenario.options.drag,
            "duration": horizon.duration,
        }
        progress = None if report is None else lambda done: report("solving", done)
        return jaxatt.solve_program(
            program,
            parameters,
            starts=scenario.solver.starts,
            seed=scenario.solver.seed,
            progress=progress,
        )

    def judge(self, scenario, start, found):
        target, duration = scenario.targets[start.index], scenario.horizon.duration
        states = exact_flight((start.state or scenario.initial).state, found, scenario)
        error = float(np.linalg.norm(states[-1] - target.state))
        reached = error <= target.state_tolerance
        count = len(found.controls)
        effort = np.abs(found.controls).sum() * duration / count
        status = np.asarray(found.starts.status)
        phase = Phase(
            family=self.name,
            start_time=start.time,
            step=duration / count,
            controls=found.controls,
            series={"state": states, "control": found.controls},
            reference={"state": target.state},
            errors={"state": error},
            tolerances={"state": target.state_tolerance},
            limit_violation=0.0,
            margin_violation=0.0,
            objective={"effort": float(found.objective)},
            l1_effort=float(effort),
            reached=reached,
            failure_reason="" if reached else "the target state is missed",
            active=np.abs(found.controls).max(axis=1) > 1e-6,
            starts=StartsRecord(
                status=status,
                reached=status == Status.CONVERGED,
                active_intervals=np.full(len(status), count),
                effort=np.asarray(found.starts.objective),
                long_way=np.zeros(len(status), bool),
                iterations=np.asarray(found.starts.iterations),
                shortfall=np.zeros(len(status)),
                distinct_minima=len(found.minima),
            ),
            section=CartSection(float(np.abs(found.controls).max())),
        )
        return phase, state_of(states[-1])


def state_of(state):
    return InitialState(NO_ATTITUDE, np.zeros(3), np.zeros(0), np.asarray(state))


PROGRAMS = {}


def cart_program(intervals):
    """One object for each grid, so that nothing is compiled again."""
    if intervals not in PROGRAMS:
        PROGRAMS[intervals] = jaxatt.transcribe(
            lambda x, u, p: (
                np.array([1.0, 0.0]) * x[1] + np.array([0.0, 1.0]) * (u[0] - p["drag"] * x[1])
            ),
            states=2,
            controls=1,
            intervals=intervals,
            initial_state=lambda p: p["begin"],
            final_time=lambda p: p["duration"],
            running_cost=lambda x, u, p: u[0] ** 2,
            terminal_equality=lambda x, p: x - p["target"],
        )
    return PROGRAMS[intervals]


def exact_flight(x, found, scenario):
    """States at the nodes by the closed form of one interval, (N + 1, 2)."""
    h, drag = scenario.horizon.step, scenario.options.drag
    states = [np.asarray(x)]
    for (u,) in found.controls:
        position, speed = states[-1]
        if drag == 0.0:
            states.append(np.array([position + h * speed + h * h * u / 2, speed + h * u]))
            continue
        final, decay = u / drag, np.exp(-drag * h)
        gained = final * h + (speed - final) * (1.0 - decay) / drag
        states.append(np.array([position + gained, final + (speed - final) * decay]))
    return np.array(states)


DOCUMENT = {
    "name": "cart",
    "system": "cart",
    "initial": {"state": [0.0, 0.0]},
    "target": {"state": [2.0, 0.0]},
    "horizon": {"horizon_s": 3.0, "intervals": 40, "coast_intervals": 0},
    "objective": {"kind": "least-effort"},
    "solver": {"starts": 3},
}


@pytest.fixture(scope="module", autouse=True)
def registered():
    registry.register(Cart())
    yield
    registry.unregister("cart")


@pytest.fixture(scope="module")
def solved():
    return jaxatt.solve(scenarios.from_mapping(DOCUMENT))


def test_the_pipeline_solves_it(solved):
    assert solved.reached, solved.phases[0].failure_reason
    # Piecewise constant control on N intervals costs a share 1 / N^2 more than the exact optimum.
    exact = 12.0 * 2.0**2 / 3.0**3
    assert solved.phases[0].objective["effort"] == pytest.approx(exact, rel=1e-3)
    assert solved.phases[0].section.peak == pytest.approx(6.0 * 2.0 / 3.0**2, rel=0.03)


def test_the_report_is_complete(solved, tmp_path):
    files = {file.name for file in solved.save(tmp_path / "cart")}
    assert {"summary.json", "result.nc", "overview.png"} <= files
    numbers = json.loads((tmp_path / "cart/summary.json").read_text())
    assert numbers["status"] == "reached" and numbers["peak"] > 1.0
    assert numbers["starts"]["converged"] == 3
    archive = open_archive(tmp_path / "cart/result.nc")
    np.testing.assert_allclose(archive.state.values[-1], [2.0, 0.0], atol=1e-6)
    assert "peak" in str(solved) and "state error" in str(solved)


def test_a_field_of_its_own_changes_the_answer(solved):
    slowed = jaxatt.solve(scenarios.replace(solved.scenario, {"cart.drag_1_s": 0.4}))
    assert slowed.reached
    assert slowed.phases[0].objective["effort"] > solved.phases[0].objective["effort"]


def test_bad_input_is_named_as_for_any_family():
    with pytest.raises(scenarios.ScenarioError, match=r"\[cart\] drag_1_s.*at least 0"):
        scenarios.from_mapping({**DOCUMENT, "cart": {"drag_1_s": -1.0}})
    with pytest.raises(scenarios.ScenarioError, match="least-effort"):
        scenarios.from_mapping({**DOCUMENT, "objective": {"kind": "l0"}})
    with pytest.raises(scenarios.ScenarioError, match=r"waypoint.*no meaning for system = cart"):
        scenarios.from_mapping({**DOCUMENT, "waypoint": {}})
    with pytest.raises(ValueError, match="guess"):
        jaxatt.solve(scenarios.from_mapping(DOCUMENT), guess="pd")
    with pytest.raises(scenarios.ScenarioError, match="not a matter of supports"):
        jaxatt.certify(scenarios.from_mapping(DOCUMENT))


def test_check_knows_its_files(tmp_path):
    path = tmp_path / "cart.toml"
    assert faults_of(DOCUMENT, str(path), "manoeuvre", tmp_path) == []
    (fault,) = faults_of({**DOCUMENT, "cart": {"drag_1_s": -1.0}}, str(path), "manoeuvre", tmp_path)
    assert "drag_1_s" in str(fault)


def test_a_family_that_was_never_loaded_goes_and_comes_back(monkeypatch):
    monkeypatch.setattr(registry, "_FORMATS", dict(registry._FORMATS))
    monkeypatch.setattr(registry, "_FAMILIES", {})
    registry.unregister("toy")
    assert "toy" not in {known.name for known in registry.formats()}
    with pytest.raises(KeyError):
        registry.family_named("toy")
    toy = type("Other", (Cart,), {"name": "toy", "systems": ("toy",), "kinds": ("toy",)})()
    registry.register(toy)
    assert registry.family_named("toy") is toy


def test_a_name_or_kind_that_is_taken_is_refused():
    with pytest.raises(ValueError, match="name is taken"):
        registry.register(Cart())
    other = type("Other", (Cart,), {"name": "other"})()
    with pytest.raises(ValueError, match=r"least-effort.*taken"):
        registry.register(other)


def test_phases_start_at_the_flown_end_of_the_one_before(solved):
    scenario = scenarios.from_mapping(DOCUMENT)
    back = dataclasses.replace(scenario.targets[0], state=np.zeros(2))
    there_and_back = dataclasses.replace(scenario, targets=(scenario.targets[0], back))
    result = jaxatt.solve(there_and_back)
    first, second = result.phases
    assert result.reached and second.start_time == pytest.approx(3.0)
    np.testing.assert_array_equal(second.series["state"][0], first.series["state"][-1])
