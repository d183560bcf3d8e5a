"""Read picked points: find the format, learn the photo's size and lens, check, join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePath

from plumbline.errors import OptionError
from plumbline.files import read_bytes
from plumbline.formats.base import Order, ReadOptions, Source
from plumbline.formats.known import format_of
from plumbline.observations import Observations, Origin, Photo
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.reading.photo import (
    ONE_FOCAL_LENGTH,
    agreed_size,
    note_on_orientation,
    photo_beside,
    with_exif,
)

_ONE_FIELD_OF_VIEW = 0.02
_GIVE_SIZE = ", or the size alone with --size WIDTHxHEIGHT"
_SHIFT_AND_SHEAR = ("d", "e", "g", "t")


def read(
    path: str | Path,
    *,
    photo: str | Path | None = None,
    size: tuple[int, int] | None = None,
    image: int | None = None,
    format: str | None = None,  # noqa: A002
    grid: tuple[int, int] | None = None,
    order: Order = "raster",
    pixel_aspect: float = 1.0,
    ideal: bool = False,
    singly: bool = False,
) -> Observations:
    """Read picked points from a file of any known format.

    Args:
        path: The file.
        photo: The photograph they were picked in; tells its size, and by EXIF its lens.
        size: Width and height of the photograph, where neither file nor photo tell it.
        image: Take only photo number `image` of the file, counted from 0.
        format: Name of the file's format; recognised by suffix and content if None.
        grid: Rows and columns, where one polyline holds a whole grid (WinMorph).
        order: How that polyline runs: each row from the left, or back and forth.
        pixel_aspect: Width of one pixel over its height, for video frames.
        ideal: The points are ideal ones, which may lie outside the photo.
        singly: Points count, not lines: lines of one or two points and duplicates stay.

    Returns:
        Checked observations.

    Raises:
        ReadError: the file is missing, damaged or holds no usable line.
        OptionError: an argument contradicts the file, or it has no such photo.
        DegenerateLinesError: no line has three distinct points.

    Example:
        >>> import plumbline
        >>> plumbline.read("building.pto").n_points  # doctest: +SKIP
        64
    """
    source = Source(str(path), read_bytes(path))
    found = format_of(source, format)
    if grid is not None and found.name != "winmorph":
        raise OptionError(
            f"{path}: a grid is for WinMorph files, and this one is read as {found.name}",
            hint="leave out --grid, or name the format with --format winmorph",
        )
    if grid is not None and min(grid) < 2:
        raise OptionError("a grid has at least two rows and two columns", hint="as --grid 7x9")
    shot = None if photo is None else read_photo(photo, remedy=_GIVE_SIZE)
    known = size if size is not None or shot is None else shot.size
    raw = _chosen(source, found.read(source, ReadOptions(known, grid, order)), image)
    notes = list(raw.notes)
    with_lines = {line.photo for line in raw.lines}
    one_lens = len({raw.photos[index].lens for index in with_lines}) == 1
    if shot is not None and not one_lens:
        notes.append(
            f"{shot.name} was not used: the project has lines of several lenses, and it is not "
            "known which of them took it (--image N selects one)"
        )
    photos: list[Photo] = []
    pictures: dict[int, list[PhotoFacts]] = {}
    for index, each in enumerate(raw.photos):
        picture = photo_beside(source, each, notes) if shot is None else None
        if one_lens and index in with_lines:
            picture = picture or shot
        agreed = agreed_size(source, each, size if index in with_lines else None, picture)
        name = each.name or (picture.name if picture else "")
        photos.append(replace(each, size=agreed, name=name, pixel_aspect=pixel_aspect))
        if picture and index in with_lines:
            pictures.setdefault(each.lens, []).append(picture)
            notes += [n for n in note_on_orientation(picture, agreed) if n not in notes]
    lenses = [with_exif(f, pictures.get(i, []), notes) for i, f in enumerate(raw.lenses)]
    return replace(
        raw,
        photos=tuple(photos),
        lenses=tuple(lenses),
        notes=tuple(notes),
        origins=(Origin(str(path), found.name, source.content),),
    ).checked(ideal=ideal, singly=singly)


def _chosen(source: Source, raw: Observations, image: int | None) -> Observations:
    """The photos by their numbers, or only the one that the user wants."""
    only = PurePath(source.path).name if len(raw.photos) == 1 else ""
    photos = tuple(
        replace(photo, number=number, source=only) for number, photo in enumerate(raw.photos)
    )
    raw = replace(raw, photos=photos)
    if image is None:
        return raw
    if not 0 <= image < len(photos):
        raise OptionError(
            f"{source.path}: there is no photo number {image}; there are {len(photos)}",
            hint="photos are counted from 0",
        )
    chosen = raw.of_photo(image)
    if not chosen.lines:
        raise OptionError(
            f"{source.path}: photo number {image} has no straight lines",
            hint="photos with lines: "
            + ", ".join(str(number) for number in sorted({line.photo for line in raw.lines})),
        )
    return chosen


def join(parts: Sequence[Observations]) -> Observations:
    """Photos of one lens, read from several files, as one set of observations.

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
    return replace(whole, photos=photos, lenses=(facts,))


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
                f"{part.named}the lens has {name} = {now:g}, in the files before it {before:g}: "
                "these are not photos of one lens",
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
