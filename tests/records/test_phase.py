"""Records of phases: what they derive from their arrays, and earlier names that still work."""

import dataclasses

import handmade_results
import numpy as np
import pytest

from jaxatt.records.phase import Section, squared_effort
from jaxatt.records.timeline import at_nodes, node_times, timeline


def two_phases(coast):
    """Phases of three and two intervals; the second begins where the first ends."""
    base = handmade_results.handmade("double-integrator").phases[0]
    random = np.random.default_rng(coast)

    def phase(start, step, count):
        return dataclasses.replace(
            base,
            start_time=start,
            step=step,
            series={
                "state": random.normal(size=(count + coast + 1, 2)),
                "power": random.normal(size=count),
            },
            active=np.arange(count) % 2 == 0,
            controls=random.normal(size=(count, 1)),
        )

    return phase(0.0, 2.0, 3), phase(6.0, 0.5, 2)


@pytest.mark.parametrize("coast", [0, 1, 4])
def test_phases_join_and_only_the_last_one_coasts(coast):
    first, second = two_phases(coast)
    line = timeline((first, second))
    np.testing.assert_allclose(line.edges, [0.0, 2.0, 4.0, 6.0, 6.5, 7.0])
    np.testing.assert_allclose(line.time[:3], [0.0, 2.0, 4.0])
    np.testing.assert_allclose(line.time[3:], 6.0 + 0.5 * np.arange(3 + coast))
    assert line.spans == [(0.0, 6.0), (6.0, 7.0)]
    np.testing.assert_array_equal(
        line.nodes["state"], np.concatenate([first.series["state"][:3], second.series["state"]])
    )
    assert len(line.intervals["power"]) == 5 and set(line.nodes) == {"state"}


def test_a_series_as_long_as_the_intervals_is_held_over_them():
    first, _ = two_phases(0)
    assert at_nodes(first, "state") and not at_nodes(first, "power")
    without = dataclasses.replace(first, series={"power": first.series["power"]})
    assert len(node_times(without)) == 4


def test_the_effort_is_that_of_the_actuators_and_of_the_controls_where_there_are_none():
    first, _ = two_phases(0)
    assert first.quadratic_effort == pytest.approx(2.0 * np.sum(first.controls**2))
    wheels, thrusters = np.full((3, 4), 2.0), np.full((3, 1), 1.0)
    both = dataclasses.replace(
        first, series={"torque_wheels": wheels, "torque_thrusters": thrusters}
    )
    assert both.quadratic_effort == pytest.approx(2.0 * (3 * 4 * 4.0 + 3 * 1.0))
    assert squared_effort(np.array([[1.0, 2.0], [3.0, 0.0]]), 0.5) == 7.0


def test_earlier_names():
    result = handmade_results.resting()
    assert result.legs is result.phases
    assert result.phases[0].obstacle == "the target attitude is missed"


def test_a_section_without_words_of_its_own_tells_times():
    phases = [dataclasses.replace(phase, section=Section()) for phase in two_phases(0)]
    assert phases[0].section.headline(phases) == "6.0000 s, 1.0000 s"
    assert phases[0].section.brief(phases) == "7 s"
    assert repr(phases[1]) == "Phase(reached, 1 s)"
