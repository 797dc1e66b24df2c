"""The PD law on all phases of a scenario, judged like an optimised answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import jax
import numpy as np

from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.pd_flight import flown_controls, fly_pd
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Flags


@dataclass(frozen=True, eq=False)
class FlownPD:
    """Result of one phase under the PD law.

    active : (N,), intervals with a mean torque that counts as more than zero.
    errors : name -> number, as in `jaxatt.records.phase.Phase`.
    l1_effort : L1 effort of the mean body torques [N m s].  cost : the printed cost.
    """

    active: Flags
    errors: Mapping[str, float]
    l1_effort: float
    cost: float
    reached: bool


def fly_pd_phases(scenario: Scenario, clipped: bool = True) -> tuple[FlownPD, ...]:
    """Fly the PD law (5.8) of Schaanning (2021) on every phase, each from where the last one ended.

    clipped : whether each wheel's torque is held within its limit.
    """
    if scenario.vehicle is None:
        raise ValueError(f"{scenario.name}: the PD law is for spacecraft, not {scenario.system}")
    phases: list[FlownPD] = []
    initial_state: InitialState | None = None
    for index in range(len(scenario.targets)):
        # Path limits are left out, which the law does not know of.
        task = build_slew(scenario, index, initial_state).ignoring_path_limits()
        flown = fly_pd(task, clipped)
        end = task.intervals
        initial_state = InitialState(
            *(np.asarray(part[end]) for part in (flown.q_ob, flown.omega_ob, flown.omega_bw))
        )
        controls = flown_controls(task, flown)[None]
        batch = jax.tree.map(lambda leaf: leaf[None], flown)
        verdict, cost = task.judge(batch, controls), task.cost(batch, controls)
        phases.append(
            FlownPD(
                active=np.any(task.active(controls[0]), axis=1),
                errors={name: float(error[0]) for name, error in verdict.errors.items()},
                l1_effort=float(task.l1_effort(controls)[0]),
                cost=float(sum(part[0] for part in cost.values())),
                reached=bool(
                    all(error[0] <= verdict.tolerances[n] for n, error in verdict.errors.items())
                ),
            )
        )
    return tuple(phases)
