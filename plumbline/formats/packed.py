"""What archives may hold, and how broken ones show."""

from __future__ import annotations

import lzma
import struct
import tarfile
import zipfile
import zlib

from plumbline.formats.base import Source

MAX_MEMBERS = 10_000
"""Chosen: a set of selections, one for each line, has at most some hundred."""

MAX_UNPACKED = 512 * 2**20
"""Bytes; chosen, because an archive of points holds one photo of at most some hundred MB."""

BROKEN = (
    zipfile.BadZipFile, zipfile.LargeZipFile, tarfile.TarError, zlib.error, lzma.LZMAError,
    struct.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError, KeyError,
    IndexError, OverflowError, TypeError, AttributeError, SyntaxError, AssertionError,
)  # fmt: skip
"""What the libraries raise for damaged archives and workbooks."""


def unpacked_size(source: Source, archive: zipfile.ZipFile) -> int:
    """Bytes of all members of a zip.

    Raises:
        ReadError: there are more members than any real file has.
    """
    infos = archive.infolist()
    if len(infos) > MAX_MEMBERS:
        raise source.error(f"the archive holds more than {MAX_MEMBERS:,} files")
    return sum(info.file_size for info in infos)
