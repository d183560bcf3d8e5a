"""The sample projects that are not façades: four photographs of a chequerboard, and a pair."""

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from . import board, pair
from .optics import DATABASE, Lens, View
from .scene import Picture

SIZE = (1200, 900)
SHOTS = {
    f"board{number + 1}.jpg": board.Shot(
        View(board.COMPACT, board.framed(board.COMPACT, board.POSES[pose], SIZE), *SIZE),
        (board.BOARD,),
        seed=500 + number,
        noise=2.0,
        blur_px=0.8,
    )
    for number, pose in enumerate((0, 2, 3, 4))
}
PAIR = pair.Pair(lens=board.KIT, size=(1080, 810), seed=31)
PAIR_NAMES = "developed.jpg", "camera.jpg"
QUALITY = 88


def texts() -> dict[str, str]:
    """Every text file of the two, by its path below `sample_projects/`."""
    counts = [_counts(shot) for shot in SHOTS.values()]
    lines, points = (sum(each) for each in zip(*counts, strict=True))
    boards = {
        "command": ["board", *SHOTS],
        "truth": _truth(board.COMPACT),
        "n_points": points,
        "n_lines": lines,
        "curve_within_px": 0.5,
        "outputs": ["board.json", "board.jpg", "board.fit.pto"],
    }
    both = {
        "command": ["pair", *PAIR_NAMES],
        "truth": _truth(board.KIT) | {"scale": PAIR.scale},
        "curve_within_px": 0.5,
        "outputs": ["developed.fit.pto"],
    }
    return {
        "board/expected.json": json.dumps(boards, indent=2) + "\n",
        "pair/expected.json": json.dumps(both, indent=2) + "\n",
    }


def pictures(target: Path) -> None:
    """Take and write the photographs."""
    for name, shot in SHOTS.items():
        _save(board.take(shot), target / "board" / name)
    for name, picture in zip(PAIR_NAMES, pair.take(PAIR), strict=True):
        _save(picture, target / "pair" / name)


def _counts(shot: board.Shot) -> tuple[int, int]:
    """Lines of three corners or more that a photograph shows, and the corners on them.

    A corner none of whose squares is wholly in view counts for nothing: it cannot be told from a
    stray.
    """
    cells = board.BOARD.cells[board.visible(shot, board.BOARD)]
    cells = cells[_in_whole_squares(cells)]
    found = [
        count
        for axis in (0, 1)
        for count in (int((cells[:, axis] == each).sum()) for each in set(cells[:, axis].tolist()))
        if count >= 3
    ]
    return len(found), sum(found)


def _in_whole_squares(cells: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which cells are a corner of a square whose four corners are all among them."""
    seen = np.zeros(cells.max(axis=0) + 1, dtype=bool)
    seen[tuple(cells.T)] = True
    squares = seen[:-1, :-1] & seen[1:, :-1] & seen[:-1, 1:] & seen[1:, 1:]
    good = np.zeros_like(seen)
    for right in (0, 1):
        for down in (0, 1):
            good[right : right + squares.shape[0], down : down + squares.shape[1]] |= squares
    return good[tuple(cells.T)]


def _truth(lens: Lens) -> dict[str, object]:
    return {
        "model": "ptlens",
        "coefficients": lens.coefficients,
        "source": f"{DATABASE}, {lens.entry}, {lens.lens}, focal {lens.focal:g}",
    }


def _save(picture: Picture, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
