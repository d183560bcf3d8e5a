"""Which picks of a line agree with each other on a straight line, and how surely.

A line's picks are a mixture: good ones scatter about it by σ, which is one for the whole photo,
wrong ones lie anywhere (P. Torr and A. Zisserman, "MLESAC: a new robust estimator", 2000). Every
pair of few picks, or some pairs of many, proposes the picks near the line through both to have been
meant. What speaks for a proposal is its likelihood with the line's place and direction integrated
out (Laplace's approximation), so that three of five picks on a line count for little where chance
would do it as well, and proposals that exclude each other share the belief. Summed over the lines,
the best proposals tell how likely a lens is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.robust.pixels import stretch_of_lines
from plumbline.fit.robust.screening import Picks, distances, pairs
from plumbline.frame import Array
from plumbline.geometry.lines import Lines, direction, fit_lines

LEAST = 3
"""Fewer picks than these agree on any line."""
_WRONG = 0.25
"""Share of wrong picks that is reckoned with."""
_PAIRS = 28
"""All pairs of eight picks: chosen, so that lines of few picks miss none."""
_SETTLING = 4
"""Rounds after which proposals no longer change: chosen."""
_RIGHT, _WRONGED = 2 / 3, 1 / 2
"""Belief beyond which a pick is called right, and wrong."""
_NO_LINE = 0.05
"""Share of lines that is reckoned with whose picks agree on nothing, or by chance."""


@dataclass(frozen=True, eq=False)
class Agreed:
    """What the picks of every line agree on under a lens.

    Attributes:
        kept: Which picks are believed, shape (n,): twice as likely right as wrong, on a line with
            three of them at least.
        wrong: Which are likelier wrong than not, shape (n,); neither kept nor wrong are those
            of which nobody can tell.
        lines: The lines through the believed picks, or through those that agree best.
        distance_px: Signed distance of every pick from its line in the photograph, shape (n,).
        evidence: Logarithm of the likelihood, up to a constant of the photo.
    """

    kept: NDArray[np.bool_]
    wrong: NDArray[np.bool_]
    lines: Lines
    distance_px: Array
    evidence: float


class Alike(NamedTuple):
    """Lines with the same number of picks.

    Attributes:
        rows: Their picks, shape (l, n).
        first: One pick of each pair that is tried, shape (p,).
        second: The other.
    """

    rows: NDArray[np.int64]
    first: NDArray[np.int64]
    second: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """Lines through proposed picks, shapes (..., p)."""

    count: Array
    middle: tuple[Array, Array]
    along: tuple[Array, Array]
    spread: Array
    square: Array


def alike(sizes: NDArray[np.int64]) -> Iterator[Alike]:
    """The lines in groups of the same number of picks; those of fewer than three tell nothing."""
    starts = np.cumsum(sizes) - sizes
    for size in np.unique(sizes[sizes >= LEAST]).tolist():
        rows = starts[sizes == size][:, None] + np.arange(size)
        yield Alike(rows, *pairs(size, _PAIRS))


def credit(sigma_px: float, wrong_px: float) -> float:
    """What a pick on a line speaks for it, against its being wrong, as a logarithm."""
    return float(np.log((1 - _WRONG) / _WRONG * wrong_px / (np.sqrt(2 * np.pi) * sigma_px)))


def evidence(
    uv: Array, scale: Array, groups: list[Alike], sigma_px: float, wrong_px: float
) -> Array:
    """How likely lenses are, shape (b,).

    Args:
        uv: Picks under each lens in square pixels, shape (b, n, 2).
        scale: Pixels of the corrected photo for one of the photograph at each, shape (b, n).
        groups: The lines.
        sigma_px: Standard deviation of good picks.
        wrong_px: Width of the band that wrong picks fall into.
    """
    total = np.zeros(len(uv))
    worth = credit(sigma_px, wrong_px)
    for rows, first, second in groups:
        points, weight = _centred(uv[:, rows], scale[:, rows])
        away = _from_pairs(points, weight, first, second)
        agreeing = (away < 3 * sigma_px).astype(np.float64)
        drawn = _draw(points, weight, agreeing)
        total += np.sum(np.max(_gain(drawn, drawn.count * worth, worth, sigma_px), -1), -1)
    return total


def agree(
    picks: Picks, sigma_px: float, wrong_px: float, reach: float, excuse: Array | float = 0.0
) -> Agreed:
    """Find the picks that agree, under a lens.

    Args:
        picks: The picks of one problem.
        sigma_px: Standard deviation of good picks.
        wrong_px: Width of the band that wrong picks fall into.
        reach: How many standard deviations from its line a pick may lie.
        excuse: What speaks for each pick's being wrong beside that, as a logarithm, shape (n,).
    """
    n = len(picks.line)
    scale = stretch_of_lines(picks.ideal, picks.sizes)
    right, wrong, best = np.zeros((3, n))
    worth, total = credit(sigma_px, wrong_px), 0.0
    worths = np.broadcast_to(worth - excuse, (n,))
    for rows, first, second in alike(picks.sizes):
        points, weight = _centred(picks.ideal.uv[rows], scale[rows])
        limit = reach * sigma_px
        agreeing = (_from_pairs(points, weight, first, second) < limit).astype(np.float64)
        for _ in range(_SETTLING):
            drawn, before = _draw(points, weight, agreeing), agreeing
            agreeing = _within(points, weight, drawn, before, limit)
            if np.array_equal(agreeing, before):
                break
        drawn = _draw(points, weight, agreeing)
        credited = np.einsum("lpn,ln->lp", agreeing, worths[rows])
        gain = _gain(drawn, credited, worth, sigma_px)
        nothing = _gain_of_nothing(points, weight) - np.sum(worth - worths[rows], axis=-1)
        nothing = nothing[:, None]
        highest = np.maximum(np.max(gain, axis=-1, keepdims=True), nothing)
        belief = np.exp(gain - highest) * _first_of_its_kind(agreeing)
        belief /= np.sum(belief, axis=-1, keepdims=True) + np.exp(nothing - highest)
        right[rows] = np.einsum("lp,lpn->ln", belief, agreeing)
        wrong[rows] = np.einsum("lp,lpn->ln", belief, 1 - agreeing)
        best[rows] = agreeing[np.arange(len(rows)), np.argmax(gain, axis=-1)]
        total += float(np.sum(highest))
    total += float(np.sum(np.broadcast_to(excuse, (n,))))
    kept = right > _RIGHT
    kept &= (np.bincount(picks.line, kept, len(picks.sizes)) >= LEAST)[picks.line]
    counts = np.bincount(picks.line, kept, len(picks.sizes))
    through = np.where((counts > 0)[picks.line], kept, best)
    lines = fit_lines(picks.ideal.uv, picks.sizes, through.astype(np.float64))
    lines = Lines(lines.centre, lines.along, counts.astype(np.float64), lines.spread)
    return Agreed(kept, wrong > _WRONGED, lines, distances(picks, lines), total)


def _centred(uv: Array, scale: Array) -> tuple[Array, Array]:
    """Picks from the middle of their lines, and 1/scale of each; 0 of those beyond the fold."""
    known = np.isfinite(uv[..., 0] + uv[..., 1]) & np.isfinite(scale) & (scale > 0)
    points = np.where(known[..., None], uv, 0.0)
    number = np.maximum(np.sum(known, axis=-1), 1)
    middle = np.sum(points, axis=-2) / number[..., None]
    points = np.where(known[..., None], points - middle[..., None, :], 0.0)
    return points, np.where(known, 1 / np.where(known, scale, 1.0), 0.0)


def _from_pairs(
    points: Array, weight: Array, first: NDArray[np.int64], second: NDArray[np.int64]
) -> Array:
    """Distances of a line's picks from the lines through pairs of them, shape (..., p, n)."""
    x, y = points[..., 0], points[..., 1]
    u, v = x[..., second] - x[..., first], y[..., second] - y[..., first]
    length = np.hypot(u, v)
    ready = (length > 0) & (weight[..., first] > 0) & (weight[..., second] > 0)
    u, v = (each / np.where(ready, length, 1.0) for each in (u, v))
    offset = u * y[..., first] - v * x[..., first]
    away = u[..., None] * y[..., None, :] - v[..., None] * x[..., None, :] - offset[..., None]
    away = np.abs(away) * weight[..., None, :]
    return np.where(ready[..., None] & (weight > 0)[..., None, :], away, np.inf)


