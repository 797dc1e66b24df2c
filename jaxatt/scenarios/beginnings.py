"""Files to begin with: a vehicle and a scenario of one's own numbers, with comments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from string import Template
from typing import Any

import numpy as np

from jaxatt.problems.reading.fields import ScenarioError


@dataclass(frozen=True)
class Beginning:
    """Templates of one kind of problem.

    vehicle, scenario : names of templates that are put together.
    command : that takes the scenario.  torque : usual one of its actuators [N m].
    """

    title: str
    vehicle: tuple[str, ...]
    scenario: tuple[str, ...]
    command: str = "solve"
    torque: float = 3e-3


BEGINNINGS: Mapping[str, Beginning] = {
    "hands-off": Beginning(
        "Slew with wheels in the fewest active intervals",
        ("vehicle", "wheels"),
        ("heading", "orbit", "hands-off"),
    ),
    "thrusters": Beginning(
        "Slew with thrusters in the fewest active intervals",
        ("vehicle", "thrusters"),
        ("heading", "thrusters-case"),
        torque=0.01,
    ),
    "minimum-time": Beginning(
        "Turn in the shortest time", ("vehicle", "wheels"), ("heading", "minimum-time")
    ),
    "net-power": Beginning(
        "Turn that earns the most energy",
        ("vehicle", "wheels", "panels"),
        ("heading", "net-power"),
    ),
    "flight": Beginning(
        "Flight of a feedback law",
        ("vehicle", "wheels"),
        ("heading", "orbit", "flight"),
        command="simulate",
    ),
}
"""Kinds of problems to begin with."""

_USUAL: Mapping[str, Any] = {
    "inertia": np.array([0.08, 0.11, 0.04]),
    "wheel_inertia": 2.1e-4,
    "wheel_speed": 500.0,
    "target": np.array([90.0, 45.0, 15.0]),
    "horizon": 70.0,
}
"""Numbers of a small satellite, in the units of `begin`."""


def begin(kind: str, name: str, given: Mapping[str, Any]) -> dict[str, str]:
    """Texts of the files vehicle.toml and scenario.toml.

    kind : one of `BEGINNINGS`.
    given : numbers in place of those of a small satellite: inertia (3,), principal moments
    [kg m^2], wheel_inertia [kg m^2], torque [N m], wheel_speed [rad/s], target (3,) [deg] and
    horizon [s].
    Raises `ScenarioError` for a number that such files do not have.
    """
    chosen = BEGINNINGS[kind]
    numbers = {**_USUAL, "torque": chosen.torque, **given}
    rows = "".join(f"    {row},\n" for row in np.diag(numbers["inertia"]).tolist())
    values = {
        **numbers,
        "name": name,
        "title": chosen.title,
        "inertia": f"[\n{rows}]",
        "target": list(map(float, numbers["target"])),
    }
    texts = {
        "vehicle.toml": Template("".join(map(_text, chosen.vehicle))),
        "scenario.toml": Template("".join(map(_text, chosen.scenario))),
    }
    known = {each for text in texts.values() for each in text.get_identifiers()}
    for key in given:
        if key not in known:
            option = f"--{key.replace('_', '-')}"
            raise ScenarioError(f"{option}: files of kind {kind} have no such number; drop it")
    return {name: text.substitute(values) for name, text in texts.items()}


def _text(name: str) -> str:
    file = resources.files("jaxatt.scenarios") / "templates" / f"{name}.toml"
    return file.read_text(encoding="utf-8")
