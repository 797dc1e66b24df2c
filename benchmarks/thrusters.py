"""On/off thrusters: 64 starts of a slew here and with IPOPT, on the same cores.

    python -m benchmarks.thrusters [--case eseo-1] [--starts 64] [--repeats 5] [--json FILE]

Both sides get all cores, compilation apart.  The other side is `casadi_thrusters`: the `reach` form
with bang-bang guesses, compiled.  This side starts from random torques.  An answer counts if an
independent flight reaches and it has no more active intervals than the best known.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import jaxatt

jaxatt.configure()

from benchmarks.__main__ import machine  # noqa: E402
from benchmarks.both_cores import run_together  # noqa: E402
from benchmarks.cases import BEST_KNOWN, task_of  # noqa: E402
from benchmarks.timing import timed  # noqa: E402
from benchmarks.usefulness import useful  # noqa: E402
from jaxatt.problems.hands_off.search.search import Found, search  # noqa: E402


def main() -> None:
    """Run both sides and print what they took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", choices=("eseo-1", "eseo-2", "eseo-3"), default="eseo-1")
    parser.add_argument("--starts", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    case, task, best = options.case, task_of(options.case), BEST_KNOWN[options.case]

    last: list[Found] = []

    def run(seed: int) -> None:
        last[:] = [search(task, options.starts, seed)]

    time = timed(run, options.repeats)
    ours = int(useful(task, last[0].starts.controls, best).sum())
    with tempfile.TemporaryDirectory() as folder:
        other = run_together(case, options.starts, 0, "thrusters", folder=Path(folder))
    theirs = sum(int(useful(task, o.controls, best).sum()) for o in other.outcomes)
    found = {
        "machine": machine(),
        "case": case,
        "starts": options.starts,
        "jaxatt": {"build_s": time.compile_s, "run_s": time.run_s, "useful": ours},
        "ipopt": {"build_s": other.build_s, "run_s": other.wall_s, "useful": theirs},
        "ratio": other.wall_s / time.run_s,
    }
    print(f"{case}, {options.starts} starts on {found['machine']['cores']} cores")
    for side in ("jaxatt", "ipopt"):
        row = found[side]
        print(
            f"  {side:7} build {row['build_s']:6.1f} s   run {row['run_s']:8.3f} s   "
            f"useful {row['useful']} of {options.starts}"
        )
    print(f"  IPOPT takes {found['ratio']:.1f} times as long")
    if options.json:
        options.json.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
