"""A photograph decoded: its pixels as stored, and what is needed to write it back alike."""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, JpegImagePlugin

from plumbline.errors import ReadError
from plumbline.photos.exif import FLOATS, FLOATS_HINT
from plumbline.photos.files import jpeg, png, tiff
from plumbline.photos.files.metadata import Metadata

Pixels = NDArray[Any]

MAKER_NOTES_LOST = (
    "the maker notes were left out: they cannot be moved from one TIFF structure to another"
)

_DAMAGE = (ValueError, struct.error, IndexError, KeyError, TypeError, SyntaxError, EOFError)
_HINT = "open it in a viewer, and save it again as JPEG, TIFF or PNG"
_BITS, _EXTRA_SAMPLES = 258, 338
_CV2_MODES = ("L", "RGB")
_MODES = {"1": "L", "P": "RGB", "PA": "RGBA", "La": "LA", "RGBa": "RGBA", "RGBX": "RGB"}
_READERS: dict[str, Callable[[bytes], Metadata]] = {
    "JPEG": jpeg.read_metadata,
    "PNG": png.read_metadata,
    "TIFF": tiff.read_metadata,
}


@dataclass(frozen=True)
class Storage:
    """How a file holds its pixels.

    Attributes:
        format: Pillow's name of the format.
        sampling: JPEG's chroma subsampling: 0 for 4:4:4, 1 for 4:2:2, 2 for 4:2:0.
        progressive: Whether a JPEG is.
        compression: TIFF's number of its compression.
        lossless: Whether a WebP is.
    """

    format: str
    sampling: int = 0
    progressive: bool = False
    compression: int = 5
    lossless: bool = False


@dataclass(frozen=True)
class Picture:
    """A decoded photograph.

    Attributes:
        pixels: As stored, 8 or 16 bit: grey (rows, columns), grey and alpha (…, 2), blue,
            green, red (…, 3), with alpha (…, 4), or four inks.
        inks: Whether the four channels are cyan, magenta, yellow and black.
        metadata: What the file says of itself.
        storage: How the file held it.
        notes: What could not be kept, in plain sentences.
    """

    pixels: Pixels
    inks: bool
    metadata: Metadata
    storage: Storage
    notes: tuple[str, ...] = ()

    @property
    def alpha(self) -> bool:
        """Whether the last channel is alpha."""
        return self.pixels.ndim == 3 and self.pixels.shape[2] in (2, 4) and not self.inks


