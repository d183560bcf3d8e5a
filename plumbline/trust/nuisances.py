"""What else a real lens may do that the fitted model does not: nuisances, each with a prior.

Standard errors hold for a lens of the fitted family. Real ones are not quite: the distortion
centre lies off the middle of the photo, elements are decentred, the curve needs more powers of
r. Such terms are added to the fit, each with the spread it has among lenses as its prior, and
solved for by one Gauss–Newton step (a ridge regression; A. Hoerl and R. Kennard 1970). Where the
picks tell a term its prior hardly matters, elsewhere the prior is what is known of it. How far
the step moves the correction, and how uncertain it stays, is what the fitted model may be off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.derivatives import Ideal, by_coefficients, by_powers, by_tangential
from plumbline.geometry.finding import radial_curve
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE

CENTRE_SPREAD = 0.015
"""Standard deviation of either coordinate of the distortion centre as a share of half the shorter
side: chosen, because the three specimens in the literature whose centre is told have it up to 30
px from the middle, half the shorter side being about 1,000 px and more."""

TANGENTIAL_SPREAD = 0.001
"""Standard deviation of p1 and of p2 at a radius of half the shorter side: chosen, because
calibrations of photographic lenses report values up to 0.002."""

HELD_SPREAD, RICHER_SPREAD = 1.0, 0.2
"""What a power of r that is held, and one that the model lacks, moves the corner by, as shares of
the lens's largest radial displacement: chosen, because the first may be as large as what is
fitted, and the second is small beside it; not yet tuned on `tests.benchmarks.outside`."""

LEAST_PX = 0.5
"""The least that such a term moves the corner by: chosen, because no lens is free of it, and less
cannot be picked."""

DECENTRING, RADIAL = "centre", "curve"


@dataclass(frozen=True, eq=False)
class Nuisances:
    """Terms that a lens may have besides the fitted ones.

    Attributes:
        centre: Those of `d`, `e` that are not free.
        tangential: Whether p1, p2 are among them.
        powers: Powers of r.
        spreads: Standard deviation of each term, in the order centre, tangential, powers; pixels
            for the centre.
    """

    centre: tuple[str, ...]
    tangential: bool
    powers: tuple[int, ...]
    spreads: Array

    @property
    def groups(self) -> tuple[str, ...]:
        """What each term is about: `DECENTRING` or `RADIAL`."""
        n_decentring = len(self.centre) + 2 * self.tangential
        return (DECENTRING,) * n_decentring + (RADIAL,) * len(self.powers)

    def columns(self, lens: Lens, observed_px: Array, ideal: Ideal) -> Array:
        """How ideal points move with one standard deviation of each term, (n, 2, m)."""
        parts: list[Array] = []
        if self.centre:
            parts.append(by_coefficients(lens, self.centre, observed_px, ideal))
        if self.tangential:
            parts.append(by_tangential(lens, observed_px, ideal))
        parts.append(by_powers(lens, self.powers, observed_px, ideal))
        return np.concatenate(parts, axis=2) * self.spreads


def nuisances_of(
    lens: Lens, free: Sequence[str], centre_spread: float = CENTRE_SPREAD
) -> Nuisances:
    """The terms that a fit of `free` leaves out.

    Args:
        lens: The fitted lens.
        free: Names of the fitted coefficients.
        centre_spread: Standard deviation of the distortion centre, as `CENTRE_SPREAD`.
    """
    model, frame = lens.model, lens.frame
    centre = tuple(name for name in CENTRE if name not in free)
    tangential = not model.decentred(tuple(free))
    held = tuple(p for n, p in zip(model.radial, model.powers, strict=True) if n not in free)
    highest = max((*model.powers, *model.next_powers))
    further = (highest + 1) if highest % 2 else highest + 2
    lacking = (*model.next_powers, further)
    corner = frame.corner_radius * frame.radius_px / lens.unit_px
    observed, ideal = radial_curve(lens)
    bend_px = max(float(np.max(np.abs(observed - ideal), initial=0.0)), LEAST_PX)
    shares = np.array([HELD_SPREAD] * len(held) + [RICHER_SPREAD] * len(lacking))
    moved_px = np.maximum(shares * bend_px, LEAST_PX)
    powers = np.array((*held, *lacking))
    spreads = [centre_spread * frame.radius_px] * len(centre)
    spreads += [TANGENTIAL_SPREAD] * (2 * tangential)
    of_powers = moved_px / (lens.unit_px * corner ** (powers + 1.0))
    return Nuisances(centre, tangential, (*held, *lacking), np.array([*spreads, *of_powers]))
