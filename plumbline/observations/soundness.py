"""The checks of picks that need no fit, for all lines in one go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.observations.picks import Line, Photo

_FEWEST = 3
"""Points without which there is no line."""


def is_sound(lines: Sequence[Line], photos: Sequence[Photo], *, ideal: bool) -> bool:
    """Whether no line is short, no point stands twice on one, and all lie in their photos.

    Args:
        lines: The lines.
        photos: Their photos, of known sizes.
        ideal: The points are ideal ones, which may lie outside their photos.
    """
    sizes = np.array([len(line.points_px) for line in lines])
    if not len(sizes) or np.min(sizes) < _FEWEST:
        return False
    points = np.concatenate([line.points_px for line in lines])
    of_photo = np.repeat([line.photo for line in lines], sizes)
    for number, photo in enumerate(photos):
        own = points[of_photo == number]
        if not np.all(np.isfinite(own) if ideal else photo.frame.contains(own)):
            return False
    line = np.repeat(np.arange(len(sizes)), sizes)
    order = np.lexsort((points[:, 1], points[:, 0], line))
    repeated = np.all(np.diff(points[order], axis=0) == 0, axis=1) & (np.diff(line[order]) == 0)
    return not repeated.any()
