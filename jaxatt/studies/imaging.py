"""Ground sampling distance of a push-broom camera while slewing and while pointing to nadir."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from rich import box
from rich.table import Table as RichTable
from rich.text import Text

from jaxatt.attitude import quaternion
from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_text
from jaxatt.environment import epoch, kepler, orbit
from jaxatt.environment.ellipsoid import EQUATORIAL_RADIUS, POLAR_RADIUS
from jaxatt.environment.motion import TwoBody
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.keys import Number, Numbers, TableKey
from jaxatt.problems.reading.keys import Text as TextKey
from jaxatt.problems.reading.tables.manoeuvre import HEADING
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import write_json
from jaxatt.scenarios.bundled import text
from jaxatt.simulation.slew_metrics import footprints, sampling_distance

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


NAME = "hypso1-imaging"

_LINES = 400
"""Lines of which the distance to the next one is taken, over the whole image."""

_KEYS = TableKey(
    "images of the ground",
    {
        **HEADING,
        "altitudes_km": Numbers("altitudes", required=True, example="[500.0]"),
        "inclination_deg": Number("inclination of the orbit", at_most=180.0, required=True),
        "latitude_deg": Number("latitude that is overflown", at_most=90.0, required=True),
        "duration_s": Number("length of the image", above=0.0, required=True),
        "nadir_quaternion": Numbers("attitude of the nadir image", size=4, required=True),
        "first_angle_deg": Number("pitch at which the slew begins", required=True),
        "rate_rad_s": Numbers("rate of the slew", size=3, required=True),
        "epoch": TextKey("moment (UTC)", required=True),
        "printed_nadir_m": Number("printed distance of the nadir image", above=0.0),
        "printed_slew_m": Number("printed distance of the slew", above=0.0),
    },
)


@dataclass(frozen=True)
class Row:
    """Mean ground sampling distances at one altitude [km].

    frame_rate : [1/s], with which the nadir image has its printed distance.  slew_m : [m], mean
    distance of the slew at that rate.
    """

    altitude_km: float
    frame_rate: float
    nadir_m: float
    slew_m: float


@dataclass(frozen=True, eq=False)
class Imaging:
    """Distances by altitude, and over time at the altitude at which both printed distances hold.

    fitted_km : [km].  time : (T,) [s].  nadir, slew : (T,) [m], at the fitted altitude.
    """

    title: str
    source: str
    printed: Mapping[str, float]
    rows: tuple[Row, ...]
    fitted: Row
    time: Floats
    nadir: Floats
    slew: Floats

    def table(self) -> RichTable:
        """Return the comparison as a rich table."""
        table = RichTable(
            title=Text(f"{self.title}\nprinted: {self.source}", style="bold"),
            caption=Text(
                f"The nadir image fixes the frame rate; both printed distances hold together at "
                f"{self.fitted.altitude_km:.0f} km only."
            ),
            box=box.SIMPLE_HEAD,
            title_justify="left",
            caption_justify="left",
        )
        for name in ("altitude [km]", "frame rate [1/s]", "nadir [m]", "slew [m]"):
            table.add_column(Text(name), justify="right")
        table.add_row("printed", "", f"{self.printed['nadir']:g}", f"{self.printed['slew']:g}")
        for row in (*self.rows, self.fitted):
            table.add_row(
                f"{row.altitude_km:.1f}",
                f"{row.frame_rate:.2f}",
                f"{row.nadir_m:.1f}",
                f"{row.slew_m:.1f}",
            )
        return table

    def plot(self) -> Picture:
        """Plot the distance over time, as figure 12.9."""
        figure = picture(8.0, 3.6, f"{self.title}\n{self.fitted.altitude_km:.0f} km")
        axes = figure.subplots()
        for index, (name, values) in enumerate((("nadir", self.nadir), ("slew", self.slew))):
            axes.plot(self.time, values, color=colour(index), label=name)
            axes.axhline(self.printed[name], color=colour(index), linestyle=":", linewidth=1.0)
        axes.set_xlabel("time [s]")
        axes.set_ylabel("ground sampling\ndistance [m]")
        axes.set_ylim(bottom=0.0)
        axes.legend(frameon=False)
        tidy(axes)
        return figure

    def save(self, folder: str | Path) -> list[Path]:
        """Write comparison.json and the figure."""
        with filling(folder) as partial:
            content = {
                "scenario": NAME,
                "source": self.source,
                "printed_m": dict(self.printed),
                "rows": [asdict(row) for row in self.rows],
                "fitted": asdict(self.fitted),
            }
            write_json(content, partial / "comparison.json")
            save_figure(self.plot(), partial / "ground_sampling.png")
        return [Path(folder) / name for name in ("comparison.json", "ground_sampling.png")]

    def __repr__(self) -> str:
        found = self.fitted
        return (
            f"Imaging(nadir {found.nadir_m:.1f} m and slew {found.slew_m:.1f} m at "
            f"{found.altitude_km:.0f} km and {found.frame_rate:.2f} frames a second)"
        )

    def __str__(self) -> str:
        return as_text(self.table())


def compare_imaging(document: Mapping[str, Any] | None = None) -> Imaging:
    """Compute the distances of table 12.2 of Kristiansen (2023) at several altitudes, on WGS 84.

    document : as the bundled TOML file has it, which is taken by default.
    """
    data = dict(parse(text(NAME), NAME) if document is None else document)
    table = Table(data, NAME, "", _KEYS)
    case = _Case(table)
    printed = {k: table.number(f"printed_{k}_m") for k in ("nadir", "slew")}
    altitudes = table.require("altitudes_km")
    rows = tuple(case.row(float(altitude), printed["nadir"]) for altitude in altitudes)
    low, high = 300.0, 900.0
    for _ in range(20):
        middle = 0.5 * (low + high)
        slower = case.row(middle, printed["nadir"]).slew_m > printed["slew"]
        low, high = (middle, high) if slower else (low, middle)
    fitted = case.row(high, printed["nadir"])
    nadir, time = case.distances(high, fitted.frame_rate, slewing=False)
    slew, _ = case.distances(high, fitted.frame_rate, slewing=True)
    title, source = table.text("title", NAME), table.text("source", "not stated")
    return Imaging(title, source, printed, rows, fitted, time, nadir, slew)


class _Case:
    def __init__(self, table: Table) -> None:
        self.inclination = math.radians(table.number("inclination_deg"))
        self.latitude = math.radians(table.number("latitude_deg"))
        self.duration = table.number("duration_s")
        offset = table.vector("nadir_quaternion")
        self.nadir = offset / np.linalg.norm(offset)
        self.first = math.radians(table.number("first_angle_deg"))
        self.rate = table.vector("rate_rad_s")
        self.days = epoch.days_since_j2000(epoch.parse(table.text("epoch")))
        if abs(math.sin(self.latitude)) >= abs(math.sin(self.inclination)):
            table.fail("latitude_deg", "is never overflown", "give a latitude below the orbit's")

    def row(self, altitude_km: float, printed_nadir: float) -> Row:
        one = float(self.distances(altitude_km, 1.0, slewing=False)[0].mean())
        rate = one / printed_nadir
        return Row(
            altitude_km,
            rate,
            float(self.distances(altitude_km, rate, slewing=False)[0].mean()),
            float(self.distances(altitude_km, rate, slewing=True)[0].mean()),
        )

    def distances(
        self, altitude_km: float, frame_rate: float, *, slewing: bool
    ) -> tuple[Floats, Floats]:
        """Distances (T,) [m] and their times (T,) [s], centred on the pass over the latitude."""
        flat = (POLAR_RADIUS / EQUATORIAL_RADIUS) ** 2
        # Geocentric radius of the ellipsoid below, for a geocentric latitude.
        sin, cos = math.sin(self.latitude), math.cos(self.latitude)
        ground = POLAR_RADIUS / math.sqrt(sin**2 + flat * cos**2)
        axis = ground + 1e3 * altitude_km
        # Descending, as a morning pass of a sun-synchronous orbit.
        along = math.pi - math.asin(sin / math.sin(self.inclination))
        motion = float(orbit.mean_motion(axis))
        start = along - 0.5 * motion * self.duration
        elements = kepler.KeplerianElements(
            *(jnp.asarray(v) for v in (axis, 0.0, self.inclination, 0.0, 0.0, start))
        )
        first = np.linspace(0.0, self.duration - 1.0 / frame_rate, _LINES)
        begun = quaternion.from_axis_angle(jnp.array([0.0, 1.0, 0.0]), jnp.asarray(self.first))
        q_ob, rate = (begun, self.rate) if slewing else (jnp.asarray(self.nadir), np.zeros(3))
        found = _between(
            TwoBody(elements, jnp.asarray(orbit.MU_EARTH)),
            jnp.asarray(self.days),
            first,
            jnp.asarray(1.0 / frame_rate),
            q_ob,
            rate,
        )
        return np.asarray(found), first


@jax.jit
def _between(
    motion: TwoBody,
    days: jax.Array,
    first: jax.Array,
    period: jax.Array,
    start: jax.Array,
    rate: jax.Array,
) -> jax.Array:
    """Distance (T,) [m] between the lines taken at `first` [s] and those one period later."""

    def at(times: jax.Array) -> jax.Array:
        turned = quaternion.from_rotation_vector(jnp.outer(times, rate))
        q_ob = quaternion.multiply(start, turned)
        return footprints(motion, days, times, q_ob)

    return sampling_distance(jnp.stack([at(first), at(first + period)]))[0]
