"""Paints a road, photographs it at eye height, surveys it, and writes `sample_projects/road`.

Run from the top of the repository: `python -m tests.render.road [folder]`.

The road lies in x (right), y (ahead) and is uneven by a smooth centimetre and a half: photograph,
picks and tapes all see the same unevenness. As all of this package it imports nothing of plumbline.
"""

import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from . import optics, photo
from .optics import Array, Pose, View
from .scene import Picture, clouds

TARGET = Path(__file__).resolve().parents[2] / "sample_projects" / "road"


class RoadView(View):
    """A view whose focal length is that of the observed picture at its centre, as EXIF means it."""

    @property
    def focal_px(self) -> float:
        """The ideal picture's, smaller by the gauge of the a, b, c formula."""
        return super().focal_px / float(self.lens.stretch(np.zeros(1))[0])


VIEW = RoadView(optics.G15_6, Pose(0.35, 1.58, 0.0, yaw=2.0, pitch=-9.0, roll=0.7), 2048, 1536)
UNEVEN_M, PICK_PX, SURVEY_M, TAPE_M = 0.015, 0.5, 0.01, 0.005
CROSSES = {
    "A": (-1.60, 3.20), "B": (1.70, 3.40), "C": (3.00, 11.00), "D": (-2.90, 10.60),
    "E": (0.30, 6.20), "F": (2.10, 19.50), "G": (-2.40, 17.80),
}  # fmt: skip
TAPED = ("AB", "BC", "CD", "DA", "AC", "BD")
LANES = {"left": -3.20, "right": 3.30}
SKID = {"S1": (0.75, 7.40), "S2": (-0.20, 15.60)}
"""Where the tyre mark begins and ends."""

AERIAL_M, AERIAL_LEFT, AERIAL_TOP, AERIAL_SIZE = 0.04, -8.0, 30.0, (400, 800)
SEED = 601


@dataclass(frozen=True)
class Road:
    """The road's colours and heights on the plane.

    Attributes:
        seed: Of texture and unevenness.
    """

    seed: int = SEED

    @cached_property
    def _layers(self) -> tuple[Array, Array, Array]:
        rng = np.random.default_rng(self.seed)
        fine = clouds((2048, 1024), rng, cells=128, octaves=3)
        coarse = clouds((1024, 512), rng, cells=12)
        height = clouds((512, 256), rng, cells=10, octaves=2)
        return fine, coarse, height * UNEVEN_M

    def _at(self, layer: Array, places: Array, metres: float) -> Array:
        """A layer laid over 40 m by 80 m, repeated; `metres` a texel."""
        rows, columns = layer.shape
        u = np.mod((places[..., 0] + 20) / metres, columns - 1).astype(np.float32)
        v = np.mod(places[..., 1] / metres, rows - 1).astype(np.float32)
        return cv2.remap(layer.astype(np.float32), u, v, cv2.INTER_LINEAR).astype(np.float64)

    def height(self, places: Array) -> Array:
        """Height over the plane, metres."""
        return self._at(self._layers[2], places, 80 / 512)

    def colour(self, places: Array) -> Array:
        """Colours of places (n, m, 2), sRGB."""
        x, y = places[..., 0], places[..., 1]
        fine, coarse, _ = self._layers
        grey = 92 + 9 * self._at(fine, places, 80 / 2048) + 7 * self._at(coarse, places, 80 / 1024)
        rgb = np.stack((grey, grey, grey * 1.02), axis=-1)
        grass = np.array([86.0, 104.0, 58.0]) * (grey / 92)[..., None]
        rgb = np.where((np.abs(x) > 4.2)[..., None], grass, rgb)
        mark = x - _tyre(y)
        between = (y > SKID["S1"][1]) & (y < SKID["S2"][1]) & (np.abs(mark) < 0.09)
        rgb = np.where(between[..., None], rgb * 0.55, rgb)
        lane = np.zeros(x.shape, bool)
        for middle in LANES.values():
            lane |= np.abs(x - middle) < 0.06
        lane |= (np.abs(x - 0.05) < 0.06) & (np.mod(y, 9.0) < 4.5)
        rgb = np.where(lane[..., None], 206 + (rgb - 92) * 0.6, rgb)
        for cx, cy in CROSSES.values():
            dx, dy = np.abs(x - cx), np.abs(y - cy)
            cross = ((dx < 0.02) & (dy < 0.15)) | ((dy < 0.02) & (dx < 0.15))
            rgb = np.where(cross[..., None], np.array([236.0, 214.0, 60.0]), rgb)
        return rgb


def _tyre(y: Array) -> Array:
    """The tyre mark's middle: a gentle curve from S1 to S2."""
    (x1, y1), (x2, y2) = SKID["S1"], SKID["S2"]
    share = np.clip((y - y1) / (y2 - y1), 0, 1)
    return x1 + (x2 - x1) * share**1.4


