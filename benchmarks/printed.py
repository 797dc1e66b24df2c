"""Printed values beside obtained ones, as tables of the pages on the sources.

    python -m benchmarks.printed                      # every case of every source: hours
    python -m benchmarks.printed mrp-k4 eseo-1        # these cases only
    python -m benchmarks.printed --tables             # nothing is solved, tables only

Each case is what `jaxatt compare CASE` runs, with its own starts and seed 0. The rows go to
docs/sources/obtained/CASE.json, with the day, and from there into the page of the source, between
the two lines of HTML comment that name the case.
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jaxatt
from jaxatt.runtime.files import replacing
from jaxatt.scenarios import kind_of
from jaxatt.studies.imaging import compare_imaging

PAGES = Path(__file__).parents[1] / "docs" / "sources"

SOURCES: dict[str, tuple[str, ...]] = {
    "hands-off-thesis": (
        "hypso1-45-0-0",
        "hypso1-90-45-15",
        "hypso1-75-50-15",
        "hypso1-90-45-15-perturbed",
        "hypso1-path",
        "hypso1-path-two",
    ),
    "thrusters-paper": ("eseo-1", "eseo-2", "eseo-3"),
    "energy-thesis": (
        "hypso1-netpower",
        "hypso2-orbit",
        "mtq-free-time",
        "hypso1-pointing",
        "hypso1-slewing",
        "hypso1-imaging",
    ),
    "inverse-optimal-paper": ("microsatellite-large-slew", "microsatellite-rest-to-rest"),
    "wheels-paper": ("mrp-k4",),
}
"""Page of a source -> its cases that have printed values."""

CLOSE = 1e-3
"""Relative difference up to which an optimum counts as the printed one."""

Row = dict[str, str]


def main() -> None:
    """Solve the cases asked for and write all tables."""
    known = [case for cases in SOURCES.values() for case in cases]
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(known)}")
    parser.add_argument("--tables", action="store_true", help="solve nothing")
    asked = parser.parse_args()
    unknown = sorted(set(asked.cases) - set(known))
    if unknown:
        parser.error(f"{', '.join(unknown)}: no case with printed values; choose of {known}")
    jaxatt.configure()
    for case in () if asked.tables else asked.cases or known:
        record = {
            "case": case,
            "date": datetime.date.today().isoformat(),
            "rows": list(rows_of(case)),
        }
        _write(json.dumps(record, indent=1, ensure_ascii=False) + "\n", obtained(case))
        print(f"{case}: {len(record['rows'])} rows", flush=True)
    for page, cases in SOURCES.items():
        text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
        _write(with_tables(text, cases), PAGES / f"{page}.md")


def _write(text: str, path: Path) -> None:
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")


def obtained(case: str) -> Path:
    """The file that holds the rows of a case."""
    return PAGES / "obtained" / f"{case}.json"


def with_tables(page: str, cases: tuple[str, ...]) -> str:
    """The page with each case's table as its file has it."""
    for case in cases:
        file = obtained(case)
        if not file.exists():
            continue
        begin, end = f"<!-- printed: {case} -->", "<!-- end -->"
        pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
        made = f"{begin}\n{table(json.loads(file.read_text(encoding='utf-8')))}\n{end}"
        page = pattern.sub(lambda _, made=made: made, page)
    return page


def table(record: dict[str, Any]) -> str:
    """Rows as a table of Markdown, and the command that gives them."""
    lines = ["| | figure | printed | obtained | |", "| --- | --- | --- | --- | --- |"]
    for row in record["rows"]:
        cells = (row["of"], row["figure"], row["printed"], row["obtained"], row["verdict"])
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + f"\n\n`jaxatt compare {record['case']}`, {record['date']}."


def rows_of(case: str) -> Iterator[Row]:
    """Run the comparison of a case; one row for each printed figure."""
    kind = kind_of(case)
    if kind == "imaging":
        found = compare_imaging()
        for row in (*found.rows, found.fitted):
            printed, of = found.printed["slew"], f"{row.altitude_km:.0f} km"
            verdict = "reproduced" if abs(row.slew_m - printed) < 0.5 else "does not hold"
            figure = "ground sampling, slew [m]"
            yield _row(of, figure, f"{printed:g}", f"{row.slew_m:.1f}", verdict)
        return
    if kind == "flight":
        for line in jaxatt.compare_flight(case).to_dict()["lines"]:
            if line["printed"] is not None:
                yield _flight_row(line)
        return
    numbers = jaxatt.compare(case).to_dict()
    printed = numbers.get("printed", {})
    for row in numbers["rows"]:
        if "controller" in row:
            yield from _sparse_rows(row)
        elif "integration" in row:
            yield from _time_rows(row, printed)
        elif "time_weight" in row:
            yield from _weight_rows(row)
        else:
            yield from _energy_rows(row, printed)


