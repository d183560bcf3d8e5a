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


@dataclass(frozen=True, eq=False)
class Jackknife:
    """What leaving out one line after the other says.

    Attributes:
        covariance: Of the free coefficients, shape (k, k).
        shifts: Change of the coefficients without each line, shape (l, k); lines of which no pick
            was kept are not among them.
        lines: Which lines were left out, shape (l,).
    """

    covariance: Array
    shifts: Array
    lines: NDArray[np.int64]

    @property
    def dof(self) -> int:
        """Degrees of freedom: lines − 1."""
        return len(self.lines) - 1


def jackknife(linear: Linearised) -> Jackknife | None:
    """Leave one line out after the other, in one Gauss–Newton step each.

    Returns:
        None if some line is needed to determine the coefficients at all.
    """
    shifts = linear.without_each_line()
    if shifts is None:
        return None
    used = np.flatnonzero(np.bincount(linear.line[linear.kept], minlength=linear.n_lines) >= 3)
    if len(used) < 2:
        return None
    shifts = shifts[used]
    away = shifts - shifts.mean(axis=0)
    share = (len(used) - 1) / len(used)
    return Jackknife(share * away.T @ away, shifts, used)
