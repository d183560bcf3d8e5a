"""Photographs of flat walls by many lenses, near and far, clean and spoiled, by number."""

from dataclasses import replace

import numpy as np

from . import optics
from .optics import Array, Lens, Pose, View
from .picks import inside
from .plane import Camera, Wall, facade, interrupted
from .scene import Edge

ACTION = Lens(
    "", "action camera", "a wide lens of action cameras", 3.0, 5.6, 0.004, -0.045, 0.0,
    "chosen: 15 % of barrel in the corner",
)  # fmt: skip
LENSES = (
    optics.EFS_18, optics.NIKKOR_42, optics.G15_6, optics.DX_18, optics.DX_35, optics.DX_105, ACTION
)  # fmt: skip

STEP_PX = 2.0  # pixels between the points of a true edge


def shot(number: int, *, size: tuple[int, int] = (1500, 1000)) -> tuple[Camera, Wall]:
    """Return photograph `number`: each is another lens, pose, blur, noise and compression."""
    rng = np.random.default_rng([1913, number])
    wall = facade(rng, float(rng.uniform(30, 48)), float(rng.uniform(18, 28)))
    if number % 4 == 3:
        wall = interrupted(wall, rng, 12)
    wide, high = size if number % 6 != 5 else size[::-1]
    view = _view(LENSES[number % len(LENSES)], wall, rng, wide, high, fills=number % 3 != 2)
    blur = float(rng.uniform(0.55, 1.1))
    camera = Camera(
        view,
        blur_px=(blur, blur * float(rng.uniform(1.0, 1.9))),
        noise=float(rng.choice([0.5, 1, 2, 4, 8])),
        sharpening=float(rng.choice([0, 0, 0, 1])),
        quality=int(rng.choice([0, 0, 70, 80, 90, 95])),
        sampling_420=bool(rng.integers(2)),
        exposure=float(rng.choice([0.25, 1.0, 1.0, 1.0, 1.15])),
        falloff=float(rng.uniform(0, 0.4)),
        seed=number,
    )
    return camera, wall


def clean(camera: Camera) -> Camera:
    """Return the same camera without compression and sharpening."""
    return replace(camera, quality=0, sharpening=0.0)


def _view(
    lens: Lens, wall: Wall, rng: np.random.Generator, wide: int, high: int, *, fills: bool
) -> View:
    """Stand before the middle of the wall, so far away that it fills the frame or does not."""
    right = max(edge.level for edge in wall.edges if edge.axis == "v")
    top = max(edge.level for edge in wall.edges if edge.axis == "h")
    trial = View(lens, Pose(0, 0, 1), wide, high)
    corner = trial.undistort(np.array([0.0, 0.0]))
    across, up = np.abs(corner - trial.centre) / trial.focal_px
    near = min(right / 2 / across, top / 2 / up) * 0.9
    far = max(right / 2 / across, top / 2 / up) * 1.1
    distance = float(near if fills else far)
    yaw, pitch, roll = rng.uniform(-1, 1, 3) * (5, 3, 1.5)
    pose = Pose(right / 2, top / 2, distance, float(yaw), float(pitch), float(roll))
    return View(lens, pose, wide, high)


def seen(view: View, edge: Edge) -> Array:
    """Return points along the longest visible part of an edge, two pixels apart. Shape (n, 2)."""
    along = np.linspace(edge.spans[0][0], edge.spans[-1][1], 4000)
    points = view.project(edge.points(along))
    shown = np.flatnonzero(np.diff(np.pad(inside(view, points, 6.0), 1).astype(int)))
    if len(shown) == 0:
        return points[:0]
    first, last = max(shown.reshape(-1, 2).tolist(), key=lambda run: run[1] - run[0])
    points = points[first:last]
    if len(points) < 2:
        return points
    way = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    at = np.arange(0.0, way[-1], STEP_PX)
    return np.stack([np.interp(at, way, points[:, axis]) for axis in (0, 1)], axis=-1)


def long_edges(view: View, wall: Wall, share: float = 0.35) -> list[tuple[Edge, Array]]:
    """Return the edges seen over this share of the photo's shorter side, and their points."""
    least = share * min(view.width, view.height)
    found = [(edge, seen(view, edge)) for edge in wall.edges]
    return [(edge, points) for edge, points in found if len(points) * STEP_PX > least]
