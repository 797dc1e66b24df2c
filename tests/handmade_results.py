"""Results made by hand, so that reporting and the command line are tested without a solve."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from jaxatt import scenarios
from jaxatt.problems.hands_off.record import SparseSection
from jaxatt.problems.time_optimal.record import TimeOptimum
from jaxatt.problems.time_optimal.switches import switch_times
from jaxatt.records.phase import Phase
from jaxatt.records.starts import StartsRecord
from jaxatt.report.result import Result

ACTIVE = (0, 20, 49)


def starts_record(count: int = 6) -> StartsRecord:
    index = np.arange(count)
    return StartsRecord(
        status=index % 5,
        reached=index % 2 == 0,
        active_intervals=2 + index,
        effort=1e-3 * (1.0 + index),
        long_way=index == 4,
        iterations=10 * index,
        shortfall=0.5 + 1.0 * index,
        distinct_minima=2,
    )


def spacecraft_phase(scenario: scenarios.Scenario, index: int = 0, **changes: Any) -> Phase:
    """A phase that turns about x and fires in the intervals of `ACTIVE`."""
    horizon, target = scenario.horizon, scenario.targets[index]
    count, nodes = horizon.intervals, horizon.intervals + horizon.coast_intervals + 1
    assert scenario.vehicle is not None
    torque = np.zeros((count, 3))
    torque[list(ACTIVE), 0] = (1e-3, -2e-3, 1e-3)
    half = 0.5 * np.minimum(1.0, np.arange(nodes) / count)
    rolled = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)
    angle = scenario.waypoint is not None
    phase = Phase(
        family="hands-off",
        start_time=index * horizon.duration,
        step=horizon.step,
        controls=torque,
        series={
            "q_ob": rolled,
            "omega_ob": np.full((nodes, 3), 0.01),
            "omega_ib": np.full((nodes, 3), 0.02),
            "omega_bw": np.linspace(0.0, 50.0, 4 * nodes).reshape(nodes, 4),
            "torque_body": torque,
            "torque_wheels": torque @ np.asarray(scenario.vehicle.wheels.allocation).T,
        },
        reference={"q_ob": target.q_ob, "omega_ob": target.omega_ob},
        errors={"attitude": math.radians(0.005), "rate": 1e-6}
        | ({"waypoint": math.radians(0.05)} if angle else {}),
        tolerances={"attitude": target.attitude_tolerance, "rate": target.rate_tolerance}
        | ({"waypoint": 0.1} if angle else {}),
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"rate": 1.0, "attitude": 2.0, "sparsity": 20.0},
        l1_effort=5.6e-3,
        reached=True,
        failure_reason="",
        active=np.abs(torque).max(axis=1) > 1e-6,
        starts=starts_record(),
        section=SparseSection(
            weight=scenarios.window_weights(scenario),
            window=scenarios.window_mask(scenario),
            forbidden=scenarios.forbidden_mask(scenario),
            max_complementarity=1e-8,
        ),
    )
    return changed(phase, **changes)


def changed(phase: Phase, **changes: Any) -> Phase:
    """A phase with other values of its own fields and of its section's."""
    own = {field.name for field in dataclasses.fields(phase.section)}
    section = {name: value for name, value in changes.items() if name in own}
    rest = {name: value for name, value in changes.items() if name not in own}
    return dataclasses.replace(phase, section=dataclasses.replace(phase.section, **section), **rest)


def toy_phase(scenario: scenarios.Scenario) -> Phase:
    """A phase of the double integrator."""
    count = scenario.horizon.intervals
    control = np.zeros((count, 1))
    control[:10] = -1.0
    return Phase(
        family="toy",
        start_time=0.0,
        step=scenario.horizon.step,
        controls=control,
        series={"state": np.ones((count + 1, 2)), "control": control},
        reference={"state": np.zeros(2)},
        errors={"state": 1e-8},
        tolerances={"state": 1e-6},
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"sparsity": 10.0},
        l1_effort=0.5,
        reached=True,
        failure_reason="",
        active=np.abs(control[:, 0]) > 0,
        starts=starts_record(),
        section=SparseSection(
            weight=np.ones(count),
            window=np.zeros(count, bool),
            forbidden=np.zeros(count, bool),
            max_complementarity=1e-6,
        ),
    )


