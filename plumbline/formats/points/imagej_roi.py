"""The selections (ROIs) of ImageJ, one a file or a zipped set; see `imagej`.

Kept: names, coordinates to the part of a pixel where stored, counters, groups. Source:
`ij/io/RoiDecoder.java`, through the package roifile.
"""

from __future__ import annotations

import io
import lzma
import struct
import zipfile
import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from plumbline.formats.base import Source, shown
from plumbline.formats.points.lines import LineGatherer, clean_label
from plumbline.frame import Array
from plumbline.observations import Observations

if TYPE_CHECKING:
    from roifile import ImagejRoi

MAX_ENTRIES = 10_000
"""Chosen: ImageJ's manager slows down at some thousand selections."""
MAX_UNPACKED = 64 * 2**20
"""Bytes; chosen, a million picks take 8 MB; it stops archives that unfold without end."""
_TYPES = (
    "polygon", "rectangle", "oval", "line", "freehand line", "polyline",
    "nothing", "freehand area", "traced area", "angle", "point",
)  # fmt: skip
_READ = {"line", "freehand line", "polyline", "point"}
_ZIP_ERRORS = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, lzma.LZMAError, struct.error,
    NotImplementedError, RuntimeError, EOFError, OSError, ValueError, KeyError, IndexError,
)  # fmt: skip


def read_selections(source: Source) -> Observations:
    """Lines of one selection, or of a zipped set of them.

    Raises:
        ReadError: the file is broken, or unpacks to more than any real set.
    """
    gatherer = LineGatherer(source)
    grouped: dict[int, list[Array]] = {}
    for name, content in _entries(source):
        kind = _kind(source, name, content)
        if kind not in _READ:
            gatherer.leave_aside(kind)
            continue
        roi = _decoded(source, name, content)
        points = np.asarray(roi.coordinates(), dtype=np.float64).reshape(-1, 2)
        if kind == "point" and len(points) == 1 and roi.group:
            grouped.setdefault(int(roi.group), []).append(points)
            continue
        for label, chosen in _parts(roi, clean_label(roi.name or "") or name, points):
            gatherer.add(chosen, label)
    for group, single in grouped.items():
        gatherer.add(np.concatenate(single), f"Group {group}")
    return gatherer.observations("line, polyline, freehand line and point selections")


def _entries(source: Source) -> Iterator[tuple[str, bytes]]:
    """Names without suffix and contents of the selections in the file."""
    content = source.content
    if not content.startswith(b"PK"):
        yield source.path.replace("\\", "/").rpartition("/")[2].removesuffix(".roi"), content
        return
    # Every entry of the directory starts with this mark: count before it is all parsed.
    entries = content.count(b"PK\x01\x02")
    if entries > MAX_ENTRIES or len(content) > MAX_UNPACKED:
        raise source.error(f"the set of selections is too large: {entries:,} entries")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            chosen = [
                info
                for info in archive.infolist()
                if info.filename.lower().endswith(".roi") and "__MACOSX" not in info.filename
            ]
            if sum(info.file_size for info in archive.infolist()) > MAX_UNPACKED:
                raise source.error("the set unpacks to more than 64 MiB")
            for info in chosen:
                name = info.filename.replace("\\", "/").rpartition("/")[2][:-4]
                with archive.open(info) as entry:
                    yield name, entry.read(MAX_UNPACKED)
    except _ZIP_ERRORS as error:
        raise source.error(
            f"the zipped set of selections is broken: {clean_label(str(error))}",
            hint="save it again from the ROI Manager",
        ) from None
    if not chosen:
        raise source.error(
            "the zip file holds no selections (.roi)",
            hint="save the ROI Manager's selections with More » Save",
        )


def _kind(source: Source, name: str, content: bytes) -> str:
    if len(content) < 64 or not content.startswith(b"Iout"):
        raise source.error(f"{shown(name)} is not an ImageJ selection", hint="save it again")
    return _TYPES[content[6]] if content[6] < len(_TYPES) else "unknown selection"


def _decoded(source: Source, name: str, content: bytes) -> ImagejRoi:
    from roifile import ImagejRoi

    try:
        return ImagejRoi.frombytes(content)
    except (ValueError, TypeError, IndexError, OverflowError, AssertionError, struct.error):
        raise source.error(
            f"the selection {shown(name)} is cut off or broken", hint="save it again"
        ) from None


def _parts(roi: ImagejRoi, label: str, points: Array) -> Iterator[tuple[str, Array]]:
    """One line a counter of a multi-point selection; all others whole."""
    counters = roi.counters
    if counters is None or len(counters) != len(points) or len(set(counters.tolist())) < 2:
        yield label, points
        return
    for counter in dict.fromkeys(counters.tolist()):
        yield f"{label} counter {counter}", points[counters == counter]
