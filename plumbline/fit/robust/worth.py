"""Whether picks are wrong, or the whole project is as coarse as they are.

A fit to fewer picks always leaves less. Two explanations are weighed by their likelihoods: all
picks are good with the plain fit's σ; or m of n are wrong and lie anywhere in a band, the others
are good with the σ of the robust fit. Both σ, and the share m/n, are those that suit the picks
best; nothing is measured against the photo's size but the band, and the σ of the most careless
picks.
"""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array

EVIDENCE = log(50)
"""How much likelier wrong picks must be: chosen, so that of fifty clean projects one at most is
accused by chance. Two lenses that differ by less are about as likely."""

MOST_CARELESS = 1 / 100
"""σ that picks may have at most, as a share of half the shorter side: chosen, 10 px in a photo of
2,000 by 3,000, since nobody is more careless; what scatters more is wrong."""

ROUNDED_PX = 0.29
"""Standard deviation of a coordinate rounded to whole pixels, 1/√12."""


def explains_more(
    plain: tuple[float, int],
    robust: tuple[float, int],
    kept: NDArray[np.bool_],
    sizes: NDArray[np.int64],
    radius_px: float,
    band_px: float,
    n_bent: int = 0,
) -> bool:
    """Whether wrong picks explain the plain fit's residuals better than a larger σ.

    Args:
        plain: σ̂ and degrees of freedom of the fit to all picks, pixels.
        robust: The same of the fit without the wrong ones.
        kept: Which picks are not left out, line after line, shape (n,).
        sizes: Number of picks of each line.
        radius_px: Half the shorter side.
        band_px: Width of the band that wrong picks fall into, and bends.
        n_bent: How many lines are not left out but bent by themselves.
    """
    n, wrong = len(kept), int(np.count_nonzero(~kept))
    if wrong == n:
        return True
    lost = int(np.count_nonzero(np.add.reduceat(kept, np.cumsum(sizes) - sizes) == 0))
    chosen = _choice(wrong, n) + _choice(n_bent, len(sizes)) - n_bent * log(band_px)
    # Two picks of a line are owed to the line itself, whatever they are.
    scattered = -(wrong - 2 * lost) * log(band_px)
    most_px = MOST_CARELESS * radius_px
    bad = _of_good(*robust, most_px) + chosen + scattered
    return bad - _of_good(*plain, most_px) > EVIDENCE


def _choice(some: int, n: int) -> float:
    """Logarithm of the likelihood that these of n are the odd ones."""
    if not 0 < some < n:
        return 0.0
    return some * log(some / n) + (n - some) * log(1 - some / n)


def _of_good(sigma_px: float, dof: int, most_px: float) -> float:
    """Logarithm of the likelihood of `dof` independent contrasts that scatter by σ̂.

    Their σ is what suits them best, up to that of the most careless picks.
    """
    true_px = min(sigma_px, most_px)
    return -dof * (log(sqrt(2 * pi) * true_px) + (sigma_px / true_px) ** 2 / 2)


def rounded(finest_px: Array) -> Array:
    """σ of the rounding of picks whose least σ is so; 0 where they are not rounded."""
    return np.where(finest_px >= ROUNDED_PX, ROUNDED_PX, 0.0)