def _draw(points: Array, weight: Array, agreeing: Array) -> _Drawn:
    """Least-squares lines through proposed picks, distances weighted as in the photograph."""
    x, y, w = points[..., 0], points[..., 1], weight**2
    every = (np.ones_like(w), w, w * x, w * y, w * x * x, w * x * y, w * y * y)
    sums = np.moveaxis(agreeing @ np.stack(every, axis=-1), -1, 0)
    count, whole = sums[0], np.where(sums[1] > 0, sums[1], 1.0)
    u, v = sums[2] / whole, sums[3] / whole
    xx, xy, yy = sums[4] - sums[2] * u, sums[5] - sums[2] * v, sums[6] - sums[3] * v
    apart = np.hypot(xx - yy, 2 * xy)
    square = np.maximum(xx + yy - apart, 0.0) / 2
    return _Drawn(count, (u, v), direction(xx, xy, yy), (xx + yy + apart) / 2, square)


def _within(points: Array, weight: Array, drawn: _Drawn, agreeing: Array, limit: float) -> Array:
    """Which picks are within reach of lines, what they do to them allowed for, (..., p, n)."""
    x, y = (points[..., None, :, i] - drawn.middle[i][..., None] for i in (0, 1))
    cosine, sine = (each[..., None] for each in drawn.along)
    along, away = x * cosine + y * sine, (y * cosine - x * sine) * weight[..., None, :]
    spread = np.where(drawn.spread > 0, drawn.spread, np.inf)[..., None]
    leverage = 1 / np.maximum(drawn.count, 1.0)[..., None]
    leverage = leverage + (along * weight[..., None, :]) ** 2 / spread
    room = np.where(agreeing > 0, np.maximum(1 - leverage, 0.05), 1 + leverage)
    near = (away**2 < limit**2 * room) & (weight > 0)[..., None, :]
    return np.where((drawn.count >= LEAST)[..., None], near, agreeing).astype(np.float64)


