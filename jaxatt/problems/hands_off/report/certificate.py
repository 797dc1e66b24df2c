"""Result of a certification, which prints, draws and saves itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from jaxatt.drawing.figure import save as save_figure
from jaxatt.drawing.rendering import as_html, as_text
from jaxatt.problems.hands_off.certificate import CertificateRecord
from jaxatt.problems.hands_off.report.certificate_map import plot
from jaxatt.problems.hands_off.report.certificate_numbers import to_dataset, to_dict
from jaxatt.problems.hands_off.report.certificate_table import table
from jaxatt.problems.hands_off.report.certificate_words import sentences
from jaxatt.runtime.files import filling, replacing
from jaxatt.runtime.json_files import write_json

if TYPE_CHECKING:
    import xarray

    from jaxatt.drawing.picture import Picture


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(CertificateRecord):
    """A certificate that prints, draws and saves itself; the fields are `CertificateRecord`'s."""

    def sentences(self) -> list[str]:
        """Return what was shown, in sentences."""
        return sentences(self)

    def table(self) -> Table:
        """Return a table of the classes of supports and what became of them."""
        return table(self)

    def plot(self) -> Picture:
        """Plot a map of the feasible pairs of intervals."""
        return plot(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, ready for JSON."""
        return to_dict(self)

    def to_dataset(self) -> xarray.Dataset:
        """Return every support of the found cost, with effort and residual both ways round."""
        return to_dataset(self)

    def save(self, folder: str | Path) -> list[Path]:
        """Write certificate.json, certificate.nc and certificate.png; all of them, or none."""
        names = ("certificate.json", "certificate.nc", "certificate.png")
        with filling(folder) as partial:
            write_json(self.to_dict(), partial / names[0])
            with replacing(partial / names[1]) as path:
                self.to_dataset().to_netcdf(path, engine="h5netcdf")
            save_figure(self.plot(), partial / names[2])
        return [Path(folder) / name for name in names]

    def __repr__(self) -> str:
        return f"Certificate({self.result.scenario.name}: {' '.join(self.sentences())})"

    def __str__(self) -> str:
        return as_text(self.table()) + "\n" + "\n".join(self.sentences())

    def _repr_html_(self) -> str:
        return as_html(self.table()) + "".join(f"<p>{s}</p>" for s in self.sentences())
