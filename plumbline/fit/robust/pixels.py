"""How long the photograph's pixels are across lines that nobody has drawn yet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.derivatives import Ideal
from plumbline.geometry.lines import fit_lines, line_numbers


def stretch_of_lines(ideal: Ideal, sizes: NDArray[np.int64]) -> Array:
    """Pixels of the corrected photo for one of the photograph, before lines are known, (n,).

    The mean over all directions, but for the shape of the photograph's pixels, which counts across
    the rough direction of each line.
    """
    xx, xy, yx, yy = ideal.stretch.reshape(-1, 4).T
    return np.sqrt(np.abs(xx * yy - xy * yx)) * shape_across(ideal.uv, sizes, ideal.aspect)


def shape_across(points: Array, sizes: NDArray[np.int64], aspect: Array | float) -> Array:
    """How long a pixel's step across the rough direction of a pick's line is, (n,).

    Args:
        points: Points in square pixels, line after line, shape (n, 2); NaN ones do not count.
        sizes: Number of points of each line.
        aspect: Width over height of the photograph's pixels.
    """
    if np.all(np.equal(aspect, 1.0)):
        return np.ones(len(points))
    known: Array = np.where(np.isfinite(points).all(axis=1), 1.0, 0.0)
    rough = fit_lines(points, sizes, known).across[line_numbers(sizes)]
    return np.hypot(rough[:, 0] * aspect, rough[:, 1])
