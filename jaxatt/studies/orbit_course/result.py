"""An orbit followed for some time, as a result that prints, draws and saves itself."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.runtime.files import filling
from jaxatt.runtime.json_files import plain, write_json
from jaxatt.studies.orbit_course.course import Course, course_of
from jaxatt.studies.orbit_course.numbers import course_numbers
from jaxatt.studies.orbit_course.reading import known_orbit
from jaxatt.studies.orbit_course.view import course_figure, course_table

if TYPE_CHECKING:
    import xarray

    from jaxatt.drawing.picture import Picture

_SERIES = {
    "position": ("axis", "m", "position in inertial axes (EME2000)"),
    "velocity": ("axis", "m/s", "velocity in inertial axes (EME2000)"),
    "attitude": ("quaternion", "1", "q_io, attitude of the orbit frame, scalar first"),
    "rate": ("axis", "rad/s", "omega_io, rate of the orbit frame, in orbit axes"),
    "latitude": (None, "rad", "geodetic latitude below"),
    "longitude": (None, "rad", "longitude below, east"),
    "altitude": (None, "m", "height above the WGS 84 ellipsoid"),
    "sun": ("axis", "1", "direction of the sun in inertial axes"),
    "light": (None, "1", "share of the sun's disk that is seen"),
    "beta": (None, "rad", "angle of the sun above the plane of the orbit"),
    "field": ("axis", "T", "magnetic field in inertial axes"),
}


@dataclass(frozen=True, eq=False)
class OrbitCourse:
    """Ground track, eclipses, sun and magnetic field of an orbit over some time."""

    course: Course

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, ready for JSON."""
        return course_numbers(self.course)

    def table(self) -> Table:
        """Return a rich table."""
        return course_table(self.to_dict())

    def plot(self) -> Picture:
        """Draw the ground track, and light, altitude, beta and field over time."""
        return course_figure(self.course, self.course.known.title)

    def to_dataset(self) -> xarray.Dataset:
        """Labelled series with the numbers as attributes, in SI units and radians."""
        import xarray

        known = self.course.known
        series = {
            name: (
                ("time",) if inner is None else ("time", inner),
                getattr(self.course, name),
                {"units": unit, "long_name": words},
            )
            for name, (inner, unit, words) in _SERIES.items()
            if getattr(self.course, name) is not None
        }
        numbers = self.to_dict()
        time = ("time", self.course.times, {"units": "s", "long_name": "time from the epoch"})
        return xarray.Dataset(
            series,
            coords={
                "time": time,
                "axis": ["x", "y", "z"],
                "quaternion": ["w", "x", "y", "z"],
            },
            attrs={
                "name": known.name,
                "title": known.title,
                "source": numbers["source"],
                "epoch": numbers["epoch"],
                "days_since_j2000": known.orbit.days,
                "frame": numbers["frame"],
                "numbers": json.dumps(plain(numbers)),
            },
        )

    def save(self, folder: str | Path) -> list[Path]:
        """Write summary, archive and figure; either all of them appear, or none."""
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / "summary.json")
            self.to_dataset().to_netcdf(partial / "orbit.nc", engine="h5netcdf")
            save_figure(self.plot(), partial / "orbit.png")
        return [Path(folder) / name for name in ("orbit.nc", "orbit.png", "summary.json")]

    def __repr__(self) -> str:
        numbers = self.to_dict()
        return (
            f"{numbers['title']}: {numbers['eclipse_percent']:.1f} % in eclipse, beta "
            f"{numbers['beta_deg'][0]:.2f} deg at {numbers['epoch']}"
        )

    def __str__(self) -> str:
        return as_text(self.table())

    def _repr_html_(self) -> str:
        return as_html(self.table())


def orbit_course(
    case: str | Path, hours: float | None = None, *, wanted: str = "", epoch: str = ""
) -> OrbitCourse:
    """Follow the orbit of a scenario, a flight, or a TLE, OMM or OEM.

    hours : how long; three revolutions by default.
    wanted : name or number of the object, where a file holds several.
    epoch : the moment to start at, such as 2026-06-21T12:00:00Z; by default the file's.
    Raises `ScenarioError`.
    """
    known = known_orbit(case, wanted, epoch)
    return OrbitCourse(course_of(known, None if hours is None else 3600.0 * hours))
