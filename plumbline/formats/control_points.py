"""Control points of Panorama Tools scripts (`c` records), to lines of points and back."""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import ReadError
from plumbline.formats.base import Source, shown
from plumbline.formats.script import decimal
from plumbline.frame import Array
from plumbline.observations import Line
from plumbline.straightness import along_and_across
from plumbline.wording import count

FIRST_LINE_TYPE = 3

_POINT = re.compile(
    r"c n(\d{1,9}) N(\d{1,9}) x([-+\d.eE]+) y([-+\d.eE]+) X([-+\d.eE]+) Y([-+\d.eE]+)"
    r"(?: t(\d{1,9}))?[ \t\r]*\Z",
    re.ASCII,
)
_TOKEN = re.compile(r"(?<=[ \t])([nNxyXYt])(\S+)")


@dataclass
class ControlPoints:
    """Control points as they are collected; of each two images and four coordinates."""

    images: array[int] = field(default_factory=lambda: array("q"))
    kinds: array[int] = field(default_factory=lambda: array("q"))
    ends: array[float] = field(default_factory=lambda: array("d"))
    rows: array[int] = field(default_factory=lambda: array("q"))

    def add(self, source: Source, row: int, text: str) -> None:
        """Read one `c` record."""
        match = _POINT.match(text)
        n, m, x, y, x2, y2, kind = match.groups("0") if match else _scrambled(source, row, text)
        try:
            ends = float(x), float(y), float(x2), float(y2)
        except ValueError:  # "1-2": the sentence comes from the check of each
            ends = tuple(source.number(value, row) for value in (x, y, x2, y2))
        self.images.extend((int(n), int(m)))
        self.kinds.append(int(kind))
        self.ends.extend(ends)
        self.rows.append(row)

    def count_from(self, first: int) -> None:
        """Let the image that has been number `first` be number 0."""
        self.images = array("q", (number - first for number in self.images))


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


def collect_lines(
    source: Source, points: ControlPoints, n_images: int, notes: list[str]
) -> tuple[Line, ...]:
    """Group control points into lines; what is left aside goes to the notes.

    Raises:
        ReadError: a point belongs to no image, or no straight line is there at all.
    """
    images = np.array(points.images, dtype=np.int64).reshape(-1, 2)
    kinds, rows = np.array(points.kinds, dtype=np.int64), np.array(points.rows, dtype=np.int64)
    unknown = np.any((images < 0) | (images >= n_images), axis=1)
    if np.any(unknown):
        raise source.error(
            "the control point refers to an image that is not in the project, which has "
            f"{count(n_images, 'image')}",
            int(rows[int(np.argmax(unknown))]),
            hint="remove this line, or put the image back",
        )
    straight = kinds >= FIRST_LINE_TYPE
    within = images[:, 0] == images[:, 1]
    chosen = straight & within
    if not np.any(chosen):
        raise _no_lines(source, len(kinds))
    _note_others(straight, within, notes)
    ends = np.array(points.ends).reshape(-1, 4)[chosen]
    if np.all((ends[:, :2] == ends[:, 2:]).all(axis=1)):
        notes.append(
            "every pair has one point on both ends, which Hugin cannot optimise; each was taken "
            "as one pick"
        )
    return _grouped(images[chosen, 0], kinds[chosen], ends, rows[chosen])


def _no_lines(source: Source, n_points: int) -> ReadError:
    left = f" among its {count(n_points, 'control point')}" if n_points else ""
    return source.error(
        f"there is no straight line in this project{left}",
        hint="in Hugin, set control points of type 'New line' (t3, t4, …) along straight edges of "
        "one photo",
    )


def _note_others(straight: NDArray[np.bool_], within: NDArray[np.bool_], notes: list[str]) -> None:
    aside = int(np.count_nonzero(~straight))
    across = int(np.count_nonzero(straight & ~within))
    if aside:
        notes.append(
            f"{count(aside, 'control point')} of other kinds (normal, horizontal, vertical) "
            "left aside"
        )
    if across:
        notes.append(f"{count(across, 'line point')} between different images left aside")


def _grouped(
    images: NDArray[np.int64], kinds: NDArray[np.int64], ends: Array, rows: NDArray[np.int64]
) -> tuple[Line, ...]:
    order = np.lexsort((rows, kinds, images))
    images, kinds, ends, rows = images[order], kinds[order], ends[order], rows[order]
    starts = np.flatnonzero(np.diff(images, prepend=-1) | np.diff(kinds, prepend=-1))
    stops = np.append(starts[1:], len(images))
    lines: list[Line] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        points = np.concatenate((ends[start:stop, :2], ends[start:stop, 2:]))
        _, first = np.unique(points, axis=0, return_index=True)
        with np.errstate(all="ignore"):  # absurd numbers are refused later, by name
            along, _ = along_and_across(points[first])
        first = first[np.argsort(along, kind="stable")]
        line_rows = np.tile(rows[start:stop], 2)[first]
        lines.append(Line(points[first], int(images[start]), f"t{kinds[start]}", line_rows))
    return tuple(lines)


def pairs(line: Line, kind: int) -> list[str]:
    """`c` records of a line: its points paired with their reversed order.

    The middle one of an odd number is paired with its neighbour, never with itself.

    Args:
        line: The points, at square pixels.
        kind: The number that the line gets, 3 or above.
    """
    points = line.points_px
    out: list[str] = []
    for index in range(len(points)):
        other = len(points) - 1 - index
        if other == index:
            other = index - 1
        x, y, x2, y2 = (decimal(v) for v in (*points[index].tolist(), *points[other].tolist()))
        out.append(f"c n{line.photo} N{line.photo} x{x} y{y} X{x2} Y{y2} t{kind}")
    return out
