"""Small pictures of one edge, drawn in closed form: what the parts are held against."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Light = NDArray[np.float32]
SIZE = (600, 400)


def edge_y(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """A gently bent edge from left to right."""
    return 180.3 + 0.02 * x + 6.0 * (x / 600) * (1 - x / 600)


def drawn(
    profile: Callable[[NDArray[np.float64]], NDArray[np.float64]], *, noise: float = 0.0
) -> Light:
    """Linear light as a function of the vertical distance from the edge."""
    x, y = np.meshgrid(np.arange(SIZE[0], dtype=float), np.arange(SIZE[1], dtype=float))
    light = profile(y - edge_y(x))
    light = light + noise * np.random.default_rng(5).standard_normal(light.shape)
    return light.astype(np.float32)


def step(d: NDArray[np.float64], blur: float = 0.8) -> NDArray[np.float64]:
    """Dark above, bright below."""
    return 0.2 + 0.5 * ndtr(d / blur)


def groove(d: NDArray[np.float64], width: float = 2.6, blur: float = 0.8) -> NDArray[np.float64]:
    """A dark joint between two bright plates."""
    return 0.7 - 0.5 * (ndtr((d + width / 2) / blur) - ndtr((d - width / 2) / blur))


def picks(number: int = 5, off: float = 0.0, seed: int = 1) -> NDArray[np.float64]:
    """Rough picks along the edge, off by a normal error across it."""
    x = np.linspace(20, 580, number)
    y = edge_y(x) + off * np.random.default_rng(seed).standard_normal(number)
    return np.stack((x, y), axis=-1)


def stored(light: Light) -> NDArray[np.uint8]:
    """8-bit sRGB values of linear light (IEC 61966-2-1)."""
    light = np.clip(light, 0, 1)
    bent = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.rint(255 * bent).astype(np.uint8)