def decode(data: bytes, path: str | Path) -> Picture:
    """The picture that a file's bytes hold.

    Args:
        data: The bytes.
        path: Where they come from, for messages.

    Raises:
        ReadError: the file is cut short, damaged, of an unknown kind or too large.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = Image.open(io.BytesIO(data))
            storage = _storage(image, data)
            pixels = _by_cv2(image, data) if _suits_cv2(image, data) else _by_pillow(image, path)
            metadata, notes = _metadata(image, data, storage.format)
            frames = getattr(image, "n_frames", 1) if image.format != "MPO" else 1
    except ReadError:
        raise
    except Image.DecompressionBombError:
        raise ReadError(
            "this picture claims to have more pixels than any camera", path=path, hint=_HINT
        ) from None
    except MemoryError:
        raise ReadError("the picture does not fit into memory", path=path) from None
    except (OSError, cv2.error, *_DAMAGE) as error:
        reason = "" if isinstance(error, cv2.error) else f": {error}"
        raise ReadError(
            f"the picture is cut short or damaged{reason}", path=path, hint=_HINT
        ) from None
    if frames > 1:
        notes.append(f"only the first of {frames} pictures in the file was taken")
    return Picture(pixels, image.mode == "CMYK", metadata, storage, tuple(notes))


def _storage(image: Image.Image, data: bytes) -> Storage:
    name = "JPEG" if image.format == "MPO" else image.format or ""
    if name == "JPEG":
        sampling = JpegImagePlugin.get_sampling(image)
        progressive = bool(image.info.get("progressive"))
        return Storage(name, sampling=sampling if sampling >= 0 else 2, progressive=progressive)
    if name == "TIFF":
        return Storage(name, compression=int(_tag(image, tiff.COMPRESSION, 5)))
    return Storage(name, lossless=name == "WEBP" and b"VP8L" in data[:1024])


def _tag(image: Image.Image, tag: int, default: Any) -> Any:
    tags: Any = getattr(image, "tag_v2", {})
    return tags.get(tag, default)


def _suits_cv2(image: Image.Image, data: bytes) -> bool:
    """Whether OpenCV decodes this faithfully; Pillow knows 16 bits only in grey."""
    if image.format in ("JPEG", "MPO"):
        if not jpeg.complete(data):
            raise ValueError("its end is missing")
        return image.mode in _CV2_MODES
    if image.format == "PNG":
        for _ in png.chunks(data):
            pass  # a file cut short is refused
        depth, _ = png.depth_and_kind(data)
        plain = image.mode in (*_CV2_MODES, "RGBA") and "transparency" not in image.info
        return depth == 16 or (depth == 8 and plain)
    if image.format == "TIFF":
        bits = set(_tag(image, _BITS, (1,)))
        return bits == {16} or (
            bits == {8} and image.mode in _CV2_MODES and not _tag(image, _EXTRA_SAMPLES, ())
        )
    return False


def _by_cv2(image: Image.Image, data: bytes) -> Pixels:
    flags = cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION
    pixels: Any = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    if pixels is None or pixels.shape[:2] != (image.height, image.width):
        raise ValueError("its pixels cannot be decoded")
    return pixels


def _by_pillow(image: Image.Image, path: str | Path) -> Pixels:
    mode = _MODES.get(image.mode, image.mode)
    if "transparency" in image.info and mode in ("L", "RGB"):
        mode = "LA" if mode == "L" and image.mode != "P" else "RGBA"
    if mode in ("I", "I;16", "I;16B"):
        values = np.asarray(image)
        if values.size and (values.min() < 0 or values.max() > np.iinfo(np.uint16).max):
            raise ValueError("its grey values have more than 16 bits")
        return values.astype(np.uint16)
    if mode == "F":
        raise ReadError(FLOATS, path=path, hint=FLOATS_HINT)
    if mode not in ("L", "LA", "RGB", "RGBA", "CMYK"):
        mode = "RGB"
    pixels = np.asarray(image if image.mode == mode else image.convert(mode))
    return swapped(pixels) if mode.startswith("RGB") else pixels


def swapped(pixels: Pixels) -> Pixels:
    """Blue and red exchanged: from OpenCV's order to Pillow's and back."""
    order = [2, 1, 0, 3][: pixels.shape[2]]
    return np.ascontiguousarray(pixels[..., order])


def _metadata(image: Image.Image, data: bytes, name: str) -> tuple[Metadata, list[str]]:
    """The file's metadata in the form of its own format and in that of others."""
    info = image.info
    xmp: Any = info.get("xmp") or b""
    packet = xmp if isinstance(xmp, bytes) else str(xmp).encode()
    dpi: Any = info.get("dpi")
    exif: Any = info.get("exif") or b""
    common = Metadata(
        exif=exif.removeprefix(b"Exif\0\0"),
        icc=info.get("icc_profile") or b"",
        xmp=packet,
        dpi=(float(dpi[0]), float(dpi[1])) if dpi else None,
    )
    reader = _READERS.get(name)
    if reader is None:
        return common, []
    try:
        own = reader(data)
    except _DAMAGE:
        return Metadata(), ["its metadata are damaged and were not kept"]
    lost = [MAKER_NOTES_LOST] if name == "TIFF" and tiff.has_maker_notes(data) else []
    return (
        Metadata(own.exif, common.icc or own.icc, packet or own.xmp, common.dpi, own.records),
        lost,
    )
