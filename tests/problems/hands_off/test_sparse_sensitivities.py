"""Sensitivities of sparse answers on hand-made supports, against SciPy's SLSQP solving again."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import optimize

import jaxatt
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.hands_off.family import SparseAnswer
from jaxatt.problems.hands_off.least_cost import cost_form, cost_programme, without_leaders
from jaxatt.problems.hands_off.least_effort import effort_programme
from jaxatt.problems.hands_off.slew.thruster_path import path_response
from jaxatt.problems.hands_off.support import Support
from jaxatt.problems.registry import family_of
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.sensitivities import sensitive_answer, sensitivities
from jaxatt.studies.sweep.numbers import places, set_at, whole_document

WHEELS = {"horizon.intervals": 16, "horizon.coast_intervals": 1, "windows": None}
LOOSE = {"limits.body_rate_deg_s": [90.0, 90.0, 90.0]}
COST = {**WHEELS, "objective.terminal": "penalty"}
THRUSTERS = {"horizon.intervals": 12, "horizon.coast_intervals": 1}
FIRST = PhaseStart()

# name: scenario, changes, active intervals at both ends, share of the torque, parameters
CASES = {
    "published": (
        "hypso1-90-45-15",
        {},
        ([0], [49], 0.15),
        ["horizon.horizon_s", "vehicle.inertia_kgm2.0.0", "orbit.semi_major_axis_km"],
    ),
    "thrusters": (
        "eseo-3",
        THRUSTERS,
        ([0, 1, 2], [9, 10, 11], 0.8),
        ["vehicle.thrusters.torque_limit_Nm", "vehicle.inertia_kgm2.0.0", "horizon.horizon_s"],
    ),
    "thrusters and cones": (
        "eseo-1-keep-out",
        {**THRUSTERS, "keep_out.0.half_angle_deg": 8.0, "keep_out.1.half_angle_deg": 8.0},
        ([0, 1, 5], [10, 11], 0.8),
        ["keep_out.1.half_angle_deg", "vehicle.inertia_kgm2.0.0"],
    ),
    "rate": (
        "hypso1-90-45-15",
        {**WHEELS, "limits.body_rate_deg_s": [1.1, 90.0, 90.0]},
        ([0, 1], [14, 15], 0.15),
        ["limits.body_rate_deg_s.0", "vehicle.inertia_kgm2.0.0", "horizon.horizon_s"],
    ),
    "cone": (
        "hypso1-90-45-15-keep-out",
        {**WHEELS, **LOOSE, "keep_out.0.half_angle_deg": 12.0},
        ([0, 1, 7], [14, 15], 0.15),
        ["keep_out.0.half_angle_deg", "vehicle.inertia_kgm2.0.0", "horizon.horizon_s"],
    ),
    "printed count": (
        "hypso1-90-45-15",
        COST,
        ([0], [15], 0.15),
        ["vehicle.inertia_kgm2.0.0", "target.attitude_deg.0", "horizon.horizon_s"],
    ),
    "printed sum": (
        "hypso1-90-45-15",
        {**COST, "objective.kind": "l1"},
        ([0, 1], [14, 15], 0.15),
        ["objective.sparsity_weight", "vehicle.inertia_kgm2.0.0"],
    ),
    "printed, valves": (
        "eseo-1",
        {**THRUSTERS, "horizon.intervals": 30, "objective.terminal": "penalty"},
        ([0, 1, 2], [], 1.0),
        ["vehicle.thrusters.torque_limit_Nm", "vehicle.inertia_kgm2.0.0"],
    ),
}


def short(name, changes):
    return jaxatt.scenarios.replace(jaxatt.scenarios.load(name), changes)


def built(scenario, start=FIRST):
    return family_of(scenario).build(scenario, start)(scenario, enforce_speed_limits=False)


def bursts(task, first, last, share):
    """Scaled controls that turn about the axis to the target and stop."""
    q, r = np.asarray(task.start.q_ob), np.asarray(task.target.q_ob)
    r = r * np.sign(q @ r or 1.0)
    axis = q[0] * r[1:] - r[0] * q[1:] - np.cross(q[1:], r[1:])
    mounting = task.mounting
    pull = (mounting.to_external - mounting.to_body).T @ np.asarray(task.craft.inertia) @ axis
    pull = pull * task.scale / np.abs(pull * task.scale).max()
    u = np.zeros((task.intervals, task.size))
    u[first], u[last] = share * pull, -share * pull
    if task.goal.weights.on_off and task.goal.terminal == "penalty":
        u = np.round(u)
    return np.maximum(u, 0.0) if task.form.has_thrusters else u


def answered(scenario, u, start=FIRST):
    """The sensitive answer of scaled controls, as if a search had found them."""
    task = built(scenario, start)
    best = SimpleNamespace(controls=task.to_controls(u[None]), sign=np.ones(1))
    found = SparseAnswer(task, SimpleNamespace(best=best), None)
    return family_of(scenario).sensitive(scenario, start, found)


def with_number(scenario, name, value):
    document = whole_document(scenario)
    for place in places(scenario, document, name):
        set_at(document, place, value)
    return jaxatt.scenarios.from_mapping(document)


class Again:
    """SciPy's SLSQP on the programme of an answer."""

    def __init__(self, answer):
        self.answer, functions = answer, answer.optimum.answer.conditions.functions
        self.objective = jax.jit(lambda x, a: jax.value_and_grad(functions.objective)(x, *a))
        rows = {"ineq": functions.inequality, "eq": functions.equality}
        self.rows = {
            kind: (
                jax.jit(lambda x, a, f=f: f(x, *a)),
                jax.jit(lambda x, a, f=f: jax.jacfwd(f)(x, *a)),
            )
            for kind, f in rows.items()
            if f is not None
        }

    def __call__(self, scenario):
        """Objective and variables of a changed scenario."""
        args, point = self.answer.arguments(scenario), self.answer.optimum.answer.point
        found = optimize.minimize(
            lambda x: [np.asarray(leaf) for leaf in self.objective(x, args.args)],
            np.asarray(point.x),
            jac=True,
            method="SLSQP",
            bounds=np.stack(args.box, axis=1),
            constraints=[
                {
                    "type": kind,
                    "fun": lambda x, f=value: np.asarray(f(x, args.args)),
                    "jac": lambda x, f=slope: np.asarray(f(x, args.args)),
                }
                for kind, (value, slope) in self.rows.items()
            ],
            options={"ftol": 1e-15, "maxiter": 200},
        )
        read = self.answer.optimum.read(point._replace(x=jnp.asarray(found.x)), args)
        return found.fun, np.asarray(read["controls"])


