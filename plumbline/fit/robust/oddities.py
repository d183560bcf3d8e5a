"""Lines that bend by themselves, and places picked twice: seen over flat arrays of picks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

_BEND, _EXPLAINED, _LEAST_PICKS = 5.0, 0.8, 5
"""Standard errors of a bend, the share of the residuals that it explains, and the fewest picks
that show one: chosen, so that clean lines hardly ever do (`tests.benchmarks.spoiled`)."""
_ROUNDED_BENDS = 3.5
"""Bends of less, in standard deviations of rounding, may be rounding alone: an edge a little
askew is rounded up for a stretch and down for the next, a pixel at most in all."""
_SAME_PLACE_PX, _SAME_SHARE = 1.0, 0.1


class Bends(NamedTuple):
    """What a curve of their own explains of lines.

    Attributes:
        bend_px: How far each line bends from end to end, shape (l,).
        bent: Whether it bends by itself, shape (l,).
        left_square: Sum of squared distances that its curve leaves, shape (l,).
    """

    bend_px: Array
    bent: NDArray[np.bool_]
    left_square: Array


def bends(
    line: NDArray[np.int64],
    along: Array,
    distance_px: Array,
    sigma_px: Array,
    rounded_px: Array | float = 0.0,
) -> Bends:
    """Look for lines whose picks follow a parabola much better than a straight line.

    Args:
        line: Line of each pick, rising from 0, shape (n,).
        along: Position along the line, shape (n,).
        distance_px: Distance from the line, shape (n,); infinite ones do not count.
        sigma_px: σ of one pick of each line, shape (l,).
        rounded_px: The part of it that is rounding, whose errors go together along a line.
    """
    n = len(sigma_px)
    known = np.isfinite(distance_px)
    weight = known.astype(np.float64)
    r = np.where(known, distance_px, 0.0)
    t = np.where(known, along, 0.0)

    def total(values: Array) -> Array:
        return np.bincount(line, values * weight, n).astype(np.float64)

    number = np.maximum(total(np.ones_like(r)), 1.0)
    t = t - (total(t) / number)[line]
    spread = np.where(total(t * t) > 0, total(t * t), np.inf)
    t = np.where(known, t / np.sqrt(spread / number)[line], 0.0)

    def straightened(values: Array) -> Array:
        mean, slope = total(values) / number, total(values * t) / np.maximum(total(t * t), 1e-300)
        return values - mean[line] - slope[line] * t

    r, q = straightened(r), straightened(t * t)
    size = total(q * q)
    curve = total(q * r) / np.where(size > 1e-12, size, np.inf)
    whole, explained = total(r * r), curve**2 * size
    left = np.maximum(whole - explained, 0.0)
    rest = np.sqrt(left / np.maximum(number - 3, 1.0))
    error = np.maximum(rest, sigma_px)
    starts = np.searchsorted(line, np.arange(n))
    length = np.maximum.reduceat(t, starts) - np.minimum.reduceat(t, starts)
    bend_px = np.abs(curve) * (length / 2) ** 2
    bent = (
        (bend_px > _ROUNDED_BENDS * rounded_px)
        & (number >= _LEAST_PICKS)
        & (np.abs(curve) * np.sqrt(size) > _BEND * error)
    )
    return Bends(bend_px, bent & (explained > _EXPLAINED * whole), left)


def twins(line: NDArray[np.int64], along: Array, across: Array) -> NDArray[np.int64]:
    """Pairs of picks of one line that are closer together than anybody picks on purpose.

    Less than 1 px, and less than a tenth of the line's usual gap.

    Args:
        line: Line of each pick, rising from 0, shape (n,).
        along: Position along the line in pixels, shape (n,).
        across: Distance from the line in pixels, shape (n,).

    Returns:
        Places of the two picks of each pair, shape (m, 2).
    """
    known = np.flatnonzero(np.isfinite(along + across))
    reach = 2 * np.max(np.abs(along[known]), initial=1.0)
    order = known[np.argsort(line[known] + along[known] / (2 * reach))]
    first, second = order[:-1], order[1:]
    same = line[first] == line[second]
    gap = np.hypot(along[second] - along[first], across[second] - across[first])
    close = same & (gap < _SAME_PLACE_PX)
    if not np.any(close):
        return np.zeros((0, 2), dtype=np.int64)
    usual = np.zeros(int(line[-1]) + 1)
    np.add.at(usual, line[first[same]], gap[same])
    usual /= np.maximum(np.bincount(line[first[same]], minlength=len(usual)), 1)
    close &= gap < _SAME_SHARE * usual[line[first]]
    pairs = np.stack((first[close], second[close]), axis=1)
    return np.sort(pairs, axis=1)
