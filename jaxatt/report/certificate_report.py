"""A certificate in words, numbers and a picture."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.report.figure import Picture, colour, picture
from jaxatt.report.wording import indices_text, plural, short

if TYPE_CHECKING:
    import xarray

    from jaxatt.pipeline.certify import Certificate, ClassRecord, LegCertificate

_LARGE = 1e15


def sentences(certificate: Certificate) -> list[str]:
    """What was shown, what was only tried, and what is out of reach."""
    several = len(certificate.legs) > 1
    found = []
    for number, leg in enumerate(certificate.legs, start=1):
        where = f"Leg {number}: " if several else ""
        found += [where + sentence for sentence in _leg_sentences(leg)]
    return found


def _leg_sentences(leg: LegCertificate) -> list[str]:
    if not leg.found.reached:
        return ["No answer reaches the target, so there is nothing to certify."]
    told = []
    tried = [record for record in leg.cheaper if record.tried]
    left = [record for record in leg.cheaper if not record.tried]
    many = plural(sum(record.kind.number for record in tried), "cheaper support")
    if leg.refuted:
        cheaper = sum(int(record.reached.sum()) for record in tried)
        told.append(
            f"Not minimal: {plural(cheaper, 'support')} that cost less reach the target in the "
            "roll-out; solve again from more starts."
        )
    elif leg.minimal:
        told.append(
            f"Minimal, shown numerically: none of the {many} reaches "
            "the target, the short or the long way round, from rest or from random torques."
        )
    elif not leg.consistent:
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
    equal = [record for record in leg.equal if record.tried]
    if equal:
        reached = sum(int(record.reached.sum()) for record in equal)
        total = sum(record.kind.number for record in equal)
        told.append(f"{reached} of {_many(total)} supports that cost as much reach the target.")
    for record in leg.equal:
        if not record.tried:
            told.append(
                f"Not tried: the {_many(record.kind.number)} supports of {record.kind.size} that "
                f"cost as much, about {_duration(record.seconds)}."
            )
    if leg.best is not None and leg.best_effort is not None:
        same = leg.best_effort >= leg.found.effort * (1.0 - 1e-6)
        way = ", the long way round" if leg.best_long else ""
        effort = f"{short(leg.best_effort)} N m s,"
        told.append(
            f"The least L1 effort among them has {_where(leg)}{way}: {effort}"
            + (
                " the answer's own effort."
                if same
                else f" less than the answer's {short(leg.found.effort)}."
            )
        )
    return told


def _where(leg: LegCertificate) -> str:
    assert leg.best is not None
    return "intervals " + indices_text(sorted(set(leg.best[:, 0].tolist())))


def _many(number: int) -> str:
    return f"{number}" if number < _LARGE else f"{float(number):.3g}"


def _duration(seconds: float) -> str:
    for unit, size in (("years", 3.15576e7), ("days", 86400.0), ("hours", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.2g} s"


def table(certificate: Certificate) -> Table:
    """One row a class of supports."""
    grid = Table(
        title=Text(f"Certificate for {certificate.result.scenario.title}", style="bold"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
    )
    several = len(certificate.legs) > 1
    names = ("leg",) if several else ()
    for name in (*names, "active", "cost", "supports", "reach, short", "reach, long", "time [s]"):
        grid.add_column(Text(name), justify="right")  # rich would read "[s]" as a style
    for number, leg in enumerate(certificate.legs, start=1):
        for record in (*leg.cheaper, *leg.equal):
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


def to_dict(certificate: Certificate) -> dict[str, Any]:
    """Plain numbers, ready for JSON."""
    result = certificate.result
    return {
        "scenario": result.scenario.name,
        "objective": result.scenario.objective.kind,
        "minimal": certificate.minimal,
        "sentences": sentences(certificate),
        "legs": [_leg_numbers(leg) for leg in certificate.legs],
        "seed": result.seed,
        "device": result.device,
        "versions": dict(result.versions),
    }


def _leg_numbers(leg: LegCertificate) -> dict[str, Any]:
    return {
        "active_intervals": leg.found.active_intervals,
        "active_interval_indices": np.flatnonzero(leg.found.active).tolist(),
        "weighted_cost": leg.found_cost,
        "l1_effort_Nms": leg.found.effort,
        "minimal": leg.minimal,
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
            for record in (*leg.cheaper, *leg.equal)
        ],
        "best_support": None if leg.best is None else leg.best[:, 0].tolist(),
        "best_l1_effort_Nms": leg.best_effort,
        "best_long_way": leg.best_long,
    }


def to_dataset(certificate: Certificate) -> xarray.Dataset:
    """Every support that was tried, both ways round.

    Dimensions "support" and "slot"; `interval` and `group` are -1 in slots that a support does not
    use.
    """
    import xarray

    rows: dict[str, list[Any]] = {name: [] for name in ("leg", "cost", "way", "reached")}
    effort, residual, groups = [], [], []
    for number, leg in enumerate(certificate.legs):
        for record in (*leg.cheaper, *leg.equal):
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


def plot(certificate: Certificate) -> Picture:
    """Least effort of the supports that hold two given intervals, a panel a leg."""
    legs = certificate.legs
    figure = picture(5.6 * len(legs), 5.2, certificate.result.scenario.title)
    for index, leg in enumerate(legs):
        axes = figure.add_subplot(1, len(legs), index + 1)
        _pair_map(figure, axes, leg)
        if len(legs) > 1:
            axes.set_title(f"leg {index + 1}")
    return figure


def _pair_map(figure: Picture, axes: Axes, leg: LegCertificate) -> None:
    """Short way round above the diagonal, long way below it."""
    count = len(leg.found.controls)
    least = np.full((count, count), np.inf)
    size = 0
    for record in leg.equal:
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
        axes.text(0.5, 0.5, _nothing(leg), ha="center", va="center", transform=axes.transAxes)
    if leg.best is not None:
        ordered = [(j, i) if leg.best_long else (i, j) for i, j in _pairs(leg.best[:, 0])]
        style: dict[str, Any] = {"s": 130, "marker": "*", "edgecolor": "black", "zorder": 5}
        x, y = zip(*ordered, strict=True)
        axes.scatter(x, y, color=colour(1), label="least effort", clip_on=False, **style)
        axes.legend(loc="lower center", fontsize=8, framealpha=0.9)
    axes.set_facecolor("#F2F2F2")
    others = f" and {size - 2} more" if size > 2 else ""
    axes.set_xlabel("active interval\nabove the line the short way round, below it the long one")
    axes.set_ylabel(f"second active interval{others}")


def _pairs(intervals: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of different intervals, the earlier first; a lone interval with itself."""
    several = sorted(set(intervals.tolist()))
    return list(itertools.combinations(several, 2)) or [(several[0], several[0])]


def _nothing(leg: LegCertificate) -> str:
    if not leg.found.reached:
        return "no answer reaches"
    return "no support was tried" if not any(r.tried for r in leg.equal) else "none reaches"
