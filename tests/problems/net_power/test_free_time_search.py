"""Search of turns by magnetorquers alone: what is found, flown and said."""

import copy
import tomllib

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.attitude import quaternion
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.build import free_manoeuvre_of
from jaxatt.problems.net_power.magnetic.along_field import farthest_from_field
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.problems.net_power.record import net_power

DOCUMENT = tomllib.loads(scenarios.text("mtq-free-time"))
STARTS = 2


def turn(longest, **tables):
    """A short turn in few intervals, which has to reach."""
    document = copy.deepcopy(DOCUMENT)
    document.pop("printed")
    document["horizon"] = {
        "final_time": "free",
        "intervals": 20,
        "shortest_s": 60.0,
        "longest_s": longest,
    }
    document["objective"] = {
        "kind": "net-power",
        "cost": "mean-power",
        "time_weight_W_s": 0.1,
    }
    return scenarios.from_mapping({**document, **tables})


@pytest.fixture(scope="module")
def answer():
    return jaxatt.solve(turn(900.0), starts=STARTS)


@pytest.mark.slow
def test_a_turn_reaches_and_is_worth_what_the_solver_says(answer):
    (phase,) = answer.phases
    found = net_power(phase)
    assert phase.reached
    assert 60.0 <= phase.final_time <= 900.0
    assert found.claimed == pytest.approx(found.energy.net, rel=5e-3)
    cost = 0.1 * phase.final_time - found.energy.net / phase.final_time
    assert found.cost == pytest.approx(cost, rel=1e-9)
    limit = np.asarray(answer.scenario.vehicle.magnetorquers.dipole_limit)
    assert (np.abs(phase.controls) <= limit * (1.0 + 1e-12)).all()


def multiplied(scenario, factor):
    """The turn of a satellite `factor` times as heavy, strong and well lit."""
    craft, document = scenario.vehicle, scenario.document
    coils, disturbances = craft.magnetorquers, document["disturbances"]
    residual = np.asarray(disturbances["residual_dipole_Am2"])
    changes = {
        "vehicle.inertia_kgm2": factor * craft.inertia,
        "vehicle.panels.area_m2": factor * craft.panels.area,
        "vehicle.magnetorquers.dipole_limit_Am2": factor * coils.dipole_limit,
        "vehicle.magnetorquers.turns": 1.0,
        "vehicle.magnetorquers.coil_area_m2": 1.0,
        "vehicle.magnetorquers.resistance_ohm": coils.loss_coefficient / factor,
        "disturbances.residual_dipole_Am2": factor * residual,
        "disturbances.eddy_coefficient": factor * disturbances["eddy_coefficient"],
        "objective.time_weight_W_s": factor * document["objective"]["time_weight_W_s"],
    }
    return scenarios.replace(scenario, changes)


@pytest.mark.slow
def test_a_smaller_satellite_turns_alike_and_earns_in_proportion(answer):
    factor = 1e-6
    want = answer.phases[0]
    phase = jaxatt.solve(multiplied(turn(900.0), factor), starts=STARTS).phases[0]
    assert phase.reached
    assert phase.final_time == pytest.approx(want.final_time, rel=1e-4)
    assert net_power(phase).cost == pytest.approx(factor * net_power(want).cost, rel=1e-5)


@pytest.mark.slow
def test_starts_are_ranked_by_the_cost(answer):
    (phase,) = answer.phases
    found, reached = net_power(phase), phase.starts.reached
    assert -found.cost == found.start_score[reached].max()


@pytest.mark.slow
def test_a_turn_along_the_field_is_said_with_what_was_left():
    """The axis of the turn is the field's direction, which hardly moves in so short a time."""
    from_rest = turn(120.0)
    task = MagneticTask(free_manoeuvre_of(from_rest, PhaseStart()))
    begin = np.asarray(task.parameters.start)[:4]
    field = np.asarray(task.parameters.environment.at(0.0).field.array)
    axis = field / np.linalg.norm(field)
    half = 0.5 * np.radians(100.0)
    end = np.asarray(quaternion.multiply(np.array([np.cos(half), *np.sin(half) * axis]), begin))
    seen = quaternion.conjugate(task.parameters.environment.at(90.0).q_io.array)
    target = {"frame": "orbit", "attitude_quaternion": quaternion.multiply(seen, end).tolist()}
    scenario = turn(120.0, target=target | {"attitude_tolerance_deg": 1.0})
    asked = MagneticTask(free_manoeuvre_of(scenario, PhaseStart()))
    assert farthest_from_field(asked, 90.0) < np.radians(15.0)
    result = jaxatt.solve(scenario, starts=STARTS)
    assert not result.reached
    reason = result.phases[0].failure_reason
    assert "along the magnetic field" in reason
    assert "deg were left at best" in reason
