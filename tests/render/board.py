"""Photographs of chequerboards: where every corner truly lies, and what the camera shows of it.

A board hangs on a wall full of clutter. Every pixel is the mean of `RAYS` rays, taken in
linear light; the wall is met by the rays of `optics.View`, so nothing here knows how a lens is
fitted or a corner found.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from .optics import Array, Lens, Pose, View
from .scene import Picture, clouds

RAYS = 16  # a pixel
PAPER, INK = 0.82, 0.045  # reflectances
TEXELS = 160  # of the clutter, a metre
WALL_M = 8.0
WALLS = 3  # different ones; a shot's seed chooses

Layer = NDArray[np.float32]

MILD = Lens(
    "Nikon", "Nikon D750", "Nikkor AF-S 24-85mm f/3.5-4.5G ED VR", 42, 1.0,
    0.00831, -0.00929, 0.02554, "slr-nikon.xml",
)  # fmt: skip
KIT = Lens(
    "Canon", "Canon EOS 450D", "Canon EF-S 18-55mm f/3.5-5.6 IS", 18, 1.622,
    0.00644, -0.01245, -0.0348, "slr-canon.xml",
)  # fmt: skip
COMPACT = Lens(
    "Canon", "Canon PowerShot G15", "Canon PowerShot G15 6.1-30.5mm f/1.8-2.8", 6.1, 4.65,
    0.022578, -0.081031, 0.011077, "compact-canon.xml",
)  # fmt: skip
ACTION = Lens(
    "GoPro", "HERO3+ Black Edition", "GoPro Hero3+ black & compatibles", 2.77, 7.66,
    0.01049, 0.01663, -0.40901, "actioncams.xml",
)  # fmt: skip
LENSES = {"mild": MILD, "kit": KIT, "compact": COMPACT, "action": ACTION}


@dataclass(frozen=True)
class Board:
    """A chequerboard on the wall, metres right and up of the wall's origin.

    Attributes:
        columns: Inner corners in a row.
        rows: Inner corners in a column.
        square: Side of a square.
        at: Its middle.
        turn: Degrees that it is turned in the wall.
        margin: White paper around it, in squares.
        seam: Metres that everything right of the middle column is moved to the right.
    """

    columns: int
    rows: int
    square: float = 0.1
    at: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0
    margin: float = 0.7
    seam: float = 0.0

    @property
    def cells(self) -> NDArray[np.int64]:
        """Column and row of every inner corner, shape (rows · columns, 2)."""
        return np.stack(np.meshgrid(np.arange(self.columns), np.arange(self.rows)), -1).reshape(
            -1, 2
        )

    @property
    def corners(self) -> Array:
        """Where they lie on the wall, in the same order."""
        local = (self.cells - np.array([self.columns - 1, self.rows - 1]) / 2) * self.square
        local[:, 0] += self.seam * (self.cells[:, 0] > self.columns // 2)
        return local * np.array([1.0, -1.0]) @ self._axes + np.array(self.at)

    @property
    def _axes(self) -> Array:
        cosine, sine = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        return np.array([[cosine, sine], [-sine, cosine]])

    def paint(self, x: Layer, y: Layer, wall: Layer) -> Layer:
        """Reflectance at points of the wall, where `wall` is what it has without the board."""
        (right_x, right_y), (up_x, up_y) = (self._axes / self.square).tolist()
        x, y = x - self.at[0], y - self.at[1]
        u = x * right_x + y * right_y + (self.columns + 1) / 2
        v = (self.rows + 1) / 2 - x * up_x - y * up_y
        if self.seam:
            split, gap = self.columns // 2 + 1.5, self.seam / self.square
            u = np.where(u > split + gap, u - gap, np.minimum(u, split))
        wide, high, m = self.columns + 1, self.rows + 1, self.margin
        sheet = (u >= -m) & (v >= -m) & (u < wide + m) & (v < high + m)
        dark = (u >= 0) & (v >= 0) & (u < wide) & (v < high)
        dark &= ((np.floor(u) + np.floor(v)).astype(np.int32) & 1) == 0
        seen = np.where(sheet, np.float32(PAPER), wall)
        seen[dark] = INK
        return seen


@dataclass(frozen=True)
class Shot:
    """One photograph to be taken.

    Attributes:
        view: Lens, pose and size.
        boards: What hangs on the wall.
        seed: Of clutter and noise.
        noise: Standard deviation in grey levels.
        blur_px: Standard deviation of the blur.
        glare: Light of a lamp's reflection, as a share of white paper.
    """

    view: View
    boards: tuple[Board, ...]
    seed: int = 1
    noise: float = 1.0
    blur_px: float = 0.7
    glare: float = 0.0

    def corners(self, board: Board) -> Array:
        """Where the photo shows a board's corners, NaN behind the camera, shape (n, 2)."""
        return self.view.project(board.corners)


def visible(shot: Shot, board: Board, margin_px: float = 8.0) -> NDArray[np.bool_]:
    """Which corners of a board lie in the photo, that far from its edges."""
    x, y = shot.corners(board).T
    last = np.array([shot.view.width - 1, shot.view.height - 1])
    with np.errstate(invalid="ignore"):
        return (
            (x >= margin_px)
            & (y >= margin_px)
            & (x <= last[0] - margin_px)
            & (y <= last[1] - margin_px)
        )


@lru_cache(maxsize=4)
def _wall(seed: int) -> Layer:
    return clutter(np.random.default_rng(seed))


