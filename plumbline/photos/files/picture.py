"""A photograph decoded: its pixels as stored, and what is needed to write it back alike."""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, JpegImagePlugin, UnidentifiedImageError

from plumbline.errors import ReadError
from plumbline.photos.files import jpeg, png
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.kinds import FLOATS, FLOATS_HINT, HEAD, is_tiff, refuse_by_name

Pixels = NDArray[Any]

MAKER_NOTES_LOST = (
    "the maker notes were left out: they cannot be moved from one TIFF structure to another"
)

_DAMAGE = (ValueError, struct.error, IndexError, KeyError, TypeError, SyntaxError, EOFError)
_HINT = "open it in a viewer, and save it again as JPEG, TIFF or PNG"
_CV2_MODES = ("L", "RGB")
_MODES = {"1": "L", "P": "RGB", "PA": "RGBA", "La": "LA", "RGBa": "RGBA", "RGBX": "RGB"}
_READERS: dict[str, Callable[[bytes], tuple[Metadata, list[str]]]] = {
    "JPEG": jpeg.read_metadata,
    "PNG": png.read_metadata,
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
    refuse_by_name(data[:HEAD], path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _tiff(data, path) if is_tiff(data) else _other(data, path)
    except ReadError:
        raise
    except Image.DecompressionBombError:
        raise ReadError(
            "this picture claims to have more pixels than any camera", path=path, hint=_HINT
        ) from None
    except MemoryError:
        raise ReadError("the picture does not fit into memory", path=path) from None
    except UnidentifiedImageError:
        raise ReadError("this is not a picture that can be read", path=path, hint=_HINT) from None
    except (OSError, cv2.error, *_DAMAGE) as error:
        reason = "" if isinstance(error, cv2.error) else f": {error}"
        raise ReadError(
            f"the picture is cut short or damaged{reason}", path=path, hint=_HINT
        ) from None


def _other(data: bytes, path: str | Path) -> Picture:
    """The picture of any format but TIFF."""
    image = Image.open(io.BytesIO(data))
    storage = _storage(image, data)
    pixels = _by_cv2(image, data) if _suits_cv2(image, data) else _by_pillow(image, path)
    if _seems_unfilled(pixels, storage) and not jpeg.filled(data, storage.progressive):
        raise ValueError("a part of its pixels is missing")
    metadata, notes = _metadata(image, data, storage.format)
    frames = getattr(image, "n_frames", 1) if image.format != "MPO" else 1
    if frames > 1:
        notes.append(_first_of(frames))
    return Picture(pixels, image.mode == "CMYK", metadata, storage, tuple(notes))


def _tiff(data: bytes, path: str | Path) -> Picture:
    from plumbline.photos.files import tiff, tiff_tags

    with tiff.opened(io.BytesIO(data), path) as page:
        storage = Storage("TIFF", compression=int(page.compression))
        found = tiff.read_pixels(page, path)
        notes = list(found.notes)
        try:
            metadata, left = tiff_tags.read_metadata(page)
            notes += [*left, *([MAKER_NOTES_LOST] if tiff_tags.has_maker_notes(page) else [])]
        except tiff_tags.DAMAGE:
            metadata = Metadata()
            notes.append("its metadata are damaged and were not kept")
        frames = tiff.pictures(page)
    if frames > 1:
        notes.append(_first_of(frames))
    return Picture(found.pixels, found.inks, metadata, storage, tuple(notes))


def _first_of(frames: int) -> str:
    return f"only the first of {frames} pictures in the file was taken"


def _seems_unfilled(pixels: Pixels, storage: Storage) -> bool:
    """Whether a JPEG's last row is all one colour, as decoders fill what is missing."""
    if storage.format != "JPEG":
        return False
    return storage.progressive or not np.any(pixels[-1] != pixels[-1, 0])


def _storage(image: Image.Image, data: bytes) -> Storage:
    name = "JPEG" if image.format == "MPO" else image.format or ""
    if name == "JPEG":
        progressive = bool(image.info.get("progressive"))
        return Storage(name, sampling=_sampling(image), progressive=progressive)
    return Storage(name, lossless=name == "WEBP" and b"VP8L" in data[:1024])


def _sampling(image: Image.Image) -> int:
    sampling = JpegImagePlugin.get_sampling(image)
    if sampling >= 0:
        return sampling
    layers: Any = getattr(image, "layer", ())  # four inks, which Pillow does not look at
    return 0 if len({tuple(layer[1:3]) for layer in layers}) == 1 else 2


def _suits_cv2(image: Image.Image, data: bytes) -> bool:
    """Whether OpenCV decodes this faithfully; Pillow knows 16 bits only in grey."""
    if image.format in ("JPEG", "MPO"):
        if not jpeg.complete(data):
            raise ValueError("its end is missing")
        return image.mode in _CV2_MODES
    if image.format == "PNG":
        png.refuse_damage(data)
        depth, _ = png.depth_and_kind(data)
        plain = image.mode in (*_CV2_MODES, "RGBA") and "transparency" not in image.info
        return depth == 16 or (depth == 8 and plain)
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
        own, notes = reader(data)
    except _DAMAGE:
        return Metadata(), ["its metadata are damaged and were not kept"]
    icc, xmp = common.icc or own.icc, own.xmp or (b"" if notes else packet)
    return replace(own, icc=icc, xmp=xmp, dpi=common.dpi), notes
