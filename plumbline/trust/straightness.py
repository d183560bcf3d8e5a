"""How straight the lines of a project are, before and after a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lines import by_line, drawn_through, fit_lines, line_numbers
from plumbline.observations import Line, Observations


class LineStraightness(NamedTuple):
    """How straight one line is, before and after; all in pixels.

    Attributes:
        label: The line's name.
        photo: Index of its photo.
        n_points: Number of its points that were fitted.
        rms_before_px: Root mean square distance of the observed points from a line.
        rms_after_px: The same of the fit's residuals.
        largest_after_px: The largest residual, without its sign.
        bend_px: Root mean square of what the edge bends by itself; None where that is not told
            from noise.
    """

    label: str
    photo: int
    n_points: int
    rms_before_px: float
    rms_after_px: float
    largest_after_px: float
    bend_px: float | None = None

    @property
    def left_out(self) -> bool:
        """Whether it was left out as a whole, and its numbers are those of no fit."""
        return self.n_points == 0


def straightness_before(
    observations: Observations, kept: Sequence[NDArray[np.bool_]] | None = None
) -> tuple[Array, ...]:
    """Signed distances in square pixels of every line's observed points, before any fit.

    Args:
        observations: The picks.
        kept: Which points of each line its straight line is fitted to; all by default, and of a
            line that kept none.
    """
    points, sizes = observations.centred_px, observations.sizes
    every = np.ones(len(points), dtype=np.bool_)
    drawn = every if kept is None else drawn_through(np.concatenate(kept), sizes)
    lines = fit_lines(points, sizes, drawn.astype(np.float64))
    return by_line(lines.place(points, line_numbers(sizes))[1], sizes)


def straightness_of(
    line: Line, before_px: Array, after_px: Array, kept: NDArray[np.bool_], noise_px: float | None
) -> LineStraightness:
    """How straight a line is; one left out as a whole is measured by all its points.

    Args:
        line: The line.
        before_px: Distances of its observed points from a straight line, shape (n,).
        after_px: Residuals, shape (n,).
        kept: Which points were fitted, shape (n,).
        noise_px: σ̂ where bends are told from noise: what residuals hold beyond it is the bend.
    """
    which = kept if kept.any() else ~kept
    before, after = [before_px[which]], [after_px[which]]
    bend_px = None
    if noise_px is not None:
        square = rms(after) ** 2 * len(after[0]) / max(len(after[0]) - 2, 1)
        bend_px = float(np.sqrt(max(square - noise_px**2, 0.0)))
    count = int(np.count_nonzero(kept))
    numbers = rms(before), rms(after), largest(after)
    return LineStraightness(line.label, line.photo, count, *numbers, bend_px)


def edges_bend_px(lines: Sequence[LineStraightness]) -> float | None:
    """Root mean square of what edges bend by themselves; None where it is not told."""
    known = [line.bend_px for line in lines if line.bend_px is not None and not line.left_out]
    return float(np.sqrt(np.mean(np.square(known)))) if known else None


def rms(arrays: Sequence[Array]) -> float:
    """Root mean square over all arrays."""
    total = sum(float(values @ values) for values in arrays)
    return float(np.sqrt(total / sum(len(values) for values in arrays)))


def largest(arrays: Sequence[Array]) -> float:
    """Largest absolute value over all arrays."""
    return max(float(np.max(np.abs(values))) for values in arrays)
