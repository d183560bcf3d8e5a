"""How far one fit can be trusted: every judgement of it, computed when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.geometry.finding import Finding, find
from plumbline.geometry.lens import Lens
from plumbline.observations import Observations
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.displacement import Displacement, displacement_errors, grid_px
from plumbline.trust.jackknife import Jackknife, jackknife
from plumbline.trust.linearised import Linearised, in_frame, linearise
from plumbline.trust.model_error import ModelError, model_error
from plumbline.trust.suspect import Suspect

ResidualKind = Literal["image", "corrected"]


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
        return find(self.lens)

    @cached_property
    def linearised(self) -> Linearised:
        """Residuals and their derivatives, from which all that follows is computed."""
        return linearise(
            self.lens,
            in_frame(self.observations, self.lens.frame),
            self.free,
            np.concatenate(self.kept),
            image=self.residual == "image",
            richer=self.lens.model.richer(self.free),
        )

    @cached_property
    def jackknife(self) -> Jackknife | None:
        """How much the result depends on each line; None where it needs one of them."""
        return jackknife(self.linearised)

    @cached_property
    def model_error(self) -> ModelError | None:
        """How far a richer model would move the correction."""
        return model_error(self.lens, self.free, self.linearised, self.sigma_px)

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

    @property
    def quotes_jackknife(self) -> bool:
        """Whether the jackknife's error is the one to quote: it is the larger."""
        if self.displacement is None or self.jackknife_displacement is None:
            return False
        return self.jackknife_displacement.worst_px > self.displacement.worst_px

    @property
    def quoted_displacement(self) -> Displacement | None:
        """Standard errors of the correction to quote."""
        return self.jackknife_displacement if self.quotes_jackknife else self.displacement

    @cached_property
    def bootstrap_displacement(self) -> Displacement | None:
        """The same from the bootstrap."""
        return None if self.bootstrap is None else self._displacement(self.bootstrap.covariance)

    def _displacement(self, covariance: Array) -> Displacement | None:
        points_px = grid_px(self.lens)
        errors_px = displacement_errors(self.lens, self.free, covariance, points_px)
        return None if errors_px is None else Displacement(points_px, errors_px)
