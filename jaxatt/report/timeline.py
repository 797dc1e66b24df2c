"""The legs of a result, one after another on one time axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.report.result import Flags, Floats, Leg, Result

NODE_SERIES = ("q_ob", "omega_ob", "omega_ib", "omega_bw", "state")
INTERVAL_SERIES = ("torque_body", "torque_wheels", "torque_thrusters", "control")


@dataclass(frozen=True, eq=False)
class Timeline:
    """What was flown, with K nodes and I intervals over all legs.

    time : (K,) [s].  nodes : name -> (K, ...).  edges : (I + 1,) [s].
    intervals : name -> (I, ...).  active, window, forbidden : (I,).
    ends : [s], end of each leg's horizon.
    """

    time: Floats
    nodes: Mapping[str, Floats]
    edges: Floats
    intervals: Mapping[str, Floats]
    active: Flags
    window: Flags
    forbidden: Flags
    ends: tuple[float, ...]


def node_times(leg: Leg) -> Floats:
    """Times of a leg's nodes from the leg's start, (M,) [s], the coasting tail included."""
    count = max(len(leg.series[name]) for name in NODE_SERIES if name in leg.series)
    return np.asarray(leg.step * np.arange(count))


def timeline(result: Result) -> Timeline:
    """Join the legs; a leg's coasting tail is kept only where no other leg follows."""
    legs = result.legs
    kept = [len(leg.active) for leg in legs[:-1]] + [len(node_times(legs[-1]))]

    def nodes(name: str) -> Floats:
        return np.concatenate([leg.series[name][:k] for leg, k in zip(legs, kept, strict=True)])

    first = legs[0]
    starts = [leg.start_time + leg.step * np.arange(len(leg.active)) for leg in legs]
    ends = tuple(leg.start_time + leg.step * len(leg.active) for leg in legs)
    return Timeline(
        time=np.concatenate(
            [leg.start_time + node_times(leg)[:k] for leg, k in zip(legs, kept, strict=True)]
        ),
        nodes={name: nodes(name) for name in NODE_SERIES if name in first.series},
        edges=np.concatenate([*starts, [ends[-1]]]),
        intervals={
            name: np.concatenate([leg.series[name] for leg in legs])
            for name in INTERVAL_SERIES
            if name in first.series
        },
        active=np.concatenate([leg.active for leg in legs]),
        window=np.concatenate([leg.window for leg in legs]),
        forbidden=np.concatenate([leg.forbidden for leg in legs]),
        ends=ends,
    )
