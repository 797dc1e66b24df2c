"""Notebooks run from top to bottom, in a kernel that ends with them."""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
CELL_TIMEOUT_S = 600


def run_notebook(name: str, folder: Path, probe: str = "", optimised: bool = True) -> Any:
    """Run a percent script in a fresh kernel of this very Python; return the executed notebook.

    probe : a last cell that only the test adds, to print what the notebook's variables hold.
    optimised : compiled as users have it; otherwise as in tests (tests/conftest.py), whose programs
    it shares: for notebooks that compile for longer than they run.

    Raises `nbclient.exceptions.CellExecutionError` where a cell fails.
    """
    with warnings.catch_warnings():
        # Jupyter announces where it will look for its own files.
        warnings.filterwarnings("ignore", "Jupyter is migrating", DeprecationWarning)
        import jupytext
        import nbformat
        from jupyter_client.kernelspec import KernelSpecManager
        from jupyter_client.manager import AsyncKernelManager
        from nbclient import NotebookClient

        # A kernel of its own name: a "python3" installed by the user might be another Python.
        kernel = folder / "kernels" / "this-python"
        kernel.mkdir(parents=True)
        specification = {
            "argv": [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"],
            "display_name": "this Python",
            "language": "python",
            "env": {"MPLBACKEND": "agg"} | ({"XLA_FLAGS": ""} if optimised else {}),
        }
        (kernel / "kernel.json").write_text(json.dumps(specification), encoding="utf-8")
        known = KernelSpecManager(kernel_dirs=[str(folder / "kernels")])
        notebook = jupytext.read(NOTEBOOKS / f"{name}.py")
        if probe:
            notebook.cells.append(nbformat.v4.new_code_cell(probe))
        return NotebookClient(
            notebook,
            km=AsyncKernelManager(kernel_name="this-python", kernel_spec_manager=known),
            timeout=CELL_TIMEOUT_S,
            resources={"metadata": {"path": str(folder)}},
        ).execute(cleanup_kc=True)  # Else the kernel stays, and its memory.


def printed(notebook: Any) -> Any:
    """What the probe printed, as JSON."""
    return json.loads(notebook.cells[-1]["outputs"][0]["text"])


def outputs(notebook: Any, kind: str) -> list[str]:
    """All outputs of a MIME type."""
    return [
        output["data"][kind]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if kind in output.get("data", {})
    ]


def complaints(notebook: Any) -> list[Any]:
    """All that went to standard error."""
    return [o for c in notebook.cells for o in c.get("outputs", []) if o.get("name") == "stderr"]
