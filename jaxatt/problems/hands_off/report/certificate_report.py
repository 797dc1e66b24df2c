"""Text, numbers and figure of a certificate."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import Picture, colour, picture
from jaxatt.problems.hands_off.certificate import CertificateRecord, ClassRecord, PhaseCertificate
from jaxatt.records.wording import indices_text, plural, short

if TYPE_CHECKING:
    import xarray

_LARGE = 1e15


def sentences(certificate: CertificateRecord) -> list[str]:
    """Sentences on what was shown, what was only tried, and what is out of reach."""
    several = len(certificate.phases) > 1
    found = []
    for number, phase in enumerate(certificate.phases, start=1):
        where = f"Leg {number}: " if several else ""
        found += [where + sentence for sentence in _phase_sentences(phase)]
    return found


def _phase_sentences(phase: PhaseCertificate) -> list[str]:
    if not phase.found.reached:
        return ["No answer reaches the target, so there is nothing to certify."]
    told = []
    tried = [record for record in phase.cheaper if record.tried]
    left = [record for record in phase.cheaper if not record.tried]
    many = plural(sum(record.kind.number for record in tried), "cheaper support")
    if phase.refuted:
        cheaper = sum(int(record.reached.sum()) for record in tried)
        told.append(
            f"Not minimal: {plural(cheaper, 'support')} that cost less reach the target in the "
            "roll-out; solve again from more starts."
        )
    elif phase.minimal:
        told.append(
            f"Minimal, shown numerically: none of the {many} reaches "
            "the target, the short or the long way round, from rest or from random torques."
        )
    elif not phase.consistent:
        told.append(
            f"Nothing is shown: {many} were tried and none reaches, but neither does the answer's "
            "own support, which flies; the trials are not to be trusted here."
        )
    elif tried:
        told.append(
            f"None of {many} tried reaches the target; minimality is "
            "not shown, because others are out of reach."
        )
    if left:
        told.append(
            f"Out of reach: {_many(sum(r.kind.number for r in left))} cheaper supports, about "
            f"{_duration(sum(r.seconds for r in left))}."
        )
    equal = [record for record in phase.equal if record.tried]
    if equal:
        reached = sum(int(record.reached.sum()) for record in equal)
        total = sum(record.kind.number for record in equal)
        told.append(f"{reached} of {_many(total)} supports that cost as much reach the target.")
    for record in phase.equal:
        if not record.tried:
            told.append(
                f"Not tried: the {_many(record.kind.number)} supports of {record.kind.size} that "
                f"cost as much, about {_duration(record.seconds)}."
            )
    if phase.best is not None and phase.best_effort is not None:
        same = phase.best_effort >= phase.found.effort * (1.0 - 1e-6)
        way = ", the long way round" if phase.best_long else ""
        effort = f"{short(phase.best_effort)} N m s,"
        told.append(
            f"The least L1 effort among them has {_where(phase)}{way}: {effort}"
            + (
                " the answer's own effort."
                if same
                else f" less than the answer's {short(phase.found.effort)}."
            )
        )
    return told


def _where(phase: PhaseCertificate) -> str:
    assert phase.best is not None
    return "intervals " + indices_text(sorted(set(phase.best[:, 0].tolist())))


def _many(number: int) -> str:
    return f"{number}" if number < _LARGE else f"{float(number):.3g}"


def _duration(seconds: float) -> str:
    for unit, size in (("years", 3.15576e7), ("days", 86400.0), ("hours", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.2g} s"


def table(certificate: CertificateRecord) -> Table:
    """Table with one row a class of supports."""
    grid = Table(
        title=Text(f"Certificate for {certificate.result.scenario.title}", style="bold"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
    )
    several = len(certificate.phases) > 1
    names = ("leg",) if several else ()
    for name in (*names, "active", "cost", "supports", "reach, short", "reach, long", "time [s]"):
        grid.add_column(Text(name), justify="right")  # rich would read "[s]" as a style
    for number, phase in enumerate(certificate.phases, start=1):
        for record in (*phase.cheaper, *phase.equal):
            first = (str(number),) if several else ()
            grid.add_row(*(Text(cell) for cell in (*first, *_cells(record))))
    return grid


def _cells(record: ClassRecord) -> tuple[str, ...]:
    kind = record.kind
    label = str(kind.size)
    if len(kind.weights) > 1:
        parts = zip(kind.counts, kind.weights, strict=True)
        label += " (" + " + ".join(f"{c} of weight {short(w)}" for c, w in parts if c) + ")"
        label = label.removesuffix(" ()")
    unknown = "" if record.tried else "not tried"
    ways = [
        unknown if way is None else str(int(way.reached.sum()))
        for way in (record.short, record.long)
    ]
    time = short(record.seconds, 2) if record.tried else f"about {_duration(record.seconds)}"
    return label, short(kind.cost), _many(kind.number), *ways, time


def to_dict(certificate: CertificateRecord) -> dict[str, Any]:
    """Plain numbers, ready for JSON."""
    result = certificate.result
    return {
        "scenario": result.scenario.name,
        "objective": result.scenario.objective.kind,
        "minimal": certificate.minimal,
        "sentences": sentences(certificate),
        "legs": [_phase_numbers(phase) for phase in certificate.phases],
        "seed": result.seed,
        "device": result.device,
        "versions": dict(result.versions),
    }


def _phase_numbers(phase: PhaseCertificate) -> dict[str, Any]:
    return {
        "active_intervals": phase.found.active_intervals,
        "active_interval_indices": np.flatnonzero(phase.found.active).tolist(),
        "weighted_cost": phase.found_cost,
        "l1_effort_Nms": phase.found.effort,
        "minimal": phase.minimal,
        "classes": [
            {
                "active": record.kind.size,
                "cost": record.kind.cost,
                "supports": record.kind.number if record.kind.number < _LARGE else None,
                "tried": record.tried,
                "reach_short_way": None
                if record.short is None
                else int(record.short.reached.sum()),
                "reach_long_way": None if record.long is None else int(record.long.reached.sum()),
                "time_s": record.seconds,
            }
            for record in (*phase.cheaper, *phase.equal)
        ],
        "best_support": None if phase.best is None else phase.best[:, 0].tolist(),
        "best_l1_effort_Nms": phase.best_effort,
        "best_long_way": phase.best_long,
    }


def to_dataset(certificate: CertificateRecord) -> xarray.Dataset:
    """Return every support that was tried, both ways round, as a Dataset.

    Dimensions "support" and "slot"; `interval` and `group` are -1 in slots that a support does not
    use.
    """
    import xarray

    rows: dict[str, list[Any]] = {name: [] for name in ("leg", "cost", "way", "reached")}
    effort, residual, groups = [], [], []
    for number, phase in enumerate(certificate.phases):
        for record in (*phase.cheaper, *phase.equal):
            for way, found in ((1, record.short), (-1, record.long)):
                if found is None:
                    continue
                count = len(found.reached)
                rows["leg"] += [number] * count
                rows["cost"] += [record.kind.cost] * count
                rows["way"] += [way] * count
                rows["reached"] += found.reached.tolist()
                effort.append(found.effort)
                residual.append(found.residual)
                groups += list(found.groups)
    slots = max((len(entry) for entry in groups), default=0)
    filled = np.full((len(groups), slots, 2), -1)
    for index, entry in enumerate(groups):
        filled[index, : len(entry)] = entry
    empty = np.zeros(0)
    return xarray.Dataset(
        {
            "interval": (("support", "slot"), filled[..., 0]),
            "group": (("support", "slot"), filled[..., 1]),
            "leg": ("support", np.asarray(rows["leg"], int)),
            "weighted_cost": ("support", np.asarray(rows["cost"], float)),
            "way_round": ("support", np.asarray(rows["way"], int), {"values": "1 short, -1 long"}),
            "reached": ("support", np.asarray(rows["reached"], bool)),
            "l1_effort": ("support", np.concatenate([empty, *effort]), {"units": "N m s"}),
            "residual": ("support", np.concatenate([empty, *residual]), {"units": "rad"}),
        },
        attrs={
            "scenario": certificate.result.scenario.name,
            "text": " ".join(sentences(certificate)),
        },
    )


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
