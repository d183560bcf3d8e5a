"""A scene photographed twice: as the lens bends it, and as a camera's own correction leaves it.

The scene is painted where a perfect lens would show it; nothing here knows how points are matched
or a lens fitted.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from .board import KIT, Layer
from .optics import Array, Lens, Pose, View
from .scene import Picture, clouds

MARGIN = 0.35  # of the longer side, painted around what a perfect lens shows
RAYS = 2  # a pixel, across and down


@dataclass(frozen=True)
class Pair:
    """Two pictures to be taken of one scene.

    Attributes:
        lens: What bends the first.
        size: Of the first.
        scale: How much the second is enlarged.
        shift: Pixels that the second is moved right and down.
        corrected_size: Of the second; that of the first by default.
        turn: Degrees that the second is turned by.
        seed: Of scene and noise.
        scene: Seed of the scene of the second, where it is another.
        quality: Of the JPEG.
        noise: Standard deviation in grey levels.
    """

    lens: Lens = KIT
    size: tuple[int, int] = (1640, 1230)
    scale: float = 1.05
    shift: tuple[float, float] = (7.3, -4.6)
    corrected_size: tuple[int, int] | None = None
    turn: float = 0.0
    seed: int = 1
    scene: int | None = None
    quality: int = 85
    noise: float = 1.5

    @property
    def view(self) -> View:
        """The first picture's lens and size."""
        return View(self.lens, Pose(0, 0, 1), *self.size)

    def corrected(self, ideal: Array) -> Array:
        """Where the second picture shows ideal points of the first, pixels."""
        centre = (np.array(self.corrected_size or self.size) - 1) / 2
        cosine, sine = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        turned = (ideal - self.view.centre) @ np.array([[cosine, sine], [-sine, cosine]])
        return centre + self.scale * turned + np.array(self.shift)

    def ideal(self, corrected: Array) -> Array:
        """The other way."""
        centre = (np.array(self.corrected_size or self.size) - 1) / 2
        cosine, sine = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        turned = (corrected - centre - np.array(self.shift)) / self.scale
        return self.view.centre + turned @ np.array([[cosine, -sine], [sine, cosine]])


def take(pair: Pair) -> tuple[Picture, Picture]:
    """The two pictures in grey levels, after their JPEGs."""
    rng = np.random.default_rng(1000 + pair.seed)
    first = _seen(pair, scene(pair.seed, pair.size), pair.size, pair.view.undistort)
    of = pair.seed if pair.scene is None else pair.scene
    second = _seen(pair, scene(of, pair.size), pair.corrected_size or pair.size, pair.ideal)
    return _jpeg(pair, first, rng), _jpeg(pair, second, rng)


@lru_cache(maxsize=2)
def scene(seed: int, size: tuple[int, int]) -> Layer:
    """A wall of posters, bricks and stains of every size, in grey levels."""
    rng = np.random.default_rng(seed)
    wide, high = (round(side * (1 + 2 * MARGIN)) for side in size)
    wall = (120 + 25 * clouds((high, wide), rng, cells=9)).astype(np.float32)
    for _ in range(9000):
        side = float(np.exp(rng.uniform(np.log(4), np.log(110))))
        at = rng.uniform(0, [wide, high])
        corners = at + side * (rng.uniform(-1, 1, (int(rng.integers(3, 6)), 2)))
        cv2.fillPoly(wall, [np.rint(corners * 16).astype(np.int32)], float(rng.uniform(20, 235)),
                     cv2.LINE_AA, 4)  # fmt: skip
    return cv2.GaussianBlur(wall, (0, 0), 0.8).astype(np.float32)


def _seen(
    pair: Pair, wall: Layer, size: tuple[int, int], to_ideal: Callable[[Array], Array]
) -> Layer:
    steps = (np.arange(RAYS) + 0.5) / RAYS - 0.5
    pixels = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), -1).astype(np.float64)
    margin = MARGIN * np.array(pair.size)
    light = np.zeros(pixels.shape[:2], dtype=np.float32)
    for right in steps:
        for down in steps:
            at = (to_ideal(pixels + np.array([right, down])) + margin).astype(np.float32)
            light += cv2.remap(
                wall, at[..., 0], at[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
            )
    return cv2.GaussianBlur(light / RAYS**2, (0, 0), 0.6).astype(np.float32)


def _jpeg(pair: Pair, light: Layer, rng: np.random.Generator) -> Picture:
    noisy = light + rng.normal(0, pair.noise, light.shape)
    grey = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    _, data = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, pair.quality])
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), dtype=np.uint8)


def true_matches(pair: Pair, n: int, noise_px: float, seed: int) -> tuple[Array, Array]:
    """Matched points of both pictures with independent errors of half the variance each."""
    rng = np.random.default_rng(seed)
    ideal = rng.uniform(0, pair.size, (4 * n, 2))
    observed, corrected = pair.view.distort(ideal), pair.corrected(ideal)
    inside = _within(observed, pair.size) & _within(corrected, pair.corrected_size or pair.size)
    observed, corrected = observed[inside][:n], corrected[inside][:n]
    error = noise_px / np.sqrt(2)
    return (
        observed + rng.normal(0, error, observed.shape),
        corrected + rng.normal(0, error, corrected.shape),
    )


def _within(points: Array, size: tuple[int, int]) -> NDArray[np.bool_]:
    return np.all((points >= 0) & (points <= np.array(size) - 1), axis=1)
