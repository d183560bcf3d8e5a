"""How far one fit can be trusted: every judgement of it, computed when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.finding import Finding, finding_of
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.trust.bends import Bends, weighed
from plumbline.trust.besides import Besides
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.clusters import clusters_of
from plumbline.trust.displacement import (
    Displacement,
    displacement_errors,
    errors_of,
    grid_px,
    motions,
)
from plumbline.trust.edges import edges_of
from plumbline.trust.jackknife import Jackknife, jackknife
from plumbline.trust.linearised import Linearised, in_frame, linearise
from plumbline.trust.model_error import ModelError, model_error
from plumbline.trust.nuisances import DECENTRING, RADIAL, Nuisances, nuisances_of
from plumbline.trust.picked import picked_range_px, reached_share
from plumbline.trust.quoted import Quoted
from plumbline.trust.refit import Refit
from plumbline.trust.steadiness import Steadiness, steadiness
from plumbline.trust.student import quantile, widening
from plumbline.trust.suspect import Suspect

ResidualKind = Literal["image", "corrected"]

_MANY = 10**6
"""Degrees of freedom of the normal distribution, as far as anyone can tell."""


@dataclass(frozen=True, eq=False)
class Assessment:
    """What a fit is judged by.

    Attributes:
        observations: What was fitted to.
        lens: The fitted lens.
        free: Names of the fitted coefficients.
        residual: Which residual was minimised.
        covariance: Of the free coefficients, shape (k, k); `d`, `e` in pixels.
        sigma_px: Estimated standard deviation of one pick across its line.
        kept: Which picks of each line were fitted.
        suspects: Picks that a robust fit finds wrong.
        robust: Whether suspicious picks were left out.
        bootstrap: Repeated fits to resampled residuals, where they were asked for.
        rival_px: How far another lens, under which the picks agree as well, is from this one.
        bends: How edges bend by themselves, where that is told from noise.
    """

    observations: Observations
    lens: Lens
    free: tuple[str, ...]
    residual: ResidualKind
    covariance: Array
    sigma_px: float
    kept: tuple[NDArray[np.bool_], ...]
    suspects: tuple[Suspect, ...]
    robust: bool
    bootstrap: Bootstrap | None
    rival_px: float | None
    bends: Bends | None

    @property
    def standard_errors(self) -> dict[str, float]:
        """One standard deviation of each free coefficient."""
        deviations = np.sqrt(np.diag(self.covariance))
        return {name: float(value) for name, value in zip(self.free, deviations, strict=True)}

    @cached_property
    def correlation(self) -> Array:
        """Correlations of the free coefficients, in the order of `free`; 0 where exact."""
        deviations = np.sqrt(np.diag(self.covariance))
        scale = np.outer(deviations, deviations)
        return np.divide(self.covariance, scale, out=np.zeros_like(scale), where=scale > 0)

    @cached_property
    def finding(self) -> Finding:
        """The distortion in a nutshell."""
        return finding_of(self.lens)

    @cached_property
    def linearised(self) -> Linearised:
        """Residuals and their derivatives, pick by pick."""
        return linearise(
            self.lens,
            in_frame(self.observations, self.lens.frame),
            self.free,
            np.concatenate(self.kept),
            image=self.residual == "image",
            richer=self.lens.model.richer(self.free),
            nuisances=self.nuisances,
        )

    @cached_property
    def weighed(self) -> Linearised:
        """The same as if picks erred independently, from which all that follows is computed."""
        if self.bends is None:
            return self.linearised
        return weighed(self.linearised, self.bends, self.sigma_px)

    @cached_property
    def nuisances(self) -> Nuisances:
        """What else the lens may do."""
        return nuisances_of(self.lens, self.free)

    @cached_property
    def dof(self) -> int:
        """Degrees of freedom: points − 2 · lines − free coefficients."""
        kept = [int(np.count_nonzero(each)) for each in self.kept]
        return max(sum(kept) - 2 * sum(n > 0 for n in kept) - len(self.free), 1)

    @cached_property
    def range_px(self) -> Array:
        """Points of the photo within the range of the picks, shape (n, 2)."""
        return picked_range_px(self.lens, self.observations, np.concatenate(self.kept))

    @cached_property
    def reached(self) -> float:
        """How far out the picks reach, as a share of the way to the corner."""
        return reached_share(self.lens, self.observations, np.concatenate(self.kept))

    @cached_property
    def jackknife(self) -> Jackknife | None:
        """How much the result depends on each line; None where it needs one of them."""
        if self.bends is not None:
            return jackknife(self.weighed, self.together)
        lines_px = in_frame(self.observations, self.lens.frame)
        refit = Refit(self.lens, self.free, lines_px)
        return jackknife(self.linearised, self.edges, refit, self.sigma_px)

    @cached_property
    def edges(self) -> NDArray[np.int64]:
        """The edge of each line, as the number of the first line along it, shape (l,)."""
        return edges_of(self.lens, self.observations, self.sigma_px)

    @cached_property
    def together(self) -> NDArray[np.int64]:
        """The lines that a jackknife leaves out together, as the number of the first, shape (l,).

        Those along one edge; where edges bend, also parallel neighbours, which may share a bend.
        """
        if self.bends is None:
            return self.edges
        return clusters_of(self.lens, self.observations)

    @cached_property
    def model_error(self) -> ModelError | None:
        """How far a richer model would move the correction."""
        return model_error(self.lens, self.free, self.weighed, self.sigma_px)

    @cached_property
    def displacement(self) -> Displacement | None:
        """Standard errors of the correction over the photo, for independent picking errors.

        After the best common scale and translation, see `plumbline.trust.displacement`; None
        where the model folds inside the photo.
        """
        return self._displacement(self.covariance)

    @cached_property
    def jackknife_displacement(self) -> Displacement | None:
        """The same from the jackknife."""
        return None if self.jackknife is None else self._displacement(self.jackknife.covariance)

    @cached_property
    def steadiness(self) -> Steadiness | None:
        """The jackknife against what chance would make of it; None where there is none."""
        own, wide = self._in_range(self.covariance), self._jackknife_in_range
        if self._moved is None or own is None or wide is None:
            return None
        k = len(self.free)
        return steadiness(
            self.weighed,
            self.together,
            self._moved[..., :k],
            float(np.max(own)),
            float(np.max(wide)),
            self.dof,
        )

    @property
    def quotes_jackknife(self) -> bool:
        """Whether the jackknife is larger than what independent errors make within the range."""
        return self.steadiness is not None and self.steadiness.ratio > 1.0

    @cached_property
    def besides(self) -> Besides:
        """What the lens may do besides the fitted model, and what the picks say of that."""
        return Besides(self.weighed, self.nuisances, self.dof, self._moved, self.steadiness)

    @cached_property
    def quoted(self) -> Quoted | None:
        """The error to quote; None where the model folds within the range of the picks."""
        moved, k = self._moved, len(self.free)
        if moved is None or "" not in self.besides.steps:
            return None
        missed = {
            name: step.missed_px(moved[..., np.concatenate((np.ones(k, dtype=np.bool_), which))])
            for name, (step, which) in self.besides.steps.items()
        }
        picks_px = self._picks_px(moved)
        total_px = np.hypot(picks_px, missed[""])
        worst, none = int(np.argmax(total_px)), np.zeros(len(total_px))
        flat = self._motions(self.range_px, perspective=True)
        return Quoted(
            Displacement(self.range_px, total_px),
            float(picks_px[worst]),
            float(missed[""][worst]),
            float(missed.get(DECENTRING, none)[worst]),
            float(missed.get(RADIAL, none)[worst]),
            None if flat is None else self._worst_px(flat),
            self.reached,
        )

    def quoted_errors_px(self, points_px: Array) -> Array | None:
        """The error to quote at any points of the photo, one standard error, shape (n,).

        Args:
            points_px: Observed points, shape (n, 2).

        Returns:
            None where the model folds before it reaches one of them, or among the picks.
        """
        moved = self._motions(points_px, perspective=None)
        if moved is None or self.quoted is None:
            return None
        return np.hypot(self._picks_px(moved), self.besides.steps[""][0].missed_px(moved))

    @property
    def interval_factor(self) -> float:
        """Standard errors to quote in a 95 % interval; they are widened for their freedom."""
        return quantile(0.975, _MANY)

    @property
    def quoted_displacement(self) -> Displacement | None:
        """Standard errors of the correction to quote."""
        return None if self.quoted is None else self.quoted.total

    @cached_property
    def _moved(self) -> Array | None:
        """How points within the range move with coefficients and nuisances, (n, 2, k + m)."""
        return self._motions(self.range_px, perspective=None)

    def _motions(self, points_px: Array, *, perspective: bool | None) -> Array | None:
        return motions(
            self.lens,
            self.free,
            points_px,
            gauge_px=self.range_px,
            nuisances=self.nuisances,
            perspective=perspective,
        )

    def _in_range(self, covariance: Array) -> Array | None:
        moved = self._moved
        return None if moved is None else errors_of(moved[..., : len(self.free)], covariance)

    @cached_property
    def _jackknife_in_range(self) -> Array | None:
        return None if self.jackknife is None else self._in_range(self.jackknife.covariance)

    def _picks_px(self, moved: Array) -> Array:
        """What the errors of the picks make of points that move so, widened to be quoted, (n,)."""
        own = errors_of(moved[..., : len(self.free)], self.covariance)
        if self.jackknife is None or self.steadiness is None:
            return own * widening(self.dof)
        wide = errors_of(moved[..., : len(self.free)], self.jackknife.covariance)
        wrong = self.besides.unlike(RADIAL) or self.besides.unlike(DECENTRING)
        by_lines = self.steadiness.alarmed and not wrong
        pooled = self.steadiness.pooled(own, wide, by_lines=by_lines)
        return np.maximum(own * widening(self.dof), pooled)

    def _worst_px(self, moved: Array) -> float:
        """The largest error to quote of points that move so."""
        missed_px = self.besides.steps[""][0].missed_px(moved)
        return float(np.max(np.hypot(self._picks_px(moved), missed_px)))

    @cached_property
    def bootstrap_displacement(self) -> Displacement | None:
        """The same from the bootstrap."""
        return None if self.bootstrap is None else self._displacement(self.bootstrap.covariance)

    def _displacement(self, covariance: Array) -> Displacement | None:
        points_px = grid_px(self.lens)
        errors_px = displacement_errors(self.lens, self.free, covariance, points_px)
        return None if errors_px is None else Displacement(points_px, errors_px)
