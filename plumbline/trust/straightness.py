"""How straight the lines of a project are, before and after a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.lines import by_line, drawn_through, fit_lines, line_numbers
from plumbline.observations import Observations


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
    """Signed distances of every line's observed points in the photograph's pixels, before any fit.

    Args:
        observations: The picks.
        kept: Which points of each line its straight line is fitted to; all by default, and of a
            line that kept none.
    """
    points, sizes = observations.centred_px, observations.sizes
    every = np.ones(len(points), dtype=np.bool_)
    drawn = every if kept is None else drawn_through(np.concatenate(kept), sizes)
    lines = fit_lines(points, sizes, drawn.astype(np.float64))
    photos = [observations.photos[line.photo] for line in observations.lines]
    aspects = np.array([photo.pixel_aspect for photo in photos])
    square_px = np.hypot(lines.across[:, 0] * aspects, lines.across[:, 1])
    line = line_numbers(sizes)
    return by_line(lines.place(points, line)[1] / square_px[line], sizes)


def line_by_line(
    observations: Observations,
    before_px: Sequence[Array],
    after_px: Sequence[Array],
    kept: Sequence[NDArray[np.bool_]],
    noise_px: float | None = None,
) -> tuple[LineStraightness, ...]:
    """Straightness of every line; one left out as a whole is measured nevertheless.

    Args:
        observations: The picks.
        before_px: Their distances from straight lines before the fit, one array a line.
        after_px: Their residuals, likewise.
        kept: Which of them were fitted.
        noise_px: σ̂ where bends are told from noise: what residuals hold beyond it is the bend.
    """
    sizes = np.array([len(values) for values in after_px])
    starts, fitted = np.cumsum(sizes) - sizes, np.concatenate(kept)
    counted = drawn_through(fitted, sizes)
    before, after = (
        np.where(counted, np.abs(np.concatenate(values)), 0.0) for values in (before_px, after_px)
    )
    number = np.add.reduceat(counted.astype(np.float64), starts)
    squares = np.add.reduceat(after**2, starts)
    columns = [
        np.add.reduceat(fitted.astype(np.int64), starts),
        np.sqrt(np.add.reduceat(before**2, starts) / number),
        np.sqrt(squares / number),
        np.maximum.reduceat(after, starts),
    ]
    if noise_px is not None:
        bend = squares / np.maximum(number - 2, 1) - noise_px**2
        columns.append(np.sqrt(np.maximum(bend, 0.0)))
    every = zip(observations.lines, *(column.tolist() for column in columns), strict=True)
    return tuple(LineStraightness(line.label, line.photo, *each) for line, *each in every)


def edges_bend_px(lines: Sequence[LineStraightness]) -> float | None:
    """Root mean square of what edges bend by themselves; None where it is not told."""
    known = [line.bend_px for line in lines if line.bend_px is not None and not line.left_out]
    return float(np.sqrt(np.mean(np.square(known)))) if known else None


def rms(arrays: Sequence[Array]) -> float:
    """Root mean square over all arrays."""
    values = np.concatenate(arrays)
    return float(np.sqrt(values @ values / len(values)))


def largest(arrays: Sequence[Array]) -> float:
    """Largest absolute value over all arrays."""
    return float(np.max(np.abs(np.concatenate(arrays))))
