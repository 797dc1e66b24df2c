"""Problems of one's own: published answers, closed forms, and input that makes no sense."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.status import Status
from jaxatt.problems.toy.published_programs import PUBLISHED


@functools.cache
def published(name):
    problem = PUBLISHED[name]()
    return problem, jaxatt.solve_program(problem.program, problem.parameters)


SOLVED = [
    pytest.param(name, marks=[pytest.mark.slow] * (name == "rigid body")) for name in PUBLISHED
]


@pytest.mark.parametrize("name", SOLVED)
def test_published_answers_from_sixteen_random_starts(name):
    problem, found = published(name)
    assert found.status is Status.CONVERGED
    assert found.objective == pytest.approx(problem.objective, abs=1e-3)
    assert found.violation < 1e-8 and found.stationarity < 1e-8
    assert len(found.starts.status) == 16
    assert found.minima[0][0] == pytest.approx(found.objective)
    assert found.share_at_best >= 0.3
    assert found.flight.factor == 10
    assert found.flight.end_error < 1e-5 and found.flight.terminal_violation < 1e-5
    assert found.status.name in repr(found) and "minima" in repr(found)


@pytest.mark.parametrize("name", SOLVED)
def test_converged_starts_are_flown_feasible_and_within_their_limits(name):
    """Put together again from the answer alone, by the programme's own dynamics."""
    problem, found = published(name)
    program, p = problem.program, jax.tree.map(jnp.asarray, problem.parameters)
    u = jax.vmap(program.layout.scaled, in_axes=(0, None))(jnp.asarray(found.controls), p)
    x = program.start(p)
    if program.layout.free_time:
        x = x.at[-1].set(jnp.log(found.final_time))

    @jax.jit
    def flown(x, u):
        return jax.lax.scan(
            lambda x, row: (program.dynamics(x, row[0], row[1], p), x), x, (u, program.stages(p))
        )

    end, nodes = flown(x, u)
    np.testing.assert_allclose(nodes[:, : program.layout.states], found.states[:-1], atol=1e-6)
    assert np.abs(program.final_equalities(end, p)).max() < 1e-6
    lower, upper = program.control_limits(jax.tree.map(lambda s: s[0], program.stages(p)), p)
    assert (np.asarray(u) >= np.asarray(lower) - 1e-9).all()
    assert (np.asarray(u) <= np.asarray(upper) + 1e-9).all()
    assert found.times[0] == 0.0 and found.times[-1] == pytest.approx(found.final_time)


def test_new_parameters_compile_nothing_again():
    problem, _ = published("double integrator")
    parameters = {"distance": 4.0, "force": 2.0}
    found = jaxatt.solve_program(problem.program, parameters, seed=3)
    assert found.status is Status.CONVERGED
    assert found.objective == pytest.approx(2.0 * np.sqrt(2.0), rel=1e-6)
    force = found.controls[:, 0]
    np.testing.assert_allclose(force, np.where(np.arange(40) < 20, 2.0, -2.0), atol=1e-4)


def test_a_guess_takes_the_place_of_the_first_start():
    problem, found = published("double integrator")
    again = jaxatt.solve_program(
        problem.program,
        problem.parameters,
        controls=found.controls,
        states=found.states,
        final_time=found.final_time,
    )
    assert again.starts.status[0] == Status.CONVERGED
    assert again.starts.objective[0] == pytest.approx(2.0, rel=1e-6)
    # The others are drawn as before, whoever comes first.
    np.testing.assert_array_equal(again.starts.iterations[1:], found.starts.iterations[1:])


