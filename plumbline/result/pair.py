"""The result of a fit to an original and a corrected picture: a calibration from matches.

Its observations hold, as one "line" each, the matches of one part of the photo: observed points
and, as `Line.corrected_px`, where the corrected picture shows them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbline.frame import Array
from plumbline.observations import Observations
from plumbline.result.calibration import Calibration
from plumbline.trust.assessment import Assessment
from plumbline.trust.check import Check
from plumbline.trust.displacement import Displacement, displacement_errors
from plumbline.trust.jackknife import Jackknife
from plumbline.trust.matched import Setting, jackknife, residual_px
from plumbline.trust.matched_checks import checks_of_matches
from plumbline.trust.model_error import ModelError
from plumbline.trust.quoted import Quoted
from plumbline.trust.steadiness import Steadiness
from plumbline.trust.straightness import LineStraightness
from plumbline.trust.student import quantile


def observed_px(observations: Observations) -> Array:
    """Matches in the original, part after part, shape (n, 2)."""
    return np.concatenate([line.points_px for line in observations.lines])


def corrected_px(observations: Observations) -> Array:
    """The same matches in the corrected picture, shape (n, 2)."""
    every = [line.corrected_px for line in observations.lines]
    return np.concatenate([points for points in every if points is not None])


@dataclass(frozen=True, eq=False)
class PairAssessment(Assessment):
    """What a fit to matches is judged by.

    Attributes:
        setting: The lens, scale and place that were fitted.
    """

    setting: Setting

    @cached_property
    def jackknife(self) -> Jackknife | None:
        """How much the result depends on each part of the photo."""
        kept = np.concatenate(self.kept)
        part = np.repeat(np.arange(len(self.kept)), [len(each) for each in self.kept])[kept]
        return jackknife(
            self.setting,
            self.free,
            observed_px(self.observations)[kept],
            corrected_px(self.observations)[kept],
            part,
        )

    @cached_property
    def model_error(self) -> ModelError | None:
        """Not known: the residuals over the radius show whether the model follows the pair."""
        return None

    @cached_property
    def steadiness(self) -> Steadiness | None:
        """Not known: it is drawn for lines."""
        return None

    @property
    def quotes_jackknife(self) -> bool:
        """Whether leaving out parts says more than independent errors of the matches."""
        own, wide = self.displacement, self.jackknife_displacement
        return own is not None and wide is not None and wide.worst_px > own.worst_px

    @cached_property
    def quoted(self) -> Quoted | None:
        """Not known: what the lens may do besides is asked of lines."""
        return None

    def quoted_errors_px(self, points_px: Array) -> Array | None:
        """The same at any points."""
        left, covariance = self.jackknife, self.covariance
        if self.quotes_jackknife and left is not None:
            covariance = left.covariance
        return displacement_errors(self.lens, self.free, covariance, points_px)

    @property
    def interval_factor(self) -> float:
        """Student's t for the degrees of freedom of the error to quote."""
        left = self.jackknife
        return quantile(0.975, left.dof if self.quotes_jackknife and left else self.dof)

    @property
    def quoted_displacement(self) -> Displacement | None:
        """The larger of the errors for independent matches and of the jackknife's."""
        return self.jackknife_displacement if self.quotes_jackknife else self.displacement


@dataclass(frozen=True, eq=False, kw_only=True)
class PairCalibration(Calibration):
    """A calibration whose observations are pairs of points.

    `residuals_px` are distances of matches from where the lens puts them, `sigma_px` is the
    scatter of a match along x or y, and `dof` is 2 · matches − free coefficients − 3.

    Attributes:
        scale: Pixels of the corrected picture to one of the original.
        place_px: Where the corrected picture shows the original's centre.
    """

    scale: float
    place_px: tuple[float, float]

    @property
    def setting(self) -> Setting:
        """Lens, scale and place together."""
        return Setting(self.lens, self.scale, self.place_px)

    @cached_property
    def trust(self) -> PairAssessment:
        """How far to trust it."""
        return PairAssessment(
            self.observations,
            self.lens,
            self.free,
            self.residual,
            self.covariance,
            self.sigma_px,
            self.kept,
            self.suspects,
            self.robust,
            self.bootstrap,
            self.rival_px,
            self.bends,
            self.setting,
        )

    @cached_property
    def vectors_px(self) -> Array:
        """Matched minus predicted points in the original, part after part, shape (n, 2)."""
        return residual_px(
            self.setting, observed_px(self.observations), corrected_px(self.observations)
        )

    @cached_property
    def before_px(self) -> tuple[Array, ...]:
        """Distances of the matches from the best scale and shift without any lens."""
        seen, other = observed_px(self.observations), corrected_px(self.observations)
        kept = np.concatenate(self.kept)
        (x, y), n = other.T, len(other)
        one, none = np.ones(n), np.zeros(n)
        rows = np.stack([np.stack([x, one, none], 1), np.stack([y, none, one], 1)], axis=1)
        best = np.linalg.lstsq(rows[kept].reshape(-1, 3), seen[kept].ravel(), rcond=None)[0]
        distance = np.linalg.norm(seen - rows @ best, axis=1)
        return tuple(np.split(distance, np.cumsum([len(each) for each in self.kept])[:-1]))

    @property
    def _straight(self) -> tuple[LineStraightness, ...]:
        """Parts of a photo are not lines that could be crooked."""
        return ()

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether the matches are well placed and the result is to be trusted."""
        kept = np.concatenate(self.kept)
        return checks_of_matches(self.trust, observed_px(self.observations)[kept])
