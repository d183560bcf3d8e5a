"""What stands before the pixels of a picture file: its size, EXIF, XMP and remarks."""

from __future__ import annotations

import struct
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbline.errors import ReadError
from plumbline.photos.kinds import HEAD, is_tiff, refuse_by_name

_EXIF_IFD = 0x8769
"""The tag that points to EXIF's directory."""
_DAMAGE = (
    *(OSError, ValueError, SyntaxError, LookupError, TypeError, EOFError, struct.error),
    *(OverflowError, AttributeError, RuntimeError, NotImplementedError),
)
"""What Pillow and tifffile raise for files that make no sense."""


@dataclass(frozen=True)
class Header:
    """What stands before the pixels.

    Attributes:
        size: Width and height as stored.
        tags: EXIF's values by tag, of its first two directories.
        block: The EXIF block; may be empty.
        packet: The XMP packet; may be empty.
        remark: A comment that plumbline left; else empty.
    """

    size: tuple[int, int]
    tags: dict[int, Any]
    block: bytes
    packet: bytes
    remark: str


def read_header(path: str | Path, hint: str) -> Header:
    """Read what stands before the pixels.

    Args:
        path: The file.
        hint: The remedy where it cannot be read.

    Raises:
        ReadError: the file is missing, or not a picture that can be read.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        _refuse_other_than_file(path, hint)
        with Path(path).open("rb") as file:
            head = file.read(HEAD)
        refuse_by_name(head, path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _tiff_header(path) if is_tiff(head) else _other_header(path)
    except ReadError:
        raise
    except FileNotFoundError:
        raise ReadError("there is no such photo", path=path, hint=hint) from None
    except UnidentifiedImageError:
        raise ReadError("this is not a picture that can be read", path=path, hint=hint) from None
    except Image.DecompressionBombError:
        raise ReadError(
            "this picture claims to have more pixels than any camera", path=path, hint=hint
        ) from None
    except _DAMAGE as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise ReadError(f"the photo cannot be read: {reason}", path=path, hint=hint) from None


def _refuse_other_than_file(path: str | Path, hint: str) -> None:
    if not Path(path).is_file() and Path(path).exists():
        raise ReadError("this is not a file", path=path, hint=hint)


def _other_header(path: str | Path) -> Header:
    from PIL import Image

    with Image.open(path) as image:
        exif = image.getexif()
        tags = dict(exif) | dict(exif.get_ifd(_EXIF_IFD))
        block, packet = image.info.get("exif") or b"", image.info.get("xmp") or b""
        comment = image.info.get("comment") or image.info.get("Software") or b""
        words = comment.decode("utf-8", "replace") if isinstance(comment, bytes) else str(comment)
        return Header(
            image.size,
            tags,
            block.removeprefix(b"Exif\0\0") if isinstance(block, bytes) else b"",
            packet if isinstance(packet, bytes) else str(packet).encode(),
            words if "plumbline" in words else "",
        )


def _tiff_header(path: str | Path) -> Header:
    from PIL import Image

    from plumbline.photos.files import tiff, tiff_tags

    with tiff.opened(path, path) as page:
        size, block, packet = tiff.size_of(page), tiff_tags.exif_block(page), tiff_tags.xmp(page)
    if min(size) < 1:
        raise ValueError("it has no pixels")
    exif = Image.Exif()
    exif.load(b"Exif\0\0" + block)
    tags = dict(exif) | dict(exif.get_ifd(_EXIF_IFD))
    return Header(size, tags, block, packet, "")
