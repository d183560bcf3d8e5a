"""Whether enough picks agree to tell the lens at all.

Three things say that they do not: another lens leaves about as many picks on straight lines; fewer
than half of the picks agree on any, which is where every robust fit breaks down (P. Rousseeuw and
A. Leroy, "Robust Regression and Outlier Detection", 1987); or those that agree scatter by more than
the most careless picks.
"""

from __future__ import annotations

from collections.abc import Sequence

from plumbline.trust.check import Check
from plumbline.trust.suspect import Suspect
from plumbline.wording import px

APART = 2.0
"""Quoted errors from which on two lenses are two: twice a standard error covers what one lens may
be."""

_SCATTERED = 1 / 60
"""σ̂ over half the shorter side beyond which picks are not only careless: chosen, 1.7 times what is
taken for clean, since σ̂ of five picks on each of ten lines is a fifth too large by chance."""

_REMEDY = "pick the lines again, ten picks on each"


def agreement_check(
    rival_px: float | None,
    suspects: Sequence[Suspect],
    n_points: int,
    sigma_px: float,
    radius_px: float,
) -> Check | None:
    """Say so where too little agrees; None where enough does.

    Args:
        rival_px: How far the correction by another lens, under which the picks agree about as
            well, is from this one; None where there is none.
        suspects: The suspicious picks.
        n_points: Number of all picks.
        sigma_px: σ̂.
        radius_px: Half the shorter side.
    """
    if rival_px is not None:
        told = (
            f"another lens, up to {px(rival_px)} from this one, leaves about as many picks on "
            "straight lines: which picks are wrong and what the lens is cannot be told"
        )
        return Check("agreement", False, told, _REMEDY)
    agreeing = n_points - sum(len(each.picks) for each in suspects if each.left_out)
    if 2 * agreeing < n_points:
        told = (
            f"only {agreeing:,} of {n_points:,} picks agree on straight lines: as few may do so by "
            "chance, and what the lens is cannot be told"
        )
        return Check("agreement", False, told, _REMEDY)
    if sigma_px > _SCATTERED * radius_px:
        told = (
            f"the picks scatter by {px(sigma_px)} about straight lines, more than careless ones: "
            "what the lens is cannot be told"
        )
        return Check("agreement", False, told, _REMEDY)
    return None
