"""What was found, drawn into the photographs: every corner, its rows and columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.observations.board import Board
from plumbline.wording import in_ascii

_WIDE_PX, _SHEET_PX = 1600, 2400
"""Longer side of a single photo's picture, and width of one of several; chosen, to be looked at."""

_MOST_ACROSS = 4
"""Photos side by side; chosen, so that a corner stays visible in each."""

_LINES = ((0, 140, 255), (255, 140, 0))  # rows orange, columns blue; OpenCV has blue first
_CORNER, _NAME, _NOTHING = (0, 220, 0), (255, 255, 255), (60, 60, 230)

Drawing = NDArray[np.uint8]


def drawn(image: NDArray[Any], boards: Sequence[Board], name: str, width_px: int) -> Drawing:
    """A photograph with its boards.

    Args:
        image: As `find_board` takes it.
        boards: Found in it.
        name: Written into the corner.
        width_px: Width of the drawing; the photo is made smaller, never larger.
    """
    scale = min(1.0, width_px / image.shape[1])
    size = (round(image.shape[1] * scale), max(round(image.shape[0] * scale), 1))
    drawing = cv2.resize(_eight_bits(image), size, interpolation=cv2.INTER_AREA)
    drawing = cv2.cvtColor(drawing, cv2.COLOR_GRAY2BGR) if drawing.ndim == 2 else drawing
    thick = max(1, round(max(size) / 800))
    for board in boards:
        places = np.rint(((board.corners_px + 0.5) * scale - 0.5) * 16).astype(np.int32)
        for line, members in board.lines():
            kind, _, number = line.partition(" ")
            colour = _LINES[kind == "column"]
            cv2.polylines(drawing, [places[members]], False, colour, thick, cv2.LINE_AA, 4)
            _label(drawing, number, places[members[0]] // 16, colour, thick)
        for x, y in places.tolist():
            cv2.circle(drawing, (x, y), 3 * thick * 16, _CORNER, thick, cv2.LINE_AA, 4)
    told = f"{name}: {sum(map(len, boards))}" if boards else f"{name}: no board"
    _label(drawing, told, np.array([10, 28 * thick]), _NAME if boards else _NOTHING, 2 * thick)
    return np.asarray(drawing, dtype=np.uint8)


def width_of_each(photos: int) -> int:
    """How wide each photo of a sheet is drawn."""
    return _WIDE_PX if photos == 1 else _SHEET_PX // min(photos, _MOST_ACROSS)


def sheet(drawings: Sequence[Drawing]) -> Drawing:
    """Drawings in rows of at most four, as one."""
    across = min(len(drawings), _MOST_ACROSS)
    wide = max(each.shape[1] for each in drawings)
    rows: list[Drawing] = []
    for first in range(0, len(drawings), across):
        some = drawings[first : first + across]
        high = max(each.shape[0] for each in some)
        row = np.zeros((high, wide * across, 3), dtype=np.uint8)
        for number, each in enumerate(some):
            row[: each.shape[0], number * wide : number * wide + each.shape[1]] = each
        rows.append(row)
    return np.vstack(rows)


def _eight_bits(image: NDArray[Any]) -> Any:
    colours = image[..., :3] if image.ndim == 3 and image.shape[2] >= 3 else image
    if image.dtype == np.uint16:
        return (colours >> 8).astype(np.uint8)
    return np.ascontiguousarray(np.clip(colours, 0, 255).astype(np.uint8))


def _label(
    drawing: Any, text: str, at: NDArray[Any], colour: tuple[int, int, int], size: int
) -> None:
    x, y = int(at[0]), int(at[1])
    plain = in_ascii(text)  # OpenCV's letters know no others
    how = cv2.FONT_HERSHEY_SIMPLEX, 0.4 * size
    thick = max(size // 2, 1)
    # A thicker text behind would be wider in some versions of OpenCV: so the same one, all around.
    for right, down in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        cv2.putText(drawing, plain, (x + right, y + down), *how, (0, 0, 0), thick)
    cv2.putText(drawing, plain, (x, y), *how, colour, thick)