@functools.cache
def everything():
    """A path equality, a terminal cost, a free parameter with bounds and two controls.

    Minimise the integral of |u|^2 and (theta - 3)^2 subject to u_0 + u_1 = s, x' = u_0 - u_1,
    x(1) = d, theta <= 2: u = (s + d, s - d) / 2.
    """
    return jaxatt.transcribe(
        lambda x, u, p: u[:1] - u[1:],
        states=1,
        controls=2,
        intervals=5,
        initial_state=np.zeros(1),
        final_time=1.0,
        running_cost=lambda x, u, p: jnp.sum(u**2),
        terminal_cost=lambda x, p, free: (free[0] - 3.0) ** 2,
        terminal_equality=lambda x, p: x - p["distance"],
        path_equality=lambda x, u, p: u[0] + u[1] - p["sum"],
        free_parameters=([0.0], [2.0]),
    )


def test_path_equality_terminal_cost_and_free_parameter_against_their_closed_form():
    total, distance = 0.8, -0.4
    found = jaxatt.solve_program(everything(), {"distance": distance, "sum": total}, starts=4)
    assert (found.starts.status == Status.CONVERGED).all()
    exact = [0.5 * (total + distance), 0.5 * (total - distance)]
    np.testing.assert_allclose(found.controls, np.tile(exact, (5, 1)), atol=1e-7)
    assert found.free_parameters == pytest.approx([2.0], abs=1e-6)
    assert found.objective == pytest.approx(np.sum(np.square(exact)) + 1.0, abs=1e-6)
    # Derivatives of the objective by the rows: dJ/dd = d, dJ/ds = s, an interval's share of it.
    np.testing.assert_allclose(found.multipliers.terminal_equality, -distance, atol=1e-6)
    np.testing.assert_allclose(found.multipliers.path_equality, -total / 5.0, atol=1e-6)
    assert found.multipliers.terminal_inequality == pytest.approx([0.0, 2.0], abs=1e-6)


@pytest.mark.slow
def test_a_singular_arc_between_bounds_of_states_from_every_start():
    """The rocket of Goddard, COPS 3.0: a height of 1.01283 with 0.6 of the mass left."""
    exhaust = 0.5

    def dynamics(x, u, p):
        height, speed, mass = x[0], x[1], x[2]
        drag = 310.0 * speed**2 * jnp.exp(-500.0 * (height - 1.0))
        return jnp.stack([speed, (u[0] - drag) / mass - 1.0 / height**2, -u[0] / exhaust])

    program = jaxatt.transcribe(
        dynamics,
        states=3,
        controls=1,
        intervals=60,
        initial_state=np.array([1.0, 0.0, 1.0]),
        final_time=(0.05, 1.0),
        terminal_cost=lambda x, p: -x[0],
        terminal_equality=lambda x, p: x[2] - 0.6,
        control_bounds=(0.0, 3.5),
        state_bounds=([1.0, 0.0, 0.6], [np.inf, np.inf, 1.0]),
    )
    found = jaxatt.solve_program(program)
    assert (found.starts.status == Status.CONVERGED).sum() >= 14
    assert found.objective == pytest.approx(-1.01283, abs=1e-4)
    assert (found.states[:, 1] >= -1e-8).all() and (found.states[:, 2] >= 0.6 - 1e-8).all()


@functools.cache
def the_line():
    return a_line()


@pytest.mark.parametrize("size", [1e-6, 1e7])
def test_objectives_of_any_size_are_met_as_well(size):
    found = jaxatt.solve_program(the_line(), {"size": size}, starts=4)
    assert found.status is Status.CONVERGED
    assert found.objective == pytest.approx(size, rel=1e-6)
    np.testing.assert_allclose(found.controls, 1.0, atol=1e-4)


def test_what_cannot_be_reached_is_not_called_converged():
    """The longest time allowed is a tenth of what the distance takes."""
    program = published("double integrator")[0].program
    found = jaxatt.solve_program(program, {"distance": 1e4, "force": 1.0}, max_iterations=100)
    assert not np.isin(found.starts.status, (Status.CONVERGED, Status.FEASIBLE)).any()
    assert found.violation > 0.1
    assert found.minima == () and found.share_at_best == 0.0
    assert found.flight.terminal_violation > 0.1


# What is wrong with a problem is named before it is solved.


