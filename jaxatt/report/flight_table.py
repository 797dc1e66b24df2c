"""Tables of a simulation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import indices_text, plural, short
from jaxatt.report.flight_record import FlightRecord
from jaxatt.report.flight_summary import flight_summary, units
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.simulation.settling import CHANNELS


def flight_table(result: FlightRecord) -> Table:
    """Table of median and percentiles of every figure, and of how the runs ended."""
    numbers = flight_summary(result)
    many = result.runs > 1
    title = f"{result.scenario.title}\n{numbers['title']}: {plural(result.runs, 'run')}"
    table = Table(
        title=Text(title, style="bold"),
        caption=Text(_caption(result, numbers)),
        box=box.SIMPLE_HEAD,
        show_header=many,
        title_justify="left",
        caption_justify="left",
    )
    table.add_column("")
    for name in ("5 %", "median", "95 %") if many else ("",):
        table.add_column(name, justify="right")
    saturated = numbers["dipole_saturated_percent"]
    unit, _ = units(result)
    shown = unit.replace("rad_s", "rad/s")
    for label, block in (
        *((f"settling, {axis} [s]", numbers["settling_s"][axis]) for axis in CHANNELS),
        ("settling, slowest axis [s]", numbers["settling_worst_s"]),
        (f"settled RMS, total [{shown}]", numbers[f"rms_{unit}"]["total"]),
        (f"error at the end, total [{shown}]", numbers[f"final_{unit}"]["total"]),
        ("integral of |torque| [N m s]", numbers["integral_Nms"]),
        *((f"peak torque on the body, {a} [N m]", numbers["peak_Nm"][a]) for a in CHANNELS[:3]),
        *([] if saturated is None else [("dipole at its limit [% of the time]", saturated)]),
        *((f"longest at {name} [s]", stay) for name, stay in numbers["band_stays_s"].items()),
    ):
        levels = ("p5", "p50", "p95") if many else ("p50",)
        cells = [short(block.get(level)) or "never" for level in levels]
        table.add_row(Text(label), *(Text(cell) for cell in cells))
    return table


def _caption(result: FlightRecord, numbers: dict[str, Any]) -> str:
    lines = [
        f"{numbers['settled']} settled, {numbers['not_settled']} did not, "
        f"{sum(block['count'] for block in numbers['failed'].values())} failed"
    ]
    lines += [
        f"{words}: runs {indices_text(block['runs'])}" for words, block in numbers["failed"].items()
    ]
    lines += [f"Note: {note}" for note in numbers["notes"]]
    time = ", ".join(f"{name} {value:.1f} s" for name, value in numbers["time_s"].items())
    lines.append(f"{time}; seed {result.seed}, {result.device}, float64")
    return "\n".join(lines)


_LABELS = {
    "settling_s": "settling [s]",
    "settling_worst_s": "settling, slowest axis [s]",
    "settling_limit_s": "settling limit (31) [s]",
    "rms_deg": "settled RMS [deg]",
    "rms_rad_s": "settled RMS [rad/s]",
    "peak_Nm": "peak torque [N m]",
    "integral_Nms": "integral of |torque| [N m s]",
}


def comparison_table(scenario: FlightScenario, lines: Sequence[Mapping[str, Any]]) -> Table:
    """Table of obtained and printed figures, with the reason where one is not reproduced.

    lines : as `jaxatt.studies.flight_comparison.Line` holds them.
    """
    table = dense_table(f"{scenario.title}\nprinted: {scenario.source}")
    for name in ("law", "figure", "obtained", "printed", ""):
        table.add_column(name)
    before = ""
    for line in lines:
        verdict = Text("")
        if line["reproduced"] is not None:
            away = f"{100 * line['worst']:.1f} %"
            verdict = Text(away, style="green")
            if not line["reproduced"]:
                verdict = Text(f"{away}, NOT reproduced: {line['why']}", style="yellow")
        table.add_row(
            Text("" if line["law"] == before else line["law"]),
            Text(_LABELS[line["figure"]]),
            Text(_row(line["obtained"])),
            Text("" if line["printed"] is None else _row(line["printed"])),
            verdict,
        )
        before = line["law"]
    return table


def _row(values: Sequence[float]) -> str:
    words = {-1.0: "inside"}
    return "  ".join(
        words.get(value, short(value)) if math.isfinite(value) else "never" for value in values
    )
