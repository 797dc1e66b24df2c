"""An answer's derivatives against solving its first-order conditions again at other numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.optimize.sensitivity.answer import answer_at
from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.registry import family_of
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sweep.numbers import places, set_at, value_at, whole_document

STEP = 1e-4


def with_number(scenario, name, change):
    """The scenario with a number, or all numbers of that name, changed."""
    document = whole_document(scenario)
    for place in places(scenario, document, name):
        set_at(document, place, value_at(document, place) + change)
    return scenarios.from_mapping(document)


def solved_again(scenario, sensitive, name, change):
    """Objective and variables at a changed number, by Newton steps from the answer."""
    optimum, answer = sensitive.optimum, sensitive.optimum.answer
    args = sensitive.arguments(with_number(scenario, name, change))
    again = answer_at(answer.conditions, args, answer.point)
    np.testing.assert_array_equal(again.holding.active, answer.holding.active)
    worth = float(optimum.worth(jnp.asarray(again.objective), args))
    return worth, jax.tree.map(np.asarray, optimum.read(again.point, args))


def check_against_solving_again(scenario, names, near=1e-6, cancelling=()):
    """Objective and variables at changed numbers, from the first-order conditions there.

    near : of variables, relative to the largest.  cancelling : names by which variables move by
    what is left where terms cancel, so that differences of the problem show in the fifth digit.
    """
    family = family_of(scenario)
    found = family.search(scenario, PhaseStart(), SearchOptions(), None)
    sensitive = family.sensitive(scenario, PhaseStart(), found)
    optimum = sensitive.optimum
    directions = directions_of(scenario, sensitive.arguments, names)
    record = optimum.along(directions.names, directions.values, directions.along)
    assert record.regular, record.flags
    for k, name in enumerate(names):
        step = STEP * (abs(record.values[k]) or 0.1)
        slopes, moves = [], []
        for width in (step, 2.0 * step):
            ends = [solved_again(scenario, sensitive, name, sign * width) for sign in (1.0, -1.0)]
            slopes.append((ends[0][0] - ends[1][0]) / (2.0 * width))
            moves.append(
                {key: (leaf - ends[1][1][key]) / (2.0 * width) for key, leaf in ends[0][1].items()}
            )
        # Of fourth order: steps that are small enough for the second drown in rounding.
        slope = (4.0 * slopes[0] - slopes[1]) / 3.0
        assert record.by_parameter[k] == pytest.approx(slope, rel=1e-5), name
        for variable, moved in record.variables.items():
            want = (4.0 * moves[0][variable] - moves[1][variable]) / 3.0
            size = (1e-4 if name in cancelling else near) * np.abs(want).max()
            assert np.abs(moved[k] - want).max() <= size, (name, variable)
    return sensitive, record, found
