"""The plan of chapter 5 as an answer made by hand, so that its report is tested without a solve."""

from __future__ import annotations

from typing import Any

import numpy as np
from handmade_results import assemble, changed, starts_record

from jaxatt import scenarios
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.record import Energy, NetPower
from jaxatt.records.phase import Phase
from jaxatt.report.result import Result

SOLAR, WHEELS, LAW = 36.0, 0.25, -3.0
"""[W]: of panels in the sun, of wheels, and of the PD law beside a harvest."""
SHADED = (2000.0, 4100.0)
"""[s], between which there is no sun."""


def handmade_plan(scenario: scenarios.Scenario | None = None) -> Result:
    """A plan in which every harvest but the fourth is flown as asked."""
    scenario = scenarios.load("hypso2-orbit") if scenario is None else scenario
    phases = [task_phase(scenario, task) for task in options_of(scenario).tasks]
    if len(phases) > 6:
        phases[6] = changed(
            phases[6], reached=False, failure_reason="the target rate is missed by 2e-3 rad/s"
        )
    return assemble(scenario, *phases)


def task_phase(scenario: scenarios.Scenario, task: Task) -> Phase:
    """A phase of constant powers, dark between the times of `SHADED`."""
    count, step = task.intervals, task.duration / task.intervals
    time = task.start + step * np.arange(count + 1)
    light = ((time < SHADED[0]) | (time > SHADED[1])).astype(float)
    net = SOLAR * light - WHEELS - task.load
    series = _series(count, time, light, net, step)
    law = net + LAW * task.searched
    solar = float(SOLAR * step * light[:-1].sum())
    actuation, loads = WHEELS * task.duration, task.load * task.duration
    base = float(step * law[:-1].sum())
    errors = {"attitude": 1e-4, "rate": 1e-6}
    return Phase(
        family="net-power",
        start_time=task.start,
        step=step,
        controls=series["torque_wheels"],
        series=series,
        reference={},
        errors=errors,
        tolerances={"attitude": task.attitude_tolerance, "rate": task.rate_tolerance},
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"solar energy": -solar, "actuation": actuation, "loads": loads},
        l1_effort=1.0,
        reached=True,
        failure_reason="",
        active=np.ones(count, bool),
        starts=starts_record(),
        section=NetPower(
            energy=Energy(solar, actuation, loads, base, 2.5e5, float(series["charge"].min())),
            claimed=0.0,
            start_energy=np.zeros(6),
            start_score=np.zeros(6),
            share=0.5,
            minima=1,
            refined=6,
            violation=0.0,
            stationarity=0.0,
            shadow=(),
            baseline={"net_power": law, "net_energy": _summed(law, step)},
            baseline_errors=errors,
            task=task.name,
            mode=task.mode,
        ),
    )


def _series(count: int, time: Any, light: Any, net: Any, step: float) -> dict[str, Any]:
    still = np.zeros((count + 1, 3))
    q = np.tile([1.0, 0.0, 0.0, 0.0], (count + 1, 1))
    return {
        "q_ob": q,
        "omega_ob": still,
        "q_ib": q,
        "omega_ib": still + 0.01 * np.sin(0.01 * time)[:, None],
        "omega_bw": np.tile([209.4, 209.4, 209.4, -362.8], (count + 1, 1)),
        "light": light,
        "solar_power": SOLAR * light,
        "actuation_power": np.full(count + 1, WHEELS),
        "net_power": net,
        "net_energy": _summed(net, step),
        "charge": 2.4e5 + _summed(net, step),
        "dipole": still,
        "torque_wheels": np.zeros((count, 4)),
        "torque_body": np.zeros((count, 3)),
    }


def _summed(power: Any, step: float) -> Any:
    return np.concatenate([[0.0], step * np.cumsum(power[:-1])])
