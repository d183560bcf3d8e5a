"""Whether the result hangs on single lines more than independent picking errors explain.

The jackknife's error is itself uncertain: with few lines, or with some that carry the result, it
often differs from that of independent errors by chance. Its distribution for this layout is drawn
(a parametric bootstrap; B. Efron 1979): under independent errors the gradient of line l is normal
with covariance N_l = J_lᵀJ_l, and the jackknife is a function of these gradients alone, so that a
draw costs no more than the number of lines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.displacement import errors_of
from plumbline.trust.linearised import Linearised, grouped
from plumbline.trust.student import widening

_DRAWS = 400
"""Chosen, because the 97.5 % point is then known to about 0.8 % of probability."""

_FALSE_ALARM = 0.025
"""Chosen below the 5 % that are allowed, since the point is drawn."""

_MANY_LINES = 1000
"""With more lines the distribution is narrower than `_LEAST`, and need not be drawn: it scatters
by 1/√(2 · lines)."""

_LEAST = 1.25
"""Ratio below which there is nothing to say: chosen, because an error quoted a quarter too small
misleads nobody."""

_PRIOR_DOF = 4
"""Degrees of freedom that the error for independent picks is worth beside the jackknife's: chosen,
so that few lines do not decide alone; not yet tuned on `tests.benchmarks.bent_edges`."""


@dataclass(frozen=True)
class Steadiness:
    """The jackknife against independent errors.

    Attributes:
        own_px: The largest error for independent picking errors.
        left_out_px: The jackknife's.
        limit: What the ratio exceeds by chance in one of forty projects of this layout.
        dof: Degrees of freedom of the jackknife's largest error: twice its squared mean over its
            variance under independent errors (F. Satterthwaite 1946), at most lines − 1.
        inflation: How much too large the jackknife's error is under independent errors, since a
            line left out takes its own share of the fit along (R. Bell and D. McCaffrey 2002).
    """

    own_px: float
    left_out_px: float
    limit: float
    dof: int
    inflation: float = 1.0

    @property
    def ratio(self) -> float:
        """The jackknife's largest error over that of independent errors."""
        return self.left_out_px / self.own_px if self.own_px > 0 else 1.0

    @property
    def alarmed(self) -> bool:
        """Whether chance does not explain it."""
        return self.ratio > self.limit

    def pooled(self, own: Array, wide: Array, *, by_lines: bool) -> Array:
        """Errors to quote, from those for independent errors and the jackknife's.

        The jackknife's variance alone where lines err as a whole. Elsewhere both speak of the same
        thing: their mean, weighted by degrees of freedom, scatters least. Widened, and the
        jackknife's without its bias.

        Args:
            own: Errors for independent picks, shape (n,).
            wide: The jackknife's.
            by_lines: Whether chance does not explain the ratio, nor a wrong model.
        """
        wide = wide / self.inflation
        if by_lines:
            return np.maximum(wide * widening(self.dof), own)
        mean = (_PRIOR_DOF * own**2 + self.dof * wide**2) / (_PRIOR_DOF + self.dof)
        return np.sqrt(mean) * widening(_PRIOR_DOF + self.dof)


def steadiness(
    linear: Linearised,
    edges: NDArray[np.int64],
    moved: Array,
    own_px: float,
    left_out_px: float,
    dof: int,
) -> Steadiness:
    """Compare the jackknife's error with what it would be by chance.

    Args:
        linear: The fit, linearised.
        edges: The edge of each line, see `edges_of`.
        moved: How points of the photo move with the coefficients, see `motions`, (n, 2, k).
        own_px: The largest error for independent picking errors.
        left_out_px: The jackknife's.
        dof: Degrees of freedom of σ̂.
    """
    used = grouped(linear.line_normals, edges)
    used = used[np.einsum("lii->l", used) > 0]
    if len(used) > _MANY_LINES:
        return Steadiness(own_px, left_out_px, _LEAST, len(used) - 1)
    variances, ratios = _drawn(used, moved, dof)
    freedom = 2 * np.mean(variances) ** 2 / max(float(np.var(variances)), 1e-300)
    limit = max(_LEAST, float(np.quantile(ratios, 1 - _FALSE_ALARM)))
    free_to_vary = int(np.clip(round(float(freedom)), 1, len(used) - 1))
    inflation = max(float(np.sqrt(np.mean(variances))), 1.0)
    return Steadiness(own_px, left_out_px, limit, free_to_vary, inflation)


def _drawn(normals: Array, moved: Array, dof: int) -> tuple[Array, Array]:
    """Draw the jackknife's variance and its largest error, over those of independent errors.

    Returns:
        Ratios of the variances at the worst point, and of the largest errors, both (draws,).
    """
    rng = np.random.default_rng(len(normals))
    values, vectors = np.linalg.eigh(normals)
    roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    n_lines, k = normals.shape[:2]
    total = normals.sum(axis=0)
    unit = np.linalg.pinv(total)
    rest = np.linalg.pinv(total - normals)
    own = errors_of(moved, unit)
    worst = int(np.argmax(own))
    share = (n_lines - 1) / n_lines
    scatter = np.sqrt(rng.chisquare(dof, _DRAWS) / dof)
    variances, ratios = np.empty(_DRAWS), np.empty(_DRAWS)
    for draw in range(_DRAWS):
        pulls = np.einsum("lij,lj->li", roots, rng.standard_normal((n_lines, k)))
        pulls -= np.einsum("lij,j->li", normals, unit @ pulls.sum(axis=0))
        shifts = np.einsum("lij,lj->li", rest, pulls)
        away = shifts - shifts.mean(axis=0)
        found = errors_of(moved, share * away.T @ away)
        variances[draw] = (found[worst] / own[worst]) ** 2
        ratios[draw] = np.max(found) / (own[worst] * scatter[draw])
    return variances, ratios
