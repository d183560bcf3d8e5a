"""The photograph that points were picked in: where it is, its size, and its lens by EXIF."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.observations import Photo
from plumbline.observations.facts import LensFacts, best_crop_factor
from plumbline.photos.exif import PhotoFacts, read_photo
from plumbline.photos.identity import Identity, identity_of

ONE_FOCAL_LENGTH = 0.005
"""Focal lengths in millimetres that differ by less, relatively, are one: chosen, EXIF rounds them
to a tenth of a millimetre."""

_COPIED = 1e-4
"""Crop factors that differ by less are one number, copied; chosen, as they have 4 to 6 digits."""


@dataclass(frozen=True)
class Shot:
    """A photograph at hand.

    Attributes:
        facts: What its header says.
        path: Its file; of a member of an archive only the name counts.
        content: Its bytes where it stands in an archive; else None.
    """

    facts: PhotoFacts
    path: Path
    content: bytes | None = None

    @classmethod
    def of_file(cls, path: str | Path, *, remedy: str = "") -> Shot:
        """The photo in a file.

        Raises:
            ReadError: it cannot be read.
        """
        return cls(read_photo(path, remedy=remedy), Path(path))

    @classmethod
    def of_member(cls, name: str, content: bytes) -> Shot:
        """The photo in an archive.

        Raises:
            ReadError: it cannot be read.
        """
        with _at_hand(name, content) as path:
            return cls(replace(read_photo(path), name=name), Path(name), content)

    def identity(self) -> Identity:
        """Which photograph it is.

        Raises:
            ReadError: the file cannot be read.
        """
        if self.content is None:
            return identity_of(self.path)
        with _at_hand(self.path.name, self.content) as path:
            return identity_of(path)


@contextmanager
def _at_hand(name: str, content: bytes) -> Generator[Path]:
    """A file with the bytes of a member of an archive, for as long as it is needed."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"photo{Path(name).suffix}"
        path.write_bytes(content)
        yield path


def photo_beside(source: Source, photo: Photo, notes: list[str]) -> Shot | None:
    """The photo that a file of points names, if it lies in its folder or its archive."""
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    if not name and len(source.photos) == 1:
        (name,) = source.photos
    if not name or name in (".", ".."):
        return None
    path = Path(source.path).parent / name
    try:
        if name in source.photos:
            shot = Shot.of_member(name, source.photos[name])
        elif path.is_file():
            shot = Shot.of_file(path)
        else:
            return None
    except ReadError as error:
        notes.append(f"the photo beside the file was not used: {error.message}")
        return None
    except (OSError, ValueError):
        return None
    found = shot.facts
    if photo.size not in (None, found.size, found.stored_size):
        width, height = photo.frame.size
        notes.append(
            f"{name} beside the file is {found.size[0]}x{found.size[1]} and not the file's "
            f"{width}x{height}: its EXIF was not used"
        )
        return None
    return shot


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
