"""What the fitted model may miss of the lens, in pixels of the correction.

One Gauss–Newton step from the fit with the nuisances of `plumbline.trust.nuisances` added. Its
motion of the correction, squared and less what noise alone would make of it, is what the picks say
of the lens's being another; the growth of the covariance is what they leave open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.displacement import errors_of
from plumbline.trust.linearised import Linearised
from plumbline.trust.nuisances import DECENTRING, RADIAL, Nuisances
from plumbline.trust.student import widening

_ROUNDS = 3
"""Steps in which σ̂ and the nuisances are found in turn; the third changes less than a percent."""


_FINEST_PX = 1e-3
"""σ̂ below this is rounding."""

_SINGULAR = 1e-6
"""Share of the largest variance below which a direction is rounding."""

_CLEAR = 3.09
"""Normal quantile of 0.999: chosen, so that the alarm stays rare among thousands of projects."""


@dataclass(frozen=True, eq=False)
class Step:
    """The fit with nuisances, relative to the one without.

    Attributes:
        change: Of the free coefficients and the nuisances, the latter in standard deviations of
            their priors, shape (k + m,).
        covariance: Of both, with the priors, shape (k + m, k + m).
        by_noise: Covariance that `change` has if there are no nuisances.
        own: Covariance of the free coefficients without nuisances, (k, k).
        by_lines: Covariance of `change` by leaving out one line at a time.
        sigma_px: σ of one pick that the fit with nuisances leaves.
        n_free: k.
    """

    change: Array
    covariance: Array
    by_noise: Array
    own: Array
    by_lines: Array
    sigma_px: float
    n_free: int

    def missed_px(self, moved: Array) -> NDArray[np.float64]:
        """What the fit without nuisances may miss at points, one standard error, (n,).

        Args:
            moved: How the points move with coefficients and nuisances, shape (n, 2, k + m).
        """
        told = np.sum(np.einsum("nik,k->ni", moved, self.change) ** 2, axis=1)
        told = told - errors_of(moved, self.by_noise) ** 2
        left = errors_of(moved, self.covariance) ** 2
        left -= errors_of(moved[..., : self.n_free], self.own) ** 2
        return np.sqrt(np.maximum(told, 0.0) + np.maximum(left, 0.0))

    @property
    def speaks(self) -> float:
        """χ² of the nuisances under none, where picks err independently."""
        return _square(self.change[self.n_free :], self.by_noise[self.n_free :, self.n_free :])

    @property
    def speaks_by_lines(self) -> float:
        """The same where the picks of a line may err together."""
        return _square(self.change[self.n_free :], self.by_lines[self.n_free :, self.n_free :])


def is_clear(step: Step, dof_of_lines: int) -> bool:
    """Whether the picks want the nuisances beyond doubt, by single picks and by whole lines.

    χ² that one good project in 1,000 has (E. Wilson and M. Hilferty 1931, to a percent).

    Args:
        step: The fit with nuisances.
        dof_of_lines: Degrees of freedom of what leaving out lines says.
    """
    n = len(step.change) - step.n_free
    limit = n * (1 - 2 / (9 * n) + _CLEAR * np.sqrt(2 / (9 * n))) ** 3
    by_lines = step.speaks_by_lines / widening(dof_of_lines) ** 2
    return bool(min(step.speaks, by_lines) > limit)


def _square(change: Array, covariance: Array) -> float:
    """cᵀC⁻¹c, over the directions in which C is not 0."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    seen = values > _SINGULAR * values[-1]
    along = vectors[:, seen].T @ (change / scale)
    return float(np.sum(along**2 / values[seen]))


