"""Matches to a few hundredths of a pixel, once the lens is nearly known.

A feature is the middle of a blob some pixels wide, and a lens that enlarges one side of the blob
more than the other moves that middle. So around each match a small window of the original is laid
over the corrected picture, bent as the lens that was fitted first bends it, and moved until the
two agree best (B. Lucas and T. Kanade, 1981), whatever their brightness and contrast.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from plumbline.frame import Array
from plumbline.pairs.matching import Matches, apart
from plumbline.photos.brightness import Grey, sampled
from plumbline.trust.matched import Setting

_HALF_PX = 7
"""Half the window, pixels of the original; chosen: 15 px hold a feature's own detail."""

_BLUR_PX = 1.0
"""Blur of both pictures before, in the original's pixels, against noise and JPEG's steps."""

_STEPS = 8
_SETTLED_PX = 0.01
"""Steps of Gauss and Newton's, and the last of them where a window has settled; chosen, a tenth of
what a match is good to."""

_MOST_PX = 3.0
"""How far a match may move; chosen: features were some tenths off, a wrong match is pixels off."""

_ALIKE = 0.8
"""Least correlation of the two windows; chosen: matches of rendered pictures had 0.95 and more."""


def refined(original: Grey, corrected: Grey, setting: Setting, matches: Matches) -> Matches:
    """Matches whose windows agree, one for each window's width.

    Args:
        original: Brightness in grey levels, shape (h, w).
        corrected: The same of the other.
        setting: Lens, scale and place, nearly.
        matches: Those that agree with them.

    Returns:
        Places in the original at whole pixels, and where the corrected picture shows them.
    """
    matches = matches.only(apart(matches.observed_px, 2 * _HALF_PX + 1.0))
    at = np.rint(matches.observed_px)
    near = np.arange(-_HALF_PX, _HALF_PX + 1.0)
    window = np.stack(np.meshgrid(near, near), axis=-1).reshape(-1, 2)
    places = at[:, None] + window
    shown = setting.corrected(places.reshape(-1, 2)).reshape(places.shape)
    inside = _inside(places, original) & _inside(shown, corrected)
    at, places, shown = at[inside], places[inside], shown[inside]
    target = _standard(sampled(_blurred(original, _BLUR_PX), places).astype(np.float64))
    moved, good = _moved(_blurred(corrected, _BLUR_PX * setting.scale), target, shown)
    middle = shown[:, len(window) // 2] + moved
    return Matches(at[good], middle[good])


def _moved(picture: Grey, target: Array, shown: Array) -> tuple[Array, Any]:
    """How far each window has to move in the corrected picture, shape (n, 2), and which agree."""
    moved = np.zeros((len(shown), 2))
    step = np.full(len(shown), np.inf)
    down, right = (np.asarray(each, dtype=np.float32) for each in np.gradient(picture))
    for _ in range(_STEPS):
        places = shown + moved[:, None]
        seen = sampled(picture, places).astype(np.float64)
        spread = seen.std(axis=1, keepdims=True)
        slopes = [sampled(each, places) / np.maximum(spread, 1e-6) for each in (right, down)]
        slope = np.stack([each - each.mean(axis=1, keepdims=True) for each in slopes], axis=-1)
        rest = target - _standard(seen)
        normal = np.einsum("nik,nil->nkl", slope, slope) + 1e-9 * np.eye(2)
        by = np.linalg.solve(normal, np.einsum("nik,ni->nk", slope, rest)[..., None])[..., 0]
        moved = moved + np.clip(by, -1.0, 1.0)
        step = np.linalg.norm(by, axis=1)
    seen = sampled(picture, shown + moved[:, None]).astype(np.float64)
    alike = (target * _standard(seen)).mean(axis=1)
    return moved, (alike > _ALIKE) & (step < _SETTLED_PX) & (np.abs(moved).max(axis=1) < _MOST_PX)


def _standard(values: Array) -> Array:
    """Rows of mean 0 and standard deviation 1."""
    about = values - values.mean(axis=1, keepdims=True)
    return about / np.maximum(about.std(axis=1, keepdims=True), 1e-6)


def _inside(places: Array, picture: Grey) -> Any:
    """Which windows lie in the picture as a whole, shape (n,)."""
    last = np.array(picture.shape[::-1]) - 1.0
    with np.errstate(invalid="ignore"):
        return ((places >= 0) & (places <= last)).all(axis=(1, 2))


def _blurred(picture: Grey, sigma_px: float) -> Grey:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma_px), dtype=np.float32)
