"""Where each pixel of a rectified picture is taken from: plane, perspective and lens in one step.

As in `imaging.maps`, a tile's map is evaluated on a coarse grid of nodes and interpolated between
them, once the interpolation was compared with the exact map halfway. A tile with the edge of the
photo, the horizon or the fold in it is quartered first; what shows nothing is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.ground.camera import Camera
from plumbline.imaging.maps.sampling_map import (
    NOWHERE,
    TOLERANCE_PX,
    Coordinates,
    Tile,
    between,
    refined,
    weights,
)
from plumbline.rectified.grid import Grid, farthest_depth

_TILE, _SMALLEST = 256, 32
_STEP = 32
_NEAR_PX = 64.0
"""How far outside of the photo a place still counts when an interpolation is judged; chosen. Where
nodes lie closer together than this and none of them counts, nothing between them shows either."""


@dataclass(frozen=True)
class TileMap:
    """Observed places of one tile.

    Attributes:
        rows: Number of rows of the tile.
        columns: Number of columns.
        nodes: Observed places on even nodes, shape (2, rows, columns) of nodes, float32; None
            where every pixel was evaluated.
        exact: Places of every pixel, NaN where there is none; None where nodes do.
        stretch: Photo pixels a pixel across and down, the largest of the tile.
    """

    rows: int
    columns: int
    nodes: NDArray[np.float32] | None
    exact: Array | None
    stretch: tuple[float, float]


@dataclass(frozen=True)
class GroundMap:
    """The map of a grid on the ground into a photo.

    Attributes:
        camera: The camera over the plane.
        grid: The grid.
        coarsest_m: Largest side of a photo's pixel on the ground that is shown.
    """

    camera: Camera
    grid: Grid
    coarsest_m: float

    def tiles(self) -> Iterator[Tile]:
        """Rows and columns of the tiles that make up the picture."""
        width, height = self.grid.size
        for top in range(0, height, _TILE):
            for left in range(0, width, _TILE):
                yield slice(top, min(top + _TILE, height)), slice(left, min(left + _TILE, width))

    def parts(self, tile: Tile) -> Iterator[tuple[Tile, TileMap]]:
        """The parts of a tile that may show anything, with their maps."""
        rows, columns = (each.stop - each.start for each in tile)
        if not np.any(self.fine(tile, 9)):
            return
        counts = [max(-(-(side - 1) // _STEP) + 1, 4) for side in (rows, columns)]
        fine = self._observed(tile, *(2 * count - 1 for count in counts))
        near = self._near(fine)
        if near.any() and np.isfinite(fine).all():
            coarse = fine[:, ::2, ::2]  # float32 holds 65,536 px to 0.004 px
            if np.max(np.abs(refined(coarse) - fine)[:, near]) <= TOLERANCE_PX:
                stretch = _stretch(fine, near, rows, columns)
                yield tile, TileMap(rows, columns, coarse.astype(np.float32), None, stretch)
                return
        elif not near.any() and (max(rows, columns) <= _SMALLEST or _longest(fine) < _NEAR_PX):
            return
        if max(rows, columns) > _SMALLEST:
            for quarter in _quarters(tile):
                yield from self.parts(quarter)
            return
        exact = self._observed(tile, rows, columns)
        near = self._near(exact)
        if near.any():
            stretch = _stretch(exact, near, rows, columns)
            yield tile, TileMap(rows, columns, None, exact, stretch)

    def places(self, tile: Tile, part: TileMap, across: int, down: int) -> Coordinates:
        """Observed x and y, `across` by `down` for each pixel; `NOWHERE` where there is none."""
        if part.nodes is None and (across, down) == (1, 1) and part.exact is not None:
            x, y = part.exact
        elif part.nodes is None:
            rows, columns = _finely(part.rows, down), _finely(part.columns, across)
            x, y = self._exactly(tile, rows, columns)
        else:
            count_y, count_x = part.nodes.shape[1:]
            part_y, over_rows = weights(_finely(part.rows, down), max(part.rows, 2), count_y)
            part_x, over_columns = weights(
                _finely(part.columns, across), max(part.columns, 2), count_x
            )
            x, y = between(part.nodes[:, part_y, part_x], over_rows, over_columns)
            return x, y
        lost = ~(np.isfinite(x) & np.isfinite(y))
        x, y = np.where(lost, NOWHERE, x), np.where(lost, NOWHERE, y)
        return x.astype(np.float32), y.astype(np.float32)

    def fine(self, tile: Tile, count: int | None = None) -> NDArray[np.bool_]:
        """Which pixels of a tile the photo shows finely enough, as far as it shows them.

        Args:
            tile: Rows and columns.
            count: Look at so many rows and columns only, the first and last among them.
        """
        rows, columns = (
            np.linspace(each.start, each.stop - 1, count or each.stop - each.start) for each in tile
        )
        forward, world = self.camera.rotation[2], self.grid.world
        by_column, by_row = forward[:2] @ world.matrix
        first = forward[:2] @ (world.origin - self.camera.place[:2])
        start = float(first - forward[2] * self.camera.place[2])
        depths = start + by_row * rows[:, None] + by_column * columns
        return (depths > 0) & (depths <= farthest_depth(self.camera, self.coarsest_m))

    def _near(self, places: Array) -> NDArray[np.bool_]:
        """Which places lie in the photo or near it; those that are nowhere do not."""
        width, height = self.camera.optics.lens.frame.size
        with np.errstate(invalid="ignore"):
            across = (places[0] > -_NEAR_PX) & (places[0] < width + _NEAR_PX)
            return across & (places[1] > -_NEAR_PX) & (places[1] < height + _NEAR_PX)

    def _observed(self, tile: Tile, n_rows: int, n_columns: int) -> Array:
        rows, columns = (
            np.linspace(0, each.stop - each.start - 1, count)
            for each, count in zip(tile, (n_rows, n_columns), strict=True)
        )
        return self._exactly(tile, rows, columns)

    def _exactly(self, tile: Tile, rows: Array, columns: Array) -> Array:
        """Observed places at rows and columns from a tile's first, shape (2, rows, columns)."""
        points = np.stack(
            np.meshgrid(columns + tile[1].start, rows + tile[0].start), axis=-1
        ).reshape(-1, 2)
        places = self.grid.world.places(points)
        with np.errstate(all="ignore"):
            seen = self.camera.project(np.column_stack((places, np.zeros(len(places)))))
        return np.moveaxis(seen.reshape(len(rows), len(columns), 2), -1, 0)


