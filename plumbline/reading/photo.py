"""The photograph that points were picked in: where it is, its size, and its lens by EXIF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.observations import Photo
from plumbline.observations.facts import LensFacts, best_crop_factor
from plumbline.photos.exif import PhotoFacts, read_photo

ONE_FOCAL_LENGTH = 0.005
"""Focal lengths in millimetres that differ by less, relatively, are one."""

_COPIED = 1e-4


def photo_beside(source: Source, photo: Photo, notes: list[str]) -> PhotoFacts | None:
    """The photo that a file of points names, if it lies in that file's folder."""
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    if not name and len(source.photos) == 1:
        (name,) = source.photos
    if not name or name in (".", ".."):
        return None
    path = Path(source.path).parent / name
    try:
        if name in source.photos:
            found = _read_member(name, source.photos[name])
        elif path.is_file():
            found = read_photo(path)
        else:
            return None
    except ReadError as error:
        notes.append(f"the photo beside the file was not used: {error.message}")
        return None
    except (OSError, ValueError):
        return None
    if photo.size not in (None, found.size, found.stored_size):
        width, height = photo.frame.size
        notes.append(
            f"{name} beside the file is {found.size[0]}x{found.size[1]} and not the file's "
            f"{width}x{height}: its EXIF was not used"
        )
        return None
    return found


def _read_member(name: str, content: bytes) -> PhotoFacts:
    """The header of a photo that stands in an archive."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"photo{Path(name).suffix}"
        path.write_bytes(content)
        return replace(read_photo(path), name=name)


def agreed_size(
    source: Source, photo: Photo, given: tuple[int, int] | None, picture: PhotoFacts | None
) -> tuple[int, int]:
    """The photo's size, from whoever knows it, if they agree.

    A picture that EXIF turns may have been picked in upright or as it is stored.

    Args:
        source: The file of points.
        photo: The photo as that file has it.
        given: The size that the user gives.
        picture: The photo itself.

    Raises:
        ReadError: nobody knows it, or they contradict each other.
    """
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
        as_stored = other == "the photo" and picture is not None and size == picture.stored_size
        if differing != size and not as_stored:
            raise source.error(
                f"contradictory sizes: {who} says {size[0]}x{size[1]}, {other} "
                f"{differing[0]}x{differing[1]}",
                hint="pick the points in the photo at the size that is given",
            )
    return size


def note_on_orientation(picture: PhotoFacts, size: tuple[int, int]) -> list[str]:
    """A note where picks are taken in another picture than the one stored."""
    if not picture.turned or size != picture.size:
        return []
    return [
        f"{picture.name} is stored sideways (EXIF orientation); its picks are taken in the "
        f"upright {size[0]}x{size[1]} picture"
    ]


def with_exif(facts: LensFacts, pictures: Sequence[PhotoFacts], notes: list[str]) -> LensFacts:
    """What a file of points tells of its lens, completed from EXIF, which knows better.

    Args:
        facts: What the file tells.
        pictures: The photos taken with the lens.
        notes: Gets what does not fit.
    """
    if not pictures:
        return facts
    notes += dict.fromkeys(note for picture in pictures for note in picture.notes)
    focals = {picture.name: picture.facts.focal_mm for picture in pictures}
    known = [focal for focal in focals.values() if focal]
    if known and max(known) / min(known) - 1 > ONE_FOCAL_LENGTH:
        listed = ", ".join(f"{name} at {focal:g} mm" for name, focal in focals.items() if focal)
        notes.append(
            f"photos that are linked to one lens were taken at several focal lengths ({listed}): "
            "unlink them, or select one with --image N"
        )
    exif = pictures[0].facts
    for picture in pictures[1:]:
        exif = exif.completed(picture.facts)
    if exif.crop_factor and facts.crop_factor:
        if abs(facts.crop_factor / exif.crop_factor - 1) < _COPIED:
            facts = replace(facts, crop_factor=None)  # its source tells its uncertainty too
        elif best_crop_factor([exif, facts]) is None:
            notes.append(
                f"the crop factor is {exif.crop_factor:.4g} by EXIF but {facts.crop_factor:.4g} "
                "by the project: EXIF's counts (--crop-factor)"
            )
    return replace(exif.completed(facts), projection=facts.projection)
