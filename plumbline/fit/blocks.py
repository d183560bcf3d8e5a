"""Picked points packed into arrays of few distinct shapes, so that programs are shared.

A block has `rows` rows of `width` points; a line fills as many rows as it needs, and
`row_line` says which line a row belongs to. Both numbers come from a short list, powers of two
mostly: every project of like size has the same shapes and runs the same compiled program.
Padding has weight 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.observations import Observations

_LEAST_ROWS = 16
_COARSE = 1024
_WIDTHS = 8, 32, 128


AnyArray: TypeAlias = Any
"""An array of NumPy outside compiled programs, of JAX inside them."""


class Block(NamedTuple):
    """Padded points of one problem, or with a leading axis of several.

    Attributes:
        xy: Normalised observed points about the image centre, shape (rows, width, 2).
        weight: 1 for a point, 0 for padding, shape (rows, width).
        row_line: Which line each row belongs to, shape (rows,).
    """

    xy: AnyArray
    weight: AnyArray
    row_line: AnyArray


@dataclass(frozen=True)
class Packed:
    """A block and the way back from it.

    Attributes:
        block: The padded points.
        cells: Row-major cell of each point in the block, in the order of the lines.
        sizes: Number of points of each line.
    """

    block: Block
    cells: NDArray[np.int64]
    sizes: NDArray[np.int64]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and width: what programs are compiled for."""
        rows, width = self.block.weight.shape
        return rows, width

    def unpack(self, values: AnyArray) -> Array:
        """Values of shape (rows, width, ...) for the points alone, in the order of the lines."""
        return np.asarray(values).reshape(-1, *np.shape(values)[2:])[self.cells]


def pack(observations: Observations, unit_px: float) -> Packed:
    """Pack the lines of one lens.

    Args:
        observations: Checked observations.
        unit_px: Square pixels to a normalised radius of 1.
    """
    sizes = np.array([len(line.points_px) for line in observations.lines], dtype=np.int64)
    return _packed(np.concatenate(list(_normalised(observations, unit_px))), sizes)


def _normalised(observations: Observations, unit_px: float) -> Iterator[Array]:
    """Points of neighbouring lines in one photo, normalised together."""
    for photo, lines in groupby(observations.lines, key=lambda line: line.photo):
        points_px = np.concatenate([line.points_px for line in lines])
        yield observations.photos[photo].frame.normalise(points_px, unit_px)


def pack_points(lines: Sequence[Array]) -> Packed:
    """Pack normalised lines, each of shape (n, 2)."""
    sizes = np.array([len(points) for points in lines], dtype=np.int64)
    return _packed(np.concatenate(list(lines)), sizes)


def shape_of(observations: Observations) -> tuple[int, int]:
    """Rows and width of the block that these lines are packed into."""
    sizes = np.array([len(line.points_px) for line in observations.lines], dtype=np.int64)
    width = _width(sizes)
    return bucket(int((-(-sizes // width)).sum())), width


def _packed(points: Array, sizes: NDArray[np.int64]) -> Packed:
    width = _width(sizes)
    rows_of = -(-sizes // width)
    first_row = np.cumsum(rows_of) - rows_of
    rows = bucket(int(rows_of.sum()))
    first_point = np.cumsum(sizes) - sizes
    within = np.arange(sizes.sum()) - np.repeat(first_point, sizes)
    cells = np.repeat(first_row * width, sizes) + within
    xy = np.zeros((rows * width, 2))
    xy[cells] = points
    weight = np.zeros(rows * width)
    weight[cells] = 1.0
    row_line = np.full(rows, rows - 1, dtype=np.int32)
    row_line[: rows_of.sum()] = np.repeat(np.arange(len(sizes)), rows_of)
    block = Block(xy.reshape(rows, width, 2), weight.reshape(rows, width), row_line)
    return Packed(block, cells, sizes)


def bucket(rows: int) -> int:
    """The number of rows that this many are padded to.

    A power of two; above 1,024, where padding costs more than another compilation, a quarter of
    one finer.
    """
    whole = 1 << max(0, rows - 1).bit_length()
    if rows <= _COARSE:
        return max(_LEAST_ROWS, whole)
    return -(-rows // (whole // 8)) * (whole // 8)


def _width(sizes: NDArray[np.int64]) -> int:
    """The width that pads least; ties go to the narrower."""
    cells = [int((-(-sizes // width) * width).sum()) for width in _WIDTHS]
    return _WIDTHS[int(np.argmin(np.array(cells) / np.array([1.0, 1.2, 1.3])))]