def _row(of: str, figure: str, printed: str, obtained: str, verdict: str) -> Row:
    return {
        "of": of,
        "figure": figure,
        "printed": printed,
        "obtained": obtained,
        "verdict": verdict,
    }


def _sparse_rows(row: dict[str, Any]) -> Iterator[Row]:
    printed, name = row["printed"], row["controller"]
    count, outside = printed["active_intervals"], printed["active_outside_windows"]
    if count is not None:
        verdict = _verdict(count, row["active_intervals"])
        if verdict == "does not hold" and name != "L0":
            verdict = "more: it minimises something else"
        figure = "active intervals"
        yield _row(name, figure, str(count), str(row["active_intervals"]), verdict)
    if outside is not None and name == "Moving L0":
        found = row["active_outside_windows"]
        figure = "of these outside the windows"
        yield _row(name, figure, str(outside), str(found), _verdict(outside, found))
    share = printed["relative_sparsity_percent"]
    if share is not None:
        found = row["relative_sparsity_percent"]
        verdict = _verdict(share, round(found, 2))
        yield _row(name, "relative sparsity [%]", f"{share:.2f}", f"{found:.2f}", verdict)


def _time_rows(row: dict[str, Any], printed: dict[str, Any]) -> Iterator[Row]:
    time = next((v["final_time_s"] for v in printed.values() if _has(v, "final_time_s")), None)
    of = f"{row['angle_rad']:.3g} rad, {row['integration']}"
    printed_one = row["integration"] == "euler" and row["angle_rad"] < 2.0
    yield _row(
        of,
        "final time [s]",
        f"{time:g}" if printed_one else "-",
        f"{row['final_time_s']:.4f}",
        _verdict(time, row["final_time_s"], CLOSE) if printed_one else "not printed",
    )


def _has(value: Any, key: str) -> bool:
    return isinstance(value, dict) and key in value


def _energy_rows(row: dict[str, Any], printed: dict[str, Any]) -> Iterator[Row]:
    beside = next((r for r in printed["rows"] if r["label"] == row["label"]), None)
    if beside is None:
        return
    net, law = beside["net_J"], beside["baseline_J"]
    yield _row(
        row["label"],
        "net energy [J]",
        f"{net:g}",
        f"{row['net_J']:.1f}",
        _verdict(-net, -row["net_J"], CLOSE),
    )
    same = abs(row["baseline_J"] - law) <= CLOSE * abs(law)
    yield _row(
        row["label"],
        "net energy, PD law [J]",
        f"{law:g}",
        f"{row['baseline_J']:.1f}",
        "reproduced" if same else "does not hold",
    )


def _weight_rows(row: dict[str, Any]) -> Iterator[Row]:
    printed, of = row["printed"], f"k3 = {row['time_weight']:g} W/s"
    verdict = _verdict(printed["cost"], row["cost"], CLOSE)
    yield _row(of, "cost (6.2a) [W]", f"{printed['cost']:.3f}", f"{row['cost']:.3f}", verdict)


def _flight_row(line: dict[str, Any]) -> Row:
    words = {
        "settling_s": "settling [s]",
        "settling_worst_s": "settling, slowest axis [s]",
        "peak_Nm": "peak torque [N m]",
        "integral_Nms": "integrated torque [N m s]",
        "rms_deg": "settled RMS [deg]",
        "rms_rad_s": "settled RMS [rad/s]",
    }
    figure = words.get(line["figure"], line["figure"].replace("_", " "))
    verdict = "reproduced" if line["reproduced"] else f"does not hold: {line['why']}"
    return _row(line["law"], figure, _list(line["printed"]), _list(line["obtained"]), verdict)


def _list(values: tuple[float, ...]) -> str:
    return ", ".join("inside" if value == -1.0 else f"{value:.4g}" for value in values)


def _verdict(printed: float, found: float, close: float = 0.0) -> str:
    """What the obtained value says of a printed one where less is better."""
    if abs(found - printed) <= close * abs(printed):
        return "reproduced"
    return "beaten" if found < printed else "does not hold"


if __name__ == "__main__":
    main()