def compare(scenario, answer, names, step=1e-4):
    optimum = answer.optimum
    assert not optimum.flags
    along = directions_of(scenario, answer.arguments, names)
    record = optimum.along(along.names, along.values, along.along)
    again = Again(answer)
    for k, name in enumerate(names):
        scale = abs(along.values[k]) or 1.0
        h = step * scale
        ends = [again(with_number(scenario, name, along.values[k] + s * h)) for s in (1.0, -1.0)]
        slope = (ends[0][0] - ends[1][0]) / (2.0 * h)
        np.testing.assert_allclose(record.by_parameter[k], slope, rtol=1e-5)
        if name == "objective.sparsity_weight":
            continue  # moves the controls by so little that SLSQP has ended before
        moved = (ends[0][1] - ends[1][1]) / (2.0 * h)
        # Where the answer does not move, what is left is rounding of SLSQP.
        size = max(np.abs(moved).max(), np.abs(ends[0][1]).max() / scale)
        np.testing.assert_allclose(record.variables["controls"][k], moved, atol=2e-5 * size)
    return record


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_derivatives_are_those_of_slsqp_solving_again(case):
    name, changes, active, names = CASES[case]
    scenario = short(name, changes)
    answer = answered(scenario, bursts(built(scenario), *active))
    record = compare(scenario, answer, names)
    if case in ("rate", "cone", "thrusters and cones"):
        assert any("node" in limit for limit in record.active)
    if "thrusters" in case:
        u = record.variables
        limit = np.asarray(scenario.vehicle.thrusters.torque_limit)
        step = scenario.horizon.duration / scenario.horizon.intervals
        # By the inertia: torque over its limit is the share of the interval that a valve is open.
        np.testing.assert_allclose(u["opening_times"][1] * limit, u["controls"][1] * step)


@pytest.mark.slow
@pytest.mark.optimised
def test_a_later_phase_begins_where_it_is_told():
    scenario = short("hypso1-path-two", WHEELS)
    turned = short("hypso1-path-two", {"initial.attitude_deg": [31.0, 44.0, 15.0]})
    leg = PhaseStart(1, 70.0, turned.initial)
    answer = answered(scenario, bursts(built(scenario, leg), [0], [15], 0.15), leg)
    compare(scenario, answer, ["legs.1.attitude_deg.0", "vehicle.inertia_kgm2.0.0"])
    with pytest.raises(jaxatt.ScenarioError, match="no effect"):
        directions_of(scenario, answer.arguments, ["legs.0.attitude_deg.0"])


@pytest.mark.slow
def test_phases_before_are_solved_and_flown():
    scenario = short("hypso1-path-two", {**WHEELS, "horizon.intervals": 25, "solver.starts": 4})
    found = sensitivities(scenario, ["legs.1.attitude_deg.0"], phase=2)
    assert found.regular and found["legs.1.attitude_deg.0"] != 0.0
    assert any("Phase 2 begins at 70 s" in note for note in found.notes)


