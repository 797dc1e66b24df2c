"""A simulation as a plain record: the runs, their figures, and the settings that made them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxatt.problems.wheel_speeds import longest_stays
from jaxatt.records.wording import plural
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.simulation.campaign import Spread
from jaxatt.simulation.closed_loop import FLYING, NOT_FINITE, TUMBLING, Flown
from jaxatt.simulation.flight_error import FlightError

PERCENTILES = (5.0, 25.0, 50.0, 75.0, 95.0)

ENDINGS = {
    FLYING: "flown to the end",
    TUMBLING: "diverged: the rate grew beyond the limit",
    NOT_FINITE: "not a number: the law or the state stopped being finite",
}


@dataclass(frozen=True, eq=False)
class FlightRecord:
    """Record of one law flown in R runs.

    law : its name in the scenario.  flown : arrays with leading axis R.
    reference : (records, 4), asked attitude q_d.  spread : None for the nominal run.
    flight_error : what half the Runge-Kutta step changes in the nominal run; None where that
    diverges.  notes : words on steps that are too long.
    """

    scenario: FlightScenario
    law: str
    flown: Flown
    reference: Floats
    spread: Spread | None
    seed: int
    time: Mapping[str, float]
    device: str
    versions: Mapping[str, str]
    flight_error: FlightError | None = None
    notes: tuple[str, ...] = ()

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.flown.what)

    @property
    def sound(self) -> Flags:
        """Which runs flew to the end, (R,)."""
        return np.asarray(np.asarray(self.flown.what) == FLYING)

    @property
    def settled(self) -> Flags:
        """Which of the runs that flew to the end settled on every axis, (R,)."""
        axes = np.asarray(self.flown.figures.settling)[:, :3]
        return np.asarray(self.sound & np.isfinite(axes).all(axis=1))

    @property
    def failures(self) -> dict[str, list[int]]:
        """Numbers of the runs that failed, by cause; their figures enter no statistics."""
        what = np.asarray(self.flown.what)
        named = ((ENDINGS[code], np.flatnonzero(what == code).tolist()) for code in ENDINGS if code)
        return {words: rows for words, rows in named if rows}

    @property
    def record_times(self) -> Floats:
        """Times of the records, (records,) [s]."""
        timing = self.scenario.timing
        return np.asarray(np.arange(1, timing.records + 1) * (timing.duration / timing.records))

    @property
    def band_stays(self) -> dict[str, Floats]:
        """Longest stay [s] of any wheel in each band that wheels avoid, (R',) of the sound runs.

        By the speeds of the records, between which they count as linear.
        """
        wheels, timing = self.scenario.vehicle.wheels, self.scenario.timing
        speeds = np.asarray(self.flown.recorded.omega_bw)[self.sound]
        stays = longest_stays(wheels, speeds, timing.duration / timing.records).max(axis=2)
        names = [f"{name} rad/s" for name in wheels.avoid.names]
        return dict(zip(names, stays.T, strict=True))

    def figure(self, name: str) -> Floats:
        """Values of a figure for the runs that flew to the end.

        name : one of `jaxatt.simulation.settling.Figures`, or "settling_worst", the settling time
        of the slowest axis. Not a number where a run never settles.
        """
        rows = self.sound
        if name == "settling_worst":
            return np.asarray(np.max(np.asarray(self.flown.figures.settling)[rows, :3], axis=1))
        return np.asarray(getattr(self.flown.figures, name), float)[rows]

    def __repr__(self) -> str:
        failed = sum(len(rows) for rows in self.failures.values())
        return (
            f"{type(self).__name__}({self.scenario.name}, {self.law}: {plural(self.runs, 'run')}, "
            f"{int(self.settled.sum())} settled, {failed} failed)"
        )
