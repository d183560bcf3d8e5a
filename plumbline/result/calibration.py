"""The result of a fit, and its JSON, which embeds the observations it came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from plumbline._version import __version__
from plumbline.frame import Array
from plumbline.geometry.finding import Finding
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.result.notes import notes_on
from plumbline.trust.assessment import Assessment, ResidualKind
from plumbline.trust.bends import Bends
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.check import Check
from plumbline.trust.displacement import Displacement
from plumbline.trust.jackknife import Jackknife
from plumbline.trust.linearised import Linearised
from plumbline.trust.model_error import ModelError
from plumbline.trust.placement import before_fit
from plumbline.trust.quoted import Quoted
from plumbline.trust.straightness import (
    LineStraightness,
    largest,
    line_by_line,
    rms,
    straightness_before,
)
from plumbline.trust.student import quantile
from plumbline.trust.suspect import Suspect
from plumbline.trust.verdicts import after_fit, doubt

if TYPE_CHECKING:
    from plumbline.report.notebook import Plots


@dataclass(frozen=True, eq=False, repr=False)
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
        sigma_px: Estimated standard deviation of one pick across its line, σ̂; the bends of edges
            are not in it where they are told apart.
        dof: Degrees of freedom: points − 2 · lines − free coefficients.
        residuals_px: Signed residuals, one array for each line; those of picks left out are their
            distances from the line through the others, or through all of a line left out as a
            whole, and infinite beyond the fold of the model.
        rms_corrected_px: Root mean square distance in the corrected photo, as Hugin has it.
        converged: Whether the fit ended in a minimum.
        reason: Why it ended, in a sentence.
        remarks: What was decided for the user before the fit, in plain sentences.
        kept: Which picks of each line were fitted; all, but for a robust fit.
        suspects: Picks that a robust fit finds wrong; a plain fit names them and uses them.
        robust: Whether suspicious picks were left out.
        bootstrap: Repeated fits to resampled residuals, where they were asked for.
        rival_px: How far another lens, under which the picks agree as well, is from this one; None
            where there is none.
        bends: How edges bend by themselves; None where that cannot be told from noise, and the
            fit is an ordinary one.
        command: The command line that made it; empty in Python.
        version: The version of plumbline that made it.
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
    kept: tuple[NDArray[np.bool_], ...] = ()
    suspects: tuple[Suspect, ...] = ()
    robust: bool = False
    bootstrap: Bootstrap | None = None
    rival_px: float | None = None
    bends: Bends | None = None
    command: str = ""
    version: str = __version__

    def __post_init__(self) -> None:
        if len(self.kept) != len(self.residuals_px):
            every = tuple(np.ones(len(values), dtype=np.bool_) for values in self.residuals_px)
            object.__setattr__(self, "kept", every)

    def __repr__(self) -> str:
        """In one line what was found."""
        values = ", ".join(f"{name} = {self.coefficients[name]:.6g}" for name in self.free)
        state = f"{self.rms_after_px:.3g} px rms" if self.converged else "not converged"
        return f"<Calibration: {self.model} {values or 'held'}; {state}; {self.observations!r}>"

    def _repr_html_(self) -> str:
        """The finding and the coefficients, for a notebook."""
        from plumbline.report.notebook import html_of

        return html_of(self)

    @property
    def plot(self) -> Plots:
        """Its figures, as in `calibration.plot.curve()`."""
        from plumbline.report.notebook import Plots

        return Plots(self)

    @property
    def model(self) -> str:
        """Name of the distortion model."""
        return self.lens.model.label

    @property
    def coefficients(self) -> dict[str, float]:
        """All coefficients, held ones and the distortion centre `d`, `e` included."""
        return dict(self.lens.coefficients)

    @cached_property
    def trust(self) -> Assessment:
        """How far to trust it."""
        return Assessment(
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
        )

    @property
    def standard_errors(self) -> dict[str, float]:
        """One standard deviation of each free coefficient."""
        return self.trust.standard_errors

    @property
    def held(self) -> dict[str, float]:
        """The coefficients that were not fitted, and their values."""
        return {n: v for n, v in self.lens.coefficients.items() if n not in self.free}

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What the user should know, in plain sentences."""
        unsettled = "" if self.converged else self.reason
        return (
            *self.observations.notes,
            *self.remarks,
            *notes_on(self.trust, self.checks, self._straight, unsettled),
        )

    @property
    def kept_observations(self) -> Observations:
        """The observations without the picks that were left out, and lines too short then."""
        if all(map(np.all, self.kept)):
            return self.observations
        fewer = [
            replace(line, points_px=line.points_px[kept], rows=None)
            for line, kept in zip(self.observations.lines, self.kept, strict=True)
            if np.count_nonzero(kept) >= 3
        ]
        return replace(self.observations, lines=tuple(fewer))

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % intervals of the free coefficients (Student's t)."""
        reach = quantile(0.975, self.dof)
        return {
            name: (self.coefficients[name] - reach * error, self.coefficients[name] + reach * error)
            for name, error in self.standard_errors.items()
        }

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether the lines are well placed and the result is to be trusted."""
        radial = [name for name in self.free if name in self.lens.model.radial]
        before = before_fit(self.kept_observations, len(self.free), len(radial))
        return (*before, *after_fit(self.trust))

    @cached_property
    def before_px(self) -> tuple[Array, ...]:
        """Signed distances of every line's observed points from a straight line."""
        return straightness_before(self.observations, self.kept)

    @property
    def correlation(self) -> Array:
        """Correlations of the free coefficients, in the order of `free`; 0 where exact."""
        return self.trust.correlation

    @property
    def rms_before_px(self) -> float:
        """Root mean square distance of the observed points from straight lines."""
        return rms(self._fitted(self.before_px))

    @property
    def rms_after_px(self) -> float:
        """Root mean square residual."""
        return rms(self._fitted(self.residuals_px))

    @property
    def largest_before_px(self) -> float:
        """Largest distance of an observed point from its straight line."""
        return largest(self._fitted(self.before_px))

    @property
    def largest_after_px(self) -> float:
        """Largest residual, without its sign."""
        return largest(self._fitted(self.residuals_px))

    @property
    def finding(self) -> Finding:
        """The distortion in a nutshell."""
        return self.trust.finding

    @property
    def jackknife(self) -> Jackknife | None:
        """How much the result depends on each line; None where it needs one of them."""
        return self.trust.jackknife

    @property
    def model_error(self) -> ModelError | None:
        """How far a richer model would move the correction."""
        return self.trust.model_error

    @property
    def displacement(self) -> Displacement | None:
        """Standard errors of the correction over the photo, for independent picking errors."""
        return self.trust.displacement

    @property
    def jackknife_displacement(self) -> Displacement | None:
        """Standard errors of the correction over the photo, from the jackknife."""
        return self.trust.jackknife_displacement

    @property
    def bootstrap_displacement(self) -> Displacement | None:
        """Standard errors of the correction over the photo, from the bootstrap."""
        return self.trust.bootstrap_displacement

    @property
    def quoted_displacement(self) -> Displacement | None:
        """Standard errors of the correction to quote."""
        return self.trust.quoted_displacement

    @property
    def quoted(self) -> Quoted | None:
        """The one error to quote, with its parts; None where the model folds among the picks."""
        return self.trust.quoted

    @cached_property
    def doubt(self) -> str:
        """Why the fitted model is not to be trusted; empty where nothing speaks against it."""
        return doubt(self.trust)

    @property
    def quotes_jackknife(self) -> bool:
        """Whether the jackknife is larger than what independent errors make."""
        return self.trust.quotes_jackknife

    @property
    def linearised(self) -> Linearised:
        """Residuals and their derivatives at the result."""
        return self.trust.linearised

    @cached_property
    def lines(self) -> tuple[LineStraightness, ...]:
        """Straightness of every line; one left out as a whole is measured nevertheless."""
        noise_px = None if self.bends is None else self.sigma_px
        return line_by_line(
            self.observations, self.before_px, self.residuals_px, self.kept, noise_px
        )

    @property
    def _straight(self) -> tuple[LineStraightness, ...]:
        """What notes judge lines by."""
        return self.lines

    def _fitted(self, values: Sequence[Array]) -> list[Array]:
        """The values of the picks that were fitted."""
        return [np.concatenate(values)[np.concatenate(self.kept)]]
