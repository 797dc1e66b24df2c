"""One odd value in a study: it is refused in a sentence, or its samples are made."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from references.odd_values import DOUBLED, GONE, ODD, edited

from jaxatt.scenarios import ScenarioError
from jaxatt.studies.sweep.reading import load_study, read_study

DOCUMENT = {
    "name": "odd",
    "title": "Odd",
    "scenario": "double-integrator",
    "outputs": ["active_intervals", "cost"],
    "chunk": 2,
    "fixed": {"solver": {"starts": 4}, "horizon.intervals": 20},
    "sampling": {"method": "random", "samples": 4, "seed": 1},
    "vary": [
        {"field": "control.limit", "name": "limit", "change": "multiply", "from": 1.0, "to": 2.0,
         "spacing": "logarithmic", "whole": False},
        {"field": ["initial.state.*"], "values": [0.1, 0.2]},
    ],
}  # fmt: skip
GRID = {
    "against": ["cost"],
    **{key: value for key, value in DOCUMENT.items() if key != "sampling"},
    "vary": [{"field": "control.limit", "from": 1, "to": 4, "count": 3, "whole": True}],
}


def within(value, path=()):
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else ()
    for key, item in enumerate(value) if isinstance(value, list) else items:
        yield from within(item, (*path, key))


@settings(derandomize=True, database=None, deadline=None, max_examples=600,
          suppress_health_check=list(HealthCheck))  # fmt: skip
@given(st.data())
def test_any_odd_value_of_a_study(data):
    whole = data.draw(st.sampled_from((DOCUMENT, GRID)))
    path = data.draw(st.sampled_from(list(within(whole))))
    value = data.draw(st.sampled_from((*ODD, GONE, DOUBLED, "*", "initial", "*.*", "..")))
    try:
        study = read_study(edited(whole, path, value), "odd.toml")
        study.layout()
        study.sample(0)
    except ScenarioError as error:
        message = str(error)
        assert "; " in message, f"no mend in: {message}"
        assert "odd.toml" in message or path[0] in ("scenario", "fixed", "vary"), message
        assert len(message) < 1000, message


@pytest.mark.parametrize("name", ["a\0b.toml", "a\0b", "x" * 300, "x" * 300 + ".toml", "/", "."])
def test_names_of_files_that_no_system_has(name):
    with pytest.raises(ScenarioError):
        load_study(name)
