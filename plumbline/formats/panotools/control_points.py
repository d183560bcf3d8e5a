"""Control points of Panorama Tools scripts, grouped into lines of points, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.formats.panotools.point_records import ControlPoints
from plumbline.formats.panotools.script import decimal
from plumbline.frame import Array
from plumbline.geometry.lines import by_line, fit_lines, line_numbers
from plumbline.observations.picks import Line, first_of_each
from plumbline.wording import count

FIRST_LINE_TYPE = 3
"""Hugin counts lines by the type `t` from 3 on; 0, 1 and 2 are pairs, verticals and horizontals."""


def collect_lines(
    source: Source, points: ControlPoints, n_images: int, notes: list[str]
) -> tuple[Line, ...]:
    """Group control points into lines; what is left aside goes to the notes.

    Raises:
        ReadError: a point belongs to no image, or no straight line is there at all.
    """
    images, kinds, rows = points.images, points.kinds, points.rows
    unknown = (images < 0) | (images >= n_images)
    if np.any(unknown):
        raise source.error(
            "the control point refers to an image that is not in the project, which has "
            f"{count(n_images, 'image')}",
            int(rows[int(np.argmax(unknown.any(axis=1)))]),
            hint="remove this line, or put the image back",
        )
    straight = kinds >= FIRST_LINE_TYPE
    within = images[:, 0] == images[:, 1]
    chosen = straight & within
    if not np.any(chosen):
        raise _no_lines(source, len(kinds))
    _note_others(straight, within, notes)
    ends = points.ends[chosen]
    if np.array_equal(ends[:, :2], ends[:, 2:]):
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
    if np.any(np.diff(images)) or np.any(np.diff(kinds) < 0):  # else they are sorted already
        order = np.lexsort((rows, kinds, images))
        images, kinds, ends, rows = images[order], kinds[order], ends[order], rows[order]
    starts = np.flatnonzero(np.diff(images, prepend=-1) | np.diff(kinds, prepend=-1))
    stops = np.append(starts[1:], len(images))
    picked: list[Array] = []
    standing: list[NDArray[np.int64]] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        points, others = ends[start:stop, :2], ends[start:stop, 2:]
        if not np.array_equal(points, others[::-1]):  # else the pairs are the line and its reverse
            points = np.concatenate((points, others))
        first = first_of_each(points)
        picked.append(points[first])
        standing.append(np.resize(rows[start:stop], len(points))[first])
    sizes = np.array([len(points) for points in picked])
    points, rows = np.concatenate(picked), np.concatenate(standing)
    with np.errstate(all="ignore"):  # absurd numbers are refused later, by name
        along, _ = fit_lines(points, sizes, np.ones(len(points))).place(points, line_numbers(sizes))
    lines: list[Line] = []
    parts = (by_line(values, sizes) for values in (along, points, rows))
    for start, its_along, its_points, its_rows in zip(starts, *parts, strict=True):
        order = np.argsort(its_along, kind="stable")
        label = f"t{kinds[start]}"
        lines.append(Line(its_points[order], int(images[start]), label, its_rows[order]))
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
