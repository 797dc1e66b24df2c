"""Result of `solve_program`: the best answer, all starts, and a finer flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.status import Status
from jaxatt.runtime.arrays import Floats

_SHOWN = 8


@dataclass(frozen=True)
class ProgramMultipliers:
    """Multipliers at the best answer: decrease of the objective if a row is relaxed by one.

    path_equality : (N, q) and terminal_equality : (r,), of any sign: derivatives of the objective
    by the rows.  The others are not negative, and zero where the row is not at its limit:
    path_inequality : (N, p), the programme's own rows and then the states' lower and upper bounds;
    terminal_inequality : (t,), own rows, the states' bounds, those of the free parameters and those
    of the final time, as shares of it; control_lower, control_upper : (N, b).
    """

    path_equality: Floats
    path_inequality: Floats
    terminal_equality: Floats
    terminal_inequality: Floats
    control_lower: Floats
    control_upper: Floats


@dataclass(frozen=True)
class FinerFlight:
    """The best controls flown from the first state with finer integration steps.

    factor : how many times as many steps; 0 where the programme has no finer ones, so that its own
    dynamics are flown.  states : (N + 1, s).  end_error : largest error of the last state
    against the answer's.  terminal_violation : largest violation of the terminal rows there.
    """

    factor: int
    states: Floats
    end_error: float
    terminal_violation: float


@dataclass(frozen=True)
class ProgramStartsRecord:
    """Outcome of every start; leading axis S.  Fields as in `ProgramSolution`."""

    status: npt.NDArray[np.int64]
    objective: Floats
    violation: Floats
    stationarity: Floats
    iterations: npt.NDArray[np.int64]
    final_time: Floats


@dataclass(frozen=True)
class ProgramSolution:
    """Result of `solve_program`.

    status : `Status` of the best start.  objective : its value.  violation : largest of dynamics,
    rows and bounds.  stationarity : scaled residual of the other first-order conditions.
    times : (N + 1,) [s].  states : (N + 1, s).  controls : (N, b), each held for an interval.
    final_time : [s].  free_parameters : (m,).
    minima : objectives of distinct minima among the converged starts and how many starts ended in
    each, best first.  compile_s, run_s : [s].
    """

    status: Status
    objective: float
    violation: float
    stationarity: float
    iterations: int
    times: Floats
    states: Floats
    controls: Floats
    final_time: float
    free_parameters: Floats
    multipliers: ProgramMultipliers
    flight: FinerFlight
    minima: tuple[tuple[float, int], ...]
    starts: ProgramStartsRecord
    compile_s: float
    run_s: float

    @property
    def share_at_best(self) -> float:
        """Share of all starts that ended in the best minimum."""
        return self.minima[0][1] / len(self.starts.status) if self.minima else 0.0

    def __repr__(self) -> str:
        count = len(self.starts.status)
        tally = np.bincount(self.starts.status, minlength=len(Status))
        ended = ", ".join(f"{tally[s]} {s.name}" for s in Status if tally[s])
        found = ", ".join(f"{value:.8g} x{times}" for value, times in self.minima[:_SHOWN])
        more = len(self.minima) - _SHOWN
        rows = [
            ("objective", f"{self.objective:.10g}"),
            ("final time", f"{self.final_time:.10g} s"),
            ("free parameters", np.array2string(self.free_parameters, precision=8)),
            ("violation", f"{self.violation:.3g}"),
            ("stationarity", f"{self.stationarity:.3g}"),
            ("iterations", f"{self.iterations}"),
            (
                "flown finer",
                f"{self.flight.factor} x as many steps: end off by {self.flight.end_error:.3g}, "
                f"terminal rows by {self.flight.terminal_violation:.3g}",
            ),
            ("starts", f"{count}: {ended}"),
            ("minima", (found or "none") + (f", {more} more" if more > 0 else "")),
            ("at the best", f"{100.0 * self.share_at_best:.0f} % of the starts"),
            ("time", f"{self.compile_s:.1f} s to compile, {self.run_s:.2f} s to run"),
        ]
        if not len(self.free_parameters):
            rows = [row for row in rows if row[0] != "free parameters"]
        if not self.flight.factor:
            rows = [row for row in rows if row[0] != "flown finer"]
        lines = [f"  {name:<16} {value}" for name, value in rows]
        return "\n".join([f"{self.status.name}: {self.status.meaning}", *lines])
