"""Modules that a command needs at its end are loaded while it computes."""

import sys
import threading

import pytest

from jaxatt.cli.meanwhile import loading

NAME = "loaded_in_a_test"


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module that counts in `sys` how often it is run."""
    (tmp_path / f"{NAME}.py").write_text("import sys\nsys.runs_in_a_test.append(__name__)\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "runs_in_a_test", [], raising=False)
    yield NAME
    sys.modules.pop(NAME, None)


def finished(before):
    """Wait for the threads that are new."""
    for thread in set(threading.enumerate()) - before:
        thread.join(10.0)


def test_the_first_report_begins_to_load_and_no_other_does(module):
    heard, before = [], set(threading.enumerate())
    report = loading(lambda *told: heard.append(told), (module,))
    assert set(threading.enumerate()) == before and module not in sys.modules
    report("deciding", 0)
    finished(before)
    assert sys.runs_in_a_test == [module]
    del sys.modules[module]
    report("deciding", 3)
    finished(before)
    assert sys.runs_in_a_test == [module]
    assert heard == [("deciding", 0), ("deciding", 3)]


@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_module_that_cannot_be_loaded_is_no_error(module, tmp_path):
    (tmp_path / "broken_in_a_test.py").write_text("raise OSError\n")
    before = set(threading.enumerate())
    loading(lambda *told: None, ("no.such.module", "broken_in_a_test", module))("flying", 1)
    finished(before)
    assert sys.runs_in_a_test == [module]
