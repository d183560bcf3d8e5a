"""What a lens may do besides the fitted model, and what the picks of one fit say of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array
from plumbline.trust.linearised import Linearised
from plumbline.trust.missed import Step, is_clear, nuisance_step, steps_of
from plumbline.trust.nuisances import Nuisances
from plumbline.trust.steadiness import Steadiness

_MATTERS_PX = 0.1
"""What less than this moves nobody can pick: chosen, as for the choice of a model."""

_LIKE_OTHERS = 3.5
"""Standard deviations within which good picks lie: chosen, one in 2,000 lies farther out."""


@dataclass(frozen=True, eq=False)
class Besides:
    """One fit and its nuisances.

    Attributes:
        linear: The fit, linearised, nuisances among the columns.
        nuisances: What else the lens may do.
        dof: Degrees of freedom of the fit.
        moved: How points within the range of the picks move with coefficients and nuisances,
            shape (n, 2, k + m); None where the model folds there.
        steady: The jackknife against chance; None where there is none.
    """

    linear: Linearised
    nuisances: Nuisances
    dof: int
    moved: Array | None
    steady: Steadiness | None

    @cached_property
    def steps(self) -> dict[str, tuple[Step, NDArray[np.bool_]]]:
        """The fit with nuisances: with all of them (under ""), and with each group."""
        steady = self.steady
        widened = max(steady.ratio, 1.0) if steady is not None and steady.alarmed else 1.0
        return steps_of(self.linear, self.nuisances, self.dof, widened)

    @cached_property
    def centre_step(self) -> Step | None:
        """The fit with the distortion centre free as well; None where it is free already."""
        which = np.arange(len(self.nuisances.groups)) < len(self.nuisances.centre)
        return nuisance_step(self.linear, self.dof, which, 1.0) if which.any() else None

    def unlike(self, group: str) -> bool:
        """Whether the picks say clearly that the lens has such nuisances, and that they matter.

        Args:
            group: `DECENTRING` or `RADIAL`.
        """
        if group not in self.alone or self.moved is None:
            return False
        step, which = self.alone[group]
        columns = np.concatenate((np.ones(step.n_free, dtype=np.bool_), which))
        moved = np.einsum("nik,k->ni", self.moved[..., columns], step.change)
        clear = self.steady is not None and is_clear(step, self.steady.dof)
        return clear and float(np.max(np.hypot(*moved.T))) > _MATTERS_PX

    def explains(self, accused: NDArray[np.bool_], sigma_px: float) -> bool:
        """Whether a lens with nuisances leaves accused picks where the others are.

        Args:
            accused: Which picks are called wrong under the fitted model, line after line, (n,).
            sigma_px: σ̂ of the fit without them, which is at least that of a model that is right.
        """
        step = self.alone[""][0] if "" in self.alone else None
        linear, others = self.linear, ~accused
        if step is None or not np.all(linear.kept) or np.count_nonzero(others) <= self.dof // 2:
            return False
        columns = np.concatenate((linear.jacobian, linear.besides), axis=1)
        left_px = linear.image_px + (columns * linear.in_photo[:, None]) @ step.change
        share = self.dof / len(left_px)
        sigma_px = min(sigma_px, float(np.sqrt(np.mean(left_px[others] ** 2) / share)))
        return bool(np.max(np.abs(left_px[accused])) < _LIKE_OTHERS * sigma_px)

    @cached_property
    def alone(self) -> dict[str, tuple[Step, NDArray[np.bool_]]]:
        """The steps where picks err independently: lines err as a whole under a wrong model."""
        return steps_of(self.linear, self.nuisances, self.dof, 1.0)
