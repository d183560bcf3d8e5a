"""What ImageJ and Fiji save: Results tables, XY coordinates, and selections (ROIs).

     ,Area,X,Y,Counter,Count        10.5000	20.5000        RoiSet.zip, or edge.roi:
    1,0,10.500,20.500,0,4           11.2500	120.0000       a polyline each, or points
    2,0,11.250,120.000,1,4

- Results table (Analyze > Measure on points, Results.csv): columns X and Y, or XM and YM;
  the points of one line share the values of Group, Counter, ROI, Slice and Frame, as far as
  these vary, or else the Label. Points with Group 0 belong to no group and are left aside.
- XY coordinates (File > Save As): two columns without a header, one line a file. The plain
  table `csv` reads the same, so such a file is not claimed here.
- A selection file, or a zipped set: every line, polyline, freehand line and point selection
  is one line; a multi-point selection with several counters is one line a counter; selections
  of a single point are gathered by their group. Areas and angles are left aside.

ImageJ counts line and point selections from the centre of the pixel, areas from its corner
(`Roi.useLineSubpixelConvention`): nothing is added. Results and XY
coordinates are in the unit of Analyze > Set Scale; points must be saved in pixels. Dropped:
measurements, colours, positions in a stack. Source: `ij/gui/Roi.java`, `ij/plugin/filter/
Analyzer.java` and `XYWriter.java`; selections are decoded by the package roifile.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import Row, Table
from plumbline.observations import Observations
from plumbline.wording import count

MAX_LENGTH = 16 * 2**20
"""Bytes; chosen, a results table of 100,000 picks takes 5 MB."""
_MEASURED = {"Area", "Mean", "Min", "Max", "StdDev", "Angle", "Length", "Perim.", "%Area"}
_KEYS = ("Group", "Counter", "ROI", "Slice", "Frame")
_OTHERS = {"Area", "Mean", "Min", "Max", "Mode", "StdDev", "Count", "Ch", "Label", *_KEYS}
_HINT = (
    "save the selections from the ROI Manager instead (More > Save), one polyline an edge, "
    "or give the points a Group"
)


def is_results_header(cells: Sequence[str]) -> bool:
    """Whether a row of stripped cells heads an ImageJ Results table."""
    if _axes(cells) is None and len(_MEASURED.intersection(cells)) < 2:
        return False
    if "line" in map(str.lower, cells):
        return False
    known = {"", "X", "Y", "XM", "YM", *_OTHERS}
    return not _OTHERS.isdisjoint(cells) or (cells[0] == "" and known.issuperset(cells))


def _axes(cells: Sequence[str]) -> tuple[int, int] | None:
    """The columns of the coordinates: centroid, or centre of mass, which of a point is the same."""
    for x, y in (("X", "Y"), ("XM", "YM")):
        if x in cells and y in cells:
            return cells.index(x), cells.index(y)
    return None


def read(source: Source, _options: ReadOptions) -> Observations:
    """Lines of a Results table, of XY coordinates, or of selections.

    Raises:
        ReadError: the file is none of these, or its points cannot be told apart by line.
    """
    if source.content.startswith((b"Iout", b"PK")):
        from plumbline.formats.points.imagej_roi import read_selections

        return read_selections(source)
    table = Table.of(source, comments=False)
    if len(table.text) > MAX_LENGTH:
        raise source.error(f"a table of {len(table.text):,} characters is not a Results table")
    rows = [row for row in table.rows() if any(map(str.strip, row[1]))]
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    gatherer = LineGatherer(source)
    if (axes := _axes(header)) is not None:
        _gather_results(table, header, rows[1:], axes, gatherer)
    else:
        if len(header) != 2:
            raise source.error(
                "the Results table has no columns X and Y",
                1,
                "tick Centroid in Analyze > Set Measurements and measure again, or save the "
                "selections from the ROI Manager (More > Save)",
            )
        points = _coordinates(table, rows, 0, 1)
        gatherer.add(points, rows=[at for at, _ in rows])
    return gatherer.observations()


def recognises(source: Source) -> bool:
    """Whether the file is a selection, a zipped set of them, or a Results table."""
    content = source.content
    if content.startswith(b"PK\x03\x04"):
        return b".roi" in content[-65536:].lower()
    if content.startswith(b"Iout"):
        return True
    rows = Table.opening(source, comments=False).first_rows(1)
    return bool(rows) and is_results_header(rows[0])


def _gather_results(
    table: Table,
    header: list[str],
    rows: list[Row],
    axes: tuple[int, int],
    gatherer: LineGatherer,
) -> None:
    if not rows:
        raise table.source.error("the Results table holds no points", hint=_HINT)
    points = _coordinates(table, rows, *axes)
    columns = _grouping(table, header, rows)
    groups: dict[tuple[str, ...], list[int]] = {}
    for index, (_, cells) in enumerate(rows):
        key = tuple(cells[c].strip() if c < len(cells) else "" for c in columns)
        groups.setdefault(key, []).append(index)
    names = [header[c] for c in columns]
    ungrouped = 0
    for key, members in groups.items():
        values = dict(zip(names, key, strict=True))
        if values.get("Group") in {"0", "", "NaN"}:
            ungrouped += len(members)
            continue
        label = ", ".join(v if n == "Label" else f"{n} {v}" for n, v in values.items())
        gatherer.add(points[members], label, rows=[rows[i][0] for i in members])
    if ungrouped:
        gatherer.notes.append(f"{count(ungrouped, 'point')} in no group left aside")


def _grouping(table: Table, header: list[str], rows: list[Row]) -> list[int]:
    """The columns whose values tell the lines apart."""
    values: dict[str, set[Hashable]] = {}
    for name in (*_KEYS, "Label"):
        if name in header:
            c = header.index(name)
            values[name] = {cells[c].strip() for _, cells in rows if c < len(cells)}
    varying = [name for name in _KEYS if len(values.get(name, ())) > 1]
    if not varying and len(rows) / 3 >= len(values.get("Label", ())) > 1:
        varying = ["Label"]
    if not varying and values.get("Group", {"0"}) != {"0"}:
        varying = ["Group"]
    if not varying:
        raise table.source.error(
            "the Results table does not say which points lie on one line", rows[0][0], _HINT
        )
    return [header.index(name) for name in varying]


def _coordinates(table: Table, rows: list[Row], x: int, y: int) -> np.ndarray:
    number = table.number_reader()
    points = np.empty((len(rows), 2))
    for index, (at, cells) in enumerate(rows):
        if max(x, y) >= len(cells):
            raise table.source.error("the row has no X or Y", at, "correct or remove this row")
        try:
            points[index] = number(cells[x]), number(cells[y])
        except ValueError:
            raise table.bad_number([cells[x], cells[y]], at) from None
    return points
