"""Pictures of known content: dots at known places, and textures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.truth import Array, TrueLens

SIGMA_PX = 2.5

BARREL = {"a": 0.032059, "b": -0.097803, "c": 0.041666, "d": 0.0, "e": 0.0}


def barrel(size: tuple[int, int], **changed: float) -> TrueLens:
    return TrueLens("ptlens", BARREL | changed, size)


def grid_inside(size: tuple[int, int], nx: int = 9, ny: int = 6, margin: int = 60) -> Array:
    """Ideal points on a grid, shape (nx · ny, 2)."""
    x = np.linspace(margin, size[0] - 1 - margin, nx)
    y = np.linspace(margin, size[1] - 1 - margin, ny)
    return np.stack([part.ravel() for part in np.meshgrid(x, y)], axis=1)


def dots(size: tuple[int, int], centres: Array) -> Array:
    """Grey values 0 to 1: a Gaussian dot at each centre."""
    width, height = size
    picture = np.zeros((height, width))
    reach = 14
    for cx, cy in centres:
        x0, y0 = max(round(cx) - reach, 0), max(round(cy) - reach, 0)
        y, x = np.mgrid[y0 : min(y0 + 2 * reach, height), x0 : min(x0 + 2 * reach, width)]
        picture[y, x] += np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * SIGMA_PX**2))
    return picture


def centroids(picture: NDArray[Any], near: Array) -> Array:
    """Centres of brightness around the places where dots should be."""
    reach, found = 12, list[Array]()
    for x0, y0 in np.round(near).astype(int):
        y, x = np.mgrid[y0 - reach : y0 + reach + 1, x0 - reach : x0 + reach + 1]
        patch = picture[y, x].astype(float)
        found.append(np.array([(patch * x).sum(), (patch * y).sum()]) / patch.sum())
    return np.array(found)


def texture(size: tuple[int, int], channels: int = 3, seed: int = 0) -> NDArray[np.uint8]:
    """A smooth 8-bit texture with edges in it, shape (rows, columns, channels)."""
    import cv2

    rng = np.random.default_rng(seed)
    coarse = rng.uniform(30, 225, (size[1] // 24 + 2, size[0] // 24 + 2, channels))
    picture = cv2.resize(coarse.astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
    picture = picture.reshape(size[1], size[0], channels)
    picture[:, :: size[0] // 7] *= 0.5
    picture[:: size[1] // 5] *= 0.5
    picture = cv2.GaussianBlur(picture, (0, 0), 1.0).reshape(size[1], size[0], channels)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)
