"""Files that hold others, and files that hold no points: opened, or refused with what helps."""

from __future__ import annotations

import io
import tarfile
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import PurePosixPath

from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS, POINT_FORMATS, recognised
from plumbline.formats.packed import BROKEN, MAX_MEMBERS, MAX_UNPACKED, unpacked_size
from plumbline.wording import listed

_PICTURES = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp")
_ZIP = b"PK\x03\x04"
_PHOTO_HINT = "give the file of points, and this photo with --photo"
_KINDS: tuple[tuple[bytes, int, str, str], ...] = (
    (b"\xff\xd8\xff", 0, "a photo (JPEG)", _PHOTO_HINT),
    (b"\x89PNG", 0, "a picture (PNG)", _PHOTO_HINT),
    (b"II*\x00", 0, "a picture (TIFF)", f"{_PHOTO_HINT}; of an overlay of ImageJ, save the "
     "selections: Image > Overlay > To ROI Manager, then More > Save"),
    (b"MM\x00*", 0, "a picture (TIFF)", f"{_PHOTO_HINT}; of an overlay of ImageJ, save the "
     "selections: Image > Overlay > To ROI Manager, then More > Save"),
    (b"WEBP", 8, "a picture (WebP)", _PHOTO_HINT),
    (b"ftyp", 4, "a picture or a video (HEIC, AVIF, MP4)", _PHOTO_HINT),
    (b"GIF8", 0, "a picture (GIF)", _PHOTO_HINT),
    (b"%PDF", 0, "a PDF", "export the points as text, such as a table line,x,y"),
    (b"\xd0\xcf\x11\xe0", 0, "an old Excel workbook (.xls)", "save the sheet as .xlsx or CSV"),
    (b"\x1f\x8b", 0, "a gzip file", "unpack it and give what it holds"),
    (b"7z\xbc\xaf", 0, "a 7-Zip archive", "unpack it and give what it holds"),
    (b"Rar!", 0, "a RAR archive", "unpack it and give what it holds"),
)  # fmt: skip
"""What else people give: its mark, where that stands, its name and the remedy."""


def opened(source: Source) -> Source:
    """The file of points in an archive, or the file itself.

    Raises:
        ReadError: an archive is broken or holds no file of points or several, or the file is of
            a kind that never holds points.
    """
    for mark, place, name, remedy in _KINDS:
        if source.content[place : place + len(mark)] == mark:
            raise source.error(f"this is {name}, not a file of points", hint=remedy)
    is_tar = source.content[257:262] == b"ustar"
    if not is_tar and not source.content.startswith(_ZIP):
        return source
    if any(row.packed and row.recognises(source) for row in FORMATS.values()):
        return source
    try:
        members = list(_of_tar(source) if is_tar else _of_zip(source))
    except BROKEN:
        raise source.error("the archive is broken", hint="export the points again") from None
    return _the_points(source, members)


def _the_points(source: Source, members: list[tuple[str, bytes]]) -> Source:
    photos = {
        PurePosixPath(name).name: content
        for name, content in members
        if name.lower().endswith(_PICTURES)
    }
    others = [
        replace(source, member=name, content=content, photos=photos)
        for name, content in members
        if not name.lower().endswith(_PICTURES)
    ]
    found = [each for each in others if recognised(each) is not None]
    if len(found) == 1:
        return found[0]
    names = listed([each.member for each in found or others])
    if found:
        raise source.error(
            f"the archive holds {len(found)} files of points ({names})",
            hint="unpack it, and give one of them, or several that one lens took",
        )
    raise source.error(
        "the archive holds no file of points" + (f" ({names})" if names else ""),
        hint=f"these formats are read: {', '.join(POINT_FORMATS)}",
    )


def _of_zip(source: Source) -> Iterator[tuple[str, bytes]]:
    # Every entry of the directory starts with this mark: count before it is all parsed.
    if source.content.count(b"PK\x01\x02") > MAX_MEMBERS:
        raise source.error(f"the archive holds more than {MAX_MEMBERS:,} files")
    with zipfile.ZipFile(io.BytesIO(source.content)) as archive:
        if unpacked_size(source, archive) > MAX_UNPACKED:
            raise source.error("the archive unpacks to more than 512 MiB")
        for info in archive.infolist():
            if _is_own(info.filename) and not info.is_dir():
                with archive.open(info) as member:
                    yield info.filename, member.read(info.file_size)


def _of_tar(source: Source) -> Iterator[tuple[str, bytes]]:
    total = 0
    with tarfile.open(fileobj=io.BytesIO(source.content), mode="r:") as archive:
        for number, info in enumerate(archive):
            total += info.size
            if number == MAX_MEMBERS or total > MAX_UNPACKED:
                raise source.error("the archive is too large: over 10,000 files or 512 MiB")
            member = archive.extractfile(info) if info.isreg() and _is_own(info.name) else None
            if member is not None:
                yield info.name, member.read()


def _is_own(name: str) -> bool:
    """Whether a member is not of the kind that a Mac adds."""
    path = PurePosixPath(name)
    return "__MACOSX" not in path.parts and not path.name.startswith(".")
