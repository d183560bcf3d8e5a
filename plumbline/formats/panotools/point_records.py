"""Control points of Panorama Tools scripts: the `c` records as numbers.

Records are read in blocks; a block with any record that departs from the usual form is read
record by record.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.formats.base import Source, shown
from plumbline.formats.panotools.point_block import N_FIELDS, table_of
from plumbline.formats.panotools.script import decoded, line_starts
from plumbline.frame import Array

_POINT = re.compile(
    r"c n(\d{1,9}) N(\d{1,9}) x([-+\d.eE]+) y([-+\d.eE]+) X([-+\d.eE]+) Y([-+\d.eE]+)"
    r"(?: t(\d{1,9}))?[ \t\r]*\Z",
    re.ASCII,
)
_TOKEN = re.compile(r"(?<=[ \t])([nNxyXYt])(\S+)")
_AT_ONCE = 8192
"""Records that are read at a time; chosen, it bounds memory."""


@dataclass(frozen=True)
class ControlPoints:
    """Control points; one row each.

    Attributes:
        images: The two images, shape (n, 2).
        ends: x, y in the first and in the second, pixels, shape (n, 4).
        kinds: Types: 0 normal, 1 vertical, 2 horizontal, 3 and above a straight line.
        rows: Lines of the file, counted from 1.
    """

    images: NDArray[np.int64]
    ends: Array
    kinds: NDArray[np.int64]
    rows: NDArray[np.int64]

    def counted_from(self, first: int) -> ControlPoints:
        """The same, with the image that has been number `first` as number 0."""
        return ControlPoints(self.images - first, self.ends, self.kinds, self.rows)


def take_points(source: Source) -> tuple[ControlPoints, list[tuple[int, str]]]:
    """Read the `c` records of a script, and leave the others.

    Returns:
        The control points, and the row and text of all other records.

    Raises:
        ReadError: the file is not a script, or a control point lacks something or holds what is not
            a number.
    """
    starts = line_starts(source)
    content = np.frombuffer(source.content, dtype=np.uint8)
    first, second = (content.take(starts[:-1] + i, mode="clip") for i in (0, 1))
    taken = (first == ord("c")) & ((second == ord(" ")) | (second == ord("\t")))
    rows = np.flatnonzero(taken) + 1
    table = np.empty((len(rows), N_FIELDS))
    for begin in range(0, len(rows), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        table[some] = _table(source, starts, rows[some])
    others = np.flatnonzero(~taken) + 1
    texts = [decoded(line).removesuffix("\n") for line in _lines(source, starts, others)]
    images, kinds = table[:, :2].astype(np.int64), table[:, 6].astype(np.int64)
    points = ControlPoints(images, table[:, 2:6], kinds, rows)
    return points, list(zip(others.tolist(), texts, strict=True))


def _lines(source: Source, starts: NDArray[np.int64], rows: NDArray[np.int64]) -> list[bytes]:
    """These rows of the file, each with the end of its line."""
    spans = zip(starts[rows - 1].tolist(), starts[rows].tolist(), strict=True)
    return [source.content[start:stop] for start, stop in spans]


def _table(source: Source, starts: NDArray[np.int64], rows: NDArray[np.int64]) -> Array:
    """n, N, x, y, X, Y, t of the control points in these rows, shape (n, 7)."""
    if rows[-1] - rows[0] < len(rows):  # nothing else stands between them
        block = source.content[starts[rows[0] - 1] : starts[rows[-1]]]
    else:
        block = b"".join(_lines(source, starts, rows))
    block += b"" if block.endswith(b"\n") else b"\n"
    table = table_of(block)
    if table is not None:
        return table
    texts = decoded(block).split("\n")[:-1]
    return np.array([_fields(source, *each) for each in zip(rows.tolist(), texts, strict=True)])


def _fields(source: Source, row: int, text: str) -> tuple[float, ...]:
    """n, N, x, y, X, Y, t of one record."""
    match = _POINT.match(text)
    values = match.groups("0") if match else _scrambled(source, row, text)
    try:
        numbers = tuple(float(value) for value in values)
    except ValueError:
        numbers = (math.inf,)
    if all(map(math.isfinite, numbers)):
        return numbers
    # "1-2", or hundreds of digits: the sentence comes from the check of each.
    return tuple(source.number(value, row) for value in values)


def _scrambled(source: Source, row: int, text: str) -> tuple[str, ...]:
    """The fields of a control point whose tokens stand in another order or are missing."""
    found = {match[1]: match[2] for match in _TOKEN.finditer(text)}
    missing = [name for name in "nNxyXY" if name not in found]
    if missing:
        raise source.error(
            f"the control point lacks {', '.join(missing)}", row, "complete or remove this line"
        )
    for name in "xyXY":
        source.number(found[name], row)
    for name in "nNt":
        value = found.setdefault(name, "0")
        if not (value.isascii() and value.isdigit() and len(value) < 10):
            raise source.error(
                f"{shown(name + value)} is not a whole number", row, "correct or remove this line"
            )
    return tuple(found[name] for name in "nNxyXYt")
