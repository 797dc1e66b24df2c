"""List the messages of the package, by where they come from, in docs/errors.md.

    python docs/list_errors.py

They are read from the code: what `Table.fail` and the errors that the package raises for its user
are given. What stands in braces there is shown as dots.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "errors.md"
BEGIN, END = "<!-- listed by: python docs/list_errors.py -->", "<!-- end -->"

RAISED = {"ScenarioError", "OutputError", "JoinError", "ValueError"}

PLACES = {
    "problems/reading": "Any scenario",
    "problems/hands_off": "Hands-off slews and thrusters",
    "problems/time_optimal": "Minimum time",
    "problems/net_power": "Net power and plans",
    "problems/pointing": "Cones and limits on the rate",
    "problems/toy": "Toy problems",
    "problems": "Any family",
    "scenarios": "Files of scenarios and flights",
    "spacecraft": "Vehicles",
    "environment": "Orbits",
    "exchange": "Attitude and orbit files",
    "pipeline": "Solve, simulate, certify",
    "report": "Results, archives and stores",
    "studies": "Sweeps, maps, designs, fronts and comparisons",
    "multistart": "Programmes of your own",
    "optimize": "Programmes of your own",
    "runtime": "Folders and processes",
    "cli": "The command line",
}
"""Beginning of a file's path in the package -> heading; the first that fits counts."""


def main() -> None:
    """Write the list into the page."""
    PAGE.write_text(listed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def listed(page: str) -> str:
    """The page with the list between its two marks."""
    places: dict[str, list[tuple[str, str]]] = {name: [] for name in PLACES.values()}
    for file in sorted((ROOT / "jaxatt").rglob("*.py")):
        inside = file.relative_to(ROOT / "jaxatt").as_posix()
        place = next((name for start, name in PLACES.items() if inside.startswith(start)), None)
        if place is not None:
            places[place] += messages(file.read_text(encoding="utf-8"))
    parts = [BEGIN]
    for name, rows in places.items():
        if rows:
            parts += [f"\n### {name}\n", "| it says | mend |", "| --- | --- |"]
            parts += [f"| {problem} | {mend} |" for problem, mend in dict.fromkeys(rows)]
    parts += ["", END]
    pattern = re.compile(f"{re.escape(BEGIN)}.*?{re.escape(END)}", re.DOTALL)
    return pattern.sub(lambda _: "\n".join(parts), page)


def messages(code: str) -> Iterator[tuple[str, str]]:
    """What a file says is wrong, and how to mend it."""
    for node in ast.walk(ast.parse(code)):
        if not isinstance(node, ast.Call):
            continue
        if isinstance(node.func, ast.Attribute) and node.func.attr == "fail":
            words = [said(each) for each in node.args]
            if len(words) == 3 and words[1] and words[2]:
                yield plain(f"{words[0] or '...'}: {words[1]}"), plain(words[2])
        elif isinstance(node.func, ast.Name) and node.func.id in RAISED and node.args:
            text = said(node.args[0])
            problem, found, mend = text.rpartition("; " if "; " in text else ": ")
            if len(re.findall(r"[a-z]{2,}", text)) > 3:
                yield (plain(problem), plain(mend)) if found else (plain(text), "")


def said(node: ast.expr) -> str:
    """The text of a literal, with dots for what is put into it."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(said(part) or "..." for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return said(node.left) + said(node.right)
    return ""


def plain(text: str) -> str:
    """Text that means itself in a table."""
    text = re.sub(r"(\.\.\.)+[:,]? *(?=\.\.\.)", "", text)
    return re.sub(r"([|*_<>\[\]$`])", r"\\\1", " ".join(text.split()))


if __name__ == "__main__":
    main()
