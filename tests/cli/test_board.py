"""`plumbline board`: photographs in; corners, a drawing and a lens out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

import plumbline
from tests.cli.process import Run
from tests.render import board as render
from tests.render.optics import View

SIZE = (960, 720)
OPENCV = Path("/usr/share/doc/opencv-doc/examples/data")


def shot(number: int, board: render.Board = render.BOARD, **how: Any) -> render.Shot:
    pose = render.framed(render.KIT, render.POSES[number], SIZE)
    return render.Shot(View(render.KIT, pose, *SIZE), (board,), seed=number, **how)


@pytest.fixture(scope="module")
def photos() -> dict[str, np.ndarray]:
    """Four photographs of one board and one of none."""
    made = {f"board{number}.png": render.take(shot(number)) for number in range(4)}
    made["wall.png"] = render.take(replace(shot(1), boards=()))
    return made


@pytest.fixture
def folder(tmp_path: Path, photos: dict[str, np.ndarray]) -> Path:
    for name, pixels in photos.items():
        Image.fromarray(pixels).save(tmp_path / name)
    return tmp_path


BOARDS = tuple(f"board{number}.png" for number in range(4))


def test_four_photos_give_the_lens_within_its_own_error(run: Run, folder: Path) -> None:
    done = run("board", *BOARDS, "-o", "lens.json")
    assert done.status == 0, done.err
    assert (folder / "board.json").is_file()
    assert (folder / "board.jpg").is_file()
    (made,) = plumbline.read_calibrations("lens.json")
    picks = np.concatenate([line.points_px for line in made.observations.lines])
    truth = shot(0).view
    # Lines cannot tell scale nor shift: compare after the best of both.
    ideal, true = made.lens.undistort(picks), truth.undistort(picks)
    terms = np.zeros((2 * len(picks), 3))
    terms[0::2] = np.stack([ideal[:, 0], np.ones(len(picks)), np.zeros(len(picks))], axis=1)
    terms[1::2] = np.stack([ideal[:, 1], np.zeros(len(picks)), np.ones(len(picks))], axis=1)
    best = np.linalg.lstsq(terms, true.ravel(), rcond=None)[0]
    apart_px = np.linalg.norm((terms @ best - true.ravel()).reshape(-1, 2), axis=1)
    assert np.sqrt((apart_px**2).mean()) <= 0.02
    # Where the picks reach, the error stays within 95 % of what the result says of itself.
    band = made.displacement
    assert band is not None
    radius = np.linalg.norm(picks - truth.centre, axis=1)
    for ring in np.linspace(0.3, 0.95, 5) * radius.max():
        near = np.abs(radius - ring) < 40
        at = np.abs(np.linalg.norm(band.points_px - truth.centre, axis=1) - ring) < 40
        assert apart_px[near].mean() < 1.96 * band.errors_px[at].mean()


def test_corners_are_written_in_every_format(run: Run, folder: Path) -> None:
    for name in ("corners.json", "corners.csv", "corners.pto"):
        done = run("board", *BOARDS[:2], "--points-only", "--points", name)
        assert done.status == 0, done.err
        assert not (folder / "board.fit.pto").exists()
        size = ("--size", "960x720") if name.endswith("csv") else ()
        fitted = run("fit", name, *size, "--robust", "-o", f"{name}.fit.json")
        assert fitted.status == 0, fitted.err
    made = [plumbline.read_calibration(f"corners.{kind}.fit.json") for kind in ("json", "csv")]
    assert made[0].coefficients == pytest.approx(made[1].coefficients, rel=1e-6)


def test_a_photo_without_a_board_is_named_with_the_reason(run: Run, folder: Path) -> None:
    done = run("board", "board0.png", "board3.png", "wall.png")
    assert done.status == 0
    assert "wall.png: no chequerboard: " in done.err
    assert "wall.png: no chequerboard: " in done.out
    alone = run("board", "wall.png")
    assert alone.status == 1
    assert "wall.png: no chequerboard: " in alone.err
    assert "ChArUco" in alone.err
    assert not (folder / "wall.fit.pto").exists()


def test_the_drawing_shows_the_corners(run: Run, folder: Path) -> None:
    assert run("board", "board0.png", "--points-only", "--overlay", "seen.png").status == 0
    drawn = np.asarray(Image.open(folder / "seen.png").convert("RGB")).astype(int)
    assert drawn.shape == (720, 960, 3)
    green = (drawn[..., 1] > 150) & (drawn[..., 0] < 90) & (drawn[..., 2] < 90)
    for x, y in shot(0).corners(render.BOARD):
        around = green[round(y) - 6 : round(y) + 7, round(x) - 6 : round(x) + 7]
        assert around.any()


def test_uneven_squares_are_told(run: Run, tmp_path: Path) -> None:
    seam = replace(render.BOARD, seam=0.003)
    for number in (0, 1):
        Image.fromarray(render.take(shot(number, seam))).save(f"seam{number}.png")
    done = run("board", "seam0.png", "seam1.png", "--free", "b")
    assert done.status == 0, done.err
    assert "not evenly spaced" in done.out


def test_even_squares_are_not_told(run: Run, folder: Path) -> None:
    assert "evenly spaced" not in run("board", *BOARDS).out


def test_photos_stored_sideways_are_turned(run: Run, folder: Path) -> None:
    upright = render.take(shot(1))
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise to be upright
    Image.fromarray(np.rot90(upright).copy()).save("turned.jpg", exif=exif, quality=100)
    assert run("board", "turned.jpg", "--points-only").status == 0
    found = plumbline.read("board.json")
    assert found.photos[0].frame.size == (960, 720)
    corners = np.concatenate([line.points_px for line in found.lines])
    truth = shot(1).corners(render.BOARD)
    nearest = np.linalg.norm(corners[:, None] - truth[None], axis=2).min(axis=1)
    assert nearest.max() < 0.5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("board",), "Missing argument"),
        (("board", "nothing.png"), "there is no such photo"),
        (("board", "board0.png", "board0.png"), "named twice"),
        (("board", "board0.png", "--inner", "2x9"), "--inner"),
        (("board", "board0.png", "--points", "corners.txt"), "corners are not written as .txt"),
        (("board", "board0.png", "--overlay", "seen.gif"), "drawings are not written as .gif"),
        (("board", "board0.png", "--points", "x.png"), "corners are not written as .png"),
        (("board", "board0.png", "--points-only", "--free", "b"), "does not use --free"),
        (("board", "board0.png", "--overlay", "board1.png"), "was not written by plumbline"),
        (("board", "board0.png", "--overlay", "board0.png"), "never overwritten"),
        (("board", "text.png"), "not a picture"),
        (("board", "board0.png", "--free", "k1"), "unknown coefficient"),
    ],
)
def test_wrong_calls_are_one_sentence(
    run: Run, folder: Path, words: tuple[str, ...], said: str
) -> None:
    (folder / "text.png").write_text("line,x,y\n")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = run(*words)
    assert done.status in {1, 2}
    assert said in done.err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.skipif(not OPENCV.is_dir(), reason="Debian's opencv-doc is not installed")
@pytest.mark.parametrize("side", ["left", "right"])
def test_opencvs_photos(side: str) -> None:
    paths = sorted(OPENCV.glob(f"{side}[0-9][0-9].jpg"))
    assert len(paths) == 13
    for path in paths:
        picture = cv2.imread(str(path))
        assert picture is not None
        (found,) = plumbline.find_board(picture)
        assert (len(found), sorted(found.inner)) == (54, [6, 9])
