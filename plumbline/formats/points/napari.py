"""Shapes of napari, saved as CSV (File > Save Selected Layer on a shapes layer).

    index,shape-type,vertex-index,axis-0,axis-1
    0.0,path,0.0,40.5,10.25
    0.0,path,1.0,28.0,200.0

One shape is one line. The last axis is x and the one before it y; further axes, such as the
number of a slice, tell photos apart. Points layers (without `shape-type`) hold one line. Kept:
coordinates and the number of the shape. Dropped: shapes that are not paths or lines (a note says
which). napari draws the first pixel around (0, 0), as plumbline does: nothing is added. Source:
`napari_builtins/io/_write.py`, write_csv.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import Table
from plumbline.observations import Observations

_AXIS = re.compile(r"axis-([0-9])")
_LINES = {"path", "line"}


@dataclass
class _Shape:
    kind: str
    points: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    rows: list[int] = field(default_factory=list[int])


def read(source: Source, _options: ReadOptions) -> Observations:
    """Paths and lines of a shapes layer.

    Raises:
        ReadError: the table is not napari's, or a coordinate is not a number.
    """
    table = Table.of(source, comments=False)
    rows = (row for row in table.rows() if any(map(str.strip, row[1])))
    at, header = next(rows, (1, list[str]()))
    names = [cell.strip() for cell in header]
    axes = [place for place, name in enumerate(names) if _AXIS.fullmatch(name)]
    if len(axes) < 2 or "index" not in names:
        raise source.error(
            "the columns index, axis-0 and axis-1 are missing",
            at,
            "save the shapes layer in napari again: File > Save Selected Layer",
        )
    number = table.number_reader()
    index = names.index("index")
    kind = names.index("shape-type") if "shape-type" in names else -1
    shapes: dict[tuple[str, ...], _Shape] = {}
    for at, cells in rows:
        if len(cells) < len(names):
            raise source.error(
                f"the row has {len(cells)} of {len(names)} columns", at, "complete it"
            )
        try:
            y, x = number(cells[axes[-2]]), number(cells[axes[-1]])
        except ValueError:
            raise table.bad_number([cells[axes[-2]], cells[axes[-1]]], at) from None
        slices = tuple(cells[axis].strip() for axis in axes[:-2])
        of = cells[kind].strip() if kind >= 0 else "path"
        key = (*slices, cells[index].strip() if kind >= 0 else "")
        shape = shapes.setdefault(key, _Shape(of))
        shape.points.append((x, y))
        shape.rows.append(at)
    gatherer = LineGatherer(source)
    for (*slices, label), shape in shapes.items():
        if shape.kind in _LINES:
            gatherer.add(
                shape.points, label.removesuffix(".0"), photo=tuple(slices), rows=shape.rows
            )
        else:
            gatherer.leave_aside(shape.kind)
    return gatherer.observations("paths and lines")


def recognises(source: Source) -> bool:
    """Whether the header has the columns index, axis-0 and axis-1."""
    return _HEAD.match(source.head.lstrip("\ufeff")) is not None


_HEAD = re.compile(r"index,(?:shape-type,vertex-index,)?axis-0,axis-1")
