"""A non-linear program as compiled C, and the solver over it."""

from __future__ import annotations

import contextlib
import hashlib
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import casadi as ca

FLAGS = ("-O2", "-march=native", "-fPIC", "-shared")


def compiled_solver(
    plugin: str,
    program: dict[str, Any],
    options: dict[str, Any],
    folder: Path,
    flags: tuple[str, ...] = FLAGS,
) -> ca.Function:
    """A solver whose functions and derivatives are compiled C.

    plugin : "ipopt" or "fatrop".  program : x, f, g as for `casadi.nlpsol`.
    folder : where source and library go; a library of the same source and flags is used again.
    """
    folder = folder.resolve()
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes"} if plugin == "ipopt" else {}
    options = {"print_time": False, **quiet, **options}
    interpreted = ca.nlpsol("program", plugin, program, options)
    name = f"{plugin}_program"
    # Of this process alone: others write the same source at the same time.
    with tempfile.TemporaryDirectory(dir=folder) as own:
        with contextlib.chdir(own):  # CasADi writes its source into the working directory
            interpreted.generate_dependencies(f"{name}.c")
        source, made = Path(own, f"{name}.c"), Path(own, f"{name}.so")
        key = hashlib.sha256(source.read_bytes() + " ".join(flags).encode()).hexdigest()[:16]
        library = folder / f"{name}_{key}.so"
        if not library.exists():
            subprocess.run(["cc", *flags, str(source), "-o", str(made)], check=True)
            made.replace(library)
    return ca.nlpsol("compiled", plugin, str(library), options)
