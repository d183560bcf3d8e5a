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
all that is not a pair of numbers. Any header `Shape…`, any separator and a decimal comma will
do. Source: inferred from a macro that reads such files, not from WinMorph itself.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.points.table import MAX_LINES
from plumbline.observations import Observations
from plumbline.wording import count

_HEADER = re.compile(r"^[ \t]*shape[^\n]{0,80}$", re.IGNORECASE | re.MULTILINE)
_END = re.compile(r"[ \t]*sets[ \t]*=", re.IGNORECASE)
_DOT = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
_COMMA = r"[-+]?[0-9]+,[0-9]+"
_PAIRS = [re.compile(rf"({n})[\s;,]+({n})[\s;,]*") for n in (_DOT, _COMMA)]
_MAX_ROW = 200
"""Characters; chosen, a row has two numbers or a name."""


@dataclass
class _Shape:
    title: str
    points: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    rows: list[int] = field(default_factory=list[int])


def read(source: Source, options: ReadOptions) -> Observations:
    """Lines of a WinMorph project.

    Raises:
        ReadError: there is no shape, or the photo's size is missing.
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
            f"{pair[0]:g} {pair[1]:g} are not fractions of the photo's width and height",
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
