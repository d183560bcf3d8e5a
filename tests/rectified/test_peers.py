"""ImageMagick's two steps, Barrel then Perspective, put dots where the one step here does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from plumbline.frame import Frame
from plumbline.ground.optics import Optics
from plumbline.ground.world_file import World
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from plumbline.rectified.grid import Grid
from plumbline.rectified.ground_map import GroundMap
from plumbline.rectified.render import Renderer
from tests.ground.scenes import Scene
from tests.ground.test_camera import camera_of
from tests.imaging.painted import centroids, dots
from tests.peers.tools import program, run

SCENE = Scene(height=5, pitch=60, roll=3, size=(901, 600), focal=900.0, b=-0.05)
GRID = Grid(World.north_up(-1.6, 4.6, 0.005), (640, 600))
PLACES = np.stack(np.meshgrid(np.linspace(-1.2, 1.2, 6), np.linspace(2.0, 4.2, 5)), -1).reshape(
    -1, 2
)


def test_imagemagick_s_barrel_and_perspective(tmp_path: Path) -> None:
    seen = SCENE.photo(PLACES)
    assert SCENE.lens.inside(seen).all()
    photo = np.rint(dots(SCENE.size, seen) * 60_000).astype(np.uint16)
    source, target = tmp_path / "photo.png", tmp_path / "out.png"
    cv2.imwrite(str(source), photo)
    corners = np.array([[-1.2, 2.0], [1.2, 2.0], [1.2, 4.2], [-1.2, 4.2]])
    ideal = SCENE.lens.undistort(SCENE.photo(corners)) + 0.5  # it counts from the pixel's edge
    wanted = GRID.world.pixels(corners) + 0.5
    pairs = " ".join(
        f"{x!r},{y!r} {u!r},{v!r}"
        for (x, y), (u, v) in zip(ideal.tolist(), wanted.tolist(), strict=True)
    )
    width, height = GRID.size
    run(
        [
            *(program("convert-im6.q16", "magick"), str(source), "-virtual-pixel", "black"),
            *("-distort", "Barrel", f"0 {SCENE.b} 0 {1 - SCENE.b}"),
            *("-define", f"distort:viewport={width}x{height}+0+0"),
            *("-distort", "Perspective", pairs, "-depth", "16", str(target)),
        ]
    )
    theirs = cv2.imread(str(target), cv2.IMREAD_UNCHANGED)
    assert theirs is not None
    lens = PhotoLens(Frame(*SCENE.size), get_model("ptlens"), (0.0, SCENE.b, 0.0), 300.0)
    camera = replace(camera_of(SCENE), optics=Optics(lens))
    ours = Renderer(photo, GroundMap(camera, GRID, 1.0), threads=1).render((0.0,)).pixels
    at = GRID.world.pixels(PLACES)
    apart = centroids(ours, at) - centroids(theirs if theirs.ndim == 2 else theirs[..., 1], at)
    assert np.max(np.hypot(*apart.T)) < 0.05
