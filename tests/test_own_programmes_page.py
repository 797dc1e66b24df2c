"""The example of the page on own programmes runs as it is printed, and gives what is printed."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[1] / "docs" / "own-programmes.md"


def test_the_example_of_the_page_runs_as_printed(capsys):
    code, printed = re.search(
        r"```python\n(.*?)```\n\n```\n(.*?)```", PAGE.read_text(), re.S
    ).groups()
    assert len(code.splitlines()) <= 30
    exec(compile(code, str(PAGE), "exec"), {})
    found = capsys.readouterr().out
    assert found.splitlines()[0] == printed.splitlines()[0]

    def number(text, name):
        return float(re.search(rf"{name} +([-\d.e]+)", text).group(1))

    for name in ("objective", "final time"):
        assert number(found, name) == pytest.approx(number(printed, name), rel=1e-6)
    assert number(found, "objective") == pytest.approx(1.8016, abs=1e-3)
