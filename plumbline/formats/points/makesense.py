"""Points of makesense.ai, exported as CSV.

    roof,10,40,wall.jpg,800,600
    roof,200,28,wall.jpg,800,600

Columns without a header: label, x, y, photo, width, height. Points that share a label on one
photo are one line. Kept: labels, coordinates, names and sizes of the photos. Dropped: nothing.
The page draws over the photo, where (0, 0) is the corner of the first pixel, so 0.5 is
subtracted here. Source: `src/logic/export/PointLabelsExport.ts`.
"""

from __future__ import annotations

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer, declared_size
from plumbline.formats.points.table import Table
from plumbline.observations import Observations

_COLUMNS = 6
"""label, x, y, image, width and height."""


def read(source: Source, _options: ReadOptions) -> Observations:
    """Points of one label on one photo as one line.

    Raises:
        ReadError: a row has another number of columns, or a value is not a number.
    """
    table = Table.of(source, comments=False)
    gatherer = LineGatherer(source, shift_px=-0.5)
    for at, row in table.rows():
        cells = [cell.strip() for cell in row]
        if not any(cells):
            continue
        if len(cells) != _COLUMNS:
            raise source.error(
                f"the row has {len(cells)} columns where label, x, y, photo, width and height "
                "belong",
                at,
                "export the points again as a CSV file",
            )
        label, x, y, name, width, height = cells
        size = declared_size(
            source,
            source.number(width, at, what="the width"),
            source.number(height, at, what="the height"),
            at,
        )
        point = (source.number(x, at), source.number(y, at))
        gatherer.pick(point, label, photo=name, photo_name=name, size=size, row=at)
    return gatherer.observations()


def recognises(source: Source) -> bool:
    """Whether the first row is a label, two numbers, the name of a photo and two numbers."""
    rows = Table.opening(source, comments=False).first_rows(1)
    if not rows or len(rows[0]) != _COLUMNS:
        return False
    _, x, y, name, width, height = rows[0]
    return all(map(_is_number, (x, y, width, height))) and "." in name and not _is_number(name)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