def a_line(**changes):
    """From 0 to 1 in a second, x' = u."""
    usual = {
        "dynamics": lambda x, u, p: u * jnp.ones(1),
        "states": 1,
        "controls": 1,
        "intervals": 4,
        "initial_state": np.zeros(1),
        "final_time": 1.0,
        "running_cost": lambda x, u, p: p["size"] * u[0] ** 2,
        "terminal_equality": lambda x, p: x - 1.0,
    }
    return jaxatt.transcribe(**(usual | changes))


def _plus(x, e):
    return x + e


WRONG = {
    "dynamics of another shape": (
        {"dynamics": lambda x, u, p: jnp.zeros(3)},
        r"dynamics returns an array of shape \(3,\); \(1,\) is expected",
    ),
    "a cost that is a vector": (
        {"running_cost": lambda x, u, p: u},
        r"running_cost returns an array of shape \(1,\); \(\) is expected",
    ),
    "rows of two axes": (
        {"terminal_equality": lambda x, p: x[:, None]},
        r"terminal_equality returns an array of shape \(1, 1\); \(\) or \(rows,\) is expected",
    ),
    "a value that is not a number": (
        {"dynamics": lambda x, u, p: u / x},
        r"dynamics is \[nan\] at the first evaluation",
    ),
    "a derivative that is not a number": (
        {"running_cost": lambda x, u, p: jnp.sqrt(x[0])},
        r"running_cost has a derivative that is not finite at the first evaluation",
    ),
    "bounds of controls that cross": (
        {"control_bounds": lambda p: (2.0 * p["size"], p["size"])},
        r"control_bounds: lower 2 and upper 1 of number 0 cross",
    ),
    "a manifold that does not close": (
        {"retract": lambda x, e: x + 2.0 * e, "difference": lambda x, r: x - r, "error_size": 1},
        r"retract and difference disagree at x = \[0\.\].* e is expected",
    ),
    "a manifold of another size": (
        {"retract": _plus, "difference": lambda x, r: jnp.zeros(2), "error_size": 1},
        r"difference returns an array of shape \(2,\); \(1,\), error_size, is expected",
    ),
    "a first state of another shape": (
        {"initial_state": lambda p: jnp.zeros(2)},
        r"initial_state has shape \(2,\); \(1,\) is expected",
    ),
    "a final time that has passed": (
        {"final_time": lambda p: -p["size"]},
        r"final_time is -1\.0; a positive number",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_makes_no_sense_is_named_before_anything_is_solved(case):
    changes, message = WRONG[case]
    with pytest.raises(ValueError, match=message):
        jaxatt.solve_program(a_line(**changes), {"size": 1.0})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"control_bounds": (1.0, -1.0)}, r"control_bounds: lower 1 and upper -1 of number 0"),
        (
            {"state_bounds": ([0.0, 0.0], 1.0)},
            r"state_bounds\[0\] has shape \(2,\); \(\) or \(1,\)",
        ),
        ({"initial_state": np.zeros(2)}, r"initial_state has shape \(2,\); \(1,\) is expected"),
        ({"final_time": (3.0, 2.0)}, r"final_time is \(3.0, 2.0\); .*shortest < longest"),
        ({"final_time": 0.0}, r"final_time is 0\.0; a positive number"),
        ({"states": 0}, r"states is 0; a whole number from 1 on is expected"),
        ({"retract": _plus}, r"retract and difference define a manifold together"),
        (
            {"dynamics": lambda x, u: u},
            r"dynamics takes \(x, u\); expected are \(x, u, parameters\)",
        ),
        ({"dynamics": lambda x, u, p, speed: u}, r"and then any of time, final_time, free"),
        ({"running_cost": 3.0}, r"running_cost is 3.0; a function of \(x, u, parameters\)"),
    ],
)
def test_what_makes_no_sense_is_named_where_it_is_written(changes, message):
    with pytest.raises(ValueError, match=message):
        a_line(**changes)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"size": "large"}, r"parameters\['size'\] is 'large', of type str"),
        ({"size": None}, r"parameters\['size'\] is None, of type NoneType"),
        ({"size": 1.0, "more": [1.0, object()]}, r"parameters\['more'\]\[1\] is <object"),
        ({"size": np.array([1.0 + 2.0j])}, r"parameters\['size'\] .* an array of real numbers"),
        ({"size": np.nan}, r"running_cost is nan at the first evaluation"),
    ],
)
def test_parameters_that_are_not_numbers_are_named(parameters, message):
    with pytest.raises(ValueError, match=message):
        jaxatt.solve_program(a_line(), parameters)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"starts": 0}, "starts is 0"),
        ({"tolerance": 2.0}, "tolerance is 2.0"),
        ({"controls": np.zeros((3, 1))}, r"controls has shape \(3, 1\); \(4, 1\) or"),
        ({"states": np.full((5, 1), np.nan)}, "states has entries that are not finite"),
        ({"final_time": 2.0}, "has no free final time"),
    ],
)
def test_settings_that_make_no_sense_are_named(given, message):
    with pytest.raises(ValueError, match=message):
        jaxatt.solve_program(a_line(), {"size": 1.0}, **given)


