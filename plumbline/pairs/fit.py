"""Fit a lens, a scale and a shift to matched points of which some are wrong.

The wrong ones are found by re-weighting: weights of Tukey's biweight (A. Beaton and J. Tukey,
1974), whose width shrinks from a share of the photo to the scatter of the matches, then a plain
fit to those within `WILD` deviations, repeated until nothing changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import PairError
from plumbline.frame import Array
from plumbline.trust.matched import UNSEEN, Setting, derivatives, residual_px

WILD = 4.0
"""Deviations along x or y beyond which a match is left out; of good ones 1 in 10,000 is."""

_NORMAL = 1.4826
"""Standard deviations of a normal distribution to its median absolute deviation."""

_FIRST = 0.05
"""The first width as a share of half the shorter side; chosen: the strongest lens of LensFun's
database bends by more only beyond the middle, whose matches lead outwards."""

_SHRINK = 0.6
"""By how much the width shrinks a round: chosen, slower ones end alike."""
_BIWEIGHT = 4.685
"""Widths of the biweight at which it is 95 % as efficient as least squares on good matches."""

_MOST_STEPS = 60
"""Chosen: fits take fewer than twenty."""
_SETTLED_PX = 1e-6
"""Chosen: a thousandth of what a match can tell."""
_DAMPING = 1e-3, 10.0, 1e9
"""As Levenberg–Marquardt is usually begun, made harder, and given up; chosen."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A setting fitted to matches.

    Attributes:
        setting: Lens, scale and place.
        kept: Which matches were fitted, shape (n,).
        covariance: Of the free coefficients.
        sigma_px: Scatter of a match along x or y, in the original.
        dof: 2 · matches − free coefficients − 3.
        converged: Whether the last fit ended in a minimum.
    """

    setting: Setting
    kept: NDArray[np.bool_]
    covariance: Array
    sigma_px: float
    dof: int
    converged: bool


def fit_matches(
    start: Setting, free: tuple[str, ...], observed_px: Array, corrected_px: Array
) -> Fitted:
    """Fit, leaving wrong matches out.

    Args:
        start: Without distortion: a scale and a place that some matches agree on.
        free: Coefficients to fit.
        observed_px: Matches in the original, shape (n, 2).
        corrected_px: The same in the corrected picture.

    Raises:
        PairError: too few matches agree.
    """
    setting = _approached(start, free, observed_px, corrected_px)
    kept, converged = np.ones(len(observed_px), dtype=np.bool_), False
    for _ in range(_MOST_STEPS):
        rest = residual_px(setting, observed_px, corrected_px)
        spread = max(_spread(rest[kept]), _SETTLED_PX)
        agreeing = _beyond(rest) <= WILD * spread
        if agreeing.sum() <= len(free) + UNSEEN:
            raise PairError("hardly any matches agree on one lens")
        setting, converged = _least_squares(
            setting, free, observed_px[agreeing], corrected_px[agreeing]
        )
        if np.array_equal(agreeing, kept):
            break
        kept = agreeing
    return _finished(setting, free, observed_px, corrected_px, kept, converged)


def _approached(
    setting: Setting, free: tuple[str, ...], observed_px: Array, corrected_px: Array
) -> Setting:
    """A setting near the one that most matches agree on."""
    width = _FIRST * setting.lens.frame.radius_px
    while True:
        for _ in range(3):
            rest = _beyond(residual_px(setting, observed_px, corrected_px))
            weight = np.clip(1 - (rest / width) ** 2, 0, None)
            used = weight > 0
            setting, _ = _least_squares(
                setting, free, observed_px[used], corrected_px[used], weight[used], steps=5
            )
        rest = residual_px(setting, observed_px, corrected_px)
        near = _beyond(rest) < width
        floor = _BIWEIGHT * max(_spread(rest[near]), _SETTLED_PX) if near.any() else 0.0
        if width <= floor or width <= _SETTLED_PX:
            return setting
        width = max(_SHRINK * width, floor)


def _least_squares(
    setting: Setting,
    free: tuple[str, ...],
    observed_px: Array,
    corrected_px: Array,
    weight: Array | None = None,
    steps: int = _MOST_STEPS,
) -> tuple[Setting, bool]:
    """Levenberg–Marquardt (D. Marquardt, 1963); whether it ended in a minimum."""
    root = np.ones(len(observed_px)) if weight is None else weight
    damping, harder, most = _DAMPING
    rest = residual_px(setting, observed_px, corrected_px) * root[:, None]
    for _ in range(steps):
        slopes = derivatives(setting, free, corrected_px) * root[:, None, None]
        seen = np.isfinite(rest[:, 0]) & np.all(np.isfinite(slopes), axis=(1, 2))
        normal = np.einsum("nik,nil->kl", slopes[seen], slopes[seen])
        gradient = np.einsum("nik,ni->k", slopes[seen], rest[seen])
        scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
        while True:
            stiff = normal + damping * np.diag(scale**2)
            step = -np.linalg.lstsq(stiff / np.outer(scale, scale), gradient / scale, rcond=None)[0]
            other = setting.moved(free, step / scale)
            tried = residual_px(other, observed_px, corrected_px) * root[:, None]
            if other.scale > 0 and _cost(tried, seen) <= _cost(rest, seen):
                break
            damping *= harder
            if damping > most:
                return setting, True
        moved = np.abs(slopes[seen] @ (step / scale)).max(initial=0.0)
        setting, rest = other, tried
        damping = max(damping / harder, 1e-12)
        if moved < _SETTLED_PX:
            return setting, True
    return setting, False


def _cost(rest: Array, seen: NDArray[np.bool_]) -> float:
    """Sum of squares; infinite where a point that was seen no longer is."""
    total = float((rest[seen] ** 2).sum())
    return total if np.isfinite(total) else np.inf


def _beyond(rest: Array) -> Array:
    """The larger of a residual's two sizes, infinite beyond a fold, shape (n,)."""
    return np.nan_to_num(np.abs(rest).max(axis=1), nan=np.inf)


def _spread(rest: Array) -> float:
    """Standard deviation along x or y by the median absolute deviation."""
    known = np.abs(rest[np.isfinite(rest).all(axis=1)])
    return _NORMAL * float(np.median(known)) if known.size else 0.0


def _finished(
    setting: Setting,
    free: tuple[str, ...],
    observed_px: Array,
    corrected_px: Array,
    kept: NDArray[np.bool_],
    converged: bool,
) -> Fitted:
    rest = residual_px(setting, observed_px[kept], corrected_px[kept])
    slopes = derivatives(setting, free, corrected_px[kept])
    dof = rest.size - len(free) - UNSEEN
    sigma_px = float(np.sqrt((rest**2).sum() / dof))
    normal = np.einsum("nik,nil->kl", slopes, slopes)
    if not np.linalg.cond(normal / np.sqrt(np.outer(np.diag(normal), np.diag(normal)))) < 1e12:
        raise PairError("the matches cannot tell the free coefficients apart")
    whole = sigma_px**2 * np.linalg.inv(normal)
    return Fitted(setting, kept, whole[: len(free), : len(free)], sigma_px, dof, converged)
