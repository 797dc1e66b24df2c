"""Energy to many targets in one batch: what each earns alone."""

from dataclasses import replace

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.registry import family_of


@pytest.fixture(scope="module")
def case():
    changes = {"horizon.intervals": 40, "solver.starts": 2}
    scenario = scenarios.replace(scenarios.load("hypso1-netpower"), changes)
    q = np.random.default_rng(5).normal(size=(5, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return scenario, q, family_of(scenario).answer_targets(scenario, q)


def test_every_target_earns_what_it_earns_alone(case):
    scenario, q, found = case
    family = family_of(scenario)
    assert found.reached.all()
    for k in (0, 3):
        one = replace(scenario, targets=(replace(scenario.targets[0], q_ob=q[k]),))
        answers = family.search(one, PhaseStart(), SearchOptions(), None)
        phase, _ = family.judge(one, PhaseStart(), answers)
        assert found.numbers["energy.net_J"][k] == pytest.approx(-phase.total_cost, rel=1e-5)
        assert phase.section.energy.gain == pytest.approx(
            found.numbers["energy.gain_J"][k], abs=0.05
        )


def test_flights_are_certain(case):
    _, _, found = case
    assert (found.numbers["flight_error_deg"] < 1e-3).all()
    assert (found.numbers["attitude_error_deg"] < 0.1).all()
    assert found.numbers["kkt.violation"].max() < 1e-5
