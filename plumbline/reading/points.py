"""Read picked points: find the format, learn the photo's size and lens, check, join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path, PurePath

from plumbline.errors import OptionError
from plumbline.files import is_same, read_bytes
from plumbline.formats.archives import opened
from plumbline.formats.base import Order, ReadOptions, Source
from plumbline.formats.grid import refuse_all_as_one
from plumbline.formats.known import format_of
from plumbline.formats.units import in_pixels
from plumbline.observations import Observations, Origin, Photo
from plumbline.photos.exif import PhotoFacts
from plumbline.reading.joining import join
from plumbline.reading.photo import Shot, agreed_size, note_on_orientation, photo_beside, with_exif

_GIVE_SIZE = ", or the size alone with --size WIDTHxHEIGHT"


def read(
    path: str | Path | Sequence[str | Path],
    *,
    photo: str | Path | None = None,
    size: tuple[int, int] | None = None,
    image: int | None = None,
    format: str | None = None,  # noqa: A002
    grid: tuple[int, int] | None = None,
    order: Order = "raster",
    pixel_aspect: float | None = None,
    ideal: bool = False,
    singly: bool = False,
) -> Observations:
    """Read picked points from files of any known format.

    Args:
        path: The file, or several of one lens, which are joined.
        photo: The photograph they were picked in; tells its size, and by EXIF its lens.
        size: Width and height of the photograph, where neither file nor photo tell it.
        image: Take only photo number `image` of each file, counted from 0.
        format: Name of the file's format; recognised by suffix and content if None.
        grid: Rows and columns, where the only line of a file holds a whole grid.
        order: How that line runs: each row from the left, or back and forth.
        pixel_aspect: Width of one pixel over its height, for video frames; what the file says,
            or 1, if None.
        ideal: The points are ideal ones, which may lie outside the photo.
        singly: Points count, not lines: lines of one or two points and duplicates stay.

    Returns:
        Checked observations. Copies of lines count once.

    Raises:
        ReadError: a file is missing, damaged or holds no usable line.
        OptionError: an argument contradicts the file, it has no such photo, a file is named
            twice, or the files are not of one lens.
        DegenerateLinesError: no line has three distinct points.

    Example:
        >>> import plumbline
        >>> plumbline.read("building.pto").n_points  # doctest: +SKIP
        64
    """
    if grid is not None and min(grid) < 2:
        raise OptionError("a grid has at least two rows and two columns", hint="as --grid 7x9")
    files = [path] if isinstance(path, (str, Path)) else _several(path)
    if not files:
        raise OptionError("no file is named", hint="name at least one file of points")
    for index, file in enumerate(files):
        if any(is_same(Path(file), str(other)) for other in files[:index]):
            raise OptionError(
                f"{file}: this file is named twice, and its points would count twice",
                hint="name each file once",
            )
    shot = None if photo is None else Shot.of_file(photo, remedy=_GIVE_SIZE)
    parts: list[Observations] = []
    for file in files:
        content = read_bytes(file)
        source = opened(Source(str(file), content))
        row = format_of(source, format)
        known = size if size is not None or shot is None else shot.facts.size
        raw = _chosen(source, row.read(source, ReadOptions(known, grid, order)), image)
        if grid is None and not singly:
            refuse_all_as_one(source, raw)
        part = _with_photos(source, raw, shot, size, pixel_aspect)
        part = replace(part, origins=(Origin(str(file), row.name, content),))
        if not singly:
            part = in_pixels(source, part)
        part = part.checked(ideal=ideal, singly=singly)
        parts.append(part if singly else part.counted_once())
    return join(parts)


def _several(paths: Sequence[str | Path]) -> list[str | Path]:
    try:
        return list(paths)
    except TypeError:
        raise OptionError(
            f"a file name expected, not {type(paths).__name__}", hint="give a str or a Path"
        ) from None


def _with_photos(
    source: Source,
    raw: Observations,
    shot: Shot | None,
    size: tuple[int, int] | None,
    pixel_aspect: float | None,
) -> Observations:
    """What a file holds, its photos' sizes and lenses completed by the photos themselves.

    Args:
        source: The file.
        raw: What it holds.
        shot: The photo that the user names.
        size: The photo's size that the user gives.
        pixel_aspect: The pixel aspect that the user gives.
    """
    notes = list(raw.notes)
    with_lines = {line.photo for line in raw.lines}
    one_lens = len({raw.photos[index].lens for index in with_lines}) == 1
    if shot is not None and not one_lens:
        notes.append(
            f"{shot.facts.name} was not used: the project has lines of several lenses, and it is "
            "not known which of them took it (--image N selects one)"
        )
    photos: list[Photo] = []
    pictures: dict[int, list[PhotoFacts]] = {}
    for index, each in enumerate(raw.photos):
        found = photo_beside(source, each, notes) if shot is None else None
        if one_lens and index in with_lines:
            found = found or shot
        picture = found.facts if found else None
        agreed = agreed_size(source, each, size if index in with_lines else None, picture)
        name = each.name or (picture.name if picture else "")
        aspect = each.pixel_aspect if pixel_aspect is None else pixel_aspect
        photos.append(replace(each, size=agreed, name=name, pixel_aspect=aspect))
        if found and picture and index in with_lines:
            photos[-1] = replace(photos[-1], **asdict(found.identity()))
            pictures.setdefault(each.lens, []).append(picture)
            notes += [n for n in note_on_orientation(picture, agreed) if n not in notes]
    lenses = [with_exif(f, pictures.get(i, []), notes) for i, f in enumerate(raw.lenses)]
    return replace(raw, photos=tuple(photos), lenses=tuple(lenses), notes=tuple(notes))


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
