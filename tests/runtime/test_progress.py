"""Progress of a sweep says how many samples are done and how much time is left."""

from __future__ import annotations

import time

import numpy as np
import pytest

from jaxatt.runtime.progress import SAMPLES, Reporter


def test_time_left_follows_the_pace_after_the_first_sample(monkeypatch, capsys) -> None:
    rng = np.random.default_rng(1129)
    each, total, before = rng.uniform(3.0, 50.0), 40, 10
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with Reporter(total) as report:
        report(SAMPLES, before)  # of an earlier run
        now[0] += 500.0  # the first compiles
        report(SAMPLES, 1)
        for _ in range(before + 1, total):
            now[0] += each
            report(SAMPLES, 1)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == f"samples: {before} of {total}"
    assert lines[-1] == f"samples: {total} of {total}"
    left = [line.split("about ")[1] for line in lines if "about" in line]
    assert len(left) == total - before - 2
    told, unit, _ = left[0].split()
    seconds = float(told) * {"s": 1.0, "min": 60.0, "h": 3600.0}[unit]
    assert seconds == pytest.approx((total - before - 2) * each, abs=31.0)
