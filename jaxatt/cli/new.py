"""Command `jaxatt new`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from jaxatt.cli.common import clean_exit, numbers, say
from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.vehicles import vehicle_from_mapping
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import OutputError, filling, prepare_folder
from jaxatt.scenarios.beginnings import BEGINNINGS, begin
from jaxatt.scenarios.schema_line import schema_line
from jaxatt.studies.file_kinds import faults_of, kind_of_document


class Kind(StrEnum):
    """Problems that files are written for."""

    hands_off = "hands-off"
    thrusters = "thrusters"
    minimum_time = "minimum-time"
    net_power = "net-power"
    flight = "flight"


def new(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Where vehicle.toml and scenario.toml go.")
    ] = Path("satellite"),
    kind: Annotated[Kind, typer.Option(help="What is to be found.")] = Kind.hands_off,
    inertia: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help=r"Principal moments of inertia \[kg m^2].",
            show_default="0.08,0.11,0.04",
        ),
    ] = None,
    torque: Annotated[
        float | None,
        typer.Option(
            help="Largest torque of a wheel or thruster [N m].",
            show_default="0.003, thrusters 0.01",
        ),
    ] = None,
    wheel_inertia: Annotated[
        float | None,
        typer.Option(help=r"Inertia of a wheel about its axis \[kg m^2].", show_default="2.1e-4"),
    ] = None,
    wheel_speed: Annotated[
        float | None, typer.Option(help=r"Fastest speed of a wheel \[rad/s].", show_default="500")
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            metavar="ROLL,PITCH,YAW", help=r"Attitude at the end \[deg].", show_default="90,45,15"
        ),
    ] = None,
    horizon: Annotated[
        float | None,
        typer.Option(help=r"Length of a manoeuvre whose time is fixed \[s].", show_default="70"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite files.")] = False,
) -> None:
    """Write a commented vehicle and scenario of one's own numbers."""
    with clean_exit():
        given = {
            "inertia": None if inertia is None else _three(inertia, "--inertia"),
            "torque": torque,
            "wheel_inertia": wheel_inertia,
            "wheel_speed": wheel_speed,
            "target": None if target is None else _three(target, "--target"),
            "horizon": horizon,
        }
        asked = {key: value for key, value in given.items() if value is not None}
        texts = begin(kind.value, folder.resolve().name, asked)
        for name, text in texts.items():
            document = parse(text, name)
            kind_of_file = kind_of_document(document)
            refuse(faults_of(document, name, kind_of_file))
            if kind_of_file == "vehicle":
                vehicle_from_mapping(document, name)
            if (folder / name).exists() and not force:
                raise OutputError(f"{folder / name}: is there already; give --force to overwrite")
        with filling(prepare_folder(folder)) as partial:
            for name, text in texts.items():
                head = schema_line(kind_of_document(parse(text, name)))
                (partial / name).write_text(head + text, encoding="utf-8")
        command = f"jaxatt {BEGINNINGS[kind.value].command} {folder / 'scenario.toml'}"
        say(f"Written to {folder}: {', '.join(texts)}. Next: {command}")


def _three(text: str, option: str) -> Floats:
    found = np.array(numbers(text, option))
    if found.shape != (3,):
        raise ScenarioError(f"{option} {text}: has {len(found)} numbers; give three")
    return found
