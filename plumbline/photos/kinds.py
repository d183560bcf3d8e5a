"""Kinds of picture files that are refused by name, with what to do instead."""

from __future__ import annotations

from pathlib import Path

from plumbline.errors import ReadError

HEAD = 64
"""Bytes of a file that tell its kind."""

RAW_HINT = (
    "develop it in a raw converter without lens correction, and give the TIFF or JPEG it writes"
)
FLOATS = "32-bit float pictures are not supported"
FLOATS_HINT = "save it with 16 bits a channel"

_CONVERT = "save it as JPEG, TIFF or PNG first, without lens correction"
_RAW = (
    (b"II*\0\x10\0\0\0CR", "Canon raw file (CR2)"),
    (b"IIRO", "Olympus raw file (ORF)"),
    (b"IIRS", "Olympus raw file (ORF)"),
    (b"MMOR", "Olympus raw file (ORF)"),
    (b"IIU\0", "Panasonic raw file (RW2)"),
    (b"FUJIFILMCCD-RAW", "Fujifilm raw file (RAF)"),
    (b"FOVb", "Sigma raw file (X3F)"),
    (b"\0MRM", "Minolta raw file (MRW)"),
    (b"II\x1a\0\0\0HEAPCCDR", "Canon raw file (CRW)"),
)
_OTHERS = (
    (b"8BPS", "Photoshop file (PSD)"),
    (b"\xff\x0a", "JPEG XL picture"),
    (b"\0\0\0\x0cJXL \r\n\x87\n", "JPEG XL picture"),
    (b"%PDF", "PDF file"),
)
_BRANDS = {
    b"crx ": ("Canon raw file (CR3)", RAW_HINT),
    b"heic": ("HEIC picture", _CONVERT),
    b"heix": ("HEIC picture", _CONVERT),
    b"hevc": ("HEIC picture", _CONVERT),
    b"heim": ("HEIC picture", _CONVERT),
    b"heis": ("HEIC picture", _CONVERT),
    b"mif1": ("HEIF picture", _CONVERT),
    b"msf1": ("HEIF picture", _CONVERT),
    b"avif": ("AVIF picture", _CONVERT),
    b"avis": ("AVIF picture", _CONVERT),
}
"""Brands of ISO media files, ISO/IEC 14496-12: bytes 8 to 12, after `ftyp`."""


def refuse_by_name(head: bytes, path: str | Path) -> None:
    """Refuse a file of a known kind that is not read.

    Args:
        head: Its first bytes.
        path: Its name, for the sentence.

    Raises:
        ReadError: it is a raw file, HEIC, AVIF or another picture that has to be converted.
    """
    for start, name in _RAW:
        if head.startswith(start):
            raise ReadError(f"this is a {name}", path=path, hint=RAW_HINT)
    for start, name in _OTHERS:
        if head.startswith(start):
            raise ReadError(f"this is a {name}", path=path, hint=_CONVERT)
    if head[4:8] == b"ftyp" and head[8:12] in _BRANDS:
        name, hint = _BRANDS[head[8:12]]
        article = "an" if name.startswith("AVIF") else "a"
        raise ReadError(f"this is {article} {name}", path=path, hint=hint)


def is_tiff(head: bytes) -> bool:
    """Whether a file is a TIFF file, BigTIFF included."""
    return head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
