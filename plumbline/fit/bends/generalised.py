"""Generalised least squares where edges are seen to bend by themselves.

It begins at the ordinary minimum, since from afar it ends elsewhere. Bends and lens are found in
turn: how edges bend from what the lens leaves of them, the lens by Gauss–Newton steps on residuals
that are whitened accordingly. Where bends cannot be told from noise, the ordinary fit stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.fit.bends.restricted import estimated
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import by_line
from plumbline.result.calibration import Calibration
from plumbline.trust.bends import Bends, weighed
from plumbline.trust.covariance import covariance_of, sigma_of
from plumbline.trust.linearised import Linearised, in_frame, linearise

DENSE = 20
"""Samples from which a line shows its own bend: chosen, because hand picks are five to fifteen
and samples of traced edges 32 and more."""

_LEAST_LINES = 3
"""Dense lines below which bends and lens cannot be told apart."""

_FINEST_PX = 0.01
"""σ̂ below which residuals are rounding, or of a lens that was computed and not photographed."""

_NEIGHBOURS = 1.0
"""Standard deviations of the correlation of neighbours from which bends are looked for: chosen, so
that most fits of independent picks need no look; `_CLEAR` decides."""

_CLEAR = 14.0
"""Twice the logarithm of the likelihood that bends must gain: chosen, as χ² of two reaches it once
in 1,000 projects."""

_ROUNDS, _NEAR = 4, 1.0
"""Times that bends and lens are found in turn, and the standard errors that the lens moves by in
the last: restricted likelihood does not see the lens, as far as that is linear."""

_STEPS, _HALVINGS = 12, 6
"""Gauss–Newton steps, and how often one is halved: chosen, from the ordinary minimum three
suffice."""

_SETTLED = 1e-3
"""Change of the lens by a step, in standard errors, at which it has settled: as in `outcome`."""

_SLACK = 0.01
"""Growth of the squares over σ² that is no growth: derivatives do not hold those of the stretch."""


def bending(calibration: Calibration) -> Calibration:
    """The same lens fitted by generalised least squares, where its edges bend by themselves.

    Args:
        calibration: An ordinary fit of lines.

    Returns:
        The calibration with `bends`; the one given where they cannot be told from noise, where
        lines are sparse, or where residuals are measured in the corrected photo.
    """
    counts = np.array([np.count_nonzero(kept) for kept in calibration.kept])
    if (
        calibration.residual != "image"
        or not calibration.free
        or not calibration.converged
        or not is_dense(counts)
        or calibration.sigma_px < _FINEST_PX
    ):
        return calibration
    problem = _Problem.of(calibration)
    linear = problem.at(calibration.lens)
    if _neighbours(linear, counts) < _NEIGHBOURS:
        return calibration
    estimate = estimated(linear)
    if estimate.gain < _CLEAR:
        return calibration
    lens, shape = calibration.lens, (estimate.length, estimate.order)
    bends = Bends(*shape, np.sqrt(estimate.ratios))
    for again in range(_ROUNDS):
        if again:
            bends = Bends(*shape, np.sqrt(estimated(problem.at(lens), shape).ratios))
        settled = problem.settled(lens, bends)
        if settled is None:
            return calibration
        lens, moved = settled
        if moved < _NEAR:
            break
    return problem.finished(calibration, lens, bends)


def is_dense(counts: NDArray[np.int64]) -> bool:
    """Whether lines of so many samples can show how edges bend."""
    return bool(np.count_nonzero(counts >= DENSE) >= _LEAST_LINES)


def _neighbours(linear: Linearised, counts: NDArray[np.int64]) -> float:
    """Correlation of neighbours on dense lines, in its standard deviations.

    Each line's residuals are measured by their own scatter and clipped, so that no stray counts.
    """
    rows = np.flatnonzero(linear.kept & (counts >= DENSE)[linear.line])
    rows = rows[np.lexsort((linear.along_px[rows], linear.line[rows]))]
    line, r = linear.line[rows], linear.image_px[rows]
    usual = np.sqrt(np.bincount(line, r**2, len(counts)) / np.maximum(counts, 1))
    r = np.clip(r / np.maximum(usual[line], 1e-300), -2, 2)
    same = line[1:] == line[:-1]
    products = r[1:][same] * r[:-1][same]
    return float(products.sum() / max(np.sqrt(np.sum(products**2)), 1e-300))


@dataclass(frozen=True, eq=False)
class _Problem:
    """What stays the same while bends and lens are found.

    Attributes:
        lines_px: Picks of each line.
        free: Names of the free coefficients.
        kept: Which picks count, (n,).
        dof: Degrees of freedom.
    """

    lines_px: list[Array]
    free: tuple[str, ...]
    kept: NDArray[np.bool_]
    dof: int

    @staticmethod
    def of(calibration: Calibration) -> _Problem:
        return _Problem(
            in_frame(calibration.observations, calibration.lens.frame),
            calibration.free,
            np.concatenate(calibration.kept),
            calibration.dof,
        )

    def at(self, lens: Lens) -> Linearised:
        """The residuals at a lens, and how they change."""
        return linearise(lens, self.lines_px, self.free, self.kept, image=True)

    def settled(self, lens: Lens, bends: Bends) -> tuple[Lens, float] | None:
        """The lens of least whitened residuals, and how far it moved, in standard errors.

        Args:
            lens: Where to begin.
            bends: With τ in units of σ.

        Returns:
            None where it does not settle.
        """
        linear, total = weighed(self.at(lens), bends, 1.0), 0.0
        for _ in range(_STEPS):
            rows = linear.kept
            jacobian, residual = linear.jacobian[rows], linear.residual_px[rows]
            step: Array = -np.linalg.pinv(jacobian) @ residual
            sigma_px = sigma_of(linear, self.dof)
            size = float(np.linalg.norm(jacobian @ step)) / sigma_px
            allowed = _SLACK * sigma_px**2
            square = float(residual @ residual)
            for _ in range(_HALVINGS):
                moved = _moved(lens, self.free, step)
                then = weighed(self.at(moved), bends, 1.0)
                left = then.residual_px[then.kept]
                if np.array_equal(then.kept, linear.kept) and left @ left < square + allowed:
                    break
                step, size = step / 2, size / 2
            else:
                return None
            lens, linear, total = moved, then, total + size
            if size < _SETTLED:
                return lens, total
        return None

    def finished(self, calibration: Calibration, lens: Lens, bends: Bends) -> Calibration:
        """The calibration with what was found; `bends` with τ in units of σ."""
        linear = self.at(lens)
        covariance, sigma_px = covariance_of(weighed(linear, bends, 1.0), self.dof)
        corrected_px = linear.image_px[linear.kept] * linear.stretch[linear.kept]
        return replace(
            calibration,
            lens=lens,
            covariance=covariance,
            sigma_px=sigma_px,
            residuals_px=by_line(linear.residual_px, calibration.observations.sizes),
            rms_corrected_px=float(np.sqrt(np.mean(corrected_px**2))),
            bends=replace(bends, tau_px=bends.tau_px * sigma_px),
        )


def _moved(lens: Lens, free: tuple[str, ...], step: Array) -> Lens:
    values = {n: lens.coefficients[n] + s for n, s in zip(free, step.tolist(), strict=True)}
    return replace(lens, coefficients={**lens.coefficients, **values})
