"""Map of the pairs of intervals from which the target is reached."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour, picture
from jaxatt.problems.hands_off.certificate import CertificateRecord, PhaseCertificate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


def plot(certificate: CertificateRecord) -> Picture:
    """Plot the least effort of the supports that hold two given intervals, a panel a phase."""
    phases = certificate.phases
    figure = picture(5.6 * len(phases), 5.2, certificate.result.scenario.title)
    for index, phase in enumerate(phases):
        axes = figure.add_subplot(1, len(phases), index + 1)
        _pair_map(figure, axes, phase)
        if len(phases) > 1:
            axes.set_title(f"leg {index + 1}")
    return figure


def _pair_map(figure: Picture, axes: Axes, phase: PhaseCertificate) -> None:
    """Draw the short way round above the diagonal and the long way below it."""
    count = len(phase.found.controls)
    least = np.full((count, count), np.inf)
    size = 0
    for record in phase.equal:
        for way, found in ((1, record.short), (-1, record.long)):
            if found is None or record.kind.size == 0:
                continue
            size = max(size, record.kind.size)
            for entry, effort in zip(
                found.groups[found.reached], found.effort[found.reached], strict=True
            ):
                for i, j in _pairs(entry[:, 0]):
                    row, column = (j, i) if way > 0 else (i, j)
                    least[row, column] = min(least[row, column], effort)
    shown = np.ma.masked_invalid(np.where(np.isinf(least), np.nan, 1e3 * least))
    axes.plot([-0.5, count - 0.5], [-0.5, count - 0.5], color="#888888", linewidth=0.8)
    if shown.count():
        image = axes.imshow(shown, origin="lower", cmap="viridis", interpolation="nearest")
        figure.colorbar(image, ax=axes, label="least L1 effort [mN m s]", shrink=0.85)
    else:
        axes.set_xlim(-0.5, count - 0.5)
        axes.set_ylim(-0.5, count - 0.5)
        axes.set_aspect("equal")
        axes.text(0.5, 0.5, _nothing(phase), ha="center", va="center", transform=axes.transAxes)
    if phase.best is not None:
        ordered = [(j, i) if phase.best_long else (i, j) for i, j in _pairs(phase.best[:, 0])]
        style: dict[str, Any] = {"s": 130, "marker": "*", "edgecolor": "black", "zorder": 5}
        x, y = zip(*ordered, strict=True)
        axes.scatter(x, y, color=colour(1), label="least effort", clip_on=False, **style)
        axes.legend(loc="lower center", fontsize=8, framealpha=0.9)
    axes.set_facecolor("#F2F2F2")
    others = f" and {size - 2} more" if size > 2 else ""
    axes.set_xlabel("active interval\nabove the line the short way round, below it the long one")
    axes.set_ylabel(f"second active interval{others}")


def _pairs(intervals: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of different intervals, the earlier first; a lone interval is paired with itself."""
    several = sorted(set(intervals.tolist()))
    return list(itertools.combinations(several, 2)) or [(several[0], several[0])]


def _nothing(phase: PhaseCertificate) -> str:
    if not phase.found.reached:
        return "no answer reaches"
    return "no support was tried" if not any(r.tried for r in phase.equal) else "none reaches"
