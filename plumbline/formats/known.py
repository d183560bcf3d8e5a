"""All formats, one row each in `FORMATS`: what is read and what is written.

A format of picked points is one module with

    recognises(source) -> bool                   whether a file looks like it; never raises
    read(source, options) -> Observations        see `Format.read`
    write(observations) -> bytes                 only where the row says that points are written

and one row here. The choices of `--format`, the suffixes that `convert`, `fit -o` and `export`
take, and the corpus of hostile files in the tests all come from this table. A module is loaded
when it is first asked, so that the table itself costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Literal, Protocol, cast

from plumbline.errors import OptionError
from plumbline.formats.base import ReadOptions, Source

if TYPE_CHECKING:
    from plumbline.observations import Observations

Kind = Literal["points", "results", "lens", "zoom"]
"""What a file holds: picked points, the results of fits, one lens in a program's own words, or the
lens of a zoom."""

_FOCAL = ("focal_mm", "focal_px", "crop_factor")
_LABELS = (*_FOCAL, "maker", "model", "mount", "aspect_ratio")
"""Facts of a lens, by the names of `LensFacts`."""


class _PointFormat(Protocol):
    """The module of a format of picked points."""

    def recognises(self, source: Source, /) -> bool: ...
    def read(self, source: Source, options: ReadOptions, /) -> Observations: ...
    def write(self, observations: Observations, /) -> bytes: ...


@dataclass(frozen=True)
class Format:
    """One file format: a row of `FORMATS`.

    Attributes:
        name: Name for `--format` and `export --to`.
        title: What it is, for people.
        suffixes: File name suffixes it may have, in lower case, with the dot; written is the
            first.
        module: Its module below `plumbline.formats`; empty where only lenses are written.
        reads: Whether picked points are read from it.
        packed: Whether its files may be archives, which the module opens itself.
        writes: What is written to it.
        facts: What the file of a lens says of it besides the distortion, by the names of
            `LensFacts`.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    module: str = ""
    reads: bool = True
    packed: bool = False
    writes: tuple[Kind, ...] = ()
    facts: tuple[str, ...] = ()

    def recognises(self, source: Source) -> bool:
        """Whether a file looks like this format."""
        return self.reads and self._points().recognises(source)

    def read(self, source: Source, options: ReadOptions | None = None) -> Observations:
        """Picked points of a file.

        Returns:
            Observations that may lack the photo's size and are not yet checked
            (`Observations.checked`); coordinates are plumbline's own, and `Line.rows` tells
            where in the file each point stands. A grid is rows and columns already.

        Raises:
            ReadError: the file is damaged or not of this format.
        """
        from plumbline.formats.grid import rows_and_columns

        how = options or ReadOptions()
        found = self._points().read(source, how)
        return found if how.grid is None else rows_and_columns(source, found, how.grid, how.order)

    def write(self, observations: Observations) -> bytes:
        """The file that holds picked points.

        Raises:
            OptionError: the format cannot hold them.
        """
        return self._points().write(observations)

    def _points(self) -> _PointFormat:
        return cast(_PointFormat, import_module(f"plumbline.formats.{self.module}"))


def _lens(
    name: str, title: str, suffix: str, *more: Kind, facts: tuple[str, ...] = _FOCAL
) -> Format:
    return Format(name, title, (suffix,), reads=False, writes=("lens", *more), facts=facts)


