"""How far a calibration can be trusted beyond its standard errors.

Standard errors hold for independent picking errors on straight edges. Edges are never perfectly
straight, and then the picks of one line err together; the line-by-line jackknife (J. Tukey 1958;
for least squares with groups R. Bell and D. McCaffrey 2002) sees that, since it asks how much
the result depends on each line. What neither sees is a model that cannot follow the lens: one
more power of r shows how far that would move the correction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.linearised import Linearised
from plumbline.trust.refit import Refit


@dataclass(frozen=True, eq=False)
class Jackknife:
    """What leaving out one line after the other says.

    Attributes:
        covariance: Of the free coefficients, shape (k, k).
        shifts: Change of the coefficients without each line, shape (l, k); lines of which no pick
            was kept are not among them.
        lines: The first line of each edge that was left out, shape (l,).
    """

    covariance: Array
    shifts: Array
    lines: NDArray[np.int64]

    @property
    def dof(self) -> int:
        """Degrees of freedom: edges − 1."""
        return len(self.lines) - 1


def jackknife(
    linear: Linearised,
    edges: NDArray[np.int64] | None = None,
    refit: Refit | None = None,
    sigma_px: float = 0.0,
) -> Jackknife | None:
    """Leave one edge out after the other, in one Gauss–Newton step each.

    Args:
        linear: The fit, linearised.
        edges: The edge of each line, as the number of its first line, (l,); each line is one by
            default.
        refit: What fits again where a step is large; every step counts as it is by default.
        sigma_px: Standard deviation of one pick, for that.

    Returns:
        None if some edge is needed to determine the coefficients at all.
    """
    edges = np.arange(linear.n_lines) if edges is None else edges
    shifts = linear.without_each_line(edges)
    if shifts is None:
        return None
    if refit is not None:
        shifts = refit.improved(linear, shifts, edges, sigma_px)
    kept = np.bincount(edges[linear.line[linear.kept]], minlength=linear.n_lines)[np.unique(edges)]
    used = np.flatnonzero(kept >= 3)
    if len(used) < 2:
        return None
    shifts = shifts[used]
    away = shifts - shifts.mean(axis=0)
    share = (len(used) - 1) / len(used)
    return Jackknife(share * away.T @ away, shifts, np.unique(edges)[used])