def place_of_rays(road: Road, rays: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Places on the uneven road that rays meet, and which of them go down at all."""
    down = rays[..., 1]
    good = down > 1e-4
    safe = np.where(good, down, 1.0)
    places = np.zeros((*down.shape, 2))
    lift = np.zeros(down.shape)
    for _ in range(3):
        reach = (VIEW.pose.eye - lift) / safe
        places = np.stack((VIEW.pose.x + reach * rays[..., 0], reach * rays[..., 2]), axis=-1)
        lift = np.where(good, road.height(np.where(good[..., None], places, 0.0)), 0.0)
    return places, good


def seen(road: Road, places: Array) -> Array:
    """Observed pixels of places on the uneven road, shape (n, 2)."""
    pose = VIEW.pose
    lift = road.height(places[None])[0]
    world = np.stack((places[:, 0] - pose.x, pose.eye - lift, places[:, 1]), axis=-1)
    camera = world @ pose.rotation.T
    return VIEW.distort(VIEW.centre + VIEW.focal_px * camera[:, :2] / camera[:, 2:])


def photograph(road: Road) -> Picture:
    """The photograph, sRGB."""
    rng = np.random.default_rng(SEED + 1)
    strips: list[Array] = []
    n, step = 3, 48
    sub = (np.arange(n) + 0.5) / n - 0.5
    xs = (np.arange(VIEW.width)[:, None] + sub).ravel()
    for top in range(0, VIEW.height, step):
        ys = (np.arange(top, top + step)[:, None] + sub).ravel()
        rays = VIEW.rays(np.stack(np.meshgrid(xs, ys), axis=-1))
        places, down = place_of_rays(road, rays)
        haze = np.clip(places[..., 1:] / 400, 0, 1)
        ground = road.colour(places) * (1 - haze) + np.array([196.0, 206.0, 214.0]) * haze
        up = np.clip(-rays[..., 1:2] / np.linalg.norm(rays, axis=-1, keepdims=True), 0, 1)
        sky = np.array([206.0, 216.0, 226.0]) - up * np.array([90.0, 60.0, 20.0])
        colours = np.where((down & (places[..., 1] < 400))[..., None], ground, sky)
        strips.append(colours.reshape(step, n, VIEW.width, n, 3).mean(axis=(1, 3)))
    blurred = cv2.GaussianBlur(np.concatenate(strips), (0, 0), photo.BLUR_PX)
    noisy = blurred + photo.NOISE * rng.standard_normal(blurred.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def aerial(road: Road) -> Picture:
    """The road from above at 4 cm a pixel, north up."""
    width, height = AERIAL_SIZE
    n = 3
    sub = (np.arange(n) + 0.5) / n - 0.5
    columns = (np.arange(width)[:, None] + sub).ravel()
    rows = (np.arange(height)[:, None] + sub).ravel()
    u, v = np.meshgrid(columns, rows)
    places = np.stack((AERIAL_LEFT + AERIAL_M * u, AERIAL_TOP - AERIAL_M * v), axis=-1)
    colours = road.colour(places).reshape(height, n, width, n, 3).mean(axis=(1, 3))
    return np.clip(np.rint(colours * 1.05), 0, 255).astype(np.uint8)


def texts() -> dict[str, str]:
    """Every text file of the sample, by name."""
    road, rng = Road(), np.random.default_rng(SEED + 2)
    names, places = list(CROSSES), np.array(list(CROSSES.values()))
    picks = seen(road, places) + rng.normal(0, PICK_PX, places.shape)
    survey = places + rng.normal(0, SURVEY_M, places.shape)
    points = [
        f"{x:.1f},{y:.1f},{east:.3f},{north:.3f},{name}"
        for (x, y), (east, north), name in zip(picks, survey, names, strict=True)
    ]
    taped = [
        f"{a},{b},{np.hypot(*np.subtract(CROSSES[a], CROSSES[b])) + rng.normal(0, TAPE_M):.3f}"
        for a, b in TAPED
    ]
    edges: list[str] = []
    for name, x in LANES.items():
        along = np.geomspace(7.0, 55.0, 12)
        traced = seen(road, np.stack((np.full(12, x), along), axis=-1))
        edges += [f"{name},{u:.1f},{v:.1f}" for u, v in traced + rng.normal(0, PICK_PX, (12, 2))]
    skid = seen(road, np.array(list(SKID.values()))) + rng.normal(0, PICK_PX, (2, 2))
    marks = [f"{u:.1f},{v:.1f},{name}" for (u, v), name in zip(skid, SKID, strict=True)]
    world = (AERIAL_M, 0, 0, -AERIAL_M, AERIAL_LEFT, AERIAL_TOP)
    four = [f"{u:.1f},{v:.1f},{name}" for (u, v), name in zip(picks[:4], names, strict=False)]
    return {
        "points.csv": _table("x,y,X,Y,name", points),
        "picks.csv": _table("x,y,name", four),
        "tapes.csv": _table("from,to,metres", taped),
        "edges.csv": _table("line,x,y", edges),
        "marks.csv": _table("x,y,name", marks),
        "aerial.pgw": "".join(f"{value:.10f}\n" for value in world),
        "truth.json": json.dumps(truth(), indent=2) + "\n",
    }


def truth() -> dict[str, object]:
    """What the renderer knows."""
    pose, lens = VIEW.pose, VIEW.lens
    length = float(np.hypot(*np.subtract(SKID["S1"], SKID["S2"])))
    return {
        "lens": {"model": "ptlens", "coefficients": lens.coefficients, "source": lens.source},
        "camera": {
            "x": pose.x, "height": pose.eye, "pitch_deg": pose.pitch, "roll_deg": pose.roll,
            "heading_deg": pose.yaw, "focal_px": VIEW.focal_px,
        },
        "points": CROSSES,
        "marks": SKID,
        "mark_length": length,
        "lanes": LANES,
        "noise": {
            "pick_px": PICK_PX, "survey_m": SURVEY_M, "tape_m": TAPE_M, "unevenness_m": UNEVEN_M,
        },
    }  # fmt: skip


def _table(header: str, rows: list[str]) -> str:
    return "\n".join([header, *rows]) + "\n"


def main(target: Path = TARGET) -> None:
    """Write everything but the README."""
    target.mkdir(parents=True, exist_ok=True)
    for name, text in texts().items():
        (target / name).write_text(text, encoding="utf-8", newline="\n")
    road = Road()
    Image.fromarray(aerial(road)).save(target / "aerial.png")
    photo.save(photograph(road), VIEW, target / "road.jpg", "2023:04:02 11:20:05")


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
