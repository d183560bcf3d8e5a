"""The result of a fit, and its JSON, which embeds the observations it came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from plumbline.displacement import displacement_errors, grid_px
from plumbline.errors import UnsettledError
from plumbline.finding import Finding, find
from plumbline.frame import Array
from plumbline.lens import Lens
from plumbline.notes import after_fit
from plumbline.observations import Observations
from plumbline.straightness import straightness_before

ResidualKind = Literal["image", "corrected"]


class LineStraightness(NamedTuple):
    """How straight one line is, before and after; all in pixels.

    Attributes:
        label: The line's name.
        photo: Index of its photo.
        n_points: Number of its points.
        rms_before_px: Root mean square distance of the observed points from a line.
        rms_after_px: The same of the fit's residuals.
        largest_after_px: The largest residual, without its sign.
    """

    label: str
    photo: int
    n_points: int
    rms_before_px: float
    rms_after_px: float
    largest_after_px: float


@dataclass(frozen=True, eq=False)
class Calibration:
    """A fitted lens and how far to trust it.

    Attributes:
        observations: What it was fitted to: the photos and lines of one lens.
        lens: The fitted model; maps points both ways.
        free: Names of the coefficients that were fitted.
        start: Start values of the free and values of the held coefficients; where the fit
            began from nothing, free ones are 0.
        residual: Which residual was minimised.
        covariance: Of the free coefficients in the order of `free`; `d`, `e` in pixels.
        sigma_px: Estimated standard deviation of one pick across its line, σ̂.
        dof: Degrees of freedom: points − 2 · lines − free coefficients.
        residuals_px: Signed residuals, one array for each line.
        rms_corrected_px: Root mean square distance in the corrected photo, as Hugin has it.
        converged: Whether the fit ended in a minimum.
        reason: Why it ended, in a sentence.
        remarks: What was decided for the user before the fit, in plain sentences.
    """

    observations: Observations
    lens: Lens
    free: tuple[str, ...]
    start: Mapping[str, float]
    residual: ResidualKind
    covariance: Array
    sigma_px: float
    dof: int
    residuals_px: tuple[Array, ...]
    rms_corrected_px: float
    converged: bool
    reason: str
    remarks: tuple[str, ...] = ()

    @property
    def model(self) -> str:
        """Name of the distortion model."""
        return self.lens.model.label

    @property
    def coefficients(self) -> dict[str, float]:
        """All coefficients, held ones and the distortion centre `d`, `e` included."""
        return dict(self.lens.coefficients)

    @property
    def standard_errors(self) -> dict[str, float]:
        """One standard deviation of each free coefficient."""
        deviations = np.sqrt(np.diag(self.covariance))
        return {name: float(value) for name, value in zip(self.free, deviations, strict=True)}

    @property
    def held(self) -> dict[str, float]:
        """The coefficients that were not fitted, and their values."""
        return {n: v for n, v in self.lens.coefficients.items() if n not in self.free}

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What the user should know, in plain sentences."""
        return (*self.observations.notes, *self.remarks, *after_fit(self))

    @cached_property
    def before_px(self) -> tuple[Array, ...]:
        """Signed distances of every line's observed points from a straight line."""
        return straightness_before(self.observations)

    @cached_property
    def correlation(self) -> Array:
        """Correlations of the free coefficients, in the order of `free`; 0 where exact."""
        deviations = np.sqrt(np.diag(self.covariance))
        scale = np.outer(deviations, deviations)
        return np.divide(self.covariance, scale, out=np.zeros_like(scale), where=scale > 0)

    @property
    def rms_before_px(self) -> float:
        """Root mean square distance of the observed points from straight lines."""
        return rms(self.before_px)

    @property
    def rms_after_px(self) -> float:
        """Root mean square residual."""
        return rms(self.residuals_px)

    @property
    def largest_before_px(self) -> float:
        """Largest distance of an observed point from its straight line."""
        return largest(self.before_px)

    @property
    def largest_after_px(self) -> float:
        """Largest residual, without its sign."""
        return largest(self.residuals_px)

    @cached_property
    def finding(self) -> Finding:
        """The distortion in a nutshell."""
        return find(self.lens)

    @cached_property
    def corner_error_px(self) -> float | None:
        """Standard error of the correction at the photo's worst corner.

        After the best common scale and translation, see `plumbline.displacement`; None where the
        model folds before the corner.
        """
        points = grid_px(self.lens)
        errors = displacement_errors(self.lens, self.free, self.covariance, points)
        if errors is None:
            return None
        corners = [0, int(np.sqrt(len(points))) - 1]
        return float(np.max(errors[[*corners, *(len(points) - 1 - i for i in corners)]]))

    @property
    def lines(self) -> tuple[LineStraightness, ...]:
        """Straightness of every line."""
        return tuple(
            LineStraightness(
                line.label, line.photo, len(after), rms([before]), rms([after]), largest([after])
            )
            for line, before, after in zip(
                self.observations.lines, self.before_px, self.residuals_px, strict=True
            )
        )


def refuse_unsettled(calibrations: Sequence[Calibration]) -> None:
    """Refuse fits that did not reach a minimum.

    Raises:
        UnsettledError: there is one; the sentence names its worst line.
    """
    for made in calibrations:
        if made.converged:
            continue
        worst = max(made.lines, key=lambda line: line.rms_after_px)
        raise UnsettledError(
            f"{made.observations.named}there is no result: {made.reason}; line {worst.label} is "
            f"farthest from straight, by {worst.rms_after_px:.3g} px (rms)",
            hint="check that every pick is on its line and that the photo's size (and --grid) is "
            "right",
        )


def rms(arrays: Sequence[Array]) -> float:
    """Root mean square over all arrays."""
    total = sum(float(values @ values) for values in arrays)
    return float(np.sqrt(total / sum(len(values) for values in arrays)))


def largest(arrays: Sequence[Array]) -> float:
    """Largest absolute value over all arrays."""
    return max(float(np.max(np.abs(values))) for values in arrays)
