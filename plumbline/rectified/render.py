"""The pixels of a rectified picture, tile by tile, without aliasing.

Near the camera one pixel of the picture takes in many of the photo. Each tile is sampled as many
times across and down as the photo has pixels there, and averaged; where both are large, from a
copy of the photo that was halved beforehand (P. Burt and E. Adelson, 1983).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.imaging.maps.sampling_map import Tile
from plumbline.imaging.resample import cores, one_tile
from plumbline.photos.files.picture import Pixels
from plumbline.rectified.ground_map import GroundMap, TileMap

_MOST_SAMPLES = 8
"""Samples of a pixel across or down: chosen; beyond it the photo is halved first."""

_ONCE = 0.25
"""By how many photo pixels a pixel may exceed its samples: chosen, the cubic kernel bears it."""


@dataclass(frozen=True)
class Rendered:
    """A rectified picture.

    Attributes:
        pixels: Shape (rows, columns) or (rows, columns, channels), as the photo's.
        shown: Which pixels show anything, shape (rows, columns).
        coarse: Share of the pixels that were cut because the photo is too coarse there, or the
            horizon or the lens's fold is passed.
    """

    pixels: Pixels
    shown: NDArray[np.bool_]
    coarse: float


class _Halves:
    """A photo and its halved copies, made when they are asked for."""

    def __init__(self, pixels: Pixels) -> None:
        self._levels = [pixels]

    def prepare(self, level: int) -> None:
        """Halve until there are copies down to a level."""
        while len(self._levels) <= level and min(self._levels[-1].shape[:2]) > 16:
            self._levels.append(cv2.pyrDown(self._levels[-1]))

    def at(self, level: int) -> tuple[Pixels, int]:
        """The copy of a level, or the smallest there is, and its level."""
        level = min(level, len(self._levels) - 1)
        return self._levels[level], level


@dataclass(frozen=True)
class _Sampling:
    """How a tile is sampled: times across and down, from which halved copy."""

    across: int
    down: int
    level: int

    @classmethod
    def of(cls, stretch: Sequence[float]) -> _Sampling:
        """The sampling that a stretch asks for."""
        least = min(stretch)
        level = max(math.floor(math.log2(max(least, 1e-9))) - 1, 0)
        while max(stretch) / 2**level > _MOST_SAMPLES and level < 12:
            level += 1
        across, down = (
            min(max(math.ceil(each / 2**level - _ONCE), 1), _MOST_SAMPLES) for each in stretch
        )
        return cls(across, down, level)


@dataclass(frozen=True)
class Renderer:
    """Renders a grid on the ground from a photo.

    Attributes:
        pixels: The photo's, upright.
        ground: The map of the grid into the photo.
        alpha: Whether the last channel is alpha.
        threads: Number of threads; one a core by default.
    """

    pixels: Pixels
    ground: GroundMap
    alpha: bool = False
    threads: int | None = None

    @cached_property
    def _halves(self) -> _Halves:
        return _Halves(self.pixels)

    def render(self, outside: Sequence[float]) -> Rendered:
        """The picture.

        Args:
            outside: Value of each channel where the photo shows nothing.
        """
        width, height = self.ground.grid.size
        colour = np.array(outside if self.pixels.ndim == 3 else outside[0], self.pixels.dtype)
        pixels = np.empty((height, width, *self.pixels.shape[2:]), dtype=self.pixels.dtype)
        shown = np.zeros((height, width), dtype=np.bool_)

        def fill(tile: Tile) -> int:
            covered = False
            for part, places in self.ground.parts(tile):
                filled, seen = self._part(part, places)
                shown[part] = seen
                if part == tile and seen.all():
                    pixels[tile], covered = filled, True
                    break
                if not covered:
                    pixels[tile], covered = colour, True
                where = seen[..., None] if filled.ndim == 3 else seen
                np.copyto(pixels[part], filled, where=where)
            if not covered:
                pixels[tile] = colour
            if self.ground.fine(tile, 2).all():  # depth is linear: its ends are in the corners
                return 0
            return int(np.count_nonzero(~self.ground.fine(tile)))

        coarse = 0
        self._halves.prepare(12)
        with ThreadPoolExecutor(self.threads or cores()) as pool:
            for lost in pool.map(fill, self.ground.tiles()):
                coarse += lost
        return Rendered(pixels, shown, coarse / (width * height))

    def _part(self, tile: Tile, part: TileMap) -> tuple[Pixels, NDArray[np.bool_]]:
        """The pixels of a part of the picture, and which of them show anything."""
        x, y = self.ground.places(tile, part, 1, 1)
        rows, columns = self.pixels.shape[:2]
        seen = (x >= -0.5) & (x <= columns - 0.5) & (y >= -0.5) & (y <= rows - 0.5)
        if not self.ground.fine(tile, 2).all():
            seen &= self.ground.fine(tile)
        how = _Sampling.of(part.stretch)
        pixels, level = self._halves.at(how.level)
        if (how.across, how.down) != (1, 1):
            x, y = self.ground.places(tile, part, how.across, how.down)
        interpolation = "cubic" if how.across == how.down == 1 else "linear"
        if level:
            x, y = x / np.float32(2**level), y / np.float32(2**level)
        filled = one_tile(pixels, x, y, interpolation, None, alpha=self.alpha)
        if (how.across, how.down) != (1, 1):
            size = part.columns, part.rows
            averaged = cv2.resize(filled, size, interpolation=cv2.INTER_AREA)
            filled = np.asarray(averaged).reshape(part.rows, part.columns, *filled.shape[2:])
        return filled, seen
