"""Boards in files: what the command says, in one call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from plumbline.boards.photographs import look, together
from plumbline.errors import OptionError, ReadError

SAMPLE = Path(__file__).parents[2] / "sample_projects" / "board"


def test_photographs_give_the_lens_of_their_truth() -> None:
    photos = sorted(SAMPLE.glob("board*.jpg"))[:2]
    calibration = plumbline.calibrate_board(photos, free=("b",))
    assert calibration.robust
    assert [origin.path for origin in calibration.observations.origins] == [str(p) for p in photos]
    corners = [plumbline.find_board(np.asarray(Image.open(photo).convert("L"))) for photo in photos]
    n_corners = sum(len(board) for boards in corners for board in boards)
    assert together(look([str(p) for p in photos], None)).n_points >= n_corners


def test_photos_without_a_board_are_refused(tmp_path: Path) -> None:
    Image.fromarray(np.full((200, 300), 90, np.uint8)).save(tmp_path / "flat.png")
    with pytest.raises(ReadError, match="no chequerboard"):
        plumbline.calibrate_board([tmp_path / "flat.png"])
    with pytest.raises(OptionError, match="named twice"):
        plumbline.calibrate_board([tmp_path / "flat.png"] * 2)
