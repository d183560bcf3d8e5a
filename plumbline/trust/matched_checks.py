"""Are matches well placed, and is what is fitted to them to be trusted? Each with its remedy."""

from __future__ import annotations

import numpy as np

from plumbline.frame import Array
from plumbline.trust.assessment import Assessment
from plumbline.trust.check import Check
from plumbline.wording import count, joined, px

FEW = 100
"""Matches below which errors of single ones matter; chosen, as 500 are usual."""

_REACH = 0.9
"""Share of the way to the corner that matches should reach; chosen, as for picks."""

_CORNER = 0.7
"""A match lies near a corner beyond this share of the way to it on both axes."""

_UNSTEADY = 1.5
"""As for picks: how much larger what leaving out parts says may be."""

_LEAST_PX = 1.0
"""Chosen: below a pixel at the corner an error is good for any use."""
_CORNERS = {
    "top left": (-1, -1),
    "top right": (1, -1),
    "bottom right": (1, 1),
    "bottom left": (-1, 1),
}


def checks_of_matches(trust: Assessment, observed_px: Array) -> tuple[Check, ...]:
    """What can be said of matches that were fitted.

    Args:
        trust: How far to trust the fit.
        observed_px: The matches in the original, shape (n, 2).
    """
    found = (
        _enough(observed_px, trust),
        _radius(observed_px, trust),
        _corners(observed_px, trust),
        _correction(trust),
        _steady(trust),
    )
    return tuple(check for check in found if check is not None)


def reach_of(observed_px: Array, trust: Assessment) -> float:
    """The share of the way from the centre to the corner that 99 in 100 matches stay within."""
    frame = trust.lens.frame
    radius = np.linalg.norm(frame.normalise(observed_px, frame.radius_px), axis=1)
    return float(np.quantile(radius, 0.99)) / frame.corner_radius


def _enough(observed_px: Array, trust: Assessment) -> Check:
    n = len(observed_px)
    finding = f"{count(n, 'match', 'matches')} for {count(len(trust.free), 'coefficient')}"
    if n >= FEW:
        return Check("amount", True, finding)
    return Check("amount", False, finding, "take pictures with more texture, or larger ones")


def _radius(observed_px: Array, trust: Assessment) -> Check:
    share = reach_of(observed_px, trust)
    finding = f"the matches reach {100 * share:.0f} % of the way to the corner"
    if share >= _REACH:
        return Check("radius", True, finding)
    return Check(
        "radius",
        False,
        f"{finding}; the radius beyond is not covered, and the correction there is extrapolated",
        "take a scene with texture in the corners",
    )


def _corners(observed_px: Array, trust: Assessment) -> Check:
    frame = trust.lens.frame
    half = np.array(frame.square_size) / 2 / frame.radius_px
    place = frame.normalise(observed_px, frame.radius_px) / half
    lacking = [
        name
        for name, side in _CORNERS.items()
        if not np.any((place * np.array(side) > _CORNER).all(axis=1))
    ]
    if not lacking:
        return Check("corners", True, "there are matches near all four corners")
    where = f"the {joined(lacking)} corner" + ("s" if len(lacking) > 1 else "")
    return Check("corners", False, f"there are no matches near {where}", "take a textured scene")


def _correction(trust: Assessment) -> Check:
    sure = trust.quoted_displacement
    if sure is None:
        return Check(
            "correction",
            False,
            "the model folds inside the photo, so that the error of the correction is not known",
            "free fewer coefficients",
        )
    finding = (
        f"the correction is uncertain by {px(sure.worst_px)} {sure.worst_place}, where it is worst "
        "(one standard error)"
    )
    good = sure.worst_px <= max(_LEAST_PX, abs(trust.finding.corner_px) / 20)
    return Check("correction", good, finding, "" if good else "take a scene with texture there")


def _steady(trust: Assessment) -> Check | None:
    sure, wide = trust.displacement, trust.jackknife_displacement
    if sure is None or wide is None:
        return None
    ratio = wide.worst_px / sure.worst_px if sure.worst_px > 0 else 1.0
    finding = (
        f"leaving out one part of the photo at a time, the correction is uncertain by "
        f"{px(wide.worst_px)}; independent errors of the matches would make {px(sure.worst_px)}"
    )
    remedy = "neighbouring matches err together, or the model cannot follow the correction"
    return Check("part by part", ratio <= _UNSTEADY, finding, "" if ratio <= _UNSTEADY else remedy)
