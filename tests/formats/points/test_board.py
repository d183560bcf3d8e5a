"""plumbline's own file of chequerboards: exactly what was found, and nothing else."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.board import FORMAT, PhotoOfBoards, write_boards
from plumbline.observations import Observations
from plumbline.observations.board import Board

CELLS = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [2, 1], [0, 2], [1, 2], [2, 2]])
CORNERS = CELLS * [100.25, 90.125] + [10.0625, 7.3]


def read(text: str) -> Observations:
    return FORMAT.read(Source("board.json", text.encode()), ReadOptions())


def document(**changes: Any) -> str:
    photo = {"name": "a.jpg", "size": [400, 300], "boards": [[[0, 0, 1.0, 2.0]]]} | changes
    top = {"format": "plumbline board", "format_version": 1, "photos": [photo]}
    return json.dumps(top | {k: v for k, v in changes.items() if k in top})


def test_rows_and_columns_come_back_exactly() -> None:
    board = Board(CORNERS, CELLS)
    text = write_boards(
        [
            PhotoOfBoards("a.jpg", (400, 300), (board,)),
            PhotoOfBoards("b.jpg", (300, 400), (board,) * 2),
        ]
    )
    assert FORMAT.recognises(Source("board.json", text.encode()))
    back = read(text)
    assert [(p.name, p.frame.size) for p in back.photos] == [
        ("a.jpg", (400, 300)),
        ("b.jpg", (300, 400)),
    ]
    first = [line for line in back.lines if line.photo == 0]
    assert [line.label for line in first] == ["row 1", "row 3", "column 1", "column 3"]
    assert np.array_equal(first[0].points_px, CORNERS[[0, 1, 2]])
    assert np.array_equal(first[3].points_px, CORNERS[[2, 4, 7]])
    second = [line.label for line in back.lines if line.photo == 1]
    assert second[0] == "board 1 row 1"
    assert second[4] == "board 2 row 1"
    assert len(second) == 8


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (document(format_version=2), "another version"),
        (document(size=[400]), "width and a height"),
        (document(size=[400, -3]), "impossible"),
        (document(boards=[[[0, 0, 1.0]]]), "is not column, row, x, y"),
        (document(boards=[[[0, 0.5, 1.0, 2.0]]]), "is not column, row, x, y"),
        (document(boards=[[[-1, 0, 1.0, 2.0]]]), "is not column, row, x, y"),
        (document(boards=[[[10**9, 0, 1.0, 2.0]]]), "is not column, row, x, y"),
        (document(boards=[[[0, 0, 1.0, 2.0], [0, 0, 3.0, 4.0]]]), "two corners in one cell"),
        (document(boards=[[[0, 0, "x", 2.0]]]), "where a number belongs"),
        (document(boards=[]), "no line of points"),
        (document(), "no line of points"),
        (document()[:-9], "broken"),
    ],
)
def test_damaged_files_are_refused_in_a_sentence(text: str, said: str) -> None:
    with pytest.raises(ReadError, match=said):
        read(text)
