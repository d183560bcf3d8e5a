"""Coordinates that are not pixels: fractions of the photo, or the unit of a calibrated axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbline.formats.base import Source
from plumbline.observations import Line, Observations, Photo
from plumbline.wording import count

_SMALL = 0.02
"""Part of the photo's longer side below which all its picks together are not in pixels.

Chosen, because lines in a fiftieth of a photo tell nothing of its distortion.
"""

_OUTSIDE = 0.5
"""Share of picks outside the photo from which on the unit is at fault, not a pick. Chosen."""

_HINT = (
    "export pixels: in WebPlotDigitizer with the axes 'Image', in ImageJ after Analyze > Set "
    "Scale > Click to Remove Scale"
)


def in_pixels(source: Source, observations: Observations) -> Observations:
    """The points in pixels where they were fractions of the photo's width and height.

    All points of a photo that lie within its first pixel are fractions, counted from its edges;
    a note says so.

    Args:
        source: The file, for messages.
        observations: What was read from it, the sizes of the photos known.

    Raises:
        ReadError: the points are in another unit.
        OptionError: a photo's size is impossible.
    """
    lines = list(observations.lines)
    notes = list(observations.notes)
    for number, photo in enumerate(observations.photos):
        places = [i for i, line in enumerate(lines) if line.photo == number]
        if not places:
            continue
        photo.checked(observations.named)
        points = np.concatenate([lines[i].points_px for i in places])
        if not np.isfinite(points).all():
            continue
        if points.min() >= 0 and points.max() <= 1 and np.any(points % 1):
            for i in places:
                lines[i] = _scaled(lines[i], photo)
            notes.append(
                "coordinates from 0 to 1 were taken as fractions of the photo's width and height, "
                "y down"
            )
            continue
        _refuse_other_units(source, photo, lines[places[0]], points)
    told = tuple(dict.fromkeys(notes))
    return replace(observations, lines=tuple(lines), notes=told)


def _scaled(line: Line, photo: Photo) -> Line:
    return replace(line, points_px=line.points_px * np.array(photo.frame.size) - 0.5)


def _refuse_other_units(source: Source, photo: Photo, line: Line, points: np.ndarray) -> None:
    frame = photo.frame
    row = None if line.rows is None else int(line.rows[0])
    outside = np.count_nonzero(~frame.contains(points))
    spread = float(np.ptp(points, axis=0).max())
    small = spread < _SMALL * max(frame.size)
    if outside > _OUTSIDE * len(points) and len(points) > 2:
        raise source.error(
            f"{outside:,} of {count(len(points), 'point')} lie outside the "
            f"{frame.width}x{frame.height} photo, so that they are not in its pixels",
            row,
            f"check the photo's size, or {_HINT}",
        )
    if small and len(points) > 2 and np.any(points % 1):
        raise source.error(
            f"all points lie within {spread:.3g} of a {frame.width}x{frame.height} photo, so that "
            "they are in the unit of a calibrated axis, not in pixels",
            row,
            _HINT,
        )
