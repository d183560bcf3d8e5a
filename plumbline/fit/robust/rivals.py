"""Picks that lie on other lines than their own: what that speaks for their being wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.robust.agreement import LEAST, Agreed
from plumbline.fit.robust.screening import Picks, distance_from, within
from plumbline.frame import Array

_OFTEN = 0.3
"""Share of wrong picks that are another line's."""
_ROUGHLY = 10.0
"""Lines farther apart than so many times what a pick may be are not looked at closely."""


def excuses(
    picks: Picks, agreed: Agreed, photos: NDArray[np.int64], sigma_px: float, wrong_px: float
) -> Array:
    """Logarithms of how much likelier wrong picks are where they are than anywhere, shape (n,).

    Only picks of lines that leave some of theirs out are in question, and lines with more believed
    picks than their own.

    Args:
        picks: The picks of one problem.
        agreed: What they agree on.
        photos: Photo of each line, shape (l,).
        sigma_px: Standard deviation of good picks.
        wrong_px: Width of the band that wrong picks fall into.
    """
    told = np.zeros(len(picks.line))
    split = np.bincount(picks.line, ~agreed.kept, len(photos)) > 0
    which = np.flatnonzero(
        split[picks.line] & np.isfinite(agreed.distance_px) & ~_crossings(picks, photos)
    )
    nearest_px = np.full(len(which), np.inf)
    for other in np.flatnonzero(agreed.lines.count >= LEAST).tolist():
        rival = (picks.line[which] != other) & (photos[picks.line[which]] == photos[other])
        rival &= agreed.lines.count[other] > agreed.lines.count[picks.line[which]]
        rival &= within(agreed.lines, picks.ideal.uv[which], other)
        away = distance_from(picks, which[rival], agreed.lines, other)
        nearest_px[rival] = np.minimum(nearest_px[rival], away)
    dense = np.exp(-((nearest_px / sigma_px) ** 2) / 2) / (np.sqrt(2 * np.pi) * sigma_px)
    told[which] = np.log1p(_OFTEN * wrong_px * dense)
    return told


def _crossings(picks: Picks, photos: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which picks stand on two lines of a photo, (n,): corners of a grid lie on both by design."""
    place = np.column_stack((picks.ideal.uv, photos[picks.line]))
    _, which, times = np.unique(place, axis=0, return_inverse=True, return_counts=True)
    return times[which.ravel()] > 1


def contested(
    picks: Picks, agreed: Agreed, photos: NDArray[np.int64], far_px: float
) -> NDArray[np.bool_]:
    """Lines whose believed picks all lie on another one with as many, and that line, shape (l,).

    Which of the two they were meant for nobody can tell.

    Args:
        picks: The picks of one problem.
        agreed: What they agree on.
        photos: Photo of each line, shape (l,).
        far_px: How far from a line a pick may lie.
    """
    both = np.zeros(len(photos), dtype=np.bool_)
    split = np.bincount(picks.line, ~agreed.kept, len(photos)) > 0
    counts = agreed.lines.count
    for line in np.flatnonzero(split & (counts >= LEAST)).tolist():
        mine = np.flatnonzero(agreed.kept & (picks.line == line))
        others = (counts >= counts[line]) & (photos == photos[line])
        others[line] = False
        middle = np.broadcast_to(agreed.lines.centre[line], (len(photos), 2))
        across = agreed.lines.place(middle, np.arange(len(photos)))[1]
        others &= np.abs(across) < _ROUGHLY * far_px
        for other in np.flatnonzero(others).tolist():
            near = within(agreed.lines, picks.ideal.uv[mine], other)
            if np.all(near & (distance_from(picks, mine, agreed.lines, other) < far_px)):
                both[[line, other]] = True
    return both
