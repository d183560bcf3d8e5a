"""A whole grid picked as one line: its rows and columns as lines, whatever the format."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plumbline.formats.base import Order, Source
from plumbline.frame import Array
from plumbline.observations import Line, Observations
from plumbline.wording import count

_HINT = "give the rows and columns of the grid as --grid ROWSxCOLUMNS"

_FEWEST = 6
"""A grid of two rows and three columns is the smallest that is told from a line."""

_DETOUR = 1.5
"""How much longer than its extent the path through the sorted points of a line may be.

Chosen, because a line bent by a fifth of its length has a path of 1.1 times its extent, and the
smallest grid, 2 by 3 of square meshes, one of 2.2 times.
"""

_CORNER = 0.02
"""Median distance from the best parabola, over the length, above which points turn a corner.

Chosen, because a right angle has 0.035 and an edge that a fisheye bends by a fifth of its length
less than 0.01.
"""

_WIDTH = 0.05
"""Width over length, as standard deviations, below which points count as a line however sorted.

Chosen, because picks that scatter by this much along a short edge run to and fro as well.
"""


def rows_and_columns(
    source: Source, observations: Observations, grid: tuple[int, int], order: Order
) -> Observations:
    """The rows and columns of a grid whose points were read as one line.

    Args:
        source: The file, for messages.
        observations: What was read from it: one line.
        grid: Rows and columns.
        order: How the points run: every row from the left, or back and forth.

    Raises:
        ReadError: there are several lines, or not as many points as the grid has.
    """
    rows, columns = grid
    if len(observations.lines) != 1:
        raise source.error(
            f"a grid is one line of points, but the file holds {len(observations.lines)}",
            hint="leave out --grid",
        )
    line = observations.lines[0]
    n = len(line.points_px)
    if rows < 1 or columns < 1 or rows * columns != n:
        raise source.error(
            f"the file holds {count(n, 'point')}, but a grid of {rows}x{columns} has "
            f"{rows * columns}",
            hint=_HINT,
        )
    places = np.arange(n).reshape(rows, columns)
    if order == "zigzag":
        places[1::2] = places[1::2, ::-1].copy()
    lines = [_part(line, places[row], f"row {row + 1}") for row in range(rows)]
    lines += [_part(line, places[:, at], f"column {at + 1}") for at in range(columns)]
    return replace(observations, lines=tuple(lines))


def _part(line: Line, places: NDArray[np.int64], label: str) -> Line:
    rows = None if line.rows is None else line.rows[places]
    return replace(line, points_px=line.points_px[places], label=label, rows=rows)


def refuse_all_as_one(source: Source, observations: Observations) -> None:
    """Refuse a photo whose only line holds points that no one edge could have.

    Raises:
        ReadError: as said.
    """
    for photo in range(len(observations.photos)):
        lines = [line for line in observations.lines if line.photo == photo]
        if len(lines) == 1 and not follows_one_line(lines[0].points_px):
            line = lines[0]
            raise source.error(
                f"all {len(line.points_px)} points were taken as one line, which they do not "
                "follow" + "".join(f"; {note}" for note in observations.notes),
                None if line.rows is None else int(line.rows.min()),
                "say which points lie on one edge, with a column 'line' or a blank row between "
                "the lines of a table; of a grid, give rows and columns as --grid ROWSxCOLUMNS",
            )


def follows_one_line(points: Array) -> bool:
    """Whether points of shape (n, 2), in any order, could be picks of one bent edge."""
    if len(points) < _FEWEST:
        return True
    centred = points - points.mean(axis=0)
    widths, axes = np.linalg.eigh(centred.T @ centred)
    if widths[0] <= _WIDTH**2 * widths[1]:
        return True
    along = centred @ axes[:, 1]
    order = np.argsort(along, kind="stable")
    path = np.linalg.norm(np.diff(centred[order], axis=0), axis=1).sum()
    length = np.ptp(along)
    powers = np.vander(along / length, 3)
    across = centred @ axes[:, 0]
    apart = across - powers @ np.linalg.lstsq(powers, across)[0]
    to_and_fro = path > _DETOUR * np.linalg.norm(np.ptp(centred, axis=0))
    return not (to_and_fro or np.median(np.abs(apart)) > _CORNER * length)
