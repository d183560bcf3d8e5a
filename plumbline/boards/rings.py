"""The ring test: around a corner of a chequerboard brightness alternates four times."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.boards.saddles import LEAST_CONTRAST
from plumbline.frame import Array
from plumbline.photos.brightness import Grey, sampled

_RADII_PX = 3.5, 5.0, 7.5
"""Rings, two of which must agree; chosen, because squares of 9 px hold the two smaller ones."""

_STEPS = 40
"""Samples of a ring; chosen, because they stand closer than a pixel."""

_NARROWEST = np.radians(22.0)
"""The narrowest sector: a square seen at 60° to its diagonal has 60°, barrel takes some of it."""

_BENT = np.radians(25.0)
"""How far an edge may bend at a corner; chosen, because the strongest barrel bends it by 10°."""

_ALIKE = np.radians(14.0)
"""How far the same edge may turn between two rings; chosen as a step and a half of a ring."""

_SMOOTH_PX = 0.8
"""Blur before sampling, against noise; chosen, because it moves no edge."""


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of squares and the four edges that leave each.

    Attributes:
        points: Where they lie, pixels of the picture searched, shape (n, 2).
        rays: Directions of the edges, radians from x towards y, rising, shape (n, 4).
        signs: 1 where brightness rises across the edge in that sense of rotation, else −1,
            shape (n, 4); alternates.
        contrast: Half the difference between light and dark around the corner, shape (n,).
    """

    points: Array
    rays: Array
    signs: NDArray[np.int64]
    contrast: Array

    def __len__(self) -> int:
        return len(self.points)

    def only(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Corners:
        """Some of them."""
        return Corners(
            self.points[which], self.rays[which], self.signs[which], self.contrast[which]
        )


def smoothed(grey: Grey) -> Grey:
    """Brightness as the ring test takes it."""
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), _SMOOTH_PX), dtype=np.float32)


def ring_test(smooth: Grey, points: Array, least_contrast: float = LEAST_CONTRAST) -> Corners:
    """Those points around which brightness alternates four times, on two rings alike.

    Args:
        smooth: Brightness after `smoothed`, shape (h, w).
        points: Shape (n, 2).
        least_contrast: Half the least difference between light and dark.
    """
    last = np.array(smooth.shape[::-1]) - 1
    passed = np.zeros(len(points), dtype=np.int64)
    rays, signs = np.zeros((len(points), 4)), np.zeros((len(points), 4), dtype=np.int64)
    contrast = np.zeros(len(points))
    for radius in _RADII_PX:
        good, where, sense, half = _one_ring(smooth, points, radius, least_contrast)
        good &= ((points >= radius) & (points <= last - radius)).all(axis=1)
        good &= (passed == 0) | _alike(where, sense, rays, signs)
        rays[good], signs[good], contrast[good] = where[good], sense[good], half[good]
        passed[good] += 1
    kept = passed >= 2
    return Corners(points[kept], rays[kept], signs[kept], contrast[kept])


def _alike(
    rays: Array, signs: NDArray[np.int64], others: Array, other_signs: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether the edges on two rings are the same; the first may have passed from 2π to 0."""
    alike = np.zeros(len(rays), dtype=np.bool_)
    for shift in (-1, 0, 1):
        turned = np.abs((np.roll(rays, shift, axis=1) - others + np.pi) % (2 * np.pi) - np.pi)
        same = (np.roll(signs, shift, axis=1) == other_signs).all(axis=1)
        alike |= same & (turned.max(axis=1) < _ALIKE)
    return alike


def _one_ring(
    smooth: Grey, points: Array, radius: float, least_contrast: float
) -> tuple[NDArray[np.bool_], Array, NDArray[np.int64], Array]:
    """Which points pass on one ring, and their rays, signs and contrast."""
    angles = 2 * np.pi * np.arange(_STEPS) / _STEPS
    circle = radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    values = sampled(smooth, points[:, None, :] + circle).astype(np.float64)
    ranked = np.sort(values, axis=1)
    fifth = _STEPS // 5
    low, high = ranked[:, :fifth].mean(axis=1), ranked[:, -fifth:].mean(axis=1)
    half = (high - low) / 2
    level = values - ((high + low) / 2)[:, None]
    following = np.roll(level, -1, axis=1)
    crosses = (level > 0) != (following > 0)
    good = (crosses.sum(axis=1) == 4) & (half >= least_contrast)
    rays, signs = np.zeros((len(points), 4)), np.ones((len(points), 4), dtype=np.int64)
    rows = np.flatnonzero(good)
    if not len(rows):
        return good, rays, signs, half
    step = np.nonzero(crosses[rows])[1].reshape(-1, 4)
    row = rows[:, None]
    before, after = level[row, step], following[row, step]
    where = (step + before / (before - after)) * (2 * np.pi / _STEPS)
    rays[rows] = where
    signs[rows] = np.where(after > before, 1, -1)
    sectors = np.diff(np.concatenate((where, where[:, :1] + 2 * np.pi), axis=1), axis=1)
    straight = np.abs(where[:, 2:] - where[:, :2] - np.pi)
    good[rows] = (sectors.min(axis=1) > _NARROWEST) & (straight.max(axis=1) < _BENT)
    return good, rays, signs, half
