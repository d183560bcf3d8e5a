"""Control points of Panorama Tools scripts: the `c` records as numbers.

Projects of a million points are read in one go where every record has the usual form; any that
does not sends all of them down the careful way, one by one.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.formats.base import Source, shown
from plumbline.frame import Array

_POINT = re.compile(
    r"c n(\d{1,9}) N(\d{1,9}) x([-+\d.eE]+) y([-+\d.eE]+) X([-+\d.eE]+) Y([-+\d.eE]+)"
    r"(?: t(\d{1,9}))?[ \t\r]*\Z",
    re.ASCII,
)
_TOKEN = re.compile(r"(?<=[ \t])([nNxyXYt])(\S+)")
_LETTERS = b"cnNxyXYt"
_FIELDS = len(_LETTERS) - 1
_STARTS = frozenset(("c ", "c\t"))
_MANY = 1000


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


def take_points(
    source: Source, texts: Sequence[str]
) -> tuple[ControlPoints, list[tuple[int, str]]]:
    """Read the `c` records of a script, and leave the others.

    Returns:
        The control points, and the row and text of all other records.

    Raises:
        ReadError: a control point lacks something, or holds what is no number.
    """
    taken = np.array([text[:2] in _STARTS for text in texts], dtype=np.bool_)
    rest = [(row, texts[row - 1]) for row in (np.flatnonzero(~taken) + 1).tolist()]
    rows = np.flatnonzero(taken) + 1
    chosen = list(itertools.compress(texts, taken))
    table = table_of(chosen) if len(chosen) >= _MANY else None
    if table is None:
        fields = [
            _fields(source, row, text) for row, text in zip(rows.tolist(), chosen, strict=True)
        ]
        table = np.array(fields, dtype=np.float64).reshape(-1, _FIELDS)
    images, kinds = table[:, :2].astype(np.int64), table[:, 6].astype(np.int64)
    return ControlPoints(images, table[:, 2:6], kinds, rows), rest


def table_of(texts: Sequence[str]) -> Array | None:
    """Numbers n, N, x, y, X, Y, t of records that all have the usual form, shape (n, 7); else None.

    The letters, without what numbers are made of, must spell the same in every record; every
    letter must be followed at once by the start of a number; and as many numbers must come out as
    there are letters. Then each field holds just one.
    """
    content = "\n".join(texts).encode("utf-8", errors="surrogateescape") + b"\n"
    if content.translate(None, b"0123456789+-.eE \t\r") != (_LETTERS + b"\n") * len(texts):
        return None
    classes = np.frombuffer(content.translate(_CLASSES), dtype=np.uint8)
    letter, before, after = classes[1:-1] == _LETTER, classes[:-2], classes[2:]
    if np.any(letter & ((before != _BLANK) | (after != _DIGIT))):
        return None
    blanked = content.translate(_BLANKED)
    try:
        numbers = np.fromstring(blanked, dtype=np.float64, sep=" ")
    except (DeprecationWarning, ValueError):
        return None
    if len(numbers) != _FIELDS * len(texts):
        return None
    table = numbers.reshape(-1, _FIELDS)
    whole = table[:, [0, 1, 6]]
    fine = np.all(np.isfinite(table)) and np.all((whole >= 0) & (whole < 1e9))
    return table if fine and np.all(whole == np.floor(whole)) else None


_LETTER, _DIGIT, _BLANK = b"L0 "
_CLASSES = bytes.maketrans(b"nNxyXYt0123456789+-.\t", b"LLLLLLL0000000000000 ")
_BLANKED = bytes.maketrans(_LETTERS, b" " * len(_LETTERS))


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
                f"{shown(name + value)} is no whole number", row, "correct or remove this line"
            )
    return tuple(found[name] for name in "nNxyXYt")
