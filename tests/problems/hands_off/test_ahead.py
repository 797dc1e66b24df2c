"""What is compiled ahead is what the search then calls."""

import jax
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.multistart import driver
from jaxatt.optimize.reweighting.condensed import CondensedReweighting
from jaxatt.optimize.reweighting.weights import Reweighting
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.ahead import compiled_ahead
from jaxatt.problems.hands_off.search.batch import Form, broadcast_lanes
from jaxatt.problems.hands_off.search.polish import Method, count_arguments, decide, polish
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.runtime.compilation import Routine


@pytest.fixture(scope="module")
def task():
    return build_slew(scenarios.load("hypso1-90-45-15"), enforce_speed_limits=False)


@pytest.fixture
def compiled():
    """Names of what is traced, lowered or compiled from now on."""
    seen = []

    def listen(event, duration, **about):
        if event.startswith("/jax/core/compile/"):
            seen.append(str(about.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield seen
    jax.monitoring.unregister_event_duration_listener(listen)


@pytest.fixture
def unkept():
    """Programs that are not kept on disk have names of their own."""
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", None)
    yield
    jax.config.update("jax_compilation_cache_dir", before)


def test_a_search_finds_all_its_large_programs_ready(task, compiled, unkept):
    method = Method("l0", rows=11)  # a size that no other test has had compiled
    with compiled_ahead(task, method, 11):
        pass
    begun = {name for name in compiled if name.startswith("jit(")}
    assert begun
    compiled.clear()
    starts = draw(1, 11, task.intervals, task.size, 0.2)
    u, supports = decide(task, starts, method)
    answers = polish(task, u, supports, starts.sign, method)
    assert answers.verdict.reached.all()
    assert not begun & set(compiled)


def test_a_kept_program_of_a_search_gives_the_same_bits(task, compiled, tmp_path):
    form, free = Form(task.system, task.shared, "roots", task.size), task.arguments.free
    u = 0.01 * np.random.default_rng(5).normal(size=(8, task.intervals, task.size))
    lanes = broadcast_lanes(u, free, task.arguments.row_weight, np.ones(8))
    solver = CondensedReweighting(Reweighting())
    args = driver.Job(form, False, None), lanes, count_arguments(task), solver
    found = []
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        for _ in range(2):
            compiled.clear()
            answer = Routine(driver.to_the_end.__wrapped__, statics=1)(*args)
            found.append((answer, bool(compiled)))
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    (made, traced), (again, retraced) = found
    assert (traced, retraced) == (True, False)
    for one, other in zip(*map(jax.tree.leaves, (made, again)), strict=True):
        np.testing.assert_array_equal(one, other)
