"""What looks wrong among dense samples of edges that bend by themselves.

A bend is not a mistake, and samples on it are not suspicious. A stray is: a sample away from its
neighbours; and so is a stretch, or a whole line, that bends far more than the other lines.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.robust.screening import reach
from plumbline.frame import Array
from plumbline.result.calibration import Calibration
from plumbline.trust.linearised import Linearised
from plumbline.trust.suspect import Suspect
from plumbline.wording import px

_BESIDE = 2
"""Neighbours to either side whose median tells where a sample should be: chosen, fewer are not
outvoted, and more hold a bend."""

_MAD = 1.4826
"""σ over the median absolute deviation of a normal distribution."""

_WILD = 5.0
"""Times the bends of usual lines from which a line or a stretch is named: chosen, as for `find`
with room for a façade's wavy sheet."""

_VISIBLE_PX = 0.5
"""Bend that no straight edge has, and the least that a stray is away: edges traced on photographs
bend by .06 to .5 px, and single samples on texture are off by as much."""

_STEPS = 8
"""Reweightings of a line of least absolute deviations: chosen, as half its stretch may be wrong."""


def strays(linear: Linearised) -> NDArray[np.bool_]:
    """Samples that lie away from their neighbours on the line, shape (n,).

    Args:
        linear: A fit; its bends matter little, since neighbours share them.
    """
    away = _from_neighbours(linear)
    known = np.isfinite(away)
    sigma_px = _MAD * float(np.median(np.abs(away[known]))) if known.any() else np.inf
    n = int(np.count_nonzero(known))
    return known & (np.abs(away) > max(reach(max(n - 1, 2), max(n, 1)) * sigma_px, _VISIBLE_PX))


def named(calibration: Calibration, wrong: NDArray[np.bool_]) -> tuple[Suspect, ...]:
    """What is suspicious, in words.

    Args:
        calibration: A fit that knows how its edges bend, without the strays.
        wrong: The strays, shape (n,).
    """
    linear = calibration.linearised
    starts = np.searchsorted(linear.line, np.arange(linear.n_lines))
    sizes = calibration.observations.sizes
    found: list[Suspect] = []
    for number in np.flatnonzero(wrong).tolist():
        line = int(linear.line[number])
        place = number - int(starts[line])
        label = calibration.observations.lines[line].label
        x, y = calibration.observations.lines[line].points_px[place]
        away_px = abs(float(linear.image_px[number]))
        told = f"{away_px:.1f} px from its line" if np.isfinite(away_px) else "beyond the fold"
        found.append(
            Suspect(
                line,
                (place,),
                "stray",
                away_px,
                away_px / calibration.sigma_px,
                True,
                f"pick {place + 1} of line {label} at ({x:.0f}, {y:.0f}) lies {told}, away from "
                "its neighbours",
            )
        )
    bends = np.array([line.bend_px or 0.0 for line in calibration.lines])
    limit_px = max(_WILD * float(np.median(bends)), _VISIBLE_PX)
    for line in np.flatnonzero(bends > limit_px).tolist():
        rows = slice(int(starts[line]), int(starts[line] + sizes[line]))
        found.append(_wild(calibration, line, linear.along_px[rows], linear.image_px[rows]))
    return tuple(found)


def _from_neighbours(linear: Linearised) -> Array:
    """Distance of each sample from the median of its neighbours; NaN where it has too few."""
    order = np.lexsort((linear.along_px, linear.line))
    line, r = linear.line[order], linear.image_px[order]
    steps = [step for step in range(-_BESIDE, _BESIDE + 1) if step]
    beside = np.full((len(steps), len(r)), np.nan)
    for values, step in zip(beside, steps, strict=True):
        to = np.arange(len(r)) + step
        good = (to >= 0) & (to < len(r))
        good[good] &= line[to[good]] == line[good]
        values[good] = r[to[good]]
    complete = np.isfinite(beside).all(axis=0)
    away = np.full(len(r), np.nan)
    away[complete] = r[complete] - np.median(beside[:, complete], axis=0)
    out = np.empty_like(away)
    out[order] = away
    return out


def _wild(calibration: Calibration, line: int, along_px: Array, away_px: Array) -> Suspect:
    """A line that bends more than the others, or the stretch of it that does."""
    picks, far_px = _stretch(along_px, away_px)
    label = calibration.observations.lines[line].label
    bend_px = calibration.lines[line].bend_px or 0.0
    usual = px(float(np.median([each.bend_px or 0.0 for each in calibration.lines])))
    whole = len(picks) == len(away_px)
    told = (
        f"line {label} bends by {px(bend_px)} (rms) where others bend by {usual}"
        if whole
        else f"picks {picks[0] + 1} to {picks[-1] + 1} of line {label} leave it by up to "
        f"{px(far_px)} where others bend by {usual}"
    )
    size = float(np.max(np.abs(away_px[np.isfinite(away_px)]))) / calibration.sigma_px
    return Suspect(
        line,
        picks,
        "bent line",
        bend_px if whole else far_px,
        size,
        False,
        f"{told}: the edge may not be straight, or two edges were taken for one",
    )


def _stretch(along_px: Array, away_px: Array) -> tuple[tuple[int, ...], float]:
    """The run of samples that leaves the line of the others, and how far; all where none does."""
    every = tuple(range(len(away_px)))
    known = np.isfinite(away_px)
    t, r = along_px[known], away_px[known]
    weight = np.ones_like(r)
    rest = r
    for _ in range(_STEPS):
        slope, offset = np.polyfit(t, r, 1, w=np.sqrt(weight))
        rest = r - slope * t - offset
        weight = 1 / np.maximum(np.abs(rest), 1e-3 + 0.01 * np.median(np.abs(rest)))
    far = np.abs(rest) > 3 * _MAD * np.median(np.abs(rest))
    if not far.any() or np.mean(far) >= 0.5:
        return every, 0.0
    numbers = np.flatnonzero(known)[np.argsort(t)]
    far = far[np.argsort(t)]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], far.astype(np.int8), [0]))))
    first, last = max(edges.reshape(-1, 2).tolist(), key=lambda run: run[1] - run[0])
    picks = sorted(numbers[first:last].tolist())
    return tuple(picks), float(np.max(np.abs(rest)))
