"""Names of the features that programmes may have and solvers may support.

A programme says what it has in its `features`, a solver what it takes into account in `supports`.
"""

from __future__ import annotations

WITHOUT_DYNAMICS = "variables without dynamics"
EQUALITY = "equality"
SOFT_ROWS = "soft rows"
INEQUALITY = "inequality"
STAGE_INEQUALITY = "stage inequality"
HELD_VARIABLES = "held variables"
"""Of a `Program`."""

FEW_VARIABLES = "few variables"
"""Of the functions of `minimize`, with `EQUALITY` and `INEQUALITY`."""

DYNAMICS = "dynamics over stages"
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
"""Of an `OptimalControlProgram`.

A free final time and free parameters are coordinates of the first state that are free.
"""

ROWS_AT_ONCE = "linearised rows of all stages"
ROWS_BY_STAGE = "rows stage by stage"
MAGNITUDE_LIMITS = "limits of magnitudes"
SEPARATE_BOUNDS = "bounds of each control"
ONE_SIDED_ROWS = "one-sided rows"
COUNTED_APART = "controls of a stage counted apart"
EFFORT = "effort"
"""Of a `RootProgram`."""