FORMATS: dict[str, Format] = {
    row.name: row
    for row in (
        Format(
            "json",
            "plumbline's own JSON: points, or the results of fits",
            (".json",),
            "points.own_json",
            writes=("points", "results", "zoom"),
        ),
        Format("ptgui", "PTGui (text, JSON) or PTAssembler project", (".pts",), "panotools.ptgui"),
        Format(
            "pto",
            "Hugin project, or script for the Panorama Tools optimiser",
            (".pto",),
            "panotools.pto",
            writes=("points", "results", "lens"),
            facts=_FOCAL,
        ),
        Format("cvat", "CVAT for images 1.1", (".xml",), "points.cvat"),
        Format("cell-counter", "Fiji's Cell Counter", (".xml",), "points.cell_counter"),
        Format("svg", "SVG drawing over the photo, as of Inkscape", (".svg",), "points.svg"),
        Format("labelme", "labelme annotations", (".json",), "points.labelme"),
        Format("via", "VGG Image Annotator 1 or 2", (".csv", ".json"), "points.via"),
        Format("via3", "VGG Image Annotator 3", (".csv", ".json"), "points.via3"),
        Format("datumaro", "Datumaro annotations", (".json",), "points.datumaro"),
        Format("coco", "COCO keypoints", (".json",), "points.coco"),
        Format("geojson", "GeoJSON of QuPath or QGIS", (".geojson", ".json"), "points.geojson"),
        Format(
            "imagej",
            "ImageJ or Fiji results, XY coordinates or selections",
            (".csv", ".txt", ".xls", ".tsv", ".roi", ".zip"),
            "points.imagej",
            packed=True,
        ),
        Format("wpd-project", "WebPlotDigitizer project", (".json", ".tar"), "points.wpd_project"),
        Format(
            "webplotdigitizer",
            "WebPlotDigitizer, all datasets",
            (".csv", ".txt"),
            "points.webplotdigitizer",
        ),
        Format("napari", "napari shapes", (".csv",), "points.napari"),
        Format("makesense", "makesense.ai points", (".csv",), "points.makesense"),
        Format(
            "xlsx", "Excel workbook with a table line,x,y", (".xlsx",), "points.xlsx", packed=True
        ),
        Format("winmorph", "WinMorph project", (".mrf",), "points.winmorph"),
        Format(
            "csv",
            "table of points: line,x,y",
            (".csv", ".tsv", ".txt", ".dat"),
            "points.csv",
            writes=("points",),
        ),
        _lens("lensfun", "LensFun profile", ".xml", "results", "zoom", facts=_LABELS),
        _lens("lenses-txt", "LensFun's list of measurements", ".txt", "zoom", facts=_LABELS),
        _lens("hugin-ini", "Hugin lens file", ".ini"),
        _lens("ptlens", "PTLens profile", ".txt", facts=(*_FOCAL, "model")),
        _lens("imagemagick", "ImageMagick script", ".sh", facts=()),
        _lens("opencv", "OpenCV camera file", ".yml"),
    )
}
"""From the most to the least specific: the first that recognises a file reads it."""

POINT_FORMATS = tuple(row.name for row in FORMATS.values() if row.reads)
"""Names of the formats that picked points are read from."""


def written(kind: Kind) -> dict[str, Format]:
    """The formats that something is written to, by name."""
    return {name: row for name, row in FORMATS.items() if kind in row.writes}


def suffixes(kind: Kind) -> dict[str, Format]:
    """The formats that something is written to, by the suffix that chooses them."""
    return {row.suffixes[0]: row for row in written(kind).values()}


def recognised(source: Source) -> Format | None:
    """The format that a file of points looks like, if any does."""
    return next((each for each in FORMATS.values() if each.recognises(source)), None)


def format_of(source: Source, name: str | None = None) -> Format:
    """The format of a file of points, recognised by suffix and content or given by name.

    Raises:
        OptionError: there is no format of that name.
        ReadError: no format recognises the file.
    """
    if name is not None:
        if name not in POINT_FORMATS:
            raise OptionError(
                f"there is no format {name!r}", hint=f"choose one of {', '.join(POINT_FORMATS)}"
            )
        return FORMATS[name]
    if (found := recognised(source)) is not None:
        return found
    source.text()  # empty and binary files have sentences of their own
    raise source.error(
        "the format of this file is not recognised",
        hint=f"name it with --format, one of {', '.join(POINT_FORMATS)}",
    )
