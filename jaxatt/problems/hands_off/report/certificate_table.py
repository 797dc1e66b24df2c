"""Table of the classes of supports and what became of them."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.problems.hands_off.certificate import CertificateRecord, ClassRecord
from jaxatt.problems.hands_off.report.certificate_words import duration_text, number_text
from jaxatt.records.wording import short


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
    time = short(record.seconds, 2) if record.tried else f"about {duration_text(record.seconds)}"
    return label, short(kind.cost), number_text(kind.number), *ways, time