def take(shot: Shot) -> Picture:
    """The photograph in grey levels of sRGB, shape (height, width)."""
    rng = np.random.default_rng(shot.seed)
    view = shot.view
    wall = _wall(shot.seed % WALLS)
    x, y = _wall_points(view)
    light = np.zeros(x.shape, dtype=np.float32)
    (x_down, x_right), (y_down, y_right) = np.gradient(x), np.gradient(y)
    for right, down in _within_a_pixel():
        xs, ys = (
            x + x_right * np.float32(right) + x_down * np.float32(down),
            y + y_right * np.float32(right) + y_down * np.float32(down),
        )
        seen = _sampled(wall, xs, ys)
        for board in shot.boards:
            seen = board.paint(xs, ys, seen)
        light += seen / RAYS
    light *= 0.75 + 0.25 * np.tanh((x - np.nanmean(x)) / 0.8)
    light = cv2.GaussianBlur(light + shot.glare * _lamp(view), (0, 0), shot.blur_px)
    grey = 255 * np.where(light > 0.0031308, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055,
                          12.92 * light)  # fmt: skip
    grey += rng.normal(0.0, shot.noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _within_a_pixel() -> Array:
    """Where the rays of a pixel start, no two of them in one row or column (J. Hammersley).

    On a square grid an upright edge would move in quarters of a pixel.
    """
    k = np.arange(RAYS)
    mirrored = sum(((k >> bit) & 1) / 2 ** (bit + 1) for bit in range(RAYS.bit_length() - 1))
    return np.stack([(k + 0.5) / RAYS, mirrored + 0.5 / RAYS], axis=1) - 0.5


def _wall_points(view: View) -> tuple[Layer, Layer]:
    """Where the ray of each pixel meets the wall, metres right and up."""
    pixels = np.stack(np.meshgrid(np.arange(view.width), np.arange(view.height)), -1)
    rays = view.rays(pixels.astype(np.float64))
    ahead = np.maximum(rays[..., 2], 1e-3)
    reach = view.pose.distance / ahead
    x, y = view.pose.x + reach * rays[..., 0], view.pose.eye - reach * rays[..., 1]
    return x.astype(np.float32), y.astype(np.float32)


def clutter(rng: np.random.Generator) -> Layer:
    """A wall of `WALL_M` metres with shelves, books and pictures, reflectances."""
    side = int(WALL_M * TEXELS)
    wall = (0.35 + 0.06 * clouds((side, side), rng, cells=12)).astype(np.float32)
    for _ in range(420):
        wide, high = rng.integers(12, 160, 2)
        left, top = rng.integers(0, side - 160, 2)
        wall[top : top + high, left : left + wide] = rng.uniform(0.05, 0.8)
    return np.clip(wall, 0.02, 0.9)


def _sampled(wall: Layer, x: Layer, y: Layer) -> Layer:
    u, v = (x / WALL_M + 0.5) * wall.shape[1], (0.5 - y / WALL_M) * wall.shape[0]
    seen = cv2.remap(wall, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(seen, dtype=np.float32)


def _lamp(view: View) -> Array:
    x, y = np.meshgrid(np.arange(view.width) / view.width, np.arange(view.height) / view.height)
    return np.exp(-(((x - 0.55) / 0.16) ** 2 + ((y - 0.4) / 0.2) ** 2) / 2)


POSES = (
    Pose(0.0, 0.0, 1.0),
    Pose(0.55, 0.1, 0.95, yaw=-30, pitch=4, roll=5),
    Pose(-0.1, -0.6, 0.95, yaw=5, pitch=32, roll=-8),
    Pose(-0.95, 0.25, 0.85, yaw=45, pitch=-10, roll=3),
    Pose(0.34, -0.1, 0.8, yaw=0, pitch=4, roll=12),
    Pose(-0.2, 0.36, 0.75, yaw=-6, pitch=-8, roll=85),
)
"""Straight on; turned; tipped; 45 degrees; a third out of view to the left; to the bottom."""

GOOD_POSES = 4
"""So many of them have most of the board in view."""

BOARD = Board(columns=9, rows=6)


def series(size: tuple[int, int] = (1440, 1080)) -> dict[str, Shot]:
    """The 24 photographs by name: every lens in every pose, every second one noisy."""
    shots: dict[str, Shot] = {}
    for name, lens in LENSES.items():
        for number, pose in enumerate(POSES):
            noisy = len(shots) % 4 in (1, 2)
            shots[f"{name}{number}"] = Shot(
                View(lens, framed(lens, pose, size), *size),
                (BOARD,),
                seed=100 + len(shots),
                noise=5.0 if noisy else 0.8,
                blur_px=1.1 if noisy else 0.7,
                glare=0.5 if number == 2 else 0.0,
            )  # fmt: skip
    return shots


def framed(lens: Lens, pose: Pose, size: tuple[int, int]) -> Pose:
    """The pose stepped back or forth, so that the board fills the frame as with a normal lens."""
    zoom = View(lens, pose, *size).focal_px / size[1] / 1.15
    if lens is ACTION:
        zoom *= 0.72  # barrel shrinks what is far from the centre
    return replace(pose, x=pose.x * zoom, eye=pose.eye * zoom, distance=pose.distance * zoom)


def sheet(pictures: Sequence[Picture], across: int) -> Picture:
    """Pictures of one size in rows, to look at."""
    rows = [np.hstack(pictures[i : i + across]) for i in range(0, len(pictures), across)]
    return np.vstack(rows)
