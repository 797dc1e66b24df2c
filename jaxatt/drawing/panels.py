"""Draw lines, pulses, limits and references into given axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.spacecraft.wheels import ReactionWheels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUATERNION = ("η", "ε₁", "ε₂", "ε₃")
"""Names of its components, scalar first."""


def lines(axes: Axes, time: Floats, values: Floats, names: Sequence[str]) -> None:
    """Draw one line a component; time : (K,), values : (K, n)."""
    for index, name in enumerate(names):
        axes.plot(time, values[:, index], color=colour(index), linewidth=1.5, label=name)


def references(axes: Axes, start: float, end: float, values: Floats) -> None:
    """Draw dotted targets (n,) of the components from one time to another."""
    for index, value in enumerate(values):
        axes.hlines(value, start, end, colors=colour(index), linestyles="dotted", linewidth=1.4)


def limits(axes: Axes, values: Sequence[float] | Floats) -> None:
    """Draw dashed lines at limits of either sign."""
    for limit in values:
        for sign in (-1.0, 1.0):
            axes.axhline(sign * limit, color="#444444", linewidth=0.8, linestyle=(0, (4, 3)))


def speed_limits(axes: Axes, wheels: ReactionWheels, unit: float) -> None:
    """Draw speed limits of wheels as dashed lines, and the speeds that they avoid as shaded bands.

    unit : of the axis, in which one rad/s is so much.
    """
    most = np.asarray(wheels.speed_limit) * unit
    limits(axes, np.unique(most[np.isfinite(most)]))
    a, b = (np.reshape(side, (-1,)) * unit for side in wheels.avoid.sides)
    for low, high in sorted(set(zip(a.tolist(), b.tolist(), strict=True))):
        axes.axhspan(low, high, facecolor="#B03A2E", alpha=0.12, linewidth=0)


def pulses(
    axes: Axes,
    edges: Floats,
    values: Floats,
    index: int,
    label: str,
    limit: float,
    opacity: float = 0.55,
) -> None:
    """Draw one piecewise constant control as filled steps, with its limits.

    edges : (I + 1,), of the intervals.  values : (I,).
    """
    style: dict[str, Any] = {"color": colour(index), "baseline": 0.0}
    axes.stairs(values, edges, fill=True, alpha=opacity, linewidth=0, **style)
    axes.stairs(values, edges, linewidth=1.4, label=label, **style)
    if np.isfinite(limit):
        limits(axes, [limit])
    # Room for everything, but never so little that noise looks like a manoeuvre.
    widest = max(limit if np.isfinite(limit) else 0.0, float(np.abs(values).max()), 1e-12)
    bottom, top = axes.get_ylim()
    reach = 1.15 * widest
    if index:
        reach = max(reach, abs(bottom), abs(top))
    axes.set_ylim(-reach, reach)


def runs(mask: Flags) -> list[tuple[int, int]]:
    """First index and end of every run of true entries."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(first), int(end)) for first, end in steps.reshape(-1, 2)]
