"""How long a rectified picture takes, against `correct` for as many output pixels.

    python -m tests.benchmarks.rectify_speed [--megapixels 12]

The photo is a texture of as many megapixels, taken from 5 m; the picture covers what it shows.
Decoding and encoding are left out of both, threads are those of the machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.ground.optics import Optics
from plumbline.ground.world_file import World
from plumbline.imaging.correct import correct_array
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from plumbline.rectified.grid import Grid
from plumbline.rectified.ground_map import GroundMap
from plumbline.rectified.render import Renderer
from tests.ground.scenes import Scene
from tests.ground.test_camera import camera_of
from tests.imaging.painted import texture

_REPEATS = 3


@dataclass(frozen=True)
class Times:
    """Seconds of the best of a few runs, and the share of the picture that shows anything."""

    correct_s: float
    rectify_s: float
    shown: float


def times(megapixels: float, repeats: int = _REPEATS) -> Times:
    """Both, for a picture of as many pixels as the photo."""
    width = round(np.sqrt(megapixels * 1e6 * 4 / 3))
    size = (width, round(width * 3 / 4))
    pixels = texture(size)
    model, values = get_model("ptlens"), {"a": 0.0, "b": -0.02, "c": 0.0, "d": 0.0, "e": 0.0}
    lens = Lens(model, Frame(*size), values)
    scene = Scene(height=5, pitch=35, focal=1.1 * width, size=size)
    laid = PhotoLens(Frame(*size), model, (0.0, -0.02, 0.0), min(size) / 2)
    camera = replace(camera_of(scene), optics=Optics(laid))
    metres = 7.0 / size[1]
    grid = Grid(World.north_up(-metres * width / 2, 11.5, metres), size)
    renderer = Renderer(pixels, GroundMap(camera, grid, 1.0))
    shown = float(np.mean(renderer.render((0.0, 0.0, 0.0)).shown))
    return Times(
        _best(lambda: correct_array(pixels, lens), repeats),
        _best(lambda: renderer.render((0.0, 0.0, 0.0)), repeats),
        shown,
    )


def _best(run: Callable[[], object], repeats: int) -> float:
    found: list[float] = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
    return min(found)


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--megapixels", type=float, default=12.0)
    found = times(parser.parse_args().megapixels)
    print(
        f"correct {found.correct_s:.2f} s, rectify {found.rectify_s:.2f} s "
        f"({found.rectify_s / found.correct_s:.2f} times), {100 * found.shown:.0f} % shown"
    )


if __name__ == "__main__":
    main()
