"""Where an edge is expected: a curve that the picks and the current lens predict."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbline.errors import FoldedError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens

_NODES = 129
"""Points at which the lens is asked; a curve of 5,000 px radius sags 0.02 px between them on
4,000 px, which the offsets from it make good."""

_LEAST_LENGTH = 12
"""Pixels along a line below which there is nothing to average (chosen, because three samples of
four pixels are the least that show whether an edge is straight)."""


class GuideError(Exception):
    """The picks predict no curve along which pixels could be read; the reason is a sentence."""


@dataclass(frozen=True, eq=False)
class Guide:
    """A curve through a photo, given at every whole pixel of the axis that it follows.

    Attributes:
        steep: Whether it follows the y axis; else the x axis.
        first: The first whole pixel along that axis.
        across: Place on the other axis at each whole pixel from `first` on, shape (n,).
    """

    steep: bool
    first: int
    across: Array

    @property
    def along(self) -> Array:
        """The whole pixels it is given at, shape (n,)."""
        return self.first + np.arange(len(self.across), dtype=np.float64)

    @property
    def cosine(self) -> Array:
        """Cosine of the angle between the curve and its axis at each pixel, shape (n,)."""
        return 1 / np.hypot(1.0, np.gradient(self.across))

    def share(self, along: Array) -> Array:
        """How far along the curve places on its axis are, 0 at its start and 1 at its end."""
        return (along - self.first) / (len(self.across) - 1)

    def moved(self, by: Array) -> Guide:
        """The same curve moved across by (n,) pixels."""
        return replace(self, across=self.across + by)

    def at(self, along: Array) -> Array:
        """Place on the other axis at any places along the curve."""
        return np.interp(along, self.along, self.across)

    def points(self, along: Array, offset: Array) -> Array:
        """Points (n, 2), x and y, at places along the curve and offsets from it across."""
        across = self.at(along) + offset
        return np.stack((across, along) if self.steep else (along, across), axis=-1)

    def offsets(self, points: Array) -> tuple[Array, Array]:
        """Places along the curve of points (n, 2), and how far across from it they are."""
        along, across = (points[:, 1], points[:, 0]) if self.steep else (points[:, 0], points[:, 1])
        return along, across - self.at(along)


def through_picks(picks_px: Array, lens: Lens | None, size: tuple[int, int]) -> Guide:
    """The curve that picks of one edge predict, from the first pick to the last.

    Args:
        picks_px: Shape (n, 2), at least two.
        lens: The lens as far as it is known. Without one the curve is a parabola through three
            or more picks, else the chord.
        size: Width and height of the photo.

    Raises:
        GuideError: no such curve runs through the photo.
    """
    nodes = _by_parabola(picks_px) if lens is None else _by_lens(picks_px, lens)
    return through_nodes(nodes, size)


def through_nodes(nodes: Array, size: tuple[int, int]) -> Guide:
    """The curve through points (n, 2) that follow each other closely, as far as the photo goes.

    Raises:
        GuideError: it runs back on itself, outside of the photo, or is too short.
    """
    span = np.ptp(nodes, axis=0)
    steep = bool(span[1] > span[0])
    along, across = (nodes[:, 1], nodes[:, 0]) if steep else (nodes[:, 0], nodes[:, 1])
    if along[-1] < along[0]:
        along, across = along[::-1], across[::-1]
    if np.any(np.diff(along) <= 0):
        raise GuideError("the picks run back on themselves")
    first = max(0, int(np.ceil(along[0])))
    last = min(size[1] - 1 if steep else size[0] - 1, int(np.floor(along[-1])))
    if last - first < _LEAST_LENGTH:
        raise GuideError(f"the picks are less than {_LEAST_LENGTH} px apart")
    return Guide(steep, first, np.interp(np.arange(first, last + 1), along, across))


def _by_lens(picks_px: Array, lens: Lens) -> Array:
    """Points along the straight line through the undistorted picks, as the lens shows them."""
    ideal = lens.undistort_or_nan(picks_px)
    if np.isnan(ideal).any():
        raise GuideError("the lens known so far folds before it reaches the picks")
    centre = ideal.mean(axis=0)
    direction = np.linalg.svd(ideal - centre, full_matrices=False)[2][0]
    along = (ideal - centre) @ direction
    reach = np.linspace(along.min(), along.max(), _NODES)
    try:
        return lens.distort(centre + reach[:, None] * direction)
    except FoldedError:
        raise GuideError("the lens known so far folds between the picks") from None


def _by_parabola(picks_px: Array) -> Array:
    centre = picks_px.mean(axis=0)
    frame = np.linalg.svd(picks_px - centre, full_matrices=False)[2]
    along, across = ((picks_px - centre) @ frame.T).T
    degree = min(2, len(np.unique(along)) - 1)
    if degree < 1:
        raise GuideError("all picks are at one place")
    reach = np.linspace(along.min(), along.max(), _NODES)
    bend = np.polynomial.Polynomial.fit(along, across, degree)(reach)
    return centre + np.stack((reach, bend), axis=-1) @ frame