def in_stages(**more):
    return OptimalControlProgram(
        start=lambda p: jnp.zeros(1),
        stages=lambda p: jnp.zeros(3),
        dynamics=lambda x, u, stage, p: x + u,
        cost=lambda x, u, stage, p, smoothing: u[0] ** 2,
        error_size=1,
        control_size=1,
        final_rows=lambda x, p: x - 1.0,
        **more,
    )


def test_a_programme_written_in_stages_is_solved_as_well():
    found = jaxatt.solve_program(in_stages(), starts=2)
    assert found.status is Status.CONVERGED
    np.testing.assert_allclose(found.controls, 1.0 / 3.0, atol=1e-8)
    assert found.objective == pytest.approx(1.0 / 3.0)
    assert "flown finer" not in repr(found)


@pytest.mark.parametrize(
    ("more", "feature"),
    [
        ({"final_weight": lambda p: jnp.ones(1)}, "soft terminal rows"),
        ({"free": lambda stage, p: jnp.ones(1)}, "held controls"),
        (
            {
                "equality": lambda x, u, stage, p: u,
                "equality_weight": lambda stage, p: jnp.ones(1),
            },
            "soft path rows",
        ),
    ],
)
def test_what_the_solver_does_not_support_is_refused_by_name(more, feature):
    expected = rf"{feature}: interior point does not support it; choose "
    with pytest.raises(ValueError, match=expected):
        jaxatt.solve_program(in_stages(**more))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"dynamics": lambda x, u, stage, p: u[0]}, r"dynamics .* shape \(\); \(1,\) is expected"),
        ({"cost": lambda x, u, stage, p, smoothing: u}, r"cost .* shape \(1,\); \(\) is expected"),
        ({"inequality": lambda x, u, stage, p: x[0]}, r"inequality .* shape \(\); \(rows,\) is"),
        ({"start": lambda p: jnp.full(1, jnp.nan)}, r"dynamics is \[nan\] at the first evaluation"),
        ({"retract": lambda x, e: x + e**2}, r"retract and difference disagree at x = \[0\.\]"),
        ({"stages": lambda p: (jnp.zeros(3), jnp.zeros(2))}, r"leading axes \[\(2,\), \(3,\)\]"),
    ],
)
def test_stages_that_make_no_sense_are_named(more, message):
    with pytest.raises(ValueError, match=message):
        jaxatt.solve_program(OptimalControlProgram(**(vars(in_stages()) | more)))


def test_a_programme_in_stages_needs_its_number_of_controls():
    program = in_stages()
    with pytest.raises(ValueError, match="control_size of the programme is None"):
        jaxatt.solve_program(OptimalControlProgram(**(vars(program) | {"control_size": None})))
