"""Processes on this machine that share starts: the same answers, and an end when one is lost."""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from jaxatt.cli import app
from jaxatt.report.archive import open_archive
from jaxatt.runtime.joining import JoinError, Joining

SCRIPT = Path(__file__).parents[1] / "references/shared_starts.py"
DEVICES = "--xla_force_host_platform_device_count"
COUNT = 37
"""Starts, which two processes cannot share evenly."""


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


def begin(count, process=None, processes=2, port=0, what="", devices=1, variables=None):
    """One process of the script; alone without a number."""
    where = [] if process is None else [f"127.0.0.1:{port}", str(processes), str(process), what]
    return subprocess.Popen(
        [sys.executable, SCRIPT, str(count), *where],
        env={
            **os.environ,
            **(variables or {}),
            "XLA_FLAGS": f"{os.environ['XLA_FLAGS']} {DEVICES}={devices}",
            "JAX_PLATFORMS": "cpu",
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(*running, within=120.0):
    """(exit code, standard output, standard error) of each."""
    try:
        spoken = [one.communicate(timeout=within) for one in running]
    finally:
        for one in running:
            one.kill()
    return [(one.returncode, *said) for one, said in zip(running, spoken, strict=True)]


def document(out):
    return json.loads(out.splitlines()[-1])


@pytest.fixture(scope="module")
def alone():
    ((code, out, err),) = ended(begin(COUNT))
    assert code == 0, err
    return document(out)


@pytest.mark.parametrize("devices", [1, 2])
def test_two_processes_give_what_one_gives(alone, devices):
    port = free_port()
    both = [begin(COUNT, number, port=port, devices=devices) for number in (0, 1)]
    (code, out, err), (other_code, other_out, other_err) = ended(*both)
    assert (code, other_code) == (0, 0), err + other_err
    together = document(out)
    assert (together["processes"], together["devices"]) == (2, devices)
    for what in ("x", "passes", "sines", "none"):
        assert json.dumps(together[what]) == json.dumps(alone[what]), what
    assert sum(together["told"]) == COUNT
    assert "passes" not in other_out, "only process 0 prints"


@pytest.mark.slow
def test_a_whole_solve_is_the_same_in_two_processes_of_two_devices(tmp_path):
    command = [sys.executable, "-m", "jaxatt", "solve", "hypso1-90-45-15", "--starts", "9"]

    def solve(name, devices, *flags):
        return subprocess.Popen(
            [*command, "--quiet", "--out", tmp_path / name, *flags],
            env={
                **os.environ,
                "XLA_FLAGS": f"{os.environ['XLA_FLAGS']} {DEVICES}={devices}",
                "JAX_PLATFORMS": "cpu",
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    where = ("--coordinator", f"127.0.0.1:{free_port()}", "--processes", "2", "--process")
    for code, _, err in ended(
        solve("alone", 1), *(solve("both", 2, *where, str(k)) for k in (0, 1)), within=400.0
    ):
        assert code == 0, err
    alone, both = (
        {
            key: value.values
            for key, value in open_archive(tmp_path / name / "result.nc").data_vars.items()
        }
        for name in ("alone", "both")
    )
    assert len(alone) > 10 and alone.keys() == both.keys()
    for key, value in alone.items():
        # Shares of other sizes are chunks of other sizes, which are compiled otherwise.
        if value.dtype.kind == "f":
            scale = np.abs(value[np.isfinite(value)]).max(initial=0.0)
            np.testing.assert_allclose(
                both[key], value, rtol=0, atol=1e-9 * (1.0 + scale), err_msg=key
            )
        else:
            np.testing.assert_array_equal(both[key], value, err_msg=key)


def test_processes_that_disagree_say_so():
    port = free_port()
    both = ended(*(begin(8, number, port=port, what="other") for number in (0, 1)))
    for code, _, err in both:
        assert code == 4
        assert "process 1 has other starts than process 0" in err


@pytest.mark.slow
def test_a_process_that_is_killed_before_its_share_ends_the_other():
    port = free_port()
    first, last = (begin(COUNT, number, port=port, what="killed") for number in (0, 1))
    last.wait(120.0)
    began = time.monotonic()
    (code, _, err), _ = ended(first, last)
    assert time.monotonic() - began < 60.0
    assert code != 0
    assert "another process has ended early" in err or "another task died" in err


@pytest.mark.slow
@pytest.mark.parametrize("victim", [0, 1])
def test_a_process_that_is_killed_ends_one_that_is_at_work(victim):
    port = free_port()
    both = [begin(8, number, port=port, what="slow") for number in (0, 1)]
    for one in both:
        assert any("at work" in line for line in one.stdout)
    both[victim].kill()
    began = time.monotonic()
    (code, _, err), _ = ended(both[1 - victim], both[victim])
    assert time.monotonic() - began < 60.0
    assert code != 0
    assert "another task died" in err


def test_a_coordinator_that_does_not_answer_is_named():
    port = free_port()
    done = subprocess.run(
        [
            *(sys.executable, "-m", "jaxatt", "solve", "hypso1-90-45-15"),
            *("--coordinator", f"127.0.0.1:{port}", "--processes", "2", "--process", "1"),
            *("--join-timeout", "1"),
        ],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert f"no answer from the coordinator 127.0.0.1:{port}" in done.stderr
    assert "Traceback" not in done.stderr and "Check failure" not in done.stderr


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (("--processes", 2), "need --coordinator"),
        (("--process", 0), "need --coordinator"),
        (("--coordinator", "127.0.0.1:9"), "needs --processes"),
        (("--coordinator", "127.0.0.1:9", "--processes", 2), "needs --processes"),
        (("--coordinator", "127.0.0.1:9", "--processes", 2, "--process", 2), "numbered from 0"),
        (("--coordinator", "127.0.0.1", "--processes", 2, "--process", 1), "HOST:PORT"),
        (("--coordinator", "here:0", "--processes", 2, "--process", 1), "HOST:PORT"),
        (("--coordinator", "auto", "--processes", 2), "leave them out"),
        (("--coordinator", "127.0.0.1:9", "--processes", 0, "--process", 0), "--processes"),
        (("--coordinator", "127.0.0.1:9", "--processes", 2, "--process", -1), "--process"),
    ],
)
@pytest.mark.parametrize("command", ["solve", "plan", "pareto"])
def test_flags_that_contradict_each_other_are_bad_input(command, flags, word, tmp_path):
    case = {"solve": "double-integrator", "plan": "hypso2-orbit", "pareto": "hypso1-netpower"}
    arguments = [command, case[command], "--out", tmp_path / "out", *flags]
    found = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert found.exit_code == 2
    assert word in found.output
    assert not (tmp_path / "out").exists()


def test_automatic_joining_needs_a_scheduler():
    code = (
        "from jaxatt.runtime.joining import *\n"
        "try: Joining('auto').join()\n"
        "except JoinError as error: print(error)"
    )
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("SLURM", "OMPI"))}
    done = subprocess.run(
        [sys.executable, "-c", code], env=plain, capture_output=True, text=True, timeout=120
    )
    assert "no scheduler has started this process" in done.stdout, done.stderr


def test_slurm_tells_who_is_who():
    """Two tasks as srun starts them, on this machine."""
    code = (
        "from jaxatt.runtime.joining import *\n"
        "import jax\n"
        "Joining('auto', timeout_s=60.0).join()\n"
        "print('joined', jax.process_index(), jax.process_count(), writes())"
    )

    job = str(free_port() % 4096)  # which tells the port

    def task(number):
        variables = {
            "SLURM_JOB_ID": job,
            "SLURM_STEP_NODELIST": "localhost",
            "SLURM_NTASKS": "2",
            "SLURM_PROCID": str(number),
            "SLURM_LOCALID": str(number),
            "SLURM_STEP_NUM_NODES": "1",
        }
        return subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, **variables, "JAX_PLATFORMS": "cpu"},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    for number, (code_, out, err) in enumerate(ended(task(0), task(1))):
        assert code_ == 0, err
        assert f"joined {number} 2 {number == 0}" in out


def test_fields_are_checked_before_anything_is_joined():
    with pytest.raises(JoinError, match="numbered from 0"):
        Joining("127.0.0.1:9", 2, 5).join()
