"""Coordinates instead of pixels: picked points corrected, and back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from plumbline.errors import OptionError, ReadError
from plumbline.imaging.correct import LensSource, correction_for
from plumbline.lenses.correction import Correction
from plumbline.observations import Observations
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.reading.points import read


def read_points(
    path: str | Path,
    photo: str | Path | None = None,
    size: tuple[int, int] | None = None,
    *,
    inverse: bool = False,
) -> Observations:
    """Points to be corrected, or with `inverse` to be distorted; each stays, lines need not be.

    Args:
        path: The file.
        photo: The photograph that they belong to.
        size: Its width and height in pixels, where no photograph is named.
        inverse: The points are ideal ones, which may lie outside the photograph.

    Raises:
        PlumblineError: they cannot be read, or the size of their photo is not known.
    """
    try:
        return read(path, photo=photo, size=size, ideal=inverse, singly=True)
    except ReadError as error:
        if photo is None and size is None and "size" in error.message:
            error.hint = "name the photo too, or give its size with --size WIDTHxHEIGHT"
        elif "--format" in error.hint or "--grid" in error.hint:
            error.hint += ": plumbline convert takes that, and makes a CSV of the points"
        raise


def correct_points(
    observations: Observations,
    lens: LensSource = None,
    *,
    photo: str | Path | None = None,
    inverse: bool = False,
) -> tuple[Observations, tuple[Correction, ...]]:
    """Map observed points to ideal ones, or with `inverse` ideal ones to observed ones.

    Args:
        observations: The points.
        lens: As `correct` takes it.
        photo: The photograph, whose EXIF tells of its lens.
        inverse: Go the other way.

    Returns:
        The points where they belong, and the correction used for each photo. What was known of
        the lenses is left out: it does not hold for the new points.

    Raises:
        PlumblineError: no lens is found, or it folds before it reaches a point.
    """
    used = {line.photo for line in observations.lines}
    if photo is not None and len(used) > 1:
        raise OptionError(
            f"the points lie in {len(used)} photos, and one is named", hint="leave the photo out"
        )
    facts = {index: _facts(observations, index, photo) for index in used}
    if inverse:
        facts = {index: each.taken_as_corrected() for index, each in facts.items()}
    found = {index: correction_for(each, lens) for index, each in facts.items()}
    lines = tuple(
        replace(
            line,
            points_px=(found[line.photo].distort if inverse else found[line.photo].undistort)(
                line.points_px
            ),
        )
        for line in observations.lines
    )
    photos = tuple(replace(shot, lens=0) for shot in observations.photos)
    moved = replace(observations, photos=photos, lines=lines, lenses=(LensFacts(),))
    return moved, tuple(found[index] for index in sorted(used))


def _facts(observations: Observations, index: int, photo: str | Path | None) -> PhotoFacts:
    if photo is not None:
        return read_photo(photo)
    shot = observations.photos[index]
    facts = observations.lenses[shot.lens]
    return PhotoFacts(
        shot.frame.size, facts, name=shot.name, maker=facts.exif_make, model=facts.exif_model
    )
