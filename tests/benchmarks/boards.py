"""How boards are found: against the truth of rendered photographs, and beside OpenCV.

Run: python -m tests.benchmarks.boards
OpenCV's detectors get the board's true size, ours does not. OpenCV's own photographs are those of
Debian's opencv-doc, and are left out where it is not installed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import plumbline
from plumbline.boards.membership import irregularity
from plumbline.observations.board import lines_of
from plumbline.trust.displacement import displacement_errors
from plumbline.trust.student import quantile
from tests.boards.judging import judged
from tests.render import board as render

OPENCV = Path("/usr/share/doc/opencv-doc/examples/data")
INNER = (9, 6)

Detector = Callable[[Any], bool]


@dataclass(frozen=True)
class Row:
    """One rendered photograph.

    Attributes:
        name: Of the photograph.
        share: Of its visible corners, those found.
        rms_px: Their error.
        strays: Corners found where there is none.
        seconds: Time to find them.
        offset: Median offset of corners from their neighbours' prediction, in squares.
        labels_true: Whether all labels are right.
        classic: Whether OpenCV's classic detector found the board.
        sectors: Whether its sector-based one did.
    """

    name: str
    share: float
    rms_px: float
    strays: int
    seconds: float
    offset: float
    labels_true: bool
    classic: bool
    sectors: bool


def rendered(size: tuple[int, int], names: Sequence[str] = (), *, peers: bool = True) -> list[Row]:
    """Every rendered photograph of that size, or those named."""
    rows: list[Row] = []
    for name, shot in render.series(size).items():
        if names and name not in names:
            continue
        picture = render.take(shot)
        begun = time.perf_counter()
        found = plumbline.find_board(picture)
        seconds = time.perf_counter() - begun
        verdict = judged(shot, render.BOARD, found[0])
        rows.append(
            Row(
                name,
                verdict.share,
                verdict.rms_px,
                verdict.strays,
                seconds,
                irregularity(found[0]),
                verdict.labels_true,
                peers and bool(cv2.findChessboardCorners(picture, INNER)[0]),
                peers and bool(cv2.findChessboardCornersSB(picture, INNER)[0]),
            )
        )
    return rows


@dataclass(frozen=True)
class Peer:
    """One side of OpenCV's stereo photographs.

    Attributes:
        found: Photographs of which all 54 corners were found.
        photos: How many there are.
        held_px: Straightness with the distortion centre held.
        free_px: The same with it free.
        apart_px: Root mean square difference from `cv2.calibrateCamera` on the same corners, inside
            their hull, after the best homography.
        most_px: The largest.
    """

    found: int
    photos: int
    held_px: float
    free_px: float
    apart_px: float
    most_px: float


@dataclass(frozen=True)
class Together:
    """Four rendered photographs of one lens, fitted together.

    Attributes:
        rms_px: Error of the correction at the corners found, but for scale and place.
        largest_px: The largest.
        beyond: The largest in widths of the 95 % band there.
    """

    rms_px: float
    largest_px: float
    beyond: float


def together(name: str, size: tuple[int, int] = (1440, 1080)) -> Together:
    """Fit the first four poses of a lens and compare with the truth."""
    shots = [render.series(size)[f"{name}{number}"] for number in range(render.GOOD_POSES)]
    parts: list[plumbline.Observations] = []
    for number, shot in enumerate(shots):
        boards = plumbline.find_board(render.take(shot))
        photo = plumbline.Photo(size, f"{name}{number}")
        parts.append(plumbline.Observations((photo,), tuple(lines_of(boards[:1]))).checked())
    made = plumbline.calibrate(plumbline.join(parts), robust=True)
    points = np.concatenate([line.points_px for line in made.kept_observations.lines])
    off = _but_for_scale(made.lens.undistort(points), shots[0].view.undistort(points))
    error = displacement_errors(made.lens, made.free, made.covariance, points, points)
    assert error is not None
    band = quantile(0.975, made.dof) * error
    return Together(float(np.sqrt(np.mean(off**2))), float(off.max()), float((off / band).max()))


def _but_for_scale(ours: Any, true: Any) -> Any:
    """How far apart ideal points are after the best common scale and translation."""
    about, wanted = ours - ours.mean(axis=0), true - true.mean(axis=0)
    scale = float((about * wanted).sum() / (about * about).sum())
    return np.linalg.norm(scale * about - wanted, axis=1)


def opencv(side: str) -> Peer | None:
    """OpenCV's photographs of that side; None where they are not installed."""
    paths = sorted(OPENCV.glob(f"{side}[0-9][0-9].jpg"))
    if not paths:
        return None
    parts: list[plumbline.Observations] = []
    seen: list[tuple[Any, Any]] = []
    for path in paths:
        picture: Any = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        boards = plumbline.find_board(picture)
        if not boards or len(boards[0]) != 54:
            continue
        height, width = picture.shape
        photo = plumbline.Photo((width, height), path.name)
        parts.append(plumbline.Observations((photo,), tuple(lines_of(boards[:1]))).checked())
        squares = np.column_stack([boards[0].cells, np.zeros(54)]).astype(np.float32)
        seen.append((squares, boards[0].corners_px.astype(np.float32)))
    together = plumbline.join(parts)
    held = plumbline.calibrate(together, robust=True)
    free = plumbline.calibrate(together, free=("a", "b", "c", "d", "e"), robust=True)
    return Peer(len(parts), len(paths), held.rms_after_px, free.rms_after_px, *_apart(free, seen))