def assemble(scenario: scenarios.Scenario, *phases: Phase) -> Result:
    return Result(
        scenario=scenario,
        phases=phases,
        seed=7,
        time={"compile": 1.5, "solve": 2.5, "verify": 0.25},
        device="cpu",
        precision="float64",
        versions={"jaxatt": "0.1.0"},
        notes=("a note",),
    )


def handmade(name: str = "hypso1-90-45-15", **changes: Any) -> Result:
    """Result of a bundled scenario; keyword arguments change every phase of a spacecraft."""
    scenario = scenarios.load(name)
    if scenario.vehicle is None:
        return assemble(scenario, toy_phase(scenario))
    phases = [spacecraft_phase(scenario, i, **changes) for i in range(len(scenario.targets))]
    return assemble(scenario, *phases)


def resting() -> Result:
    """A penalty answer that does nothing, with another that reaches."""
    scenario = scenarios.replace(scenarios.load("hypso1-45-0-0"), {"objective.terminal": "penalty"})
    count = scenario.horizon.intervals
    phase = spacecraft_phase(
        scenario,
        active=np.zeros(count, bool),
        controls=np.zeros((count, 3)),
        objective={"rate": 0.0, "attitude": 7.612, "sparsity": 0.0},
        reached=False,
        failure_reason="the target attitude is missed",
        alternative=spacecraft_phase(
            scenario, objective={"rate": 0.0, "attitude": 0.0, "sparsity": 20.0}
        ),
    )
    return assemble(scenario, phase)


def timed(case: str | scenarios.Scenario = "mrp-k4", step: float = 0.7) -> Result:
    """Result of a turn in minimum time: bang-bang about the target's axis, rolled along it."""
    scenario = scenarios.load(case) if isinstance(case, str) else case
    horizon, target, vehicle = scenario.horizon, scenario.targets[0], scenario.vehicle
    assert vehicle is not None
    count, wheels = horizon.intervals, vehicle.wheels.count
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    turned = share * 2.0 * np.arccos(target.q_ob[0])
    axis = target.q_ob[1:] / np.linalg.norm(target.q_ob[1:])
    torque = np.full((count, vehicle.actuators), 0.0)
    torque[: count // 2, 0], torque[count // 2, 0], torque[count // 2 + 1 :, 0] = 0.55, 0.11, -0.55
    series = {
        "q_ob": np.concatenate([np.cos(turned / 2), np.sin(turned / 2) * axis], axis=1),
        "omega_ob": np.full((count + 1, 3), 0.01),
        "omega_ib": np.full((count + 1, 3), 0.01),
        "omega_bw": np.full((count + 1, wheels), 20.0),
    }
    if wheels:
        series["torque_wheels"] = torque[:, :wheels]
        series["torque_body"] = torque[:, :wheels] @ np.asarray(vehicle.wheels.axes).T
    if vehicle.thrusters.count:
        series["torque_thrusters"] = torque[:, wheels:]
    limit = np.full(vehicle.actuators, 0.55)
    record = starts_record()
    cost = np.array([25.0, 24.5, 24.5, 82.0, math.nan, 24.5])
    phase = Phase(
        family="time-optimal",
        start_time=0.0,
        step=step,
        controls=torque,
        series=series,
        reference={"q_ob": target.q_ob, "omega_ob": target.omega_ob},
        errors={"attitude": math.radians(0.1), "rate": 1e-9},
        tolerances={"attitude": target.attitude_tolerance, "rate": target.rate_tolerance},
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"time": step * count, "effort": 0.5},
        l1_effort=12.0,
        reached=True,
        failure_reason="",
        active=np.abs(torque).max(axis=1) > 0.0,
        starts=record,
        section=TimeOptimum(
            effort_weight=scenario.objective.effort_weight,
            cost=step * count + 0.5,
            actuators=tuple(f"wheel {i + 1}" for i in range(wheels))
            + tuple(f"thruster {i + 1}" for i in range(vehicle.thrusters.count)),
            switch_times=switch_times(torque, step * np.arange(count + 1.0), -limit, limit),
            torque_share=float((np.abs(torque) / limit).max()),
            violation=1e-10,
            stationarity=1e-8,
            minima=3,
            share=0.5,
            own_error=1e-9,
            start_costs=cost,
            start_times=cost - 0.5,
            attitude=scenario.transcription.attitude,
            integration=scenario.transcription.integration,
        ),
    )
    return assemble(scenario, phase)
