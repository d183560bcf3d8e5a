"""Read picked points: find the format, learn the photo's size and lens, check, join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from plumbline.calibration import Calibration
from plumbline.errors import OptionError, ReadError
from plumbline.facts import LensFacts
from plumbline.files import read_bytes
from plumbline.formats import Source, format_of
from plumbline.formats.base import Order, ReadOptions
from plumbline.lenses.exif import PhotoFacts, read_photo
from plumbline.observations import Observations, Origin, Photo
from plumbline.result_json import from_json


def read(
    path: str | Path,
    *,
    photo: str | Path | None = None,
    size: tuple[int, int] | None = None,
    format: str | None = None,  # noqa: A002
    grid: tuple[int, int] | None = None,
    order: Order = "raster",
    pixel_aspect: float = 1.0,
) -> Observations:
    """Read picked points from a file of any known format.

    Args:
        path: The file.
        photo: The photograph they were picked in; tells its size, and by EXIF its lens.
        size: Width and height of the photograph, where neither file nor photo tell it.
        format: Name of the file's format; recognised by suffix and content if None.
        grid: Rows and columns, where one polyline holds a whole grid (WinMorph).
        order: How that polyline runs: each row from the left, or back and forth.
        pixel_aspect: Width of one pixel over its height, for video frames.

    Returns:
        Checked observations.

    Raises:
        ReadError: the file is missing, damaged or holds no usable line.
        OptionError: an argument contradicts the file.
        DegenerateLinesError: no line has three distinct points.

    Example:
        >>> import plumbline
        >>> plumbline.read("building.pto").n_points  # doctest: +SKIP
        64
    """
    source = Source(str(path), read_bytes(path))
    found = format_of(source, format)
    shot = None if photo is None else read_photo(photo)
    known = size if size is not None or shot is None else shot.size
    raw = found.read(source, ReadOptions(known, grid, order))
    photos, lenses, notes = list(raw.photos), list(raw.lenses), list(raw.notes)
    with_lines = {line.photo for line in raw.lines}
    for index, each in enumerate(photos):
        picture = shot if shot is not None and _is_meant(photos, with_lines, index) else None
        if picture is None and shot is None:
            picture = _beside(source, each, notes)
        name = Path(photo).name if picture is not None and picture is shot and photo else each.name
        photos[index] = replace(
            each,
            size=_size(source, each, size if index in with_lines else None, picture),
            name=each.name or name,
            number=index,
            pixel_aspect=pixel_aspect,
        )
        if picture is not None and index in with_lines:
            lenses[each.lens] = _joined(lenses[each.lens], picture.facts)
            notes += [note for note in picture.notes if note not in notes]
    if photo is not None and not any(_is_meant(photos, with_lines, i) for i in with_lines):
        notes.append(
            f"{Path(photo).name} was not used: the project has lines of several lenses, and it is "
            "not known which of them took it"
        )
    return replace(
        raw,
        photos=tuple(photos),
        lenses=tuple(lenses),
        notes=tuple(notes),
        origins=(Origin(str(path), found.name, source.content),),
    ).checked()


def join(parts: Sequence[Observations]) -> Observations:
    """Photos of one lens, read from several files, as one set of observations.

    Raises:
        OptionError: a file holds several lenses, or the files tell of different focal lengths.
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
        other = part.lenses[0]
        if facts.focal_mm and other.focal_mm and abs(facts.focal_mm / other.focal_mm - 1) > 0.005:
            raise OptionError(
                f"{part.named}the focal length is {other.focal_mm:g} mm, in the first file "
                f"{facts.focal_mm:g} mm: these are not photos of one lens setting",
                hint="fit each focal length by itself",
            )
        facts = _joined(facts, other)
    whole = Observations.side_by_side(parts)
    photos = tuple(replace(photo, lens=0) for photo in whole.photos)
    return replace(whole, photos=photos, lenses=(facts,))


def _is_meant(photos: Sequence[Photo], with_lines: set[int], index: int) -> bool:
    """Whether the photo the user names is this one: the only one, or one of its lens."""
    return index in with_lines and len({photos[i].lens for i in with_lines}) == 1


def _beside(source: Source, photo: Photo, notes: list[str]) -> PhotoFacts | None:
    """The photo that the file names, if it lies in the file's folder."""
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    if not name or name in (".", ".."):
        return None
    path = Path(source.path).parent / name
    try:
        if not path.is_file():
            return None
        found = read_photo(path)
    except ReadError as error:
        notes.append(f"the photo beside the file was not used: {error.message}")
        return None
    except (OSError, ValueError):
        return None
    if photo.size is not None and photo.size not in (found.size, found.size[::-1]):
        notes.append(
            f"{name} beside the file is {found.size[0]}x{found.size[1]} and not the file's "
            f"{photo.size[0]}x{photo.size[1]}: its EXIF was not used"
        )
        return None
    return found


def _size(
    source: Source, photo: Photo, given: tuple[int, int] | None, picture: PhotoFacts | None
) -> tuple[int, int]:
    """The photo's size, from whoever knows it, if they agree."""
    told = [("the file", photo.size), ("--size", given)]
    told.append(("the photo", picture.size if picture else None))
    known = [(who, size) for who, size in told if size is not None]
    if not known:
        raise source.error(
            "the size of the photo is not known",
            hint="give the photo with --photo FILE or its size with --size WIDTHxHEIGHT",
        )
    (who, size), *others = known
    for other, differing in others:
        sideways = other == "the photo" and picture is not None and picture.turned
        if differing != size and not (sideways and differing == size[::-1]):
            raise source.error(
                f"contradictory sizes: {who} says {size[0]}x{size[1]}, {other} "
                f"{differing[0]}x{differing[1]}",
                hint="picks must be made in the photo at the size that is given",
            )
    return size


def _joined(facts: LensFacts, more: LensFacts) -> LensFacts:
    """Facts, with what they do not know taken from others; EXIF knows the focal length best."""
    return replace(
        facts,
        maker=facts.maker or more.maker,
        model=facts.model or more.model,
        camera=facts.camera or more.camera,
        mount=facts.mount or more.mount,
        focal_mm=facts.focal_mm or more.focal_mm,
        crop_factor=facts.crop_factor or more.crop_factor,
        crop_factor_error=(facts if facts.crop_factor else more).crop_factor_error,
        hfov_deg=facts.hfov_deg or more.hfov_deg,
    )


def read_calibrations(path: str | Path) -> tuple[Calibration, ...]:
    """Read the calibrations of a JSON file that plumbline wrote, one a lens.

    Raises:
        ReadError: it is missing, damaged or no such file.
    """
    return from_json(Source(str(path), read_bytes(path)).text(), str(path))


def read_calibration(path: str | Path) -> Calibration:
    """Read the one calibration of a JSON file that plumbline wrote.

    Raises:
        ReadError: it is missing, damaged, no such file, or holds several lenses.
    """
    found = read_calibrations(path)
    if len(found) != 1:
        raise ReadError(
            f"the file holds {len(found)} calibrations",
            path=path,
            hint="take them all with plumbline.read_calibrations",
        )
    return found[0]
