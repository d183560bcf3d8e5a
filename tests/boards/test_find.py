"""Boards are found: rendered ones with truth, hard ones, none where there is none."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

import plumbline
from plumbline.boards.find import look_for_boards
from plumbline.errors import OptionError
from plumbline.photos.brightness import brightness
from tests.boards.judging import judged
from tests.boards.screen import monitor
from tests.render import board as render
from tests.render.optics import Pose, View

SERIES = render.series((1200, 900))
SMALL = (960, 720)


def view(pose: Pose, lens: str = "kit", size: tuple[int, int] = SMALL) -> View:
    return View(render.LENSES[lens], render.framed(render.LENSES[lens], pose, size), *size)


@pytest.mark.parametrize("name", SERIES)
def test_every_rendered_board_is_found(name: str) -> None:
    shot = SERIES[name]
    (found,) = plumbline.find_board(render.take(shot))
    verdict = judged(shot, render.BOARD, found)
    assert verdict.labels_true
    assert verdict.strays == 0
    assert verdict.rms_px <= (0.15 if shot.noise > 1 else 0.10)
    if int(name[-1]) < render.GOOD_POSES:
        assert verdict.share >= 0.95
    else:
        assert verdict.share > 0.9


@pytest.mark.parametrize("blur_px", [2.0, 4.0, 6.0])
def test_a_blurred_board_keeps_its_corners(blur_px: float) -> None:
    shot = render.Shot(view(render.POSES[2]), (render.BOARD,), blur_px=blur_px)
    (found,) = plumbline.find_board(render.take(shot))
    verdict = judged(shot, render.BOARD, found)
    assert verdict.share == 1.0
    assert verdict.rms_px < 0.15


def test_several_boards_in_one_photo() -> None:
    boards = (
        render.Board(6, 4, 0.08, at=(-0.33, 0.05), turn=10),
        render.Board(7, 5, 0.06, at=(0.33, -0.05), turn=-20),
    )
    shot = render.Shot(view(render.POSES[0]), boards)
    larger, smaller = plumbline.find_board(render.take(shot))
    for found, truth in ((larger, boards[1]), (smaller, boards[0])):
        verdict = judged(shot, truth, found)
        assert (verdict.share, verdict.strays, verdict.labels_true) == (1.0, 0, True)


def test_boards_that_touch_do_not_grow_together() -> None:
    """The second is half a square lower: one lattice would give wrong labels."""
    boards = (
        render.Board(6, 4, 0.08, at=(-0.3, 0.0), margin=0),
        render.Board(6, 4, 0.08, at=(0.265, 0.04), margin=0),
    )
    shot = render.Shot(view(render.POSES[0], size=(1440, 1080)), boards)
    found = plumbline.find_board(render.take(shot))
    assert [len(each) for each in found] == [24, 24]


def test_a_board_that_is_covered_by_another() -> None:
    boards = (
        render.Board(7, 6, 0.08, at=(-0.15, 0.0), margin=0.3),
        render.Board(6, 5, 0.07, at=(0.15, 0.03), turn=17, margin=0.2),
    )
    shot = render.Shot(view(render.POSES[0]), boards)
    whole, part = plumbline.find_board(render.take(shot))
    assert judged(shot, boards[1], whole).share == 1.0
    covered = judged(shot, boards[0], part)
    assert (covered.strays, covered.labels_true) == (0, True)


@pytest.mark.parametrize(
    "kind", ["portrait", "grey channel", "colour", "16 bits", "floats", "faint"]
)
def test_pictures_of_every_kind(kind: str) -> None:
    pose = replace(render.POSES[3], roll=90) if kind == "portrait" else render.POSES[3]
    size = (SMALL[1], SMALL[0]) if kind == "portrait" else SMALL
    shot = render.Shot(view(pose, size=size), (render.BOARD,))
    grey = render.take(shot)
    picture = {
        "portrait": lambda: grey,
        "grey channel": lambda: grey[..., None],
        "colour": lambda: np.dstack([grey, grey, grey, grey]),
        "16 bits": lambda: grey.astype(np.uint16) * 257,
        "floats": lambda: grey.astype(np.float64),
        "faint": lambda: (grey * 0.2 + 90).astype(np.uint8),
    }[kind]()
    (found,) = plumbline.find_board(picture)
    verdict = judged(shot, render.BOARD, found)
    assert (verdict.strays, verdict.labels_true) == (0, True)
    assert verdict.share >= 0.95
    assert verdict.rms_px < 0.10


def test_columns_run_rightwards_and_rows_downwards() -> None:
    shot = render.Shot(view(replace(render.POSES[1], roll=20)), (render.BOARD,))
    (found,) = plumbline.find_board(render.take(shot))
    place = {
        tuple(cell): point
        for cell, point in zip(found.cells.tolist(), found.corners_px, strict=True)
    }
    across, down = place[1, 0] - place[0, 0], place[0, 1] - place[0, 0]
    assert across[0] > abs(across[1])
    assert down[1] > abs(down[0])


def test_the_size_that_is_given_cuts_a_board_down() -> None:
    shot = render.Shot(view(render.POSES[0]), (render.BOARD,))
    picture = render.take(shot)
    for inner in ((4, 5), (5, 4)):
        (found,) = plumbline.find_board(picture, inner)
        assert (len(found), sorted(found.inner)) == (20, [4, 5])
    (found,) = plumbline.find_board(picture, (20, 20))
    assert len(found) == 54


def test_no_board_is_found_where_there_is_none() -> None:
    rng = np.random.default_rng(3)
    flat = np.full((300, 400), 128, dtype=np.uint8)
    assert look_for_boards(brightness(flat)).reason == "no place where four squares meet was found"
    clutter = render.take(render.Shot(view(render.POSES[1]), ()))
    noise = rng.integers(0, 256, (400, 600)).astype(np.uint8)
    for picture in (clutter, noise, flat[:1, :1], flat[:20, :30]):
        assert plumbline.find_board(picture) == ()


def test_a_grid_of_dots_is_no_board() -> None:
    picture = np.full((700, 900), 230, dtype=np.uint8)
    for x in range(100, 850, 60):
        for y in range(80, 650, 60):
            cv2.circle(picture, (x, y), 18, 20, -1, cv2.LINE_AA)
    assert plumbline.find_board(picture) == ()


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros(5), "is not a picture"),
        (np.zeros((4, 4, 7), dtype=np.uint8), "is not a picture"),
        (np.zeros((0, 4), dtype=np.uint8), "is not a picture"),
        (np.zeros((4, 4), dtype=np.int64), "values of type int64"),
        (np.full((40, 40), np.nan), "not finite"),
    ],
)
def test_what_is_no_picture_is_refused(array: np.ndarray, words: str) -> None:
    with pytest.raises(OptionError, match=words):
        plumbline.find_board(array)


def uneven(jitter: float) -> np.ndarray:
    """A chequerboard of four-sided patches whose corners lie off a grid, as shares of a square."""
    rng = np.random.default_rng(7)
    side = 60
    grid = np.stack(np.meshgrid(np.arange(11), np.arange(9)), -1) * side + 40.0
    grid += rng.uniform(-jitter, jitter, grid.shape) * side
    picture = np.full((560, 680), 230, dtype=np.uint8)
    for row in range(8):
        for column in range(row % 2, 10, 2):
            around = grid[[row, row, row + 1, row + 1], [column, column + 1, column + 1, column]]
            cv2.fillPoly(picture, [np.rint(around * 16).astype(np.int32)], 30, cv2.LINE_AA, 4)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.8), dtype=np.uint8)


def test_corners_that_do_not_lie_in_a_grid_are_refused_with_the_reason() -> None:
    assert len(plumbline.find_board(uneven(0.0))[0]) == 63
    search = look_for_boards(brightness(uneven(0.17)))
    assert search.boards == ()
    assert search.reason == (
        "corners of squares do not lie as in a grid: boards that overlap, or a screen whose pixels "
        "show"
    )


@pytest.mark.parametrize("pitch_px", [1.05, 1.4, 2.1, 4.0])
def test_moire_of_a_screen_leaves_corners_where_they_are(pitch_px: float) -> None:
    """To a tenth of the screen's pixel, but for a common shift: its lit part is off the middle."""
    picture, corners = monitor(pitch_px, 0.035)
    (found,) = plumbline.find_board(picture)
    offsets = found.corners_px[:, None] - corners
    nearest = np.linalg.norm(offsets, axis=2).argmin(axis=1)
    off = offsets[np.arange(len(found)), nearest]
    assert len(found) >= 0.95 * len(corners)
    assert np.abs(off).max() < 0.5 * max(pitch_px, 1.5)
    assert np.std(off, axis=0).max() < 0.1 * max(pitch_px, 1.5)