def test_which_phase_has_to_be_said():
    scenario = jaxatt.scenarios.load("hypso1-path-two")
    with pytest.raises(jaxatt.ScenarioError, match="--phase 1 to 2"):
        sensitive_answer(scenario)
    with pytest.raises(jaxatt.ScenarioError, match="phase = 3: there are 1 to 2"):
        sensitive_answer(scenario, phase=3)
    with pytest.raises(jaxatt.ScenarioError, match="there is one only"):
        sensitive_answer(jaxatt.scenarios.load("eseo-1"), phase=2)


def random_controls(rng, task, stages):
    u = np.zeros((task.intervals, task.size))
    u[stages] = rng.uniform(0.05, 0.9, (len(stages), task.size))
    return u if task.form.has_thrusters else u * rng.choice([-0.1, 0.1], u.shape)


@pytest.mark.parametrize("name", ["eseo-3", "hypso1-90-45-15"])
def test_effort_is_that_of_the_report(name):
    rng = np.random.default_rng(3)
    task = built(short(name, THRUSTERS | {"windows": None} if name[0] == "h" else THRUSTERS))
    u = random_controls(rng, task, [0, 4, 11])
    support = Support.of(u != 0.0)
    small = effort_programme(task, support, u, task.arguments.plant)
    args = small.arguments(task, task.arguments.plant)
    effort = task.l1_effort(task.to_controls(u[None]))[0]
    np.testing.assert_allclose(small.functions.objective(jnp.asarray(small.start), args), effort)


PRINTED = [
    ("eseo-3", {"objective.on_off_form": "active"}),
    ("eseo-3", {"objective.on_off_form": "printed", "objective.epsilon_Nm": 1e-3}),
    ("eseo-3", {"objective.kind": "l1"}),
    ("hypso1-90-45-15", {"objective.epsilon_Nm": 1e-5}),
    ("hypso1-90-45-15", {"objective.kind": "l1", "objective.sparsity_weight": 1e3}),
    ("hypso1-90-45-15", {"objective.kind": "moving-l0", "objective.design": 2}),
    ("hypso1-90-45-15", {"objective.design": 3, "objective.epsilon_Nm": 1e-5}),
]


@pytest.mark.parametrize(("name", "changes"), PRINTED)
def test_cost_is_the_printed_one(name, changes):
    rng = np.random.default_rng(5)
    grid = {"horizon.horizon_s": 4.0, "horizon.intervals": 12, "horizon.coast_intervals": 1}
    windows = {} if name == "eseo-3" else {"windows.0.first_interval": 3}
    windows |= {"windows.0.last_interval": 6} if windows else {}
    printed = {"objective.terminal": "penalty"}
    task = built(short(name, {**grid, **windows, **printed, **changes}))
    u = random_controls(rng, task, [0, 4, 11])
    support = Support.of(u != 0.0)
    small = cost_programme(task, support, cost_form(task, support, u), u)

    def cost(way):
        plant = task.system.turned(task.arguments.plant, jnp.asarray(way))
        args = small.arguments(task, plant)
        return float(small.functions.objective(jnp.asarray(small.start), args))

    parts = task.verify(task.to_controls(u[None]))[1]
    printed = sum(float(part[0]) for part in parts.values())
    np.testing.assert_allclose(min(cost(1.0), cost(-1.0)), printed, rtol=1e-5)


def test_the_largest_torque_is_a_variable_unless_limits_hold_it():
    task = built(short("eseo-3", {**THRUSTERS, "objective.terminal": "penalty"}))
    u = np.zeros((task.intervals, task.size))
    u[0, :2] = 1.0  # fully open, both
    u[1, :2] = 0.5  # as large, held by nothing
    u[2, :2] = 1.0, 0.5
    support = Support.of(np.repeat(u.any(axis=1, keepdims=True), task.size, axis=1))
    form = cost_form(task, support, u)
    assert [group.leader is None for group in form.groups] == [False, True, False]
    # Another torque than the leader's has become the largest.
    u[2, 2] = 0.9
    u[2, 0] = 0.8
    again = without_leaders(task, support, form, support.free_of(u))
    assert [group.leader is None for group in again.groups] == [False, True, True]


def test_margins_of_all_nodes_hold_the_worst_ones():
    rng = np.random.default_rng(7)
    scenario = short("eseo-1-keep-out", {**THRUSTERS, "horizon.horizon_s": 10.0})
    task = built(scenario)
    task = task.keeping_path_limits_of(task)
    u = jnp.asarray(rng.uniform(0.0, 1.0, (task.intervals, task.size)))
    every = np.asarray(task.system.margins(u, task.arguments.plant))
    assert len(task.path_names) == len(every)
    worst = np.asarray(
        jax.jit(path_response, static_argnums=2)(u, task.arguments.plant, task.form)[0]
    )
    thirds = every.reshape(3, task.intervals // 3, -1).min(axis=1)
    np.testing.assert_allclose(worst, thirds.ravel(), rtol=1e-9)
