"""A lens's maps turned, scaled and reversed for the picture as it is stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from plumbline.errors import FoldedError, OptionError
from plumbline.frame import Array, Frame
from plumbline.lenses.correction import Correction
from plumbline.lenses.mapping import TURNS, UPRIGHT

Scale = Literal["keep", "fit", "fill"]

SCALES: tuple[Scale, ...] = get_args(Scale)

_BISECTIONS = 40  # halves the stretch to the last digits of a double
_MOST_ON_A_SIDE = 1000  # points looked at along a side; chosen, the border is smooth
_SMALLEST, _LARGEST, _GROWTH = 0.05, 10.0, 1.05
"""Stretches tried, and the step between them: chosen wider than any lens needs."""


@dataclass(frozen=True)
class View:
    """From pixels of the corrected picture, as stored, to pixels of the photograph, as stored.

    Attributes:
        mapping: Ideal points to observed ones in the upright picture.
        size: Width and height of the upright picture.
        orientation: How the picture is stored, EXIF's 1 to 8.
        stretch: Ideal distances from the centre over those in the corrected picture.
    """

    mapping: Callable[[Array], Array]
    size: tuple[int, int]
    orientation: int = 1
    stretch: float = 1.0

    @property
    def stored_size(self) -> tuple[int, int]:
        """Width and height of the picture as stored."""
        width, height = self.size
        return (height, width) if self.orientation in (5, 6, 7, 8) else self.size

    def observed(self, points_px: Array) -> Array:
        """Where pixels of the corrected picture are seen, shape (..., 2).

        Raises:
            FoldedError: the lens shows no such point.
        """
        centre, stored = (Frame(*size).centre_px for size in (self.size, self.stored_size))
        turn = TURNS[self.orientation]
        ideal = (points_px - np.array(stored)) * self.stretch
        if turn == UPRIGHT:
            return self.mapping(ideal + np.array(centre))
        matrix = np.array(turn, dtype=np.float64)
        seen = self.mapping(ideal @ matrix.T + np.array(centre)) - np.array(centre)
        return seen @ matrix + np.array(stored)


def view_of(
    correction: Correction, *, orientation: int = 1, scale: Scale = "keep", inverse: bool = False
) -> View:
    """The view that corrects a photograph, or with `inverse` distorts a corrected one.

    Args:
        correction: The lens.
        orientation: How the picture is stored, EXIF's 1 to 8.
        scale: "keep" the circle where the lens does not scale; "fit" all of the photograph in;
            "fill" the frame so that no border is empty.
        inverse: Go from the ideal picture to the observed one.

    Raises:
        OptionError: the photograph cannot be scaled so.
    """
    there, back = correction.distort, correction.undistort
    if inverse:
        there, back = back, there
    if scale == "fit":
        stretch = _to_fit(back, correction.size)
    elif scale == "fill":
        stretch = _to_fill(there, correction.size)
    else:
        stretch = 1.0
    return View(there, correction.size, orientation, stretch)


def _to_fit(back: Callable[[Array], Array], size: tuple[int, int]) -> float:
    """The stretch at which the whole photograph lies in the frame."""
    centre = np.array(Frame(*size).centre_px)
    try:
        ideal = back(_border(size)) - centre
    except FoldedError:
        raise OptionError(
            "the lens values fold inside the photo, so that not all of it can be shown",
            hint="leave out --scale fit, or take other lens values",
        ) from None
    return float(np.max(np.abs(ideal) / np.maximum(centre, 0.5)))


def _to_fill(there: Callable[[Array], Array], size: tuple[int, int]) -> float:
    """The largest stretch at which the photograph covers the whole frame."""
    frame = Frame(*size)
    centre = np.array(frame.centre_px)
    border = _border(size) - centre
    last = np.array(size) - 1.0

    def covered(stretch: float) -> bool:
        try:
            observed = there(centre + stretch * border)
        except FoldedError:
            return False
        return bool(np.all((observed >= -1e-6) & (observed <= last + 1e-6)))

    if not covered(_SMALLEST):
        raise OptionError(
            "the photo cannot fill the frame", hint="leave out --scale fill, or check the lens"
        )
    low = high = _SMALLEST  # in small steps first: beyond a fold the frame seems covered again
    while high < _LARGEST and covered(high):
        low, high = high, high * _GROWTH
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if covered(middle) else (low, middle)
    return low


def _border(size: tuple[int, int]) -> Array:
    """Centres of pixels around the edge of a picture, shape (n, 2)."""
    right, bottom = size[0] - 1.0, size[1] - 1.0
    x = np.linspace(0, right, min(size[0], _MOST_ON_A_SIDE))
    y = np.linspace(0, bottom, min(size[1], _MOST_ON_A_SIDE))
    sides = [
        np.stack((x, np.zeros_like(x)), axis=-1),
        np.stack((x, np.full_like(x, bottom)), axis=-1),
        np.stack((np.zeros_like(y), y), axis=-1),
        np.stack((np.full_like(y, right), y), axis=-1),
    ]
    return np.concatenate(sides)