def nuisance_step(
    linear: Linearised, dof: int, which: NDArray[np.bool_], widened: float
) -> Step | None:
    """Fit the free coefficients and some nuisances together.

    Args:
        linear: The fit, with its nuisances.
        dof: Degrees of freedom of the fit.
        which: Which nuisances take part, shape (m,).
        widened: What σ is multiplied with, where lines err as a whole.

    Returns:
        None where the free coefficients cannot be told apart.
    """
    scale = linear.in_photo[linear.kept, None]
    own = linear.jacobian[linear.kept] * scale
    design = np.concatenate((own, linear.besides[linear.kept][:, which] * scale), axis=1)
    residual_px, k = linear.image_px[linear.kept], own.shape[1]
    normal = design.T @ design
    alone = _inverse(normal[:k, :k])
    if alone is None or not np.all(np.isfinite(normal)):
        return None
    # What the free coefficients could still take up does not count: they are at their minimum.
    pull = design.T @ (residual_px - own @ (alone @ (own.T @ residual_px)))
    prior = np.diag(np.concatenate((np.zeros(k), np.ones(normal.shape[0] - k))))
    square = float(residual_px @ residual_px)
    sigma2 = max(square / max(dof, 1), _FINEST_PX**2)
    change, covariance = np.zeros(len(normal)), prior
    for _ in range(_ROUNDS):
        variance = sigma2 * widened**2
        found = _inverse(normal / variance + prior)
        if found is None:
            return None
        covariance = found
        change = -covariance @ pull / variance
        taken = float(np.sum(1 - np.diag(covariance)[k:]))
        left = square + 2 * float(change @ pull) + float(change @ normal @ change)
        sigma2 = max(left / max(dof - taken, 1.0), _FINEST_PX**2)
    variance = sigma2 * widened**2
    seen = (normal - normal[:, :k] @ alone @ normal[:k]) / variance
    return Step(
        change,
        covariance,
        covariance @ seen @ covariance,
        alone * variance,
        _by_lines(linear, design, residual_px + design @ change, normal + prior * variance),
        float(np.sqrt(sigma2)),
        k,
    )


def _by_lines(linear: Linearised, design: Array, residual_px: Array, normal: Array) -> Array:
    """The jackknife's covariance of all columns of a design (J. Tukey 1958)."""
    line = linear.line[linear.kept]
    starts = np.flatnonzero(np.diff(line, prepend=-1))
    n_lines, size = len(starts), design.shape[1]
    rest = np.empty((n_lines, size, size))
    for i, j in zip(*np.triu_indices(size), strict=True):  # one product at a time: picks are many
        rest[:, i, j] = normal[i, j] - np.add.reduceat(design[:, i] * design[:, j], starts)
        rest[:, j, i] = rest[:, i, j]
    pulls = np.add.reduceat(design * residual_px[:, None], starts)
    scale = np.sqrt(np.diag(normal))
    balanced = rest / np.outer(scale, scale) + 1e-12 * np.eye(size)
    shifts = np.linalg.solve(balanced, (pulls / scale)[..., None])[..., 0] / scale
    away = shifts - shifts.mean(axis=0)
    return (n_lines - 1) / n_lines * away.T @ away


def steps_of(
    linear: Linearised, nuisances: Nuisances, dof: int, widened: float
) -> dict[str, tuple[Step, NDArray[np.bool_]]]:
    """The step with all nuisances (under ""), with those of each group, and which take part."""
    groups = np.array(nuisances.groups)
    chosen = {"": np.ones(len(groups), dtype=np.bool_)}
    chosen |= {name: groups == name for name in (DECENTRING, RADIAL) if np.any(groups == name)}
    found: dict[str, tuple[Step, NDArray[np.bool_]]] = {}
    for name, which in chosen.items():
        step = nuisance_step(linear, dof, which, widened)
        if step is not None:
            found[name] = (step, which)
    return found


def _inverse(normal: Array) -> Array | None:
    """The inverse of a positive definite matrix, None where it is singular."""
    scale = np.sqrt(np.diag(normal))
    if not np.all(np.isfinite(scale)) or np.any(scale <= 0):
        return None
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if values[0] <= 1e-13:
        return None
    return (vectors / values) @ vectors.T / np.outer(scale, scale)
