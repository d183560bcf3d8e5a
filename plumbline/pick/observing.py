"""From a document to what the fit consumes, and from a file of points to a document."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts
from plumbline.pick.document import Change, Document, PickedLine

LIVE_SAMPLES = 8
"""Samples of a traced line in the live fit. A row of the smallest compiled block holds 8
(`plumbline.fit.program.blocks`), and 8 evenly spaced samples hold the bend of a line."""


def observations_of(
    document: Document, *, most: int | None = None, origin: Origin | None = None
) -> Observations:
    """The lines of a document as observations of one lens.

    Args:
        document: The document.
        most: Take at most so many samples of a traced line, evenly spaced; free picks all count.
        origin: The file they are kept in.

    Raises:
        DegenerateLinesError: no line has three distinct points.
    """
    lines = [Line(_thinned(line, most), line.photo, line.name) for line in fitted_lines(document)]
    photos = [
        Photo(record.size, record.name, number=number, sha256=record.sha256)
        for number, record in enumerate(document.photos)
    ]
    origins = () if origin is None else (origin,)
    return Observations(tuple(photos), tuple(lines), (document.facts,), (), origins).checked()


def fitted_lines(document: Document) -> list[PickedLine]:
    """The lines that the fit uses: those of at least three distinct points."""
    return [line for line in document.lines if len(set(line.points)) >= 3]


def _thinned(line: PickedLine, most: int | None) -> Array:
    points = np.array(line.points, dtype=np.float64).reshape(-1, 2)
    if most is None or not line.snapped or len(points) <= most:
        return points
    return points[np.linspace(0, len(points) - 1, most).round().astype(np.int64)]


def known_of(facts: LensFacts) -> LensFacts:
    """What is known of a lens without what a project stores or asks for: the page decides that."""
    return replace(facts, stored={}, requested=None)


def with_points(document: Document, read: Observations, sha256: str, name: str) -> Document:
    """The document with the lines of a file of points, as one action that can be undone.

    Args:
        document: The document.
        read: What the file holds.
        sha256: Of its bytes; a file that was taken before is not taken again.
        name: Its name.

    Raises:
        OptionError: a photo of the file is not among the document's, or is of another size.
    """
    if sha256 in document.imported:
        return document
    places = [_photo_number(document, read, index) for index in range(len(read.photos))]
    changes: list[Change] = []
    for number, line in enumerate(read.lines, document.next_number):
        points = tuple((float(x), float(y)) for x, y in line.points_px)
        new = PickedLine(number, places[line.photo], points, points, label=line.label)
        changes.append(Change(None, new))
    return msgspec.structs.replace(
        document.acted(f"take the lines of {name}", changes),
        imported=(*document.imported, sha256),
        facts=document.facts.completed(known_of(read.lenses[0])),
    )


def _photo_number(document: Document, read: Observations, index: int) -> int:
    """Which photo of the document a photo of a file of points is: by name, or the only one."""
    photo = read.photos[index]
    name = photo.name.replace("\\", "/").rpartition("/")[2]
    named = [i for i, record in enumerate(document.photos) if record.name == name]
    if not named and len(document.photos) == len(read.photos) == 1:
        named = [0]
    if not named:
        raise OptionError(
            f"the points are of {name or 'a photo without a name'}, which is not opened here",
            hint="name that photo too",
        )
    record = document.photos[named[0]]
    if photo.frame.size != record.size:
        width, height = record.size
        raise OptionError(
            f"the points were picked at {photo.frame.width}x{photo.frame.height}, and "
            f"{record.name} has {width}x{height} pixels",
            hint="name the photo that the points were picked in, at its full size",
        )
    return named[0]
