"""The phases of an answer, one after another on one time axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Flags, Floats

NODE_SERIES = ("q_ob", "omega_ob", "omega_ib", "omega_bw", "state")
INTERVAL_SERIES = ("torque_body", "torque_wheels", "torque_thrusters", "control")


@dataclass(frozen=True, eq=False)
class Timeline:
    """What was flown, with K nodes and I intervals over all phases.

    time : (K,) [s].  nodes : name -> (K, ...).  edges : (I + 1,) [s].
    intervals : name -> (I, ...).  active, window, forbidden : (I,).
    ends : [s], end of each phase's horizon.
    """

    time: Floats
    nodes: Mapping[str, Floats]
    edges: Floats
    intervals: Mapping[str, Floats]
    active: Flags
    window: Flags
    forbidden: Flags
    ends: tuple[float, ...]


def node_times(phase: Phase) -> Floats:
    """Times of a phase's nodes from its start, (M,) [s], the coasting tail included."""
    count = max(len(phase.series[name]) for name in NODE_SERIES if name in phase.series)
    return np.asarray(phase.step * np.arange(count))


def timeline(phases: tuple[Phase, ...]) -> Timeline:
    """Join the phases; a phase's coasting tail is kept only where no other phase follows."""
    kept = [len(phase.active) for phase in phases[:-1]] + [len(node_times(phases[-1]))]

    def nodes(name: str) -> Floats:
        return np.concatenate(
            [phase.series[name][:k] for phase, k in zip(phases, kept, strict=True)]
        )

    first = phases[0]
    starts = [phase.start_time + phase.step * np.arange(len(phase.active)) for phase in phases]
    ends = tuple(phase.start_time + phase.step * len(phase.active) for phase in phases)
    return Timeline(
        time=np.concatenate(
            [
                phase.start_time + node_times(phase)[:k]
                for phase, k in zip(phases, kept, strict=True)
            ]
        ),
        nodes={name: nodes(name) for name in NODE_SERIES if name in first.series},
        edges=np.concatenate([*starts, [ends[-1]]]),
        intervals={
            name: np.concatenate([phase.series[name] for phase in phases])
            for name in INTERVAL_SERIES
            if name in first.series
        },
        active=np.concatenate([phase.active for phase in phases]),
        window=np.concatenate([phase.window for phase in phases]),
        forbidden=np.concatenate([phase.forbidden for phase in phases]),
        ends=ends,
    )
