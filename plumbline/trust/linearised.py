"""A fitted lens and its picks, linearised: what every question about trust starts from.

The residual r of a pick and its derivative J by the free coefficients, the line parameters
eliminated (variable projection; Golub and Pereyra 1973). With them one Gauss–Newton step answers
what another fit would: which coefficients the fit would have found without a line, and which a
richer model would add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, Frame
from plumbline.geometry.derivatives import Ideal, by_coefficients, by_powers, undistorted
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import Lines, by_line, drawn_through, fit_lines, line_numbers
from plumbline.observations import Observations
from plumbline.trust.nuisances import Nuisances

_SINGULAR = 1e-12
"""Smallest eigenvalue of a balanced normal matrix that is not rounding."""


@dataclass(frozen=True, eq=False)
class Linearised:
    """Residuals of all picks with their derivatives.

    Attributes:
        line: Line of each pick, shape (n,).
        kept: Which picks were fitted and lie within the fold, shape (n,).
        residual_px: Distance from the line through the kept picks, or through all of a line that
            kept none, shape (n,); infinite beyond the fold of the model.
        image_px: The same measured in the photograph, whichever kind was minimised.
        jacobian: Derivatives of `residual_px` by the free coefficients, shape (n, k).
        extra: The same for the terms that the next richer model adds, shape (n, m).
        besides: The same for one standard deviation of each nuisance, shape (n, m).
        stretch: Pixels of the corrected photo across the line for one of the photograph, (n,).
        along_px: Position along the line, in the corrected photo, shape (n,).
        line_leverage: 1/n + t²/Σt² of each pick on its line, shape (n,).
        image: Whether `residual_px` is measured in the photograph.
    """

    line: NDArray[np.int64]
    kept: NDArray[np.bool_]
    residual_px: Array
    image_px: Array
    jacobian: Array
    extra: Array
    besides: Array
    stretch: Array
    along_px: Array
    line_leverage: Array
    image: bool

    @property
    def n_lines(self) -> int:
        """Number of lines."""
        return int(self.line[-1]) + 1 if len(self.line) else 0

    @property
    def in_photo(self) -> Array:
        """Pixels of the photograph for one of `residual_px`, shape (n,)."""
        return np.ones_like(self.stretch) if self.image else 1 / self.stretch

    @property
    def normal(self) -> Array:
        """JᵀJ of the kept picks, shape (k, k)."""
        return self.jacobian[self.kept].T @ self.jacobian[self.kept]

    @property
    def leverage(self) -> Array:
        """How much of a pick's own error the fit takes up, or adds for one left out, (n,)."""
        unit = np.linalg.pinv(self.normal)
        of_lens = np.einsum("ni,ij,nj->n", self.jacobian, unit, self.jacobian)
        return self.line_leverage + of_lens

    def studentised(self, sigma_px: float) -> Array:
        """Residuals in the photograph in units of their own standard deviation, shape (n,).

        A kept pick has drawn line and lens towards itself; one left out has not. Infinite beyond
        the fold of the model, where there is no leverage either.
        """
        room = np.where(self.kept, np.maximum(1 - self.leverage, 1e-6), 1 + self.leverage)
        size = self.image_px / (max(sigma_px, 1e-12) * np.sqrt(room))
        return np.where(np.isfinite(self.image_px), size, np.inf)

    @cached_property
    def line_normals(self) -> Array:
        """JᵀJ of the kept picks of each line, shape (l, k, k)."""
        k, weighted = self.jacobian.shape[1], self._weighted
        normals = np.empty((self.n_lines, k, k))
        for i, j in zip(*np.triu_indices(k), strict=True):  # one product at a time: picks are many
            normals[:, i, j] = np.add.reduceat(weighted[:, i] * weighted[:, j], self._starts)
            normals[:, j, i] = normals[:, i, j]
        return normals

    @property
    def _weighted(self) -> Array:
        return np.where(self.kept[:, None], self.jacobian, 0.0)

    @property
    def _starts(self) -> NDArray[np.int64]:
        return np.searchsorted(self.line, np.arange(self.n_lines))

    def without_each_line(self, edges: NDArray[np.int64] | None = None) -> Array | None:
        """How the coefficients would change with one line left out, shape (l, k).

        Args:
            edges: Lines to leave out together, a label for each, shape (l,); then the result
                holds one row for each label, in rising order. Each by itself by default.

        One Gauss–Newton step from the fit, (N − N_l)⁻¹ g_l with N = JᵀJ and g = Jᵀr.

        Returns:
            None if there is a line without which the others do not determine the coefficients.
        """
        pulls = self._weighted * np.where(self.kept, self.residual_px, 0.0)[:, None]
        normals, gradients = self.line_normals, np.add.reduceat(pulls, self._starts)
        if edges is not None:
            normals, gradients = grouped(normals, edges), grouped(gradients, edges)
        rest = normals.sum(axis=0) - normals
        scale = np.sqrt(np.maximum(np.einsum("lii->li", rest), 0.0))
        if len(rest) < 2 or np.any(scale <= 0):
            return None
        balanced = rest / (scale[:, :, None] * scale[:, None, :])
        if np.min(np.linalg.eigvalsh(balanced)) < _SINGULAR:
            return None
        return np.linalg.solve(balanced, (gradients / scale)[..., None])[..., 0] / scale

    def left_out_px(self, shifts: Array) -> Array:
        """Residuals that kept picks would have, had their line not taken part, shape (n,)."""
        moved = np.einsum("nk,nk->n", self.jacobian, shifts[self.line])
        return np.where(self.kept, self.residual_px + moved, 0.0)


