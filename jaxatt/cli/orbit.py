"""Command `jaxatt orbit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import complain, computing, finish
from jaxatt.cli.options import Cache, NoCache, Out, Quiet
from jaxatt.runtime.files import prepare_folder
from jaxatt.studies.orbit_course.course import course_of
from jaxatt.studies.orbit_course.reading import known_orbit
from jaxatt.studies.orbit_course.result import OrbitCourse


def orbit(
    case: Annotated[
        str,
        typer.Argument(
            metavar="NAME_OR_FILE",
            help="A TLE, an OMM, an OEM, or a scenario or flight with its orbit.",
        ),
    ],
    hours: Annotated[
        float | None,
        typer.Option(min=1e-3, max=1e5, help="How long.", show_default="three revolutions"),
    ] = None,
    epoch: Annotated[
        str,
        typer.Option(
            metavar="UTC", help="When to start, 2026-06-21T12:00:00Z.", show_default="the file's"
        ),
    ] = "",
    object_: Annotated[
        str,
        typer.Option(
            "--object",
            metavar="NAME",
            help="Name or catalogue number, in a file of several.",
            show_default="the only one",
        ),
    ] = "",
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Show an orbit: elements, ground track, eclipses, the sun above its plane, magnetic field."""
    with computing(compile_cache, no_cache):
        known = known_orbit(case, object_, epoch)
        folder = prepare_folder(out or Path("results") / f"{known.name}-orbit")
        found = OrbitCourse(course_of(known, None if hours is None else 3600.0 * hours))
        finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
        for note in known.notes if quiet else ():
            complain(f"Note: {note}")
