"""How sure the correction is, in pixels of the photo.

Straight lines see neither the scale nor the place of the corrected photo (nor, with tangential
terms, its perspective). The standard error of a point's displacement is therefore taken after
the best common scale and translation (or homography) of the whole photo, which is what remains
uncertain in its geometry. It is the root mean square length of the error, the root of the trace
of its 2 × 2 covariance. About a held centre radial terms err along the radius alone, and this is
the standard error of that; with the centre or tangential terms free it holds both directions,
and is 1 to √2 times the standard error along the worse one. It holds independent picking errors
on straight edges under the right model; bent edges, wrong picks and the model's own error are
not in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.derivatives import by_coefficients, by_powers, undistorted
from plumbline.geometry.lens import Lens
from plumbline.trust.nuisances import Nuisances
from plumbline.wording import listed

_GRID = 9
"""Points along a side: chosen, corners and edges among them."""
_ALIKE = 0.01
"""Errors within one percent are equally bad: chosen."""
_CORNERS = 4
"""A photo has four."""


@dataclass(frozen=True, eq=False)
class Displacement:
    """Standard error of the correction over the photo.

    Attributes:
        points_px: Observed points over the photo, shape (n, 2).
        errors_px: One standard error at each, shape (n,).
    """

    points_px: Array
    errors_px: NDArray[np.float64]

    @property
    def worst_px(self) -> float:
        """The largest standard error."""
        return float(np.max(self.errors_px))

    @property
    def worst_at_px(self) -> Array:
        """Where it is largest, or less by at most 1 %, shape (m, 2)."""
        return self.points_px[self.errors_px >= (1 - _ALIKE) * self.worst_px]

    @property
    def worst_place(self) -> str:
        """The same in words: "at the corners", or "at (0, 751), (2255, 751)"."""
        worst, every = self.worst_at_px, self.points_px
        at_ends = (worst == every.min(axis=0)) | (worst == every.max(axis=0))
        if len(worst) == _CORNERS and np.all(at_ends):
            return "at the corners"
        if len(worst) > _CORNERS:
            return f"at {len(worst)} places"
        return "at " + listed([f"({x:.0f}, {y:.0f})" for x, y in worst.tolist()])


def displacement_errors(
    lens: Lens,
    free: tuple[str, ...],
    covariance: Array,
    points_px: Array,
    gauge_px: Array | None = None,
) -> NDArray[np.float64] | None:
    """Standard errors of the displacements of observed points.

    Args:
        lens: The fitted lens.
        free: Names of the free coefficients.
        covariance: Their covariance, `d` and `e` in pixels.
        points_px: Observed points, shape (n, 2).
        gauge_px: Points over which the best common scale and translation are taken; the whole
            photo by default.

    Returns:
        Shape (n,), pixels; None where the model folds before it reaches a point of the photo.
    """
    moved = motions(lens, free, points_px, gauge_px=gauge_px)
    return None if moved is None else errors_of(moved, covariance)


def errors_of(moved: Array, covariance: Array) -> NDArray[np.float64]:
    """Root mean square lengths of what `motions`, (n, 2, k), make of coefficients' errors, (n,)."""
    variance = np.einsum("nik,kl,nil->n", moved, covariance, moved)
    return np.sqrt(np.maximum(variance, 0.0))


def motions(
    lens: Lens,
    free: tuple[str, ...],
    points_px: Array,
    powers: tuple[int, ...] = (),
    gauge_px: Array | None = None,
    nuisances: Nuisances | None = None,
    perspective: bool | None = None,
) -> Array | None:
    """How ideal points move with each coefficient, as far as straight lines can tell.

    Args:
        lens: The lens.
        free: Coefficients, one column each.
        points_px: Observed points, shape (n, 2).
        powers: Powers of r that a richer model adds, one column each, after the others.
        gauge_px: As for `displacement_errors`.
        nuisances: What else the lens may do, one column for a standard deviation of each, last.
        perspective: Take the best homography out; by default where tangential terms are free.

    Returns:
        Shape (n, 2, k), square pixels of the corrected photo for one unit of each; None where the
        model folds before it reaches a point of the photo.
    """
    grid = grid_px(lens) if gauge_px is None else gauge_px
    every = np.concatenate((grid, points_px))
    ideal = undistorted(lens, every)
    if not np.all(np.isfinite(ideal.uv)):
        return None
    columns = by_coefficients(lens, free, every, ideal)
    if powers:
        columns = np.concatenate((columns, by_powers(lens, powers, every, ideal)), axis=2)
    if nuisances is not None:
        besides = nuisances.columns(lens, every, ideal)
        columns = np.concatenate((columns, besides), axis=2)
    if perspective is None:
        perspective = lens.model.decentred(free)
    unseen = _unseen(ideal.uv / lens.frame.radius_px, perspective=perspective)
    n = len(grid)
    on_grid = unseen[:n].reshape(2 * n, -1)
    taken = np.linalg.lstsq(on_grid, columns[:n].reshape(2 * n, -1), rcond=None)[0]
    return columns[n:] - unseen[n:] @ taken


def grid_px(lens: Lens, n: int = _GRID) -> Array:
    """A grid of n × n points over the photo, its corners included, shape (n², 2)."""
    width, height = lens.frame.size
    x, y = np.meshgrid(np.linspace(0, width - 1, n), np.linspace(0, height - 1, n))
    return np.stack((x.ravel(), y.ravel()), axis=1)


def difference_px(one: Lens, other: Lens, points_px: Array, *, perspective: bool) -> float:
    """Largest difference of two lenses that straight lines can tell.

    Args:
        one: A lens.
        other: Another one for the same photos.
        points_px: Observed points, shape (n, 2).
        perspective: Take the best homography out, not only scale and translation.

    Returns:
        Pixels; infinite where one of them folds before it reaches a point.
    """
    here, there = (lens.undistort_or_nan(points_px) for lens in (one, other))
    if not np.all(np.isfinite(here) & np.isfinite(there)):
        return float("inf")
    size = one.frame.radius_px
    u, v = ((ideal - points_px.mean(axis=0)) / size for ideal in (here, there))
    (x, y), flat = u.T, np.concatenate((v[:, 0], v[:, 1]))
    one_, none = np.ones_like(x), np.zeros_like(x)
    if perspective:
        rows_x = [x, y, one_, none, none, none, -x * v[:, 0], -y * v[:, 0]]
        rows_y = [none, none, none, x, y, one_, -x * v[:, 1], -y * v[:, 1]]
    else:
        rows_x, rows_y = [x, one_, none], [y, none, one_]
    design = np.concatenate((np.stack(rows_x, axis=1), np.stack(rows_y, axis=1)))
    rest = flat - design @ np.linalg.lstsq(design, flat, rcond=None)[0]
    return float(np.max(np.hypot(*rest.reshape(2, -1)))) * size


def _unseen(uv: Array, *, perspective: bool) -> Array:
    """Motions of the corrected photo that keep lines straight, shape (n, 2, motions)."""
    x, y = uv.T
    one, none = np.ones_like(x), np.zeros_like(x)
    moved = [(one, none), (none, one), (x, y)]
    if perspective:
        moved += [(y, none), (none, x), (x, none), (x * x, x * y), (x * y, y * y)]
    return np.stack([np.stack(motion, axis=-1) for motion in moved], axis=-1)
