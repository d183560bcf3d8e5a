"""Chequerboards as `plumbline board` finds them.

    {"format": "plumbline board", "format_version": 1,
     "photos": [{"name": "board1.jpg", "size": [4000, 3000],
                 "boards": [[[0, 0, 812.31, 640.02], [1, 0, 1003.9, 637.55], …]]}]}

A corner is column, row, x, y; rows and columns of at least three corners become lines. Kept:
names and sizes of photos, cells, coordinates. Coordinates are plumbline's own: pixels, (0, 0) the
centre of the top-left pixel, y down. Source: plumbline's own format.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.files import BOARD
from plumbline.formats.base import Format, ReadOptions, Source
from plumbline.formats.points.jsontext import as_list, as_number, as_object, as_text, parsed
from plumbline.formats.points.lines import LineGatherer, Size, declared_size
from plumbline.observations import Observations
from plumbline.observations.board import Board, lines_of

_VERSION = 1
_AGAIN = "find the boards again: plumbline board PHOTO… --points-only"
_MOST_CELLS = 10_000
"""Columns or rows beyond which a number is no cell; chosen: no camera resolves so many."""


@dataclass(frozen=True, eq=False)
class PhotoOfBoards:
    """A photograph and the boards it shows.

    Attributes:
        name: Its file name.
        size: Width and height, as a viewer shows it.
        boards: The boards.
    """

    name: str
    size: Size
    boards: tuple[Board, ...]


def write_boards(photos: Sequence[PhotoOfBoards]) -> str:
    """The JSON that `read` takes back exactly."""
    made = {
        "format": BOARD,
        "format_version": _VERSION,
        "photos": [
            {
                "name": photo.name,
                "size": list(photo.size),
                "boards": [_corners(board) for board in photo.boards],
            }
            for photo in photos
        ],
    }
    return json.dumps(made, ensure_ascii=False) + "\n"


def _corners(board: Board) -> list[list[float]]:
    pairs = zip(board.cells.tolist(), board.corners_px.tolist(), strict=True)
    return [[*cell, *corner] for cell, corner in pairs]


def read(source: Source, _options: ReadOptions) -> Observations:
    """Rows and columns of the boards of one file.

    Raises:
        ReadError: the JSON is broken, of another version or not of boards.
    """
    top = as_object(source, parsed(source, source.text()), "the file")
    if top.get("format") != BOARD or top.get("format_version") != _VERSION:
        raise source.error(
            "these boards were written by another version of plumbline", None, _AGAIN
        )
    gatherer = LineGatherer(source)
    for number, value in enumerate(as_list(source, top.get("photos"), "'photos'")):
        photo = as_object(source, value, f"photo {number}")
        name = as_text(photo.get("name"))
        size = _size(source, photo.get("size"), number)
        boards = as_list(source, photo.get("boards"), f"'boards' of photo {number}")
        found = tuple(_board(source, each, f"of photo {number}") for each in boards)
        for line in lines_of(found):
            gatherer.add(line.points_px, line.label, photo=number, photo_name=name, size=size)
    return gatherer.observations("chequerboards")


def recognises(source: Source) -> bool:
    """Whether the file is a JSON object that begins with the name of this format."""
    return source.head.lstrip().startswith("{") and f'"{BOARD}"' in source.head[:200]


def _size(source: Source, value: object, number: int) -> Size:
    sides = as_list(source, value, f"'size' of photo {number}")
    if len(sides) != 2:
        raise source.error(f"'size' of photo {number} is not a width and a height", None, _AGAIN)
    what = f"'size' of photo {number}"
    width, height = (as_number(source, side, what) for side in sides)
    return declared_size(source, width, height)


def _board(source: Source, value: object, where: str) -> Board:
    rows: list[list[float]] = []
    for number, each in enumerate(as_list(source, value, f"a board {where}"), start=1):
        what = f"corner {number} {where}"
        row = [as_number(source, v, what) for v in as_list(source, each, what)]
        cell = row[:2]
        if len(row) != 4 or not all(v == int(v) and 0 <= v < _MOST_CELLS for v in cell):
            raise source.error(f"{what} is not column, row, x, y", None, _AGAIN)
        rows.append(row)
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    cells = table[:, :2].astype(np.int64)
    if len(np.unique(cells, axis=0)) != len(cells):
        raise source.error(f"a board {where} has two corners in one cell", None, _AGAIN)
    return Board(table[:, 2:], cells)


FORMAT = Format(
    name="board",
    title="chequerboards found by plumbline",
    suffixes=(".json",),
    recognises=recognises,
    read=read,
)
