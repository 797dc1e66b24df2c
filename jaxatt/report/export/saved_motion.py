"""Attitude over time, relative to inertial axes, of a result that was saved."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.attitude.attitude_path import AttitudePath, turn_between
from jaxatt.environment import epoch
from jaxatt.environment.motion import Motion
from jaxatt.problems.along_orbit import to_inertial
from jaxatt.problems.reading.dates import moment_of
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.report.archive import ARCHIVES, open_archive
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    import datetime as dt

    import xarray

_JOINED = 1e-6
"""[rad] and [rad/s] by which the end of a phase and the start of the next differ by rounding."""


@dataclass(frozen=True, eq=False)
class SavedMotion:
    """Motion of a saved result.

    name : of its scenario.
    paths : one for each span without a jump, with times from the scenario's start.
    orbit : motion along it; None without one.  epoch : of the start, UTC; None where there is none.
    """

    name: str
    paths: tuple[AttitudePath, ...]
    orbit: Motion | None
    epoch: dt.datetime | None


def saved_motion(result: str | Path, run: int = 0) -> SavedMotion:
    """Read the motion of a result's folder, or of its archive itself.

    run : of a campaign.
    Raises `ScenarioError` where there is no archive, or none with an attitude.
    """
    place = Path(result)
    found = _opened(place)
    document = json.loads(found.attrs.get("scenario_document") or found.attrs["document"])
    if "run" in found.dims:
        found = _one_run(found, run, place)
    elif run:
        raise ScenarioError(f"{place}: run {run}: it has one run only; leave the number out")
    if "q_ib" not in found and "q_ob" not in found:
        raise ScenarioError(
            f"{place}: holds no attitude (it is of {found.attrs['scenario']}); give the result of "
            "a spacecraft"
        )
    legs = _legs(found)
    where = str(found.attrs.get("scenario_folder", ""))
    sky = _sky(document, Path(where) if where else None, str(place), float(legs[-1]["time"][-1]))
    return SavedMotion(
        str(found.attrs["scenario"]),
        _joined(_paths(legs, sky.motion)),
        sky.motion,
        None if sky.days is None else moment_of(sky.days),
    )


def _sky(document: dict[str, Any], folder: Path | None, origin: str, last: float) -> Sky:
    """Orbit and date of a scenario's document, for a motion of `last` [s]."""
    date = document.get("environment", {}).get("epoch")
    days = None if date is None else epoch.days_since_j2000(epoch.parse(date))
    if "orbit" not in document:
        return Sky(days=days)
    orbit = read_orbit(document["orbit"], origin, folder, [], days)
    return sky_over(covering(orbit, document["orbit"], origin, last), folder)


def _opened(place: Path) -> xarray.Dataset:
    files = [place / name for name in ARCHIVES] if place.is_dir() else [place]
    for file in files:
        if file.is_file():
            try:
                return open_archive(file)
            except (OSError, ValueError, KeyError):
                raise ScenarioError(
                    f"{file}: is no archive of a result; give the folder that `jaxatt solve`, "
                    "`plan` or `simulate` has written"
                ) from None
    raise ScenarioError(
        f"{place}: holds neither {' nor '.join(ARCHIVES)}; give the folder that `jaxatt solve`, "
        "`plan` or `simulate` has written"
    )


def _one_run(found: xarray.Dataset, run: int, place: Path) -> xarray.Dataset:
    runs = found.sizes["run"]
    if run >= runs:
        raise ScenarioError(f"{place}: run {run}: there are {runs}, counted from 0; give less")
    one = found.isel(run=run)
    if int(one["ending"]):
        raise ScenarioError(
            f"{place}: run {run} failed after {float(one['ended']):g} s; choose one that flew to "
            "the end"
        )
    return one


def _legs(found: xarray.Dataset) -> list[dict[str, Any]]:
    """Times (n,) from the scenario's start, and the series at them, of every phase.

    What was flown after the end of a phase's horizon is left out where another phase follows.
    """
    phases = (
        [found.isel(leg=i) for i in range(found.sizes.get("leg", 1))]
        if "leg" in found.dims
        else [found]
    )
    legs = []
    for number, phase in enumerate(phases):
        time = np.asarray(phase["node_time" if "node_time" in phase else "time"], float)
        name = "q_ib" if "q_ib" in phase else "q_ob"
        kept = np.isfinite(np.asarray(phase[name])).all(axis=1) & np.isfinite(time)
        if number + 1 < len(phases) and "coasting" in phase:
            kept &= ~np.nan_to_num(np.asarray(phase["coasting"], float)).astype(bool)
        start = float(phase["leg_start"]) if "leg_start" in phase else 0.0
        series = ("q_ib", "omega_ib", "q_ob", "omega_ob")
        legs.append(
            {"time": start + time[kept]}
            | {name: np.asarray(phase[name], float)[kept] for name in series if name in phase}
        )
    return legs


def _paths(legs: list[dict[str, Floats]], orbit: Motion | None) -> list[AttitudePath]:
    """Inertial path of every phase."""
    if "q_ib" in legs[0]:
        return [AttitudePath(leg["time"], leg["q_ib"], leg["omega_ib"]) for leg in legs]
    whole = [np.concatenate([leg[key] for leg in legs]) for key in ("time", "q_ob", "omega_ob")]
    edges = np.cumsum([len(leg["time"]) for leg in legs])[:-1]
    parts = [np.split(part, edges) for part in to_inertial(orbit, *whole)]
    return [AttitudePath(leg["time"], q, omega) for leg, q, omega in zip(legs, *parts, strict=True)]


def _joined(paths: list[AttitudePath]) -> tuple[AttitudePath, ...]:
    """Paths, where those of which one begins as the other ends are one."""
    joined = paths[:1]
    for path in paths[1:]:
        before = joined[-1]
        turn = turn_between(np.stack([before.q[-1], path.q[0]]))
        jump = np.abs(np.concatenate([turn[0], before.omega[-1] - path.omega[0]])).max()
        if jump > _JOINED or abs(path.time[0] - before.time[-1]) > _JOINED:
            joined.append(path)
            continue
        joined[-1] = AttitudePath(
            *(
                np.concatenate([getattr(before, part), getattr(path, part)[1:]])
                for part in ("time", "q", "omega")
            )
        )
    return tuple(joined)
