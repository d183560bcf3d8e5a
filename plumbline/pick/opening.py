"""From files that the user names to a session: photos, picks beside them, files of points."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import msgspec

from plumbline.errors import OptionError, ReadError
from plumbline.files import is_same, read_bytes
from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS
from plumbline.frame import Frame
from plumbline.photos.exif import read_photo
from plumbline.pick.document import FORMAT, VERSION, Document, PhotoRecord
from plumbline.pick.observing import known_of, with_points
from plumbline.pick.photos import LoadedPhoto, is_photo
from plumbline.pick.saving import Keeper, picks_beside
from plumbline.pick.session import Session
from plumbline.pick.tracing import Tracer
from plumbline.reading.gathering import labelled
from plumbline.reading.points import read
from plumbline.wording import listed

_MOST_PHOTOS = 20
"""Photos of one lens side by side. Chosen, because each takes its size in memory."""


def open_session(sources: Sequence[str], labels: Mapping[str, Any]) -> Session:
    """Open photos and what was picked in them.

    Args:
        sources: Photographs of one lens, and at most one file of points.
        labels: What the user says of the lens, by the options' names.

    Raises:
        ReadError: a file cannot be read, or the picks beside the photo are of another size.
        OptionError: the files do not go together.
        WriteError: another program has the picks open.
    """
    paths = [Path(source) for source in sources]
    photos = [LoadedPhoto(path) for path in paths if not path.exists() or is_photo(path)]
    points = [path for path in paths if path.exists() and not is_photo(path)]
    if not photos:
        _refuse_unreadable(points)
        raise OptionError(
            f"none of the files is a photo: {listed(list(sources))}",
            hint="name the photo that the points were picked in, as in plumbline pick "
            "facade.jpg picks.csv",
        )
    _refuse_many(photos, points)
    keeper = Keeper(picks_beside(photos[0].path))
    with ExitStack() as undo:
        undo.callback(keeper.close)
        document, notes = _document(keeper, photos, labels)
        for path in points:
            document = _taken(document, path, photos)
        keeper.write(document)
        undo.pop_all()  # from here on the session holds the picks
    return Session(document, photos, keeper, Tracer(photos), notes)


def _refuse_unreadable(paths: Sequence[Path]) -> None:
    """Refuse files that hold neither points nor a photo: they were meant as photos."""
    for path in paths:
        known = path.is_file() and any(
            each.recognises(Source(str(path), read_bytes(path))) for each in FORMATS.values()
        )
        if not known:
            read_photo(path)


def _refuse_many(photos: Sequence[LoadedPhoto], points: Sequence[Path]) -> None:
    if len(points) > 1:
        raise OptionError(
            f"there are {len(points)} files of points: {listed([str(p) for p in points])}",
            hint="name one of them; the page takes one file of points at a time",
        )
    if len(photos) > _MOST_PHOTOS:
        raise OptionError(f"there are {len(photos)} photos, and at most {_MOST_PHOTOS} fit")
    for index, photo in enumerate(photos):
        if any(is_same(photo.path, str(other.path)) for other in photos[:index]):
            raise OptionError(f"{photo.path}: this photo is named twice", hint="name it once")
    first = photos[0].size
    for photo in photos[1:]:
        if photo.size not in (first, first[::-1]):
            raise OptionError(
                f"{photo.path.name} has {photo.size[0]}x{photo.size[1]} pixels and "
                f"{photos[0].path.name} {first[0]}x{first[1]}: these are not photos of one lens "
                "setting",
                hint="open photos of one size together",
            )


def _document(
    keeper: Keeper, photos: Sequence[LoadedPhoto], labels: Mapping[str, Any]
) -> tuple[Document, list[str]]:
    """What was picked before, with the photos that are new; or an empty document."""
    found = keeper.read()
    records = [PhotoRecord(photo.path.name, photo.size) for photo in photos]
    frame = Frame(*photos[0].size)
    facts = photos[0].facts.facts
    for photo in photos[1:]:
        facts = facts.completed(photo.facts.facts)
    if found is None:
        empty = Document(
            FORMAT, VERSION, tuple(records), facts=known_of(labelled(facts, labels, frame))
        )
        return empty, []
    known = {record.name: record for record in found.photos}
    for record in records:
        before = known.get(record.name)
        if before is not None and before.size != record.size:
            raise ReadError(
                f"the picks were made at {before.size[0]}x{before.size[1]}, and {record.name} "
                f"has {record.size[0]}x{record.size[1]} pixels",
                path=keeper.path,
                hint="open the photo that they were picked in, or move the picks away",
            )
    missing = [name for name in known if name not in {record.name for record in records}]
    if missing:
        raise OptionError(
            f"{keeper.path.name} holds picks in {listed(missing)} too",
            hint="name these photos too, those of the picks first",
        )
    in_order = [*found.photos, *(each for each in records if each.name not in known)]
    document = msgspec.structs.replace(
        found, photos=tuple(in_order), facts=labelled(found.facts, labels, frame)
    )
    return document, [f"went on with {keeper.path.name}"]


def _taken(document: Document, path: Path, photos: Sequence[LoadedPhoto]) -> Document:
    """The document with the lines of a file of points."""
    content = read_bytes(path)
    photo = str(photos[0].path) if len(photos) == 1 else None
    observed = read(path, photo=photo)
    return with_points(document, observed, hashlib.sha256(content).hexdigest(), path.name)
