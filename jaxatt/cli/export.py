"""Command `jaxatt export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import computing, say
from jaxatt.cli.options import Quiet
from jaxatt.report.export.export import export as write
from jaxatt.report.export.files import Format
from jaxatt.runtime.files import prepare_folder


def export(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Folder of a solve, plan or simulation.")
    ],
    form: Annotated[
        Format,
        typer.Option(
            "--format", help="CCSDS AEM 2 (aem, aem-xml) or 1 (aem-1), STK .a, or a table."
        ),
    ] = Format.aem,
    epoch: Annotated[
        str | None,
        typer.Option(
            metavar="UTC", help="When the scenario starts.", show_default="the scenario's epoch"
        ),
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(
            min=1e-6,
            help="Seconds between two attitudes, at most.",
            show_default="a tenth of the result's",
        ),
    ] = None,
    orbit: Annotated[bool, typer.Option("--orbit", help="The orbit, too, as a CCSDS OEM.")] = False,
    run: Annotated[int, typer.Option(min=0, help="Run of a campaign.")] = 0,
    name: Annotated[
        str | None,
        typer.Option(help="OBJECT_NAME of CCSDS files.", show_default="the scenario's name"),
    ] = None,
    designator: Annotated[
        str, typer.Option("--object-id", help="OBJECT_ID of CCSDS files, such as 2022-002B.")
    ] = "UNKNOWN",
    out: Annotated[
        Path | None, typer.Option(help="Folder for the files.", show_default="the result's")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the flown attitude, from EME2000 to body, as a file for other tools."""
    with computing():
        if out is not None:
            prepare_folder(out)
        files = write(
            result,
            out,
            form=form,
            epoch=epoch,
            step=step,
            orbit=orbit,
            run=run,
            name=name,
            designator=designator,
        )
        if quiet:
            say("; ".join(str(file.path) for file in files))
            return
        for file in files:
            say(f"{file.path.name}: {file.contents}")
        say(f"Written to {files[0].path.parent}")
