"""Simulate the runs of a flight."""

from __future__ import annotations

import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt import scenarios
from jaxatt.control.feedback import FeedbackLaw
from jaxatt.environment.table import tabulate
from jaxatt.pipeline.solve import solve, versions
from jaxatt.pipeline.step_check import check_steps
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.tables.manoeuvre import MOST_SEED
from jaxatt.problems.surroundings import surroundings_of
from jaxatt.report.flight_result import FlightResult
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.clock import compile_seconds
from jaxatt.scenarios.catalog import load_flight
from jaxatt.scenarios.flight_build import Plan, build_flight
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.scenarios.flight_schema import MOST_RUNS
from jaxatt.simulation.campaign import Spread, fly_runs
from jaxatt.simulation.flight import fly_torque

_FINE = 4  # Runge-Kutta steps a sample, when a plan is flown for its reference


def simulate(
    flight: FlightScenario | str | Path,
    law: str | FeedbackLaw | None = None,
    *,
    runs: int | None = None,
    seed: int | None = None,
    spread: Spread | None = None,
    plan: Plan | None = None,
    report: Report | None = None,
) -> FlightResult:
    """Fly a law of a flight, or a law of your own, in one run or in a campaign.

    flight : a `FlightScenario`, the name of a bundled one or a TOML file.
    law : name in the file (the first by default), or any callable law.
    runs : None for the nominal run; else that many runs, with the file's spread.  Run i depends on
    the seed and on i only.  spread : replaces the file's.
    plan : replaces the optimised manoeuvre that the file names.
    report : called by the host with (stage, runs ended).

    Raises `ScenarioError` (a `ValueError`) where the flight does not make sense.
    """
    if jnp.result_type(float) != jnp.float64:
        raise ValueError(
            "jax_enable_x64 is off: flights need 64-bit floats; call jaxatt.configure() before "
            "the first use of JAX"
        )
    if not isinstance(flight, FlightScenario):
        flight = load_flight(flight)
    name, chosen = _law(flight, law)
    if plan is None and flight.asked.manoeuvre:
        plan = plan_of(flight, report)
    began, compiled = time.perf_counter(), compile_seconds()
    shared, start = build_flight(flight, plan)
    count = 1 if runs is None else runs
    number = flight.seed if seed is None else seed
    for key, value, least, most in (("runs", count, 1, MOST_RUNS), ("seed", number, 0, MOST_SEED)):
        if not least <= value <= most:
            raise ValueError(f"{key} = {value}: must be at least {least} and at most {most}")
    drawn = (spread or flight.spread) if runs is not None else None
    progress = None if report is None else (lambda done: report("flying", done))
    flown = fly_runs(shared, start, chosen, count, number, drawn, progress)
    nominal = flown if drawn is None else fly_runs(shared, start, chosen, 1, number, alike=count)
    error, notes = check_steps(flight, chosen, nominal, number, plan)
    total = time.perf_counter() - began
    compiling = compile_seconds() - compiled
    return FlightResult(
        scenario=flight,
        law=name,
        flown=flown,
        reference=np.asarray(shared.ends[1].attitude.array),
        spread=drawn,
        seed=number,
        time={"compile": compiling, "simulate": max(0.0, total - compiling)},
        device=str(jax.devices()[0].device_kind),
        versions=versions(),
        flight_error=error,
        notes=notes,
    )


def _law(flight: FlightScenario, law: str | FeedbackLaw | None) -> tuple[str, FeedbackLaw]:
    if law is None:
        law = next(iter(flight.laws))
    if not isinstance(law, str):
        return type(law).__name__, law
    if law not in flight.laws:
        raise ScenarioError(
            f"{flight.origin}: [laws.{law}]: there is no such law; there are: "
            f"{', '.join(flight.laws)}"
        )
    return law, flight.laws[law]


def plan_of(flight: FlightScenario, report: Report | None = None) -> Plan:
    """Solve the manoeuvre that a flight follows, and sample its answer at the flight's instants.

    Raises `ScenarioError` where the sampling period does not divide the manoeuvre's intervals, or
    the manoeuvre does not reach its target.
    """
    scenario = scenarios.load(flight.asked.manoeuvre)
    where = f'{flight.origin}: [reference] manoeuvre = "{flight.asked.manoeuvre}"'
    if scenario.horizon.free:
        raise ScenarioError(
            f"{where}: its final time is free, so its intervals need not be a multiple of "
            "sampling_s; name a manoeuvre with a fixed final time"
        )
    if scenario.vehicle is None or len(scenario.targets) > 1:
        raise ScenarioError(f"{where}: only a spacecraft's single manoeuvre can be followed")
    task = build_slew(scenario)
    period = flight.timing.sampling
    each = round(task.step / period)
    if each < 1 or abs(each * period - task.step) > 1e-9:
        raise ScenarioError(
            f"{where}: its intervals of {task.step:g} s are no multiple of sampling_s = {period:g};"
            " choose a sampling period that divides them"
        )
    result = solve(scenario, report=report)
    if not result.reached:
        raise ScenarioError(
            f"{where}: its answer does not reach the target; {result.phases[0].failure_reason}"
        )
    wheels = np.repeat(result.phases[0].series["torque_wheels"], each, axis=0)
    table = tabulate(surroundings_of(scenario), 0.0, period, len(wheels), _FINE)
    flown = jax.jit(fly_torque)(task.craft, task.start, jnp.asarray(wheels), table)
    body = wheels @ np.asarray(task.craft.wheels.axes).T
    return Plan(np.asarray(flown.q_ob), np.asarray(flown.omega_ob), body)