def _apart(made: plumbline.Calibration, seen: Sequence[tuple[Any, Any]]) -> tuple[float, float]:
    """Difference from OpenCV's calibration inside the hull of the corners, rms and largest."""
    squares, corners = ([pair[k] for pair in seen] for k in (0, 1))
    _, camera, bend, _, _ = cv2.calibrateCamera(
        squares, corners, made.lens.frame.size, np.eye(3), np.zeros(5)
    )
    hull = cv2.convexHull(np.concatenate(corners))
    x, y = (np.arange(0, side, 8.0) for side in made.lens.frame.size)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = np.array([cv2.pointPolygonTest(hull, tuple(p), False) >= 0 for p in grid.tolist()])
    points = grid[inside]
    theirs = cv2.undistortPoints(points[:, None], camera, bend, P=camera)[:, 0]
    ours = made.lens.undistort(points)
    plane: Any = cv2.findHomography(ours, theirs)[0]
    moved = cv2.perspectiveTransform(ours[:, None], plane)[:, 0]
    off = np.linalg.norm(moved - theirs, axis=1)
    return float(np.sqrt(np.mean(off**2))), float(off.max())


def main() -> None:
    """Print both."""
    size = (1440, 1080)
    print("photo       found  rms px  strays  labels  seconds  offset  classic  sectors")
    rows = rendered(size, sys.argv[1:])
    for row in rows:
        print(
            f"{row.name:10}  {100 * row.share:4.0f} %  {row.rms_px:6.3f}  {row.strays:6}  "
            f"{'true' if row.labels_true else 'WRONG':6}  {row.seconds:7.2f}  {row.offset:6.3f}  "
            f"{row.classic!s:7}  {row.sectors}"
        )
    print(
        f"{len(rows)} photos; OpenCV's classic detector found {sum(r.classic for r in rows)}, its "
        f"sector-based one {sum(r.sectors for r in rows)}"
    )
    for name in render.LENSES:
        lens = together(name)
        print(
            f"four of {name}: {lens.rms_px:.4f} px rms off the truth at the corners, at most "
            f"{lens.largest_px:.4f}, {lens.beyond:.2f} of the 95 % band"
        )
    for megapixels in (12, 45):
        wide = 4 * round(np.sqrt(megapixels * 1e6 / 12))
        (row,) = rendered((wide, wide * 3 // 4), ["kit1"], peers=False)
        print(f"{megapixels} MP: {100 * row.share:.0f} % in {row.seconds:.2f} s")
    for side in ("left", "right"):
        peer = opencv(side)
        if peer is None:
            print(f"OpenCV's {side} photographs are not here: Debian's opencv-doc has them")
            continue
        print(
            f"OpenCV {side}: {peer.found} of {peer.photos}; straight to {peer.held_px:.3f} px with "
            f"the centre held, {peer.free_px:.3f} px free; from cv2.calibrateCamera "
            f"{peer.apart_px:.3f} px rms, at most {peer.most_px:.3f} px inside the corners' hull"
        )


if __name__ == "__main__":
    main()
