"""Which corners are neighbours: the ends of one edge of a square, each the other's nearest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.boards.rings import Corners
from plumbline.frame import Array
from plumbline.photos.brightness import Grey, sampled

_ASIDE = np.radians(20.0)
"""How far from its edge's direction a neighbour may lie: an edge bends by up to 10° in a square."""

_RIVALS = 4
"""How many corners along an edge are tried; chosen, because strays lie beside few edges."""

_AROUND = 40
"""How many corners around one are looked at: a third neighbour's ring has 36."""

_LEAP = 1.6
"""How much longer than the edge behind a corner the one ahead may be: two boards side by side
must not grow together; chosen, because tilts to 45° and strong barrel stretch it less."""

_ALONG = np.linspace(0.2, 0.8, 7)
"""Where along an edge contrast is measured, away from its ends' blur."""

_ASIDE_SHARE, _ASIDE_LEAST_PX = 0.15, 1.5
"""How far from the edge: a share of its length that exceeds its bow, and at least the blur."""

_STEP = 0.35
"""Share of the ends' contrast that each place along an edge must have; chosen, because glare and
blur leave more than half."""

_ROWS = 256
"""Corners compared with all others in one go."""

NONE = -1
"""Where a corner has no neighbour: no index is negative."""


@dataclass(frozen=True, eq=False)
class Links:
    """Neighbours of each corner, `NONE` where there is none.

    Attributes:
        to: Number of the corner at the other end of each edge, shape (n, 4).
        back: Which edge of that corner leads back, shape (n, 4).
    """

    to: NDArray[np.int64]
    back: NDArray[np.int64]

    def onwards(
        self, corner: NDArray[np.int64], ray: NDArray[np.int64], turn: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Follow edges to their other ends and turn there by so many edges; `NONE` stays."""
        ahead = np.where(corner == NONE, NONE, self.to[corner, ray])
        returning = self.back[corner, ray]
        return ahead, np.where(ahead == NONE, 0, (returning + 2 + turn) % 4)


def link(smooth: Grey, corners: Corners) -> Links:
    """Link corners that are each other's nearest along an edge with contrast.

    Args:
        smooth: Brightness after `smoothed`, shape (h, w).
        corners: Those that passed the ring test.
    """
    n = len(corners)
    if n < 2:
        nothing = np.full((n, 4), NONE)
        return Links(nothing, np.zeros_like(nothing))
    rivals = [_rivals(corners, first) for first in range(0, n, _ROWS)]
    to, back = (np.concatenate(parts) for parts in zip(*rivals, strict=True))
    good = _has_contrast(smooth, corners, to) & (to != NONE)
    first = np.argmax(good, axis=2)[..., None]
    found = np.take_along_axis(good, first, 2)[..., 0]
    chosen = np.where(found, np.take_along_axis(to, first, 2)[..., 0], NONE)
    returning = np.where(found, np.take_along_axis(back, first, 2)[..., 0], 0)
    return _mutual(chosen, _without_leaps(corners, chosen), returning)


def _mutual(chosen: NDArray[np.int64], good: NDArray[np.bool_], back: NDArray[np.int64]) -> Links:
    """Links whose two ends choose each other."""
    every = np.arange(len(chosen))[:, None]
    mutual = good & good[chosen, back] & (chosen[chosen, back] == every)
    return Links(np.where(mutual, chosen, NONE), np.where(mutual, back, 0))


def _without_leaps(corners: Corners, to: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which edges are there and not much longer than their continuation behind the corner."""
    offset = corners.points[to] - corners.points[:, None]
    length = np.where(to == NONE, np.inf, np.hypot(offset[..., 0], offset[..., 1]))
    behind = np.roll(length, 2, axis=1)
    return (to != NONE) & (length < _LEAP * behind)


def _rivals(corners: Corners, first: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The nearest corners along each edge of some corners, and their edges that lead back."""
    here = slice(first, first + _ROWS)
    x, y = (corners.points[None, :, k] - corners.points[here, None, k] for k in (0, 1))
    squared = x * x + y * y
    around = min(_AROUND, len(corners))
    near = np.argpartition(squared, around - 1, axis=1)[:, :around]
    x, y = (np.take_along_axis(each, near, 1) for each in (x, y))
    length, towards = np.hypot(x, y), np.arctan2(y, x)
    arriving = _turn(corners.rays[near] - (towards + np.pi)[..., None])
    back = np.argmin(arriving, axis=2)
    fits = (arriving.min(axis=2) < _ASIDE) & (length > 0)
    nearest: list[NDArray[np.int64]] = []
    edges: list[NDArray[np.int64]] = []
    for ray in range(4):
        leaves = _turn(towards - corners.rays[here, ray, None]) < _ASIDE
        opposite = corners.signs[near, back] == -corners.signs[here, ray, None]
        far = np.where(fits & leaves & opposite, length, np.inf)
        order = np.argsort(far, axis=1)[:, :_RIVALS]
        known = np.isfinite(np.take_along_axis(far, order, 1))
        pad = ((0, 0), (0, _RIVALS - order.shape[1]))
        found = np.where(known, np.take_along_axis(near, order, 1), NONE)
        nearest.append(np.pad(found, pad, constant_values=NONE))
        edges.append(np.pad(np.take_along_axis(back, order, 1), pad))
    return np.stack(nearest, axis=1), np.stack(edges, axis=1)


def _turn(angle: Array) -> Array:
    """The size of an angle, at most π."""
    return np.abs((angle + np.pi) % (2 * np.pi) - np.pi)


def _has_contrast(smooth: Grey, corners: Corners, to: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether brightness steps all along each edge, to the side its sign says, shape of `to`."""
    n, _, rivals = to.shape
    start = corners.points[:, None, None]
    offset = corners.points[to] - start
    length = np.hypot(offset[..., 0], offset[..., 1])
    aside_px = np.maximum(_ASIDE_SHARE * length, _ASIDE_LEAST_PX)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = np.stack((-offset[..., 1], offset[..., 0]), -1) * (aside_px / length)[..., None]
    middle = start[..., None, :] + offset[..., None, :] * _ALONG[:, None]
    shape = (n * 4 * rivals, len(_ALONG), 2)
    left = sampled(smooth, (middle + normal[..., None, :]).reshape(shape))
    right = sampled(smooth, (middle - normal[..., None, :]).reshape(shape))
    step = (left - right).reshape(n, 4, rivals, -1) * corners.signs[:, :, None, None]
    wanted = 2 * _STEP * np.minimum(corners.contrast[:, None, None], corners.contrast[to])
    return np.all(step > wanted[..., None], axis=-1)
