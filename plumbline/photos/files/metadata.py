"""What a photograph says of itself, apart from its pixels."""

from __future__ import annotations

import re
from dataclasses import dataclass

from plumbline._version import __version__
from plumbline.wording import in_ascii

CORRECTED = "corrected by plumbline"
"""Stands in every photograph that plumbline corrected: in EXIF's Software, else in a comment."""

_MOST_OF_A_NOTE = 240  # characters; chosen, a line or two in a viewer
_FOLDERS = re.compile(r"\S*[\\/](?=[^\s\\/]+\.[a-zA-Z]\w{1,3}\b)")


@dataclass(frozen=True)
class Metadata:
    """Metadata on its way from one file into another.

    Attributes:
        exif: The EXIF block, a small TIFF file of its own; may be empty.
        icc: The ICC colour profile; may be empty.
        xmp: The XMP packet; may be empty.
        iptc: IPTC records; may be empty.
        photoshop: Photoshop's image resources, IPTC among them; may be empty.
        comment: A comment; may be empty.
        dpi: Pixels an inch across and down.
        records: Whole segments or chunks, for a file of the same format.
        only_here: What `records` hold that no other format can take, in words.
    """

    exif: bytes = b""
    icc: bytes = b""
    xmp: bytes = b""
    iptc: bytes = b""
    photoshop: bytes = b""
    comment: str = ""
    dpi: tuple[float, float] | None = None
    records: tuple[bytes, ...] = ()
    only_here: tuple[str, ...] = ()


def note_of(description: str) -> str:
    """The note of a correction, plain ASCII, without the user's folders."""
    plain = " ".join(in_ascii(description).split())
    plain = _FOLDERS.sub("", plain)
    return f"{CORRECTED} {__version__} ({plain[:_MOST_OF_A_NOTE]})"
