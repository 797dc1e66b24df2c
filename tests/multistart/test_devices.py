"""What a start does depends on neither the number of devices nor that of processes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[1] / "references/shared_starts.py"
DEVICES = "--xla_force_host_platform_device_count"
COUNT = 37
"""Starts, which three devices cannot share evenly."""


def run(devices):
    environment = {
        **os.environ,
        "XLA_FLAGS": f"{os.environ['XLA_FLAGS']} {DEVICES}={devices}",
        "JAX_PLATFORMS": "cpu",
    }
    done = subprocess.run(
        [sys.executable, SCRIPT, str(COUNT)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def alone():
    return run(1)


def test_the_starts_are_solved_and_take_different_times(alone):
    finite = np.isfinite(alone["starts"])
    assert finite.sum() == COUNT - 1
    x, mean = np.array(alone["x"])[finite], np.array(alone["starts"])[finite]
    np.testing.assert_allclose(x - 0.9 * np.sin(x), mean, atol=1e-13)
    assert min(alone["passes"]) < max(alone["passes"])


def test_three_devices_give_what_one_gives_and_exchange_nothing(alone):
    both = run(3)
    assert (alone["devices"], both["devices"]) == (1, 3)
    # As text, where what is not a number equals itself.
    for what in ("x", "passes", "sines", "none"):
        assert json.dumps(both[what]) == json.dumps(alone[what]), what
    assert sum(both["told"]) == COUNT
    assert both["collectives"] == [] and both["sum"] != []
