"""Every solver and every feature of its kind of programme: solved, or refused by name."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.multistart.driver import Plain, run_starts
from jaxatt.optimize import features
from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.dense.constraints import Box
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.inputs import limits_of
from jaxatt.optimize.dense.solver import Case, DenseLagrangian
from jaxatt.optimize.dense.start import Draws
from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.state import InteriorSettings
from jaxatt.optimize.least_effort.primal_dual import LeastEffort
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.program import Program
from jaxatt.optimize.reweighting.bounded import BoundedReweighting
from jaxatt.optimize.reweighting.condensed import CondensedReweighting
from jaxatt.optimize.reweighting.staged import StagedReweighting
from jaxatt.optimize.reweighting.weights import Reweighting
from jaxatt.optimize.riccati.lagrangian import RiccatiLagrangian
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.solver import refuse, solve
from jaxatt.optimize.status import Status

SCHEDULE = Schedule(penalty=10.0, stage_penalty=10.0, max_iterations=200)
SOLVERS = {
    solver.name: solver
    for solver in (
        AugmentedLagrangian(SCHEDULE),
        RiccatiLagrangian(SCHEDULE),
        InteriorPoint(InteriorSettings()),
        CondensedReweighting(Reweighting(settling=8)),
        BoundedReweighting(),
        StagedReweighting(Reweighting(settling=8)),
        LeastEffort(Schedule(smoothing_factor=0.45)),
        DenseLagrangian(limits_of(1e-8, 200, "newton"), "newton"),
    )
}

# Two variables that want to be 0.1.
PLAIN = Program(
    objective=lambda x, args, s: 0.5 * jnp.sum((x - 0.1) ** 2),
    curvature=lambda x, args, s: jnp.ones((2, 1, 1)),
)
SUM = {"equality": lambda x, args: jnp.sum(x)[None] - 1.0}
VARIABLES = {
    features.WITHOUT_DYNAMICS: ({}, 0.1),
    features.EQUALITY: (SUM, 0.5),
    features.SOFT_ROWS: ({**SUM, "equality_weight": lambda x, args: jnp.ones(1)}, 1.1 / 3.0),
    features.INEQUALITY: ({"inequality": SUM["equality"]}, 0.5),
    features.STAGE_INEQUALITY: ({"stage_inequality": lambda x, args: x - 0.3}, 0.3),
    features.HELD_VARIABLES: ({"free": lambda x, args: jnp.zeros_like(x)}, 0.0),
}

# The same two variables, in the functions that `minimize` takes.
DISTANCE = Functions(lambda x: 0.5 * jnp.sum((x - 0.1) ** 2))
FEW = {
    features.FEW_VARIABLES: ({}, 0.1),
    features.EQUALITY: ({"equality": lambda x: jnp.sum(x) - 1.0}, 0.5),
    features.INEQUALITY: ({"inequality": lambda x: jnp.sum(x) - 1.0}, 0.5),
}

# A state that begins at 1 and grows by its control, which wants to be 0.1, in each of 4 stages.
STAGED = OptimalControlProgram(
    start=lambda args: jnp.ones(1),
    stages=lambda args: jnp.arange(4.0),
    dynamics=lambda x, u, stage, args: x + u,
    cost=lambda x, u, stage, args, s: 0.5 * jnp.sum((u - 0.1) ** 2),
    error_size=1,
)
AIM = {"final_rows": lambda x, args: x - 3.0}
PUSH = {"equality": lambda x, u, stage, args: u - 0.3}
STAGES = {
    features.DYNAMICS: ({}, 0.1),
    features.PATH_EQUALITY: (PUSH, 0.3),
    features.SOFT_PATH_ROWS: ({**PUSH, "equality_weight": lambda stage, args: jnp.ones(1)}, 0.2),
    features.PATH_INEQUALITY: ({"inequality": PUSH["equality"]}, 0.3),
    features.TERMINAL_EQUALITY: (AIM, 0.5),
    features.SOFT_TERMINAL_ROWS: ({**AIM, "final_weight": lambda args: jnp.ones(1)}, 0.42),
    features.TERMINAL_INEQUALITY: ({"final_inequality": AIM["final_rows"]}, 0.5),
    features.TERMINAL_COST: ({"terminal_cost": lambda x, args: 0.5 * jnp.sum((x - 3) ** 2)}, 0.42),
    features.CONTROL_BOUNDS: (
        {"limits": lambda stage, args: (jnp.asarray(-1.0), jnp.asarray(0.05))},
        0.05,
    ),
    features.HELD_CONTROLS: ({"free": lambda stage, args: jnp.zeros(1)}, 0.0),
    features.FREE_INITIAL_STATE: ({**AIM, "free_start": 1}, 0.1),
    features.MANIFOLD: (
        {
            "retract": lambda x, e: x + 2.0 * e,
            "difference": lambda x, reference: 0.5 * (x - reference),
        },
        0.1,
    ),
}

# The sparsest way to one half, and the one of least effort, is the middle stage alone.
REACH = jnp.array([0.4, 2.0, 0.7])
ROOT = RootProgram(
    free=lambda args: jnp.ones((3, 1)),
    importance=lambda args: jnp.ones(3),
    row_weight=lambda args: jnp.full(1, jnp.inf),
)
BY_STAGE = OptimalControlProgram(
    start=lambda args: jnp.zeros(1),
    stages=lambda args: REACH,
    dynamics=lambda x, u, stage, args: x + stage * u,
    cost=lambda x, u, stage, args, s: jnp.zeros(()),
    error_size=1,
    final_rows=lambda x, args: x - 0.5,
)
ROOTS = {
    features.ROWS_AT_ONCE: {
        "response": lambda u, args: (jnp.sum(REACH * u[:, 0])[None] - 0.5, REACH[:, None, None])
    },
    features.ROWS_BY_STAGE: {"stages": BY_STAGE},
    features.MAGNITUDE_LIMITS: {"limits": lambda args: jnp.ones((1, 1))},
    features.SEPARATE_BOUNDS: {"bounds": lambda args: (jnp.zeros(1), jnp.ones(1))},
    features.ONE_SIDED_ROWS: {
        "path": lambda u, args: (u[1], jnp.array([[[0.0]], [[1.0]], [[0.0]]]))
    },
    features.COUNTED_APART: {"shared": False},
    features.EFFORT: {
        "effort_map": lambda args: jnp.eye(1),
        "effort_scale": lambda args: jnp.ones(()),
    },
}


def refused(solver, program, feature):
    """Whether a programme is refused; if so by the names of the feature and of who supports it."""
    if feature in solver.supports:
        return False
    able = [other.name for other in SOLVERS.values() if feature in other.supports]
    with pytest.raises(ValueError) as caught:
        run_starts(solver, Plain(program), np.zeros((1, 4, 1)), None)
    words = str(caught.value)
    assert solver.name in words
    others = program.features - solver.supports
    assert any(other in words for other in others)
    assert feature in others
    if others == {feature}:
        assert feature in words
        assert all(name in words for name in able)
    return True


def of_another_kind(solver, program):
    """Whether a solver refuses the kind of a programme by name, though it supports the feature."""
    if program.features <= solver.supports:
        return False
    with pytest.raises(ValueError, match=solver.name):
        refuse(solver, program)
    return True


@pytest.mark.parametrize("feature", FEW)
@pytest.mark.parametrize("name", SOLVERS)
def test_functions_of_few_variables(name, feature):
    changes, answer = FEW[feature]
    solver, program = SOLVERS[name], replace(DISTANCE, **changes)
    assert feature in program.features
    if refused(solver, program, feature) or of_another_kind(solver, program):
        return
    free = Box(jnp.full(2, -jnp.inf), jnp.full(2, jnp.inf))
    found = solve(solver, program, Draws(jnp.zeros(2), jnp.ones((1, 2))), Case((), free))
    np.testing.assert_allclose(found.found.x, answer, atol=1e-6)
    assert found.status == Status.CONVERGED


@pytest.mark.parametrize("feature", VARIABLES)
@pytest.mark.parametrize("name", SOLVERS)
def test_programmes_without_dynamics(name, feature):
    changes, answer = VARIABLES[feature]
    solver, program = SOLVERS[name], replace(PLAIN, **changes)
    assert feature in program.features
    if refused(solver, program, feature) or of_another_kind(solver, program):
        return
    found = solve(solver, program, jnp.zeros((2, 1)), None)
    np.testing.assert_allclose(found.x, answer, atol=1e-5)
    assert found.status == Status.CONVERGED


@pytest.mark.parametrize("feature", STAGES)
@pytest.mark.parametrize("name", SOLVERS)
def test_programmes_in_stages(name, feature):
    changes, answer = STAGES[feature]
    solver, program = SOLVERS[name], replace(STAGED, **changes)
    assert feature in program.features
    if refused(solver, program, feature):
        return
    if solver.needs - program.features:
        with pytest.raises(ValueError, match="needs it and the programme has none"):
            refuse(solver, program)
        return
    u = jnp.zeros((4, 1))
    inside = isinstance(solver, InteriorPoint)
    found = solve(solver, program, (u, jnp.ones((5, 1))) if inside else u, None)
    np.testing.assert_allclose(found.u if inside else found.x, answer, atol=1e-5)
    assert found.status == Status.CONVERGED


@pytest.mark.parametrize("feature", ROOTS)
@pytest.mark.parametrize("name", SOLVERS)
def test_programmes_of_roots(name, feature):
    solver = SOLVERS[name]
    asked = {feature} | (solver.needs & ROOTS.keys())
    changes = {key: value for each in asked for key, value in ROOTS[each].items()}
    program = replace(ROOT, **changes)
    assert feature in program.features
    if refused(solver, program, feature):
        return
    start = 0.01 * jnp.array([[1.0], [2.0], [1.5]])
    found = solve(solver, program, start, None)
    u = found.x if isinstance(solver, LeastEffort) else found.u
    np.testing.assert_allclose(u[:, 0], [0.0, 0.25, 0.0], atol=1e-3)
    assert abs(float(jnp.sum(REACH * u[:, 0])) - 0.5) < 1e-7


@pytest.mark.parametrize("name", SOLVERS)
def test_what_a_solver_needs_is_asked_for_by_name(name):
    solver = SOLVERS[name]
    lacking = replace(ROOT) if solver.needs & ROOTS.keys() else None
    lacking = lacking or (STAGED if features.DYNAMICS not in solver.needs else PLAIN)
    with pytest.raises(ValueError, match=solver.name):
        refuse(solver, lacking)


def test_every_feature_is_supported_by_some_solver():
    supported = frozenset().union(*(solver.supports for solver in SOLVERS.values()))
    assert supported == FEW.keys() | VARIABLES.keys() | STAGES.keys() | ROOTS.keys()
