"""Where each pixel of the corrected picture is taken from.

A map is evaluated exactly on a coarse grid of nodes and interpolated between them by cubic
Lagrange polynomials, but only after the interpolation was compared with the exact map halfway
between all nodes and found good to `TOLERANCE_PX`; where no grid passes, every pixel is
evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import FoldedError
from plumbline.frame import Array
from plumbline.imaging.maps.horizon import Horizon, find_horizon

Points = Callable[[Array], Array]
Tile = tuple[slice, slice]
Coordinates = tuple[NDArray[np.float32], NDArray[np.float32]]

TOLERANCE_PX = 0.005
"""Largest error allowed halfway between nodes; the bound promised for every pixel is 0.01 px."""

NOWHERE = -1e6
"""Coordinate of a pixel that the photograph does not show."""

_TILE = 256  # pixels a side: chosen, a tile and its map stay in a processor's cache
_STEPS = (32, 16, 8)  # pixels between nodes, tried in this order; chosen
_STENCIL = 4  # nodes of a cubic
_STRIP = 64  # rows multiplied at once: for more, BLAS starts threads, beside those of the tiles
_LOOKED_AT = 65  # nodes a side when looking for a fold; chosen, 1/64 of a side apart


@dataclass(frozen=True)
class SamplingMap:
    """Observed coordinates for every pixel of a corrected picture.

    Attributes:
        size: Width and height of the picture.
        observed: Maps ideal pixels to observed ones, shape (..., 2); may raise FoldedError.
    """

    size: tuple[int, int]
    observed: Points

    def tiles(self) -> Iterator[Tile]:
        """Rows and columns of the tiles that make up the picture."""
        width, height = self.size
        for top in range(0, height, _TILE):
            for left in range(0, width, _TILE):
                yield slice(top, min(top + _TILE, height)), slice(left, min(left + _TILE, width))

    def prepare(self) -> None:
        """Evaluate the nodes, before several threads ask for coordinates."""
        _ = self._shifts

    def coordinates(self, tile: Tile) -> Coordinates:
        """Observed x and y for each pixel of a tile; `NOWHERE` where there is none."""
        if self._shifts is None:
            return self.exactly(tile)
        rows, columns = _positions(tile)
        nodes_y, nodes_x = self._shifts.shape[1:]
        part_y, across_rows = weights(rows, self.size[1], nodes_y)
        part_x, across_columns = weights(columns, self.size[0], nodes_x)
        x, y = between(self._shifts[:, part_y, part_x], across_rows, across_columns)
        x += columns.astype(np.float32)
        y += rows.astype(np.float32)[:, None]
        return x, y

    def exactly(self, tile: Tile) -> Coordinates:
        """As `coordinates`, the map evaluated for each pixel."""
        rows, columns = _positions(tile)
        points = np.stack(np.meshgrid(columns, rows), axis=-1)
        if self._horizon is None:
            found = self.observed(points)
        else:
            shown = self._horizon.contains(points)
            found = np.full(points.shape, NOWHERE)
            found[shown] = self.observed(points[shown])
        return found[..., 0].astype(np.float32), found[..., 1].astype(np.float32)

    @property
    def fold_px(self) -> float | None:
        """How far from the centre the lens folds at the nearest, if inside the picture."""
        return None if self._horizon is None else float(np.min(self._horizon.radii_px))

    @property
    def shown(self) -> float:
        """The share of the picture's area that lies within the fold, at most 1."""
        if self._horizon is None:
            return 1.0
        area = np.pi * float(np.mean(self._horizon.radii_px[:-1] ** 2))
        return min(area / (self.size[0] * self.size[1]), 1.0)

    @cached_property
    def _horizon(self) -> Horizon | None:
        """How far out the picture shows anything; None where that is everywhere."""
        try:
            nodes = _even_points(self.size, *(min(_LOOKED_AT, side) for side in self.size))
            if not _folds(self.observed(nodes)):
                return None
        except FoldedError:
            pass
        return find_horizon(self.observed, self.size)

    @cached_property
    def _shifts(self) -> NDArray[np.float32] | None:
        """Observed minus ideal points on the coarsest grid that will do, shape (2, rows, columns).

        None where no grid does.
        """
        if self._horizon is not None:
            return None
        for step in _STEPS:
            nodes_x, nodes_y = (-(-(side - 1) // step) + 1 for side in self.size)
            if min(nodes_x, nodes_y) < _STENCIL:
                continue
            nodes = _even_points(self.size, 2 * nodes_x - 1, 2 * nodes_y - 1)
            fine = np.moveaxis(self.observed(nodes) - nodes, -1, 0)
            coarse = fine[:, ::2, ::2]
            if np.max(np.abs(refined(coarse) - fine)) <= TOLERANCE_PX:
                return coarse.astype(np.float32)
        return None


def _positions(tile: Tile) -> tuple[Array, Array]:
    rows, columns = tile
    return (
        np.arange(rows.start, rows.stop, dtype=np.float64),
        np.arange(columns.start, columns.stop, dtype=np.float64),
    )


def _even_points(size: tuple[int, int], nodes_x: int, nodes_y: int) -> Array:
    """Points spread evenly over a picture from corner to corner, shape (nodes_y, nodes_x, 2)."""
    x, y = np.linspace(0, size[0] - 1, nodes_x), np.linspace(0, size[1] - 1, nodes_y)
    return np.stack(np.meshgrid(x, y), axis=-1)


def _folds(observed: Array) -> bool:
    """Whether a grid of points turns over anywhere."""
    if min(observed.shape[:2]) < 2:
        return False
    right, down = np.diff(observed, axis=1)[:-1], np.diff(observed, axis=0)[:, :-1]
    return bool(np.any(right[..., 0] * down[..., 1] <= right[..., 1] * down[..., 0]))


def weights(positions: Array, side: int, nodes: int) -> tuple[slice, NDArray[np.float32]]:
    """Cubic Lagrange weights of the nodes that positions along one side lie between.

    Args:
        positions: Pixels, rising.
        side: Length of the side in pixels, with a node on its first and its last.
        nodes: Number of nodes, at least 4.

    Returns:
        Which nodes matter, and their weights, shape (positions, nodes that matter).
    """
    at = positions * ((nodes - 1) / (side - 1))
    first = np.clip(np.floor(at).astype(np.int64) - 1, 0, nodes - _STENCIL)
    t = at - first
    start, stop = int(first[0]), int(first[-1]) + _STENCIL
    shares = np.zeros((len(positions), stop - start), dtype=np.float32)
    each = np.arange(len(positions))
    for node in range(_STENCIL):
        others = [other for other in range(_STENCIL) if other != node]
        share = np.prod([(t - other) / (node - other) for other in others], axis=0)
        shares[each, first - start + node] = share
    return slice(start, stop), shares


def between(
    nodes: NDArray[np.float32], over_rows: NDArray[np.float32], over_columns: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Values between nodes, by `weights` of rows and columns.

    Args:
        nodes: Those that matter, shape (2, nodes, nodes).
        over_rows: Shape (rows, nodes).
        over_columns: Shape (columns, nodes).

    Returns:
        Shape (2, rows, columns).
    """
    across = nodes @ over_columns.T
    values = np.empty((2, len(over_rows), len(over_columns)), dtype=np.float32)
    for first in range(0, len(over_rows), _STRIP):
        strip = slice(first, first + _STRIP)
        np.matmul(over_rows[strip], across, out=values[:, strip])
    return values


def refined(coarse: Array) -> Array:
    """Values interpolated at twice the nodes, shape (2, rows, columns)."""
    across_rows, across_columns = (
        weights(np.arange(2 * nodes - 1, dtype=np.float64), 2 * nodes - 1, nodes)[1]
        for nodes in coarse.shape[1:]
    )
    return across_rows @ coarse @ across_columns.T
