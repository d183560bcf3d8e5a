"""What two pictures must show before a lens is believed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import PairError
from plumbline.frame import Array, Frame
from plumbline.pairs.fit import Fitted
from plumbline.pairs.matching import Matches
from plumbline.result.pair import PairCalibration
from plumbline.wording import count, joined

_LEAST = 50
"""Matches that must agree; chosen: with fewer one wrong one in ten can hide."""

PARTS = 4
"""Parts of the photo across and down, left out one after the other; chosen, so that each holds a
few dozen of the usual matches."""

_LEAST_REACH = 0.5
"""Share of the way to the corner that matches must reach at least; beyond it a lens bends most."""

_LEAST_PARTS = 6
"""Parts of 16 that must hold matches; chosen: three corners' worth."""

_ALIKE_PX = 0.05
"""A correction that moves the matches by less, root mean square, is none; chosen: two pictures
without one differed by 0.003 px, the weakest lenses of LensFun's database bend by some tenths."""


def refuse_few(fitted: Fitted, matches: Matches, frame: Frame) -> None:
    """Refuse matches that are few, or that leave most of the radius uncovered.

    Raises:
        PairError: says which part.
    """
    kept = matches.observed_px[fitted.kept]
    if len(kept) < _LEAST:
        raise PairError(
            f"of {count(len(matches), 'matched point')} only {len(kept)} agree on one lens",
            hint="take pictures with more detail; one of them as the lens shows it, the other "
            "corrected",
        )
    held = np.bincount(parts_of(kept, frame), minlength=PARTS**2) > 0
    radius = np.linalg.norm(frame.normalise(kept, frame.radius_px), axis=1) / frame.corner_radius
    inner, outer = (float(np.quantile(radius, q)) for q in (0.01, 0.99))
    if held.sum() < _LEAST_PARTS or outer < _LEAST_REACH:
        raise PairError(
            f"the matches lie in {held.sum()} of {PARTS**2} parts of the photo{_side(held)}, "
            f"between {100 * inner:.0f} and {100 * outer:.0f} % of the way to the corner: the rest "
            "of the radius is not covered",
            hint="take a scene with detail all over the photo",
        )


def _side(held: NDArray[np.bool_]) -> str:
    """In which part of the photo all matches lie, where it is one side of it."""
    rows, columns = np.nonzero(held.reshape(PARTS, PARTS))
    half = PARTS // 2
    words: list[str] = []
    for places, low, high in ((rows, "top", "bottom"), (columns, "left", "right")):
        if (places < half).all() or (places >= half).all():
            words.append(low if places[0] < half else high)
    return f", all at the {joined(words)}" if words else ""


def parts_of(observed_px: Array, frame: Frame) -> NDArray[np.int64]:
    """Which of the photo's parts each point lies in, row by row, shape (n,)."""
    across = np.clip((observed_px + 0.5) * PARTS / np.array(frame.size), 0, PARTS - 1)
    column, row = across.astype(np.int64).T
    return row * PARTS + column


def refuse_alike(calibration: PairCalibration) -> None:
    """Refuse pictures that differ by a scale and a shift alone.

    Raises:
        PairError: they do.
    """
    bent_px = np.sqrt(max(calibration.rms_before_px**2 - calibration.rms_after_px**2, 0.0))
    if bent_px > _ALIKE_PX:
        return
    raise PairError(
        f"the two pictures differ by a scale ({calibration.scale:.4f}) and a shift alone: "
        "neither of them is corrected, or both are",
        hint="give one of them without the correction",
    )
