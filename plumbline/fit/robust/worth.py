"""Whether picks are wrong, or the whole project is as coarse as they are.

A fit to fewer picks always leaves less. Two explanations are weighed by their likelihoods: all
picks are good with the plain fit's σ; or m of n are wrong and lie anywhere in a band, the others
are good with the σ of the robust fit. Both σ, and the share m/n, are those that suit the picks
best; nothing is measured against the photo's size but the band.
"""

from __future__ import annotations

from math import e, log, pi, sqrt

import numpy as np

from plumbline.frame import Array

_EVIDENCE = log(50)
"""How much likelier wrong picks must be: chosen, so that of fifty clean projects one at most is
accused by chance."""

ROUNDED_PX = 0.29
"""Standard deviation of a coordinate rounded to whole pixels, 1/√12."""


def explains_more(
    plain: tuple[float, int], robust: tuple[float, int], n: int, wrong: int, band_px: float
) -> bool:
    """Whether wrong picks explain the plain fit's residuals better than a larger σ.

    Args:
        plain: σ̂ and degrees of freedom of the fit to all picks, pixels.
        robust: The same of the fit without the wrong ones.
        n: Number of picks.
        wrong: How many of them are left out.
        band_px: Width of the band that wrong picks fall into.
    """
    if not wrong:
        return False
    share = wrong / n
    chosen = wrong * log(share / band_px) + (n - wrong) * log(1 - share) if wrong < n else 0.0
    return _of_good(*robust) + chosen - _of_good(*plain) > _EVIDENCE


def _of_good(sigma_px: float, dof: int) -> float:
    """Logarithm of the likelihood of `dof` independent contrasts with the σ they have."""
    return -dof * log(sqrt(2 * pi * e) * sigma_px)


def rounded(finest_px: Array) -> Array:
    """σ of the rounding of picks whose least σ is so; 0 where they are not rounded."""
    return np.where(finest_px >= ROUNDED_PX, ROUNDED_PX, 0.0)
