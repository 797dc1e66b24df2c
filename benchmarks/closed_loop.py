"""Simulated seconds a second: closed-loop runs of the package beside Basilisk.

    python -m benchmarks.closed_loop [--runs 1000] [--repeats 5]

The same vehicle (body, four wheels, two-body orbit, gravity gradient), the same Runge-Kutta step of
0.02 s.  Basilisk flies open loop, one run in one process, which is how its users run it; the
package flies 1000 runs at once under a PD law sampled every step, with statistics.  The two take
turns, so that whatever else the machine does disturbs both; the best of each is printed.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from jaxatt.attitude import quaternion  # noqa: E402
from jaxatt.environment import frames, kepler  # noqa: E402
from jaxatt.problems.surroundings import elements_of  # noqa: E402
from jaxatt.scenarios import load_flight, replace_in_flight  # noqa: E402
from jaxatt.scenarios.flight_build import build_flight  # noqa: E402
from jaxatt.simulation.campaign import fly_runs  # noqa: E402

STEP, DURATION = 0.02, 60.0


def flight() -> jaxatt.scenarios.FlightScenario:
    """HYPSO-1 on its orbit with the gravity gradient only."""
    return replace_in_flight(
        load_flight("hypso1-pointing"),
        {
            "noise": None,
            "dumping": None,
            "environment": {"gravity_gradient": True},
            "vehicle.magnetorquers": None,
            "simulation.duration_s": DURATION,
            "simulation.records": 60,
        },
    )


def main() -> None:
    """Measure both and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
    from references import basilisk_flight

    case = flight()
    shared, start = build_flight(case)
    law, orbit, initial, craft = (
        case.laws["pd"],
        case.surroundings.orbit,
        case.initial,
        case.vehicle,
    )
    r_i, v_i = kepler.to_state(elements_of(orbit), orbit.gravitational_parameter)
    q_ib = quaternion.multiply(frames.quaternion_io(r_i, v_i), initial.q_ob)
    other = basilisk_flight.Case(
        np.asarray(craft.inertia),
        np.asarray(craft.wheels.axes),
        2.1e-4,
        np.asarray(q_ib),
        np.array([0.01, -0.02, 0.005]),
        initial.omega_bw,
        np.asarray(r_i),
        np.asarray(v_i),
        orbit.gravitational_parameter,
        np.array([1e-4, -5e-5, 2e-5, 0.0]),
        STEP,
        DURATION,
    )

    def ours() -> float:
        began = time.perf_counter()
        fly_runs(shared, start, law, arguments.runs, 0, case.spread)
        return arguments.runs * DURATION / (time.perf_counter() - began)

    def theirs() -> float:
        sim, _, kept = basilisk_flight.prepare(other)
        began = time.perf_counter()
        sim.ExecuteSimulation()
        seconds = time.perf_counter() - began
        del kept
        return DURATION / seconds

    began = time.perf_counter()
    ours()
    first = time.perf_counter() - began
    pairs = [(ours(), theirs()) for _ in range(arguments.repeats)]
    mine, other_side = (max(column) for column in zip(*pairs, strict=True))
    ratios = sorted(a / b for a, b in pairs)
    print(f"{arguments.runs} runs of {DURATION:g} s in steps of {STEP:g} s")
    print(f"jaxatt     {mine:12.0f} simulated seconds a second (first call {first:.1f} s)")
    print(f"Basilisk   {other_side:12.0f} simulated seconds a second, one run in one process")
    print(
        f"ratio      {mine / other_side:12.0f} of the best, {ratios[len(ratios) // 2]:.0f} median"
    )


if __name__ == "__main__":
    main()
