"""WinMorph projects (.mrf): shapes drawn over a photo.

      Shape1
      <line>
      <line>
      0.098145 0.031901
      0.188965 0.031250
      Sets = 0

Coordinates are fractions of width and height from the photo's top left edge, y down, so the
photo's size is needed: x_px = fraction × width − 0.5. Several shapes are one line each. A
single long one often holds a grid of rows × columns, read row by row, always from the left
(`raster`) or back and forth (`zigzag`): then `--grid` makes lines of its rows and columns.

Kept: the points. Dropped: the two lines after each header, whose meaning is not known, and
all that is no pair of numbers. Any header `Shape…`, any separator and a decimal comma will
do. Source: inferred from a macro that reads such files, not from WinMorph itself.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plumbline.formats.base import Format, ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import MAX_LINES
from plumbline.frame import Array
from plumbline.observations import Observations
from plumbline.wording import count

_HEADER = re.compile(r"^[ \t]*shape[^\n]{0,80}$", re.IGNORECASE | re.MULTILINE)
_END = re.compile(r"[ \t]*sets[ \t]*=", re.IGNORECASE)
_DOT = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
_COMMA = r"[-+]?[0-9]+,[0-9]+"
_PAIRS = [re.compile(rf"({n})[\s;,]+({n})[\s;,]*") for n in (_DOT, _COMMA)]
_MAX_ROW = 200


@dataclass
class _Shape:
    title: str
    points: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    rows: list[int] = field(default_factory=list[int])


def read(source: Source, options: ReadOptions) -> Observations:
    """Lines of a WinMorph project.

    Raises:
        ReadError: there is no shape, the photo's size is missing, or a single shape is not
            the grid it is said to be, or looks like one that is not named.
    """
    shapes, notes = _shapes(source)
    shapes = [shape for shape in shapes if shape.points]
    if not shapes:
        raise source.error(
            "the file holds no shape with points", hint="draw a polyline on each straight edge"
        )
    if options.size is None:
        raise source.error(
            "the coordinates are fractions of a photo whose size is not known",
            hint="give the photo with --photo FILE or its size with --size WIDTHxHEIGHT",
        )
    gatherer = LineGatherer(source, shift_px=-0.5)
    gatherer.notes += notes
    size = np.array(options.size, dtype=np.float64)
    if options.grid is not None:
        _add_grid(gatherer, shapes, size, options)
        return gatherer.observations()
    if len(shapes) == 1:
        _refuse_grid(source, shapes[0], size)
    for shape in shapes:
        gatherer.add(np.array(shape.points) * size, shape.title, size=options.size, rows=shape.rows)
    return gatherer.observations()


def recognises(source: Source) -> bool:
    """Whether a line `Shape…` stands near the start of an .mrf file, or before `Sets =`."""
    head = source.head
    header = _HEADER.search(head)
    if header is None:
        return False
    return source.suffix == ".mrf" or re.search(r"^[ \t]*Sets[ \t]*=", head, re.M) is not None


def _shapes(source: Source) -> tuple[list[_Shape], list[str]]:
    """The shapes, and notes about the rows that were left aside."""
    shapes: list[_Shape] = []
    skipped = doubtful = unknown = 0
    inside = False
    for at, line in enumerate(_lines(source), 1):
        if _HEADER.match(line):
            shapes.append(_Shape(line.strip()))
            inside, unknown = True, 2
        elif inside and unknown:
            unknown -= 1
            pair = _pair(line)
            doubtful += pair is not None and 0 < min(pair) <= max(pair) < 1
        elif not inside or not line.strip():
            continue
        elif _END.match(line):
            inside = False
        elif (pair := _pair(line)) is None:
            skipped += 1
        else:
            shapes[-1].points.append(_fractions(source, pair, at))
            shapes[-1].rows.append(at)
    notes: list[str] = []
    if skipped:
        notes.append(f"{count(skipped, 'row')} without a pair of numbers left aside")
    if doubtful:
        notes.append(
            f"{count(doubtful, 'row')} left aside for standing in the two after the header of a "
            "shape, though like a point"
        )
    return shapes, notes


def _lines(source: Source) -> list[str]:
    text = source.text().replace("\r\n", "\n").replace("\r", "\n")
    lines = text.count("\n") + 1
    if lines > MAX_LINES:
        raise source.error(f"the file has {lines:,} lines, more than are read")
    return text.split("\n")


def _fractions(source: Source, pair: tuple[float, float], line: int) -> tuple[float, float]:
    if not -1 <= min(pair) <= max(pair) <= 2:
        raise source.error(
            f"{pair[0]:g} {pair[1]:g} are no fractions of the photo's width and height",
            line,
            "coordinates run from 0 to 1; write points in pixels as a table line,x,y",
        )
    return pair


def _pair(line: str) -> tuple[float, float] | None:
    if len(line) > _MAX_ROW:
        return None
    for pattern in _PAIRS:
        if found := pattern.fullmatch(line.strip()):
            x, y = (float(number.replace(",", ".")) for number in found.groups())
            return x, y
    return None


def _add_grid(
    gatherer: LineGatherer, shapes: Sequence[_Shape], size: Array, options: ReadOptions
) -> None:
    rows, columns = options.grid or (0, 0)
    source, shape = gatherer.source, shapes[0]
    if len(shapes) > 1:
        raise source.error(
            f"a grid is one shape, but the file holds {len(shapes)}", hint="leave out --grid"
        )
    if rows < 1 or columns < 1 or rows * columns != len(shape.points):
        raise source.error(
            f"the shape holds {count(len(shape.points), 'point')}, "
            f"but a grid of {rows}x{columns} needs {rows * columns}",
            hint="give the rows and columns of the grid as --grid ROWSxCOLUMNS",
        )
    points = (np.array(shape.points) * size).reshape(rows, columns, 2)
    at = np.array(shape.rows, dtype=np.int64).reshape(rows, columns)
    if options.order == "zigzag":
        points[1::2], at[1::2] = points[1::2, ::-1].copy(), at[1::2, ::-1].copy()
    for row in range(rows):
        gatherer.add(points[row], f"row {row + 1}", size=options.size, rows=at[row])
    for column in range(columns):
        gatherer.add(
            points[:, column], f"column {column + 1}", size=options.size, rows=at[:, column]
        )


def _refuse_grid(source: Source, shape: _Shape, size: Array) -> None:
    """Refuse a shape that runs to and fro and is wide: no picture of a straight edge is."""
    points = np.array(shape.points) * size
    if len(points) < 6:
        return
    path = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    extent = np.linalg.norm(np.ptp(points, axis=0))
    axes = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(points.T)), 0.0))
    if path > 1.5 * extent and axes[0] > 0.05 * axes[1]:
        raise source.error(
            f"the only shape holds {len(points)} points that do not follow one line",
            shape.rows[0],
            "if it is a grid, give its rows and columns as --grid ROWSxCOLUMNS",
        )


FORMAT = Format(
    name="winmorph",
    title="WinMorph project",
    suffixes=(".mrf",),
    recognises=recognises,
    read=read,
)
