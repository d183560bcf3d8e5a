"""TIFF files written: pixels by OpenCV or tifffile, then one directory that holds all tags.

OpenCV writes the usual kinds, LZW among them; tifffile those with inks, or grey with alpha.
Neither writes EXIF, so the directory is written anew behind the pixels, with the few tags that
say how these are stored.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from plumbline.photos.files import ifd
from plumbline.photos.files.ifd import Field
from plumbline.photos.files.metadata import Metadata
from plumbline.photos.files.picture import Picture, Pixels
from plumbline.photos.files.tiff_tags import ICC, IPTC, LAYOUT, PHOTOSHOP, XMP

_COMPRESSIONS = {1: 1, 5: 5, 8: 8, 32773: 32773, 32946: 8}
_LZW = 5
"""TIFF's number of LZW."""
_STRIP_BYTES = 2**16
"""Chosen as a compromise of the TIFF specification's 8 kB and today's memory."""

_EXTRA_SAMPLES, _STRAIGHT_ALPHA = 338, 2
_X_DPI, _Y_DPI, _UNIT, _INCH = 282, 283, 296, 2


def encoded(picture: Picture, metadata: Metadata, note: str) -> bytes:
    """A TIFF file of a picture.

    Args:
        picture: The picture.
        metadata: What it is to say.
        note: What to add to Software.

    Raises:
        ValueError, struct.error: it cannot be written, or is larger than 4 GiB.
    """
    return with_metadata(_pixels(picture), metadata, note, alpha=picture.alpha)


def with_metadata(data: bytes, metadata: Metadata, note: str, *, alpha: bool = False) -> bytes:
    """A little-endian TIFF file with metadata added to its first directory."""
    stored = ifd.read_directory(data, ifd.first_directory(data))[0]
    layout = [field for field in stored if field.tag in LAYOUT]
    if alpha and not any(field.tag == _EXTRA_SAMPLES for field in layout):
        layout.append(Field(_EXTRA_SAMPLES, ifd.SHORT, struct.pack("<H", _STRAIGHT_ALPHA)))
    fields = ifd.block_fields(metadata.exif) if metadata.exif else []
    apart = (*LAYOUT, ICC, XMP, IPTC, PHOTOSHOP)
    fields = ifd.with_software([f for f in fields if f.tag not in apart], note)
    known = {field.tag for field in fields}
    for tag, value in (
        (ICC, metadata.icc),
        (XMP, metadata.xmp),
        (IPTC, metadata.iptc),
        (PHOTOSHOP, metadata.photoshop),
    ):
        if value:
            kind = ifd.UNDEFINED if tag in (ICC, IPTC) else ifd.BYTE
            fields.append(Field(tag, kind, value))
    if metadata.comment and ifd.DESCRIPTION not in known:
        text = metadata.comment.encode("utf-8") + b"\0"
        fields.append(Field(ifd.DESCRIPTION, ifd.ASCII, text))
    if metadata.dpi and _X_DPI not in known:
        across, down = (struct.pack("<II", round(value * 1000), 1000) for value in metadata.dpi)
        fields += [Field(_X_DPI, ifd.RATIONAL, across), Field(_Y_DPI, ifd.RATIONAL, down)]
        fields.append(Field(_UNIT, ifd.SHORT, struct.pack("<H", _INCH)))
    return _with_directory(data, [*layout, *fields])


def with_fields(data: bytes, fields: Iterable[Field]) -> bytes:
    """A little-endian TIFF file with fields added to its first directory."""
    held, _ = ifd.read_directory(data, ifd.first_directory(data))
    return _with_directory(data, [*held, *fields])


def _with_directory(data: bytes, fields: Iterable[Field]) -> bytes:
    data = ifd.even(data)
    directory = ifd.directory_bytes(fields, len(data), "<")
    return data[:4] + struct.pack("<I", len(data)) + data[8:] + directory


def _pixels(picture: Picture) -> bytes:
    compression = _COMPRESSIONS.get(picture.storage.compression, _LZW)
    pixels = picture.pixels
    rows = max(_STRIP_BYTES // pixels[0].nbytes, 1)
    if picture.inks or (pixels.ndim == 3 and pixels.shape[2] == 2):
        return _by_tifffile(pixels, inks=picture.inks, compressed=compression != 1, rows=rows)
    parameters = [
        *(cv2.IMWRITE_TIFF_COMPRESSION, compression),
        *(cv2.IMWRITE_TIFF_ROWSPERSTRIP, rows),
    ]
    done, data = cv2.imencode(".tif", pixels, parameters)
    if not done:
        raise ValueError("OpenCV does not say why")
    return data.tobytes()


def _by_tifffile(pixels: Pixels, *, inks: bool, compressed: bool, rows: int) -> bytes:
    import tifffile

    buffer = io.BytesIO()
    how: dict[str, Any] = {"photometric": "separated" if inks else "minisblack"}
    if not inks:
        how |= {"extrasamples": ["unassalpha"]}
    with tifffile.TiffWriter(buffer, bigtiff=False, byteorder="<") as file:
        file.write(
            np.ascontiguousarray(pixels),
            planarconfig="contig",
            compression="adobe_deflate" if compressed else None,
            rowsperstrip=rows,
            metadata=None,
            software=False,
            **how,
        )
    return buffer.getvalue()
