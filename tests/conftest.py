"""Settings for every test: those of the command line, and no silent rank promotion."""

import ctypes
import gc
import os
import resource
import shutil
import sys
import tempfile
from pathlib import Path

# One compilation cache for all workers of a run and the notebooks' kernels; set before JAX starts.
# Even the smallest programs are kept: there are thousands of them, and both workers need them.
_OWN_CACHE = "JAX_COMPILATION_CACHE_DIR" not in os.environ
if _OWN_CACHE:
    os.environ["JAX_COMPILATION_CACHE_DIR"] = tempfile.mkdtemp(prefix="jaxatt-compiled-")
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"

# What a test runs is short beside what it compiles: LLVM's passes cost more than they gain, and the
# fusion emitters double what a small program takes.
os.environ.setdefault(
    "XLA_FLAGS",
    "--xla_backend_optimization_level=0 --xla_cpu_parallel_codegen_split_count=1"
    " --xla_cpu_use_fusion_emitters=false",
)

# Tracing makes very many objects that live on; looking through them took a twentieth of the time.
gc.set_threshold(50_000, 20, 20)

import jax  # noqa: E402
import pytest  # noqa: E402

import jaxatt  # noqa: E402
from jaxatt.runtime.compilation import Routine  # noqa: E402

jaxatt.configure()
jax.config.update("jax_numpy_rank_promotion", "raise")

GIB = 2**30
ENOUGH = 1.5 * GIB
"""Memory of a worker beyond which it forgets what it has compiled, between two files."""

FIRST = (
    "test_page_runs.py",
    "test_net_power.py",
    "test_feedback_laws.py",
    "test_maximum_hands_off.py",
    "test_time_and_effort.py",
    "test_on_off_thrusters.py",
    "test_short_plan.py",
    "test_free_time_search.py",
    "test_vehicle_scale.py",
    "test_pointing_cases.py",
    "test_free_roll_turns.py",
    "test_failed_wheel_cases.py",
    "test_wheels_ends.py",
    "test_free_roll_energy.py",
    "test_sparse_sensitivities.py",
    "test_pareto.py",
    "test_free_time_sensitivities.py",
    "test_wheel_bias.py",
    "test_minimize_collection.py",
    "test_timed_cases.py",
    "test_net_power_sensitivities.py",
    "test_solve.py",
    "test_design.py",
    "test_certify.py",
    "test_sweep_run.py",
    "test_moving_paths.py",
    "test_scenario_sensitivities.py",
    "test_closed_loop.py",
    "test_motor_limits.py",
    "test_solve_program.py",
    "test_processes.py",
    "test_time_optimal_search.py",
    "test_zero_band.py",
    "test_wheels_derivatives.py",
    "test_published_cases.py",
    "test_compile_cache.py",
    "test_pointing_thrusters.py",
    "test_rotations.py",
    "test_step_check.py",
    "test_attitude_map.py",
    "test_weaker_motors.py",
    "test_free_time_derivatives.py",
)
"""The files that take longest: begun first, so that no worker is left alone with one at the end."""


@pytest.fixture
def compilations():
    """Names of what XLA compiles from now on, one each."""
    seen = []

    def listen(event, duration, fun_name="", **_):
        if event.endswith("backend_compile_duration"):
            seen.append(fun_name)

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield seen
    jax.monitoring.unregister_event_duration_listener(listen)


@pytest.fixture(scope="module", autouse=True)
def _no_hoard():
    """Between files, give back compiled programs once they fill much memory."""
    yield
    if resident() > ENOUGH:
        trim()
    if resident() > ENOUGH:
        for routine in (thing for thing in gc.get_objects() if type(thing) is Routine):
            routine._begun.clear()
            routine._plain.clear()
        gc.collect()
        jax.clear_caches()
        trim()


def resident() -> int:
    """Memory of this process [B]; 0 where that cannot be read."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * resource.getpagesize() if statm.exists() else 0


def trim() -> None:
    """Return what is free to the system, or all files after one would find too much in use."""
    if sys.platform == "linux" and hasattr(libc := ctypes.CDLL(None), "malloc_trim"):
        libc.malloc_trim(0)


def pytest_collection_modifyitems(items: list) -> None:
    """The longest files first, in the order of `FIRST`; the others as they were."""
    order = {name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: order.get(item.path.name, len(order)))


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Tell the process that reports the peak of this one's memory, and of its children's."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["peaks"] = peaks()


def peaks() -> tuple[float, float]:
    """Peak resident memory [GiB] of this process and of its largest child that has ended."""
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    own, child = (resource.getrusage(who).ru_maxrss * 1024 / GIB for who in both)
    return own, child


_PEAKS: dict[str, tuple[float, float]] = {}


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node) -> None:
    """Keep what a worker tells at its end."""
    _PEAKS[node.gateway.id] = node.workeroutput.get("peaks", (0.0, 0.0))


def pytest_terminal_summary(terminalreporter) -> None:
    """Say how much memory every worker, and its largest child, needed at most."""
    for name, (own, child) in sorted((_PEAKS or {"this process": peaks()}).items()):
        terminalreporter.write_line(f"memory of {name}: {own:.1f} GiB, a child {child:.1f} GiB")


def pytest_unconfigure() -> None:
    """Remove the compilation cache that this process made."""
    if _OWN_CACHE:
        shutil.rmtree(os.environ["JAX_COMPILATION_CACHE_DIR"], ignore_errors=True)
