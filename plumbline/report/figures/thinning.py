"""Which picks of a large project are drawn: the worst, the outermost, and an even share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

MOST_LINES = 400
"""Chosen, because more cover a photo so that none is seen, and each costs 10 ms to draw."""

MOST_PICKS = 12_000
"""Likewise: 30 on each of so many lines."""

_WORST = 100
"""Of the lines, those with the largest residuals; chosen, twice what the figures name."""


def drawn_picks(sizes: NDArray[np.int64], away_px: Array, radius_px: Array) -> NDArray[np.bool_]:
    """Which picks are drawn, shape (n,).

    Args:
        sizes: Number of picks of each line.
        away_px: Size of each pick's residual, line after line, shape (n,).
        radius_px: Its distance from the distortion centre, shape (n,).
    """
    n_lines, n = len(sizes), len(away_px)
    if n_lines <= MOST_LINES and n <= MOST_PICKS:
        return np.ones(n, dtype=np.bool_)
    starts = np.cumsum(sizes) - sizes
    known = np.where(np.isfinite(away_px), away_px, 0.0)
    worst = np.argsort(-np.maximum.reduceat(known, starts), kind="stable")[:_WORST]
    outermost = np.argmax(np.maximum.reduceat(radius_px, starts))
    some = np.linspace(0, n_lines - 1, min(n_lines, MOST_LINES - _WORST)).astype(np.int64)
    lines = np.unique(np.concatenate((worst, [outermost], some)))
    most = MOST_PICKS // len(lines)
    drawn = np.zeros(n, dtype=np.bool_)
    for start, size in zip(starts[lines].tolist(), sizes[lines].tolist(), strict=True):
        own = slice(start, start + size)
        even = np.linspace(0, size - 1, min(size, most)).astype(np.int64)
        drawn[start + even] = True
        drawn[start + np.argmax(known[own])] = True
        drawn[start + np.argmax(radius_px[own])] = True
    return drawn
