"""Command `jaxatt conventions`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, numbers, say
from jaxatt.exchange.conventions import conventions as in_every_convention
from jaxatt.problems.reading.attitudes import read_attitude
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.attitude import ATTITUDE_KEYS


def conventions(
    attitude: Annotated[
        str, typer.Option(help="Roll, pitch and yaw in degrees, as attitude_deg.")
    ] = "90,45,15",
    quaternion: Annotated[
        str | None,
        typer.Option(help="Scalar first, body to inertial, instead.", show_default=False),
    ] = None,
) -> None:
    """Print one attitude as CCSDS, STK, Basilisk, SPICE and others write it."""
    with clean_exit():
        key, given = "attitude_deg", numbers(attitude, "--attitude")
        if quaternion is not None:
            key, given = "attitude_quaternion", numbers(quaternion, "--quaternion")
        table = Table({key: given}, "command line", "", ATTITUDE_KEYS)
        for row in in_every_convention(read_attitude(table, [])):
            unit = "deg" if row.degrees else ""
            texts = "".join(f"{0.0 + round(x, 9):14.9f}" for x in row.numbers)
            say(f"{row.whose:<12} {row.form:<44}{texts:<56} {unit}".rstrip())