def grouped(values: Array, labels: NDArray[np.int64]) -> Array:
    """Sums of values of shape (l, …) over equal labels, in rising order of the labels."""
    number, which = np.unique(labels, return_inverse=True)
    sums = np.zeros((len(number), *values.shape[1:]))
    np.add.at(sums, which.ravel(), values)
    return sums


def in_frame(observations: Observations, frame: Frame) -> list[Array]:
    """Picks of every line in the pixels of one frame; photos turned otherwise share its centre."""
    return list(by_line(frame.to_pixels(observations.centred_px, 1.0), observations.sizes))


def linearise(
    lens: Lens,
    lines_px: Sequence[Array],
    free: tuple[str, ...],
    kept: NDArray[np.bool_],
    *,
    image: bool,
    richer: tuple[int, ...] = (),
    nuisances: Nuisances | None = None,
) -> Linearised:
    """Residuals and derivatives at a lens.

    Args:
        lens: The lens; for photos of one frame.
        lines_px: Observed picks of each line, shape (n, 2) each.
        free: Names of the free coefficients.
        kept: Which picks count, line after line.
        image: Whether residuals are measured in the photograph, else in the corrected one.
        richer: Powers of r that a richer model adds.
        nuisances: What else the lens may do.
    """
    observed_px = np.concatenate(list(lines_px))
    sizes = np.array([len(points) for points in lines_px], dtype=np.int64)
    line = line_numbers(sizes)
    ideal = undistorted(lens, observed_px)
    seen = np.isfinite(ideal.uv).all(axis=1)
    counts = kept & seen
    drawn = drawn_through(counts, sizes) & seen
    lines = fit_lines(ideal.uv, sizes, drawn.astype(np.float64))
    along, distance = lines.place(ideal.uv, line)
    stretch = across_stretch(ideal, lines, line)
    scale = stretch if image else np.ones_like(stretch)

    def projected(moved: Array) -> Array:
        across = np.einsum("nik,ni->nk", moved, lines.across[line])
        return _without_line(across, along, line, lines, drawn) / scale[:, None]

    leverage = (
        1 / np.maximum(lines.count, 1.0)[line]
        + along**2 / np.where(lines.spread > 0, lines.spread, np.inf)[line]
    )
    return Linearised(
        line=line,
        kept=counts,
        residual_px=np.where(seen, distance / scale, np.inf),
        image_px=np.where(seen, distance / stretch, np.inf),
        jacobian=projected(by_coefficients(lens, free, observed_px, ideal)),
        extra=projected(by_powers(lens, richer, observed_px, ideal))
        if richer
        else np.zeros((len(line), 0)),
        besides=projected(nuisances.columns(lens, observed_px, ideal))
        if nuisances
        else np.zeros((len(line), 0)),
        stretch=stretch,
        along_px=along,
        line_leverage=leverage,
        image=image,
    )


def across_stretch(ideal: Ideal, lines: Lines, line: NDArray[np.int64]) -> Array:
    """How far a step across a line in the photograph reaches in the corrected photo, (n,).

    The step is one of the photograph's own pixels, where picks err alike in x and y; they may be
    wider than high.

    Args:
        ideal: The points.
        lines: The lines, in the corrected photo.
        line: Which of them each point is compared with, shape (n,).
    """
    nx, ny = -lines.along[:, 1][line], lines.along[:, 0][line]
    xx, xy, yx, yy = ideal.stretch.reshape(-1, 4).T
    across_x, across_y = (nx * xx + ny * yx) * ideal.aspect, nx * xy + ny * yy
    return np.sqrt(across_x * across_x + across_y * across_y)


def _without_line(
    values: Array, along: Array, line: NDArray[np.int64], lines: Lines, drawn: NDArray[np.bool_]
) -> Array:
    """What the line's own offset and direction cannot take up of motions across it, (n, k)."""
    number = np.maximum(lines.count, 1.0)
    spread = np.where(lines.spread > 0, lines.spread, np.inf)
    out = np.empty_like(values)
    for column in range(values.shape[1]):
        value, t = (np.where(drawn, each, 0.0) for each in (values[:, column], along))
        mean = np.bincount(line, value, len(number)) / number
        slope = np.bincount(line, value * t, len(number)) / spread
        out[:, column] = values[:, column] - mean[line] - slope[line] * along
    return out
