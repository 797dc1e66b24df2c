"""No notebook without a test of its own."""

from pathlib import Path

from notebook_runs import NOTEBOOKS


def test_every_notebook_is_run_by_a_file_here() -> None:
    run = {file.stem.removeprefix("test_") for file in Path(__file__).parent.glob("test_*.py")}
    assert run - {"every_notebook"} == {script.stem for script in NOTEBOOKS.glob("*.py")}
