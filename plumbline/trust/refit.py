"""A fit again without some lines, in NumPy.

One Gauss–Newton step says what leaving out a line does as long as it does little. Without a line
that carries most of what is known (a long one among short ones, a dense one among sparse ones) the
lens goes far away, where the picks draw it differently; then the fit is repeated, with exact
derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.derivatives import step_unit, undistorted
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import fit_lines, line_numbers
from plumbline.models import CENTRE
from plumbline.trust.linearised import Linearised, across_stretch

_LARGE = 0.5
"""Standard errors, on average over the coefficients, that leaving out a line moves them by before
it is fitted again: chosen, because the curve of the residuals shows in the second digit there, and
of many lines few do so."""

_ENDED = 0.01
"""Share of the whole move by which the last step moves the fit: chosen, a hundredth of an error."""

_NOTHING = 1e-6
"""Share of a move that is no step any more: chosen."""

_MOST_STEPS = 30
"""Chosen, because steps end after three to eight; what takes more has no minimum nearby."""

_MOST_REFITS = 64
"""The lines that move the fit most: chosen, because with more lines each of them does little."""

_DIFFERENCE, _DIFFERENCE_PX = 1e-5, 1e-2
"""Steps of central differences: what a coefficient changes at the corner, and of the centre."""


@dataclass(frozen=True, eq=False)
class Refit:
    """What fits again.

    Attributes:
        lens: The fitted lens.
        free: Names of the fitted coefficients.
        lines_px: Observed picks of each line.
    """

    lens: Lens
    free: tuple[str, ...]
    lines_px: Sequence[Array]

    def improved(
        self, linear: Linearised, shifts: Array, edges: NDArray[np.int64], sigma_px: float
    ) -> Array:
        """Changes of the coefficients without each edge, refitted where they are large.

        Args:
            linear: The fit, linearised.
            shifts: The changes by one step each, shape (m, k).
            edges: The edge of each line, as the number of its first line, (l,).
            sigma_px: Standard deviation of one pick.
        """
        moved = np.einsum("mi,ij,mj->m", shifts, linear.normal, shifts)
        size = np.sqrt(moved / shifts.shape[1]) / max(sigma_px, 1e-12)
        large = np.argsort(-size)[:_MOST_REFITS]
        found, labels = shifts.copy(), np.unique(edges)
        observed_px = np.concatenate(list(self.lines_px))
        for row in large[size[large] > _LARGE].tolist():
            rest = linear.kept & (edges[linear.line] != labels[row])
            sizes = np.bincount(linear.line[rest])
            picks = _Picks(observed_px[rest], sizes[sizes > 0], linear.image)
            found[row] = self._settled(picks)
        return found

    def _settled(self, picks: _Picks) -> Array:
        """The change with which picks are straightest, by damped Gauss–Newton steps."""
        at = np.zeros(len(self.free))
        square = self._square(picks, at)
        for _ in range(_MOST_STEPS):
            jacobian, residual = self._jacobian(picks, at), self._residual(picks, at)
            if not (np.all(np.isfinite(jacobian)) and np.all(np.isfinite(residual))):
                break
            step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
            if np.linalg.norm(jacobian @ step) <= _ENDED * np.linalg.norm(jacobian @ at):
                return at + step
            least = _NOTHING * (np.abs(at) + np.abs(step))
            while not (reached := self._square(picks, at + step)) <= square:
                step = step / 2
                if np.all(np.abs(step) <= least):
                    return at
            at, square = at + step, reached
        return at

    def _square(self, picks: _Picks, by: Array) -> float:
        return float(np.sum(self._residual(picks, by) ** 2))

    def _residual(self, picks: _Picks, by: Array) -> Array:
        """Distances of picks from their lines; infinite beyond the fold, shape (n,)."""
        changed = dict(self.lens.coefficients)
        for name, value in zip(self.free, by.tolist(), strict=True):
            changed[name] += value
        ideal = undistorted(replace(self.lens, coefficients=changed), picks.observed_px)
        line = line_numbers(picks.sizes)
        lines = fit_lines(ideal.uv, picks.sizes, np.ones(len(line)))
        distance = lines.place(ideal.uv, line)[1]
        if picks.image:
            distance = distance / across_stretch(ideal, lines, line)
        return np.where(np.isfinite(distance), distance, np.inf)

    def _jacobian(self, picks: _Picks, by: Array) -> Array:
        """Derivatives of the distances, whose lines move along, by central differences, (n, k)."""
        columns: list[Array] = []
        for index, name in enumerate(self.free):
            size = _DIFFERENCE_PX if name in CENTRE else _DIFFERENCE / step_unit(self.lens, name)
            move = np.zeros_like(by)
            move[index] = size
            above, below = self._residual(picks, by + move), self._residual(picks, by - move)
            with np.errstate(invalid="ignore"):
                columns.append((above - below) / (2 * size))
        return np.stack(columns, axis=1)


@dataclass(frozen=True, eq=False)
class _Picks:
    """Picks that are fitted again.

    Attributes:
        observed_px: Line after line, shape (n, 2).
        sizes: Number of picks of each line.
        image: Whether distances are measured in the photograph.
    """

    observed_px: Array
    sizes: NDArray[np.int64]
    image: bool
