"""Files that are photos of one lens, as one set of observations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from plumbline.errors import OptionError
from plumbline.observations import Observations, Photo
from plumbline.observations.facts import LensFacts
from plumbline.reading.photo import ONE_FOCAL_LENGTH
from plumbline.wording import number

_ONE_FIELD_OF_VIEW = 0.02
"""Focal lengths in pixels that differ by more, relatively, are two settings of the lens.

Chosen, because fields of view that projects tell are often optimised and differ by a percent.
"""
_SHIFT_AND_SHEAR = ("d", "e", "g", "t")


def join(parts: Sequence[Observations]) -> Observations:
    """Photos of one lens, read from several files, as one set of observations.

    Lines that stand in several files, or several times in one, count once; notes name them.

    Raises:
        OptionError: a file holds several lenses, or the files tell of different lenses or
            focal lengths.
    """
    if len(parts) == 1:
        return parts[0]
    for part in parts:
        if len(part.lenses) != 1:
            raise OptionError(
                f"{part.named}the file holds {len(part.lenses)} lenses, and several files together "
                "are photos of one lens",
                hint="fit this file by itself",
            )
    facts = parts[0].lenses[0]
    for part in parts[1:]:
        _refuse_another_lens(facts, parts[0].photos[0], part)
        facts = facts.completed(part.lenses[0])
    whole = Observations.side_by_side(parts)
    photos = tuple(replace(photo, lens=0) for photo in whole.photos)
    return replace(whole, photos=photos, lenses=(facts,)).counted_once()


def _refuse_another_lens(facts: LensFacts, photo: Photo, part: Observations) -> None:
    """Refuse a file whose lens cannot be that of the files before it."""
    other = part.lenses[0]
    if other.projection != facts.projection:
        raise OptionError(
            f"{part.named}the photo is marked as {other.projection}, those before it as "
            f"{facts.projection}",
            hint="fit this file by itself, or correct the lens type in the project",
        )
    for name in _SHIFT_AND_SHEAR if facts.stored and other.stored else ():
        before, now = facts.stored.get(name, 0.0), other.stored.get(name, 0.0)
        if before != now:
            raise OptionError(
                f"{part.named}the lens has {name} = {number(now, 'g')}, in the files before it "
                f"{number(before, 'g')}: these are not photos of one lens",
                hint="fit this file by itself, or make the values the same",
            )
    hint = "fit each focal length by itself"
    if facts.focal_mm and other.focal_mm:
        if abs(facts.focal_mm / other.focal_mm - 1) > ONE_FOCAL_LENGTH:
            raise OptionError(
                f"{part.named}the focal length is {other.focal_mm:g} mm, in the files before it "
                f"{facts.focal_mm:g} mm: these are not photos of one lens setting",
                hint=hint,
            )
        return
    before_px = facts.focal_length_px(photo.frame)
    now_px = other.focal_length_px(part.photos[0].frame)
    if before_px and now_px and abs(before_px / now_px - 1) > _ONE_FIELD_OF_VIEW:
        raise OptionError(
            f"{part.named}the focal length is {now_px:.0f} px by the field of view or EXIF, in "
            f"the files before it {before_px:.0f} px: these are not photos of one lens setting",
            hint=hint + ", or correct the field of view (v) in the project",
        )
