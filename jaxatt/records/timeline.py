"""The phases of an answer, joined on one time axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class Timeline:
    """Flown states and torques over all phases, with K nodes and I intervals.

    time : (K,) [s].  nodes : name -> (K, ...).  edges : (I + 1,) [s].
    intervals : name -> (I, ...).  ends : [s], end of each phase's horizon.
    """

    time: Floats
    nodes: Mapping[str, Floats]
    edges: Floats
    intervals: Mapping[str, Floats]
    ends: tuple[float, ...]

    @property
    def spans(self) -> list[tuple[float, float]]:
        """Beginning and end of each phase's horizon [s]."""
        return list(zip((self.edges[0], *self.ends[:-1]), self.ends, strict=True))


def at_nodes(phase: Phase, name: str) -> bool:
    """Whether a series of a phase is sampled at nodes, rather than held over intervals."""
    return len(phase.series[name]) > len(phase.active)


def node_times(phase: Phase) -> Floats:
    """Times (M,) [s] of a phase's nodes from its start, the coasting tail included."""
    flown = max((len(values) for values in phase.series.values()), default=0)
    return np.asarray(phase.step * np.arange(max(flown, len(phase.active) + 1)))


def timeline(phases: Sequence[Phase]) -> Timeline:
    """Join the phases; a coasting tail is kept only after the last phase."""
    kept = [len(phase.active) for phase in phases[:-1]] + [len(node_times(phases[-1]))]
    first = phases[0]
    starts = [phase.start_time + phase.step * np.arange(len(phase.active)) for phase in phases]
    ends = tuple(phase.start_time + phase.step * len(phase.active) for phase in phases)
    joined = list(zip(phases, kept, strict=True))
    return Timeline(
        time=np.concatenate([phase.start_time + node_times(phase)[:k] for phase, k in joined]),
        nodes={
            name: np.concatenate([phase.series[name][:k] for phase, k in joined])
            for name in first.series
            if at_nodes(first, name)
        },
        edges=np.concatenate([*starts, [ends[-1]]]),
        intervals={
            name: np.concatenate([phase.series[name] for phase in phases])
            for name in first.series
            if not at_nodes(first, name)
        },
        ends=ends,
    )
