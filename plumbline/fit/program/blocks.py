"""Picked points packed into arrays of few distinct shapes, so that programs are shared.

A block has `rows` rows of `width` points; a line fills as many rows as it needs, and
`row_line` says which line a row belongs to. Both numbers come from a short list, powers of two
mostly: every project of like size has the same shapes and runs the same compiled program.
Padding has weight 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, normalised
from plumbline.observations import Observations

_LEAST_ROWS = 16
"""Chosen, because smaller blocks run no faster and would need programs of their own."""
_COARSE = 1024
"""Rows above which padding costs more than another compilation: measured on two cores."""
_WIDTHS, _ADVANTAGE = np.array([8, 32, 128]), np.array([1.0, 1.2, 1.3])
"""Row widths, and how much faster a wide row runs for each point: measured on two cores."""


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


def pack(observations: Sequence[Observations], units_px: Sequence[float]) -> list[Packed]:
    """Pack the lines of lenses whose blocks have one shape.

    Args:
        observations: Checked observations of one lens each, of one `shape_of`.
        units_px: Square pixels to a normalised radius of 1, for each.
    """
    sizes = np.concatenate([each.sizes for each in observations])
    counts = np.array([len(each.sizes) for each in observations])
    rows, width = shape_of(observations[0])
    first_line = np.cumsum(counts) - counts
    rows_of = -(-sizes // width)
    taken = np.cumsum(rows_of) - rows_of
    own = np.repeat(np.arange(len(counts)), counts)
    first_row = taken - taken[first_line][own] + rows * own
    first_point = np.cumsum(sizes) - sizes
    cells = np.repeat(first_row * width - first_point, sizes) + np.arange(sizes.sum())
    xy, weight = np.zeros((len(counts) * rows * width, 2)), np.zeros(len(counts) * rows * width)
    xy[cells] = _normalised(observations, units_px)
    weight[cells] = 1.0
    row_line = np.full(len(counts) * rows, rows - 1, dtype=np.int32)
    rows_used = np.repeat(first_row - taken, rows_of) + np.arange(rows_of.sum())
    row_line[rows_used] = np.repeat(np.arange(len(sizes)) - first_line[own], rows_of)
    blocks = map(
        Block,
        xy.reshape(-1, rows, width, 2),
        weight.reshape(-1, rows, width),
        row_line.reshape(-1, rows),
    )
    ends = np.cumsum(np.add.reduceat(sizes, first_line))[:-1]
    places = np.split(cells, ends) if len(ends) else [cells]
    return [
        Packed(block, place - number * rows * width if number else place, each.sizes)
        for number, (block, place, each) in enumerate(
            zip(blocks, places, observations, strict=True)
        )
    ]


def _normalised(observations: Sequence[Observations], units_px: Sequence[float]) -> Array:
    """All points, lens after lens and line after line, shape (n, 2)."""
    points_px = np.concatenate([line.points_px for each in observations for line in each.lines])
    frames = [photo.frame for each in observations for photo in each.photos]
    units = [u for u, each in zip(units_px, observations, strict=True) for _ in each.photos]
    if len(frames) == 1:
        return frames[0].normalise(points_px, units[0])
    counts = np.array([len(each.photos) for each in observations])
    first_photo = (np.cumsum(counts) - counts).tolist()
    photo = [
        first + line.photo
        for first, each in zip(first_photo, observations, strict=True)
        for line in each.lines
    ]
    sizes = np.concatenate([each.sizes for each in observations])
    return normalised(points_px, frames, np.repeat(photo, sizes), units)


def unpack(packed: Sequence[Packed], values: Sequence[AnyArray]) -> Array:
    """Values of blocks of one shape, (rows, width, ...) each, for the points alone.

    Shape (n, ...), problem after problem in the order of the lines.
    """
    if len(packed) == 1:
        return packed[0].unpack(values[0])
    whole = np.stack(values)
    cells = np.prod(packed[0].shape)
    places = np.concatenate([number * cells + each.cells for number, each in enumerate(packed)])
    return whole.reshape(-1, *whole.shape[3:])[places]


def shape_of(observations: Observations) -> tuple[int, int]:
    """Rows and width of the block that these lines are packed into."""
    rows = (-(-observations.sizes // _WIDTHS[:, None])).sum(axis=1)
    # The width that pads least; ties go to the narrower.
    best = np.argmin(rows * _WIDTHS / _ADVANTAGE)
    return bucket(int(rows[best])), int(_WIDTHS[best])


def bucket(rows: int) -> int:
    """The number of rows that this many are padded to.

    A power of two; above 1,024, where padding costs more than another compilation, a quarter of
    one finer.
    """
    whole = 1 << max(0, rows - 1).bit_length()
    if rows <= _COARSE:
        return max(_LEAST_ROWS, whole)
    return -(-rows // (whole // 8)) * (whole // 8)
