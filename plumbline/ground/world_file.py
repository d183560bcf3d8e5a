"""World files: six lines that lay a picture's pixels over a map.

    A  D  B  E  C  F, one a line:   X = A·x + B·y + C,   Y = D·x + E·y + F

x and y count from the centre of the top-left pixel, as everywhere here. Source: ESRI, World files
for raster datasets.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbline.errors import ReadError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.frame import Array

_DIGITS = 15
"""Significant digits written: a micrometre of ten million metres needs 13."""

SUFFIXES = {
    ".jpg": ".jgw",
    ".jpeg": ".jgw",
    ".png": ".pgw",
    ".tif": ".tfw",
    ".tiff": ".tfw",
    ".webp": ".wld",
}
"""The suffix of a picture's world file."""


@dataclass(frozen=True)
class World:
    """Pixels of a picture laid over a plane.

    Attributes:
        matrix: (A, B) and (D, E), metres a pixel, shape (2, 2).
        origin: (C, F), where the centre of the top-left pixel lies.
    """

    matrix: Array
    origin: Array

    @classmethod
    def north_up(cls, left_m: float, top_m: float, resolution_m: float) -> World:
        """The world of a picture whose top-left pixel has its centre there, Y upwards."""
        matrix = np.array([[resolution_m, 0.0], [0.0, -resolution_m]])
        return cls(matrix, np.array([left_m, top_m]))

    def places(self, pixels: Array) -> Array:
        """Pixels to places, shape (..., 2)."""
        return pixels @ self.matrix.T + self.origin

    def pixels(self, places: Array) -> Array:
        """Places to pixels, shape (..., 2)."""
        return (places - self.origin) @ np.linalg.inv(self.matrix).T

    @property
    def resolution_m(self) -> float:
        """Side of the square of the same area as one pixel."""
        return math.sqrt(abs(float(np.linalg.det(self.matrix))))

    def text(self) -> str:
        """The world file."""
        (a, b), (d, e) = self.matrix
        return "".join(f"{value:.{_DIGITS}g}\n" for value in (a, d, b, e, *self.origin))


def world_file_of(picture: str | Path) -> Path | None:
    """The world file beside a picture, or None."""
    path = Path(picture)
    suffix = path.suffix.lower()
    short = suffix[:2] + suffix[-1:] + "w"
    for name in dict.fromkeys((SUFFIXES.get(suffix, short), short, f"{suffix}w", ".wld")):
        for spelt in (name, name.upper()):
            if path.with_suffix(spelt).is_file():
                return path.with_suffix(spelt)
    return None


def read_world(picture: str | Path) -> World:
    """The world file beside a picture.

    Raises:
        ReadError: there is none, or it does not hold six numbers of a plane.
    """
    path = world_file_of(picture)
    if path is None:
        expected = SUFFIXES.get(Path(picture).suffix.lower(), ".wld")
        raise ReadError(
            f"there is no world file {Path(picture).with_suffix(expected).name} beside it",
            path=picture,
            hint="export it with the picture, or give places in metres",
        )
    source = Source(str(path), read_bytes(path))
    lines = [line for line in source.text().split() if line]
    if len(lines) != 6:
        raise source.error(
            f"a world file has six numbers, and this one has {len(lines)} words",
            hint="export it again",
        )
    a, d, b, e, c, f = (
        source.number(text.replace(",", "."), row, what="a number")
        for row, text in enumerate(lines, start=1)
    )
    matrix = np.array([[a, b], [d, e]])
    if abs(float(np.linalg.det(matrix))) < 1e-12 * float(np.sum(matrix**2)) or not matrix.any():
        raise source.error("its pixels have no area", hint="export the world file again")
    return World(matrix, np.array([c, f]))
