"""Chunks of starts take the devices of a process in turn, and no result depends on which."""

import json
import os
import subprocess
import sys

import pytest

PROGRAM = """
import json
import jax, jax.numpy as jnp, numpy as np
import jaxatt
from jaxatt.multistart import refilling

jaxatt.configure()
rng = np.random.default_rng(5)
starts = {"x": rng.uniform(0.5, 40.0, 30)}
used = set()


@jax.jit
def halve(starts, states, fresh):
    x = jnp.where(fresh, starts["x"], states["x"])
    x, count = x / 2.0, jnp.where(fresh, 0, states["count"]) + 1
    return {"x": x, "count": count}, {"x": x, "count": count}, x > 1.0


def advance(starts, states, fresh):
    states, results, running = halve(starts, states, fresh)
    used.update(device.id for device in states["x"].devices())
    return states, results, running


empty = {"x": np.zeros(4), "count": np.zeros(4, int)}
found = refilling.refilling(advance, starts, empty, 4)
print(json.dumps([sorted(used), found["x"].tolist(), found["count"].tolist()]))
"""


def run(devices):
    environment = {
        **os.environ,
        "XLA_FLAGS": f"--xla_force_host_platform_device_count={devices}",
        "JAX_PLATFORMS": "cpu",
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def test_two_devices_give_what_one_gives():
    one, *alone = run(1)
    two, *both = run(2)
    assert one == [0]
    if len(os.sched_getaffinity(0)) < 2:
        pytest.skip("one core runs one chunk at a time")
    assert two == [0, 1]
    assert both == alone