def _finely(count: int, times: int) -> Array:
    """Places of parts of pixels: the middles of `times` equal parts of each."""
    return (np.arange(count * times, dtype=np.float64) + 0.5) / times - 0.5


def _quarters(tile: Tile) -> Iterator[Tile]:
    halves = [
        [slice(each.start, middle), slice(middle, each.stop)]
        for each in tile
        for middle in [(each.start + each.stop) // 2]
    ]
    for rows in halves[0]:
        for columns in halves[1]:
            if rows.stop > rows.start and columns.stop > columns.start:
                yield rows, columns


def _stretch(
    places: Array, near: NDArray[np.bool_], rows: int, columns: int
) -> tuple[float, float]:
    """Photo pixels a pixel across and down, the largest near the photo."""
    step_y = (rows - 1) / max(places.shape[1] - 1, 1) or 1.0
    step_x = (columns - 1) / max(places.shape[2] - 1, 1) or 1.0
    across, down = np.diff(places, axis=2) / step_x, np.diff(places, axis=1) / step_y
    return _largest(across[:, near[:, 1:]]), _largest(down[:, near[1:]])


def _longest(places: Array) -> float:
    """The longest way from a node to the next; infinite where one is nowhere."""
    longest = np.max([np.max(np.abs(np.diff(places, axis=axis))) for axis in (1, 2)])
    return float(longest) if np.isfinite(longest) else np.inf


def _largest(moves: Array) -> float:
    lengths = np.hypot(*moves)
    finite = lengths[np.isfinite(lengths)]
    return float(np.max(finite)) if finite.size else 1.0
