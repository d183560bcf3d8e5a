"""Points that two pictures of one scene have in common.

Features and their descriptors are OpenCV's SIFT (D. Lowe, 2004); a match must be clearly better
than the second best (Lowe's ratio test); of several for one place the best counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.errors import PairError
from plumbline.frame import Array
from plumbline.photos.brightness import Grey

_LONG_SIDE_PX = 2400
"""Longer side of the pictures matched; chosen, because it gives thousands of matches in seconds."""

_MOST = 5000
"""Features of a picture: the strongest; chosen for the same reason."""

_CONTRAST = 0.02
"""Least contrast of a feature; half of OpenCV's, as developments differ in contrast."""

_RATIO = 0.75
"""Lowe's ratio: he has 0.8, chosen a little stricter as wrong matches cost more here than few."""

_APART_PX = 1.0
"""Features closer together are one: they err together and would count twice."""

_LEAST = 30
"""Matches that must agree on one scale and shift; chosen, because only a few wrong ones
agree by chance."""

_AGREE = 0.02
"""How far matches may lie from their common scale and shift, as a share of the longer side: what a
lens bends in the middle of the photo."""

_TURNED_DEG = 1.0
"""A turn that no correction makes."""


@dataclass(frozen=True, eq=False)
class Matches:
    """Matched points, some of them wrong.

    Attributes:
        observed_px: In the original, its own pixels, shape (n, 2).
        corrected_px: In the corrected picture.
    """

    observed_px: Array
    corrected_px: Array

    def __len__(self) -> int:
        return len(self.observed_px)

    def only(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Matches:
        """Some of them."""
        return Matches(self.observed_px[which], self.corrected_px[which])


@dataclass(frozen=True)
class Agreement:
    """Scale and shift that many matches agree on.

    Attributes:
        scale: Pixels of the corrected picture to one of the original.
        offset_px: What is added then.
        matches: How many agree.
    """

    scale: float
    offset_px: tuple[float, float]
    matches: int


def match(original: Grey, corrected: Grey) -> Matches:
    """Match two pictures.

    Args:
        original: Brightness in grey levels, shape (h, w).
        corrected: The same of the other.

    Raises:
        PairError: one of them is too plain, or they are of different scenes, turned or mirrored.
    """
    first, second = _features(original), _features(corrected)
    for features, name in ((first, "original"), (second, "corrected picture")):
        if len(features.points) < 2 * _LEAST:
            raise PairError(
                f"the {name} is too plain: it has {len(features.points)} points to match",
                hint="take a scene full of detail, such as a façade, foliage or a crowded shelf",
            )
    found = _matched(first, second)
    if _agreeing(found) < _LEAST:
        mirrored = _matched(first, _features(np.ascontiguousarray(corrected[:, ::-1])))
        if _agreeing(mirrored) >= _LEAST:
            raise PairError("one picture is mirrored", hint="mirror it back")
        raise PairError(
            f"the pictures have {len(found):,} points in common, too few that agree: they are of "
            "different scenes, or taken from different places",
            hint="give one photograph and the same one corrected",
        )
    return found


def agreement(matches: Matches) -> Agreement:
    """The scale and shift that most matches agree on.

    Raises:
        PairError: too few agree, or one picture is turned against the other.
    """
    turn, agreeing = _similarity(matches)
    if turn is None or agreeing < _LEAST:
        raise PairError(
            f"of {len(matches):,} matches only {agreeing} agree on a scale and a shift",
            hint="give one photograph and the same one corrected",
        )
    angle = float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))
    if abs(angle) > _TURNED_DEG:
        raise PairError(
            f"the corrected picture is turned by {angle:.0f}°",
            hint="turn it back before; a correction of the lens does not turn",
        )
    scale = float(np.hypot(turn[0, 0], turn[1, 0]))
    return Agreement(scale, (float(turn[0, 2]), float(turn[1, 2])), agreeing)


def _agreeing(matches: Matches) -> int:
    return _similarity(matches)[1]


def _similarity(matches: Matches) -> tuple[Any, int]:
    """Scale, turn and shift by RANSAC as a 2 × 3 matrix, and how many matches agree."""
    if len(matches) < _LEAST:
        return None, 0
    reach = _AGREE * float(np.ptp(matches.corrected_px, axis=0).max())
    found: Any
    found, good = cv2.estimateAffinePartial2D(
        np.ascontiguousarray(matches.observed_px),
        np.ascontiguousarray(matches.corrected_px),
        method=cv2.RANSAC,
        ransacReprojThreshold=reach,
        maxIters=5000,
    )
    return found, 0 if found is None else int(np.count_nonzero(good))


@dataclass(frozen=True, eq=False)
class _Features:
    points: Array
    descriptors: NDArray[np.float32]


def _features(picture: Grey) -> _Features:
    scale = max(1.0, max(picture.shape) / _LONG_SIDE_PX)
    size = (round(picture.shape[1] / scale), round(picture.shape[0] / scale))
    small: Any = picture if scale == 1 else cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    eight = np.clip(np.rint(small), 0, 255).astype(np.uint8)
    sift = cv2.SIFT.create(nfeatures=_MOST, contrastThreshold=_CONTRAST)
    points, descriptors = sift.detectAndCompute(eight, np.full_like(eight, 255))
    at = np.array([each.pt for each in points], dtype=np.float64).reshape(-1, 2)
    per_px = np.array([picture.shape[1], picture.shape[0]]) / np.array(size)
    described = np.zeros((0, 128)) if not len(at) else np.asarray(descriptors)
    return _Features((at + 0.5) * per_px - 0.5, described.astype(np.float32))


def _matched(first: _Features, second: _Features) -> Matches:
    """Matches that pass the ratio test, one for each place in both pictures."""
    here, there = _clear(first, second)
    observed, corrected = first.points[here], second.points[there]
    kept = apart(observed)
    kept = kept[apart(corrected[kept])]
    return Matches(observed[kept], corrected[kept])


def apart(points: Array, side_px: float = _APART_PX) -> NDArray[np.int64]:
    """The first point of each square of that side that holds any."""
    squares = np.floor(points / side_px).astype(np.int64)
    return np.sort(np.unique(squares, axis=0, return_index=True)[1])


def _clear(first: _Features, second: _Features) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Features of the first picture clearly like one of the second, most alike first; those."""
    if len(second.points) < 2 or not len(first.points):
        none = np.zeros(0, dtype=np.int64)
        return none, none
    pairs = cv2.BFMatcher.create(cv2.NORM_L2).knnMatch(first.descriptors, second.descriptors, 2)
    clear = [one for one, two in pairs if one.distance < _RATIO * two.distance]
    clear.sort(key=lambda one: one.distance)
    here, there = ([getattr(one, name) for one in clear] for name in ("queryIdx", "trainIdx"))
    return np.array(here, dtype=np.int64), np.array(there, dtype=np.int64)
