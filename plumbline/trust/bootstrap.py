"""What repeated fits to resampled residuals say: the result of `plumbline.fit.bootstrap`."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.frame import Array


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """Fits to residuals resampled within lines (B. Efron 1979).

    Attributes:
        fits: Number of fits that reached a minimum.
        failed: Number of those that did not.
        covariance: Of the free coefficients, shape (k, k).
        intervals: Their 2.5 and 97.5 percentiles, shape (k, 2).
    """

    fits: int
    failed: int
    covariance: Array
    intervals: Array
