"""Edges drawn into their photograph, to be looked at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plumbline.edges.trace import Traced

_WIDE_PX = 1600
"""Longer side of the drawing; chosen, to fit a screen."""

_COLOURS = ((0, 140, 255), (255, 140, 0), (80, 220, 60), (220, 60, 220), (60, 220, 220))
"""Blue, green, red; neighbours in the list are told apart."""

_GAP = 4.0
"""Times the usual distance of samples from which a line is interrupted."""


def drawn(pixels: NDArray[Any], lines: Sequence[Traced]) -> NDArray[np.uint8]:
    """A photograph (blue, green, red) with the edges found in it, numbered from 1.

    Args:
        pixels: As `Photograph.pixels`.
        lines: The edges; interrupted where they are.
    """
    scale = min(1.0, _WIDE_PX / max(pixels.shape[:2]))
    size = [max(1, round(side * scale)) for side in pixels.shape[1::-1]]
    small = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))
    picture = (small // 256 if small.dtype == np.uint16 else small).astype(np.uint8)
    drawing = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture[..., :3]
    drawing = np.ascontiguousarray(drawing)
    for number, line in enumerate(lines, start=1):
        colour = _COLOURS[number % len(_COLOURS)]
        for part in _parts(line):
            places = np.rint(((part + 0.5) * scale - 0.5) * 16).astype(np.int32)
            cv2.polylines(drawing, [places], False, colour, 1, cv2.LINE_AA, 4)
        x, y = ((line.points_px[len(line.points_px) // 3] + 0.5) * scale).astype(int).tolist()
        for ink, thick in (((0, 0, 0), 3), (colour, 1)):
            at = (x + 3, y - 3)
            cv2.putText(
                drawing, str(number), at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, ink, thick, cv2.LINE_AA
            )
    return np.asarray(drawing, dtype=np.uint8)


def _parts(line: Traced) -> list[NDArray[np.float64]]:
    """Samples in their order, cut where the edge is interrupted."""
    points = line.points_px
    points = points[np.argsort(points[:, int(np.ptp(points[:, 1]) > np.ptp(points[:, 0]))])]
    steps = np.hypot(*np.diff(points, axis=0).T)
    breaks = np.flatnonzero(steps > _GAP * np.median(steps)) + 1
    return np.split(points, breaks.tolist())
