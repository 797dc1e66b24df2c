"""What a programme over stages asks of a solver, by name, and which solver supports what."""

from __future__ import annotations

from jaxatt.optimize.optimal_control import OptimalControlProgram

PATH_EQUALITY = "path equality"
SOFT_PATH_ROWS = "soft path rows"
PATH_INEQUALITY = "path inequality"
TERMINAL_EQUALITY = "terminal equality"
SOFT_TERMINAL_ROWS = "soft terminal rows"
TERMINAL_INEQUALITY = "terminal inequality"
TERMINAL_COST = "terminal cost"
CONTROL_BOUNDS = "control bounds"
HELD_CONTROLS = "held controls"
FREE_INITIAL_STATE = "free initial state"
MANIFOLD = "manifold"

_ROWS = frozenset({PATH_EQUALITY, PATH_INEQUALITY, TERMINAL_EQUALITY, TERMINAL_INEQUALITY})
_WEIGHTED = _ROWS | {SOFT_PATH_ROWS, SOFT_TERMINAL_ROWS, HELD_CONTROLS, MANIFOLD}

SUPPORTED: dict[str, frozenset[str]] = {
    "interior point": _ROWS | {TERMINAL_COST, CONTROL_BOUNDS, FREE_INITIAL_STATE, MANIFOLD},
    "augmented Lagrangian over stages": _WEIGHTED,
    "reweighting over stages": _WEIGHTED,
}
"""Features that every solver over stages takes into account.

A free final time and free parameters are coordinates of the first state that are free.
"""


def features(program: OptimalControlProgram) -> frozenset[str]:
    """Names of what a programme has."""
    has = {
        PATH_EQUALITY: program.equality is not None,
        SOFT_PATH_ROWS: program.equality_weight is not None,
        PATH_INEQUALITY: program.inequality is not None,
        TERMINAL_EQUALITY: program.final_rows is not None,
        SOFT_TERMINAL_ROWS: program.final_weight is not None,
        TERMINAL_INEQUALITY: program.final_inequality is not None,
        TERMINAL_COST: program.terminal_cost is not None,
        CONTROL_BOUNDS: program.limits is not None,
        HELD_CONTROLS: program.free is not None,
        FREE_INITIAL_STATE: program.free_start > 0,
        MANIFOLD: program.on_manifold,
    }
    return frozenset(name for name, there in has.items() if there)


def refuse(program: OptimalControlProgram, solver: str) -> None:
    """Raise ValueError where a programme has what a solver does not take into account.

    solver : a name of `SUPPORTED`.
    """
    missing = sorted(features(program) - SUPPORTED[solver])
    if not missing:
        return
    complaints = []
    for name in missing:
        able = [f"{other!r}" for other, supported in SUPPORTED.items() if name in supported]
        complaints.append(f"{name} (supported by {', '.join(able) or 'no solver'})")
    raise ValueError(f"the solver {solver!r} does not support: {'; '.join(complaints)}")
