"""Numbers of a scenario as parameters of its answer, by the differences that they make."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import jax
import numpy as np

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.loader import from_mapping
from jaxatt.studies.sweep.numbers import Place, places, set_at, value_at, whole_document

_STEP = 1e-5
"""Of a parameter, relative, or in its own unit where it is 0."""
_UNASKED = ("printed", "solver", "windows", "legs")
"""Tables whose numbers are not parameters unless they are named."""
_COUNTS = ("intervals", "coast_intervals", "substeps", "node", "turns", "design")

Arguments = Callable[[Scenario], Any]


class Directions:
    """Directions in which the arguments of an answer move with numbers of its scenario.

    names : (P,).  values : (P,).  along : tangents of the arguments, leading axis P.
    """

    def __init__(self, names: list[str], values: list[float], along: list[Any]):
        self.names, self.values = tuple(names), np.array(values)
        self.along = jax.tree.map(lambda *leaves: np.stack(leaves), *along)


def directions_of(
    scenario: Scenario, arguments: Arguments, names: Sequence[str] | None
) -> Directions:
    """Directions of the named numbers, or of all that the answer depends on.

    Arguments are smooth functions of the scenario's numbers, so central differences give their
    derivatives to ten digits; nothing is solved for that.

    Raises `ScenarioError` for a name that is no number, or one on which nothing depends smoothly.
    """
    document = whole_document(scenario)
    base = arguments(scenario)
    found: list[str] = []
    values: list[float] = []
    along: list[Any] = []
    for name, group in _groups(scenario, document, names):
        value = value_at(document, group[0])
        change = _derivative(scenario, document, group, arguments, base)
        if isinstance(change, str):
            if names is not None:
                raise ScenarioError(f"{name}: {change}")
            continue
        found.append(name)
        values.append(float(value))
        along.append(change)
    if not found:
        raise ScenarioError(
            f"{scenario.name}: its answer depends on none of its numbers; name some with parameters"
        )
    return Directions(found, values, along)


def _groups(
    scenario: Scenario, document: dict[str, Any], names: Sequence[str] | None
) -> Iterator[tuple[str, tuple[Place, ...]]]:
    """Names with the places that move together."""
    if names is None:
        for place in _numbers(document, ()):
            lower = place[1:2] == ("inertia_kgm2",) and place[2:] != tuple(
                sorted(place[2:], key=int)
            )
            if place[0] not in _UNASKED and place[-1] not in _COUNTS and not lower:
                yield ".".join(map(str, place)), (place,)
        return
    for name in names:
        yield name, places(scenario, document, name)


def _numbers(value: Any, before: Place) -> Iterator[Place]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _numbers(item, (*before, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, (*before, index))
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield before


def _derivative(
    scenario: Scenario,
    document: dict[str, Any],
    group: tuple[Place, ...],
    arguments: Arguments,
    base: Any,
) -> Any:
    """Derivative of the arguments by one number, or a sentence where there is none."""
    values = [value_at(document, place) for place in group]
    if any(value is None for value in values):
        return "is not given; give it a value to have its sensitivity"
    step = _STEP * (max(abs(float(value)) for value in values) or 1.0)
    ends = []
    for sign in (1.0, -1.0):
        changed = copy.deepcopy(document)
        for place, value in zip(_moved_together(group), values * 2, strict=False):
            set_at(changed, place, float(value) + sign * step)
        try:
            other = from_mapping(changed, origin=scenario.origin, folder=scenario.folder)
            ends.append(arguments(other))
        except ScenarioError as error:
            return f"cannot be changed a little: {error}"
    return difference(ends[0], ends[1], 2.0 * step, base)


def _moved_together(group: tuple[Place, ...]) -> tuple[Place, ...]:
    """The places of a group, with the mirrored entry where one of the inertia is moved."""
    mirrored = tuple(
        (*place[:-2], place[-1], place[-2])
        for place in group
        if place[:2] == ("vehicle", "inertia_kgm2") and len(place) == 4 and place[2] != place[3]
    )
    return group + tuple(place for place in mirrored if place not in group)


def difference(ahead: Any, behind: Any, width: float, base: Any) -> Any:
    """Slope of arguments between two that are `width` apart, or a sentence why there is none."""
    moved = False
    leaves = []
    if {jax.tree.structure(tree) for tree in (ahead, behind)} != {jax.tree.structure(base)}:
        return "changes the form of the problem; its effect is no derivative"
    parts = (jax.tree.leaves(tree) for tree in (ahead, behind, base))
    for a, b, at in zip(*parts, strict=True):
        kind = np.asarray(at).dtype
        if np.shape(a) != np.shape(at) or np.shape(b) != np.shape(at):
            return "changes the size of the problem; its effect is no derivative"
        if not np.issubdtype(kind, np.floating):
            if not np.array_equal(a, b):
                return "changes what is counted in whole numbers; its effect is no derivative"
            leaves.append(np.zeros(np.shape(at), jax.dtypes.float0))
            continue
        a, b = np.asarray(a), np.asarray(b)
        differ = a != b  # infinities do not
        change: Floats = np.zeros(np.shape(at))
        change[differ] = (a[differ] - b[differ]) / width
        if not np.isfinite(change).all():
            return "has no derivative where it is"
        moved |= bool(np.any(change))
        leaves.append(change)
    if not moved:
        return "has no effect on the answer"
    return jax.tree.unflatten(jax.tree.structure(base), leaves)
