"""Two folders of results beside each other: which numbers of `summary.json` differ.

    python -m benchmarks.compare_summaries BEFORE AFTER

Each folder holds one folder a case, as `jaxatt solve CASE --out FOLDER/CASE` and `jaxatt simulate`
write them.  Whole numbers, texts and lists of them must be equal; other numbers may differ by 1e-6
of themselves, or by less than a hundredth of the tolerance that they are judged by.  What was
measured by a clock, and versions, are left out.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RELATIVE = 1e-6
NEGLIGIBLE = {
    "attitude_error_deg": 1e-4,
    "rate_error_rad_s": 1e-7,
    "waypoint_error_deg": 1e-3,
    "state_error": 1e-8,
    "violation": 1e-8,
    "stationarity": 1e-8,
    "max_torque_violation_Nm": 1e-12,
}
"""Sizes below which these numbers are rounding."""

_LEFT_OUT = ("time_s", "versions", "device")


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every number and text of a summary with its path."""
    if isinstance(value, dict):
        for name, item in value.items():
            # Every entry called time_s at the top is wall clock; below it is physics.
            if not (path == "" and name in _LEFT_OUT):
                yield from leaves(item, f"{path}.{name}" if path else name)
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from leaves(item, f"{path}[{index}]")
    else:
        yield path, value


def agree(path: str, a: Any, b: Any) -> bool:
    """Whether two values are the same but for rounding."""
    if a == b:
        return True
    if not (isinstance(a, float) and isinstance(b, float)):
        return False
    floor = NEGLIGIBLE.get(path.rsplit(".", 1)[-1].split("[")[0], 0.0)
    return abs(a - b) <= max(RELATIVE * max(abs(a), abs(b)), floor)


def main(before: Path, after: Path) -> int:
    """Print a line a case, and a line for every number that differs; 1 if any does."""
    failed = 0
    for file in sorted(before.glob("*/summary.json")):
        name = file.parent.name
        other = after / name / "summary.json"
        if not other.is_file():
            print(f"{name}: missing")
            failed += 1
            continue
        old, new = (dict(leaves(json.loads(f.read_text()))) for f in (file, other))
        different = [(p, old.get(p), new.get(p)) for p in {**old, **new}]
        different = [row for row in different if not agree(*row)]
        print(f"{name}: {len(old)} numbers, {len(different)} differ")
        for path, a, b in different:
            print(f"    {path}: {a} -> {b}")
        failed += bool(different)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