def _gain(drawn: _Drawn, credited: Array, worth: float, sigma_px: float) -> Array:
    """What speaks for proposed picks, as a logarithm: two of them are owed to the line itself."""
    size = np.maximum(drawn.count * drawn.spread, sigma_px**2)
    gain = credited - 2 * worth - drawn.square / (2 * sigma_px**2) - np.log(size) / 2
    return np.where(drawn.count >= LEAST - 1, gain, -1e9)


def _gain_of_nothing(points: Array, weight: Array) -> Array:
    """The same for a line whose picks lie anywhere, all of them, shape (l,)."""
    n = points.shape[-2]
    length = np.sqrt(12 * np.sum(weight**2 * np.sum(points**2, axis=-1), axis=-1) / n)
    owed = 2 * np.log((1 - _WRONG) / _WRONG) + np.log(np.maximum(length, 1.0) / 2)
    return np.log(_NO_LINE) - n * np.log(_WRONG) - owed


def _first_of_its_kind(agreeing: Array) -> NDArray[np.bool_]:
    """Which proposals of a line are not the same as one before, shape (l, p)."""
    code = agreeing @ np.random.default_rng(agreeing.shape[-1]).random(agreeing.shape[-1])
    same = np.abs(code[:, :, None] - code[:, None, :]) < 1e-12
    return ~np.any(np.tril(same, -1), axis=-1)
