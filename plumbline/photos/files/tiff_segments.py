"""Strips and tiles of a TIFF page put together, whatever they are compressed with.

tifffile unpacks, swaps and places them. What it does not decompress by itself (LZW, fax, JPEG)
is decompressed by libtiff, through Pillow, one segment at a time: so the layout of the file
(planes, tiles, byte order, predictor) is tifffile's business alone.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from plumbline.errors import ReadError

_NONE, _FAX, _LZW, _JPEG, _ZSTD = 1, (2, 3, 4), 5, 7, 50000
_BY_TIFFFILE = (_NONE, 8, 32946, 32773, 34925)
_BY_LIBTIFF = (*_FAX, _LZW, _JPEG, _ZSTD)
_FAX_OPTIONS = (292, 293)
"""T4Options and T6Options (TIFF 6.0)."""
_JPEG_TABLES = 347
"""The tag of tables that all segments share (TIFF Technical Note 2)."""
_MOST_WAITING = 64  # segments read and not yet decoded; chosen to bound the memory
_BLACK_IS_ZERO, _RGB, _SEPARATED, _YCBCR = 1, 2, 5, 6


def decoded_segments(
    page: tifffile.TiffPage, order: Sequence[int], path: str | Path
) -> NDArray[Any]:
    """The samples of a page.

    Args:
        page: The page; its attributes that say how it is compressed are changed.
        order: Which samples are wanted, and in which order.
        path: The file, for the sentence.

    Returns:
        Shape (rows, columns, samples wanted), as unsigned integers of 8 or 16 bits.

    Raises:
        ReadError: its compression is not supported.
        ValueError: a segment is missing or damaged.
    """
    compression = int(page.compression)
    if compression not in (*_BY_TIFFFILE, *_BY_LIBTIFF):
        name = getattr(page.compression, "name", str(compression))
        raise ReadError(
            f"a TIFF with the compression {name} is not supported",
            path=path,
            hint="save it with LZW, Deflate or no compression",
        )
    bits = int(page.bitspersample)
    packed = bits not in (1, 8, 16)
    decompress = None
    if compression in _BY_LIBTIFF or (packed and compression != _NONE):
        decompress = _libtiff(page)
    unpack = _unpacking(page, bits) if packed else None
    result = np.zeros((page.imagelength, page.imagewidth, len(order)), dtype=_type_of(page))

    def place(index: int, raw: bytes) -> None:
        raw = raw if decompress is None else decompress(raw, index)
        _place(page, result, order, index, raw if unpack is None else unpack(raw))

    with ThreadPoolExecutor(2) as pool:  # decompression leaves Python's lock
        waiting: list[Any] = []
        for index, raw in enumerate(_segments(page)):
            waiting.append(pool.submit(place, index, raw))
            if len(waiting) > _MOST_WAITING:
                waiting.pop(0).result()
        for each in waiting:
            each.result()
    return result


def _segments(page: tifffile.TiffPage) -> Iterator[bytes]:
    """The bytes of each strip or tile as stored."""
    file: Any = page.parent.filehandle
    for start, length in zip(page.dataoffsets, page.databytecounts, strict=True):
        if not length or start + length > file.size:
            raise ValueError("a part of the picture is missing")
        file.seek(start)
        yield file.read(length)


def _place(
    page: tifffile.TiffPage, result: NDArray[Any], order: Sequence[int], index: int, raw: bytes
) -> None:
    """Put a segment where it belongs."""
    data, (plane, _, top, left, _), shape = page.decode(raw, index)
    if data is None:
        raise ValueError("a part of the picture is missing")
    _, rows, columns, _ = shape
    rows, columns = min(rows, result.shape[0] - top), min(columns, result.shape[1] - left)
    part = data[0, :rows, :columns]
    target = result[top : top + rows, left : left + columns]
    if int(page.planarconfig) == 1 or int(page.samplesperpixel) == 1:
        target[...] = part[..., list(order)]
    elif plane in order:
        target[..., list(order).index(plane)] = part[..., 0]


def _type_of(page: tifffile.TiffPage) -> Any:
    return np.uint16 if np.dtype(page.dtype).itemsize == 2 else np.uint8


def _unpacking(page: tifffile.TiffPage, bits: int) -> Callable[[bytes], bytes]:
    """A function that spreads samples of odd sizes; the page is told that they are spread."""
    width = int(page.tilewidth if page.is_tiled else page.imagewidth)
    samples = width * (int(page.samplesperpixel) if int(page.planarconfig) == 1 else 1)
    weights = 2 ** np.arange(bits - 1, -1, -1)
    kind = np.dtype(np.uint8 if bits < 8 else np.uint16).newbyteorder(page.parent.byteorder)
    first: Any = "little" if int(page.fillorder) == 2 else "big"
    page.bitspersample = 8 * kind.itemsize
    page.fillorder = tifffile.FILLORDER.MSB2LSB

    def unpack(raw: bytes) -> bytes:
        row = -(-samples * bits // 8)
        rows = np.frombuffer(raw, np.uint8)[: len(raw) // row * row].reshape(-1, row)
        each = np.unpackbits(rows, axis=1, bitorder=first)[:, : samples * bits]
        return (each.reshape(len(rows), samples, bits) @ weights).astype(kind).tobytes()

    return unpack


def _libtiff(page: tifffile.TiffPage) -> Callable[[bytes, int], bytes]:
    """A function that decompresses one segment; the page is told that it is not compressed."""
    compression, fill = int(page.compression), int(page.fillorder)
    contiguous = int(page.planarconfig) == 1
    samples = int(page.samplesperpixel) if contiguous else 1
    bits = int(page.bitspersample)
    width = int(page.tilewidth if page.is_tiled else page.imagewidth)
    height = int(page.tilelength if page.is_tiled else page.rowsperstrip)
    strips = -(-int(page.imagelength) // height)
    known: dict[int, Any] = {259: compression, 266: fill}
    if compression in _FAX:
        known |= {258: 1, 262: _BLACK_IS_ZERO, 277: 1}
        known |= {tag: page.tags[tag].value for tag in _FAX_OPTIONS if tag in page.tags}
        columns = width
    elif compression == _JPEG:
        photometric = int(page.photometric)
        if samples == 1:
            photometric = _BLACK_IS_ZERO
        known |= {258: (8,) * samples, 262: photometric, 277: samples, 284: 1}
        if photometric == _YCBCR and 530 in page.tags:
            known[530] = page.tags[530].value
        if _JPEG_TABLES in page.tags:
            known[_JPEG_TABLES] = bytes(page.tags[_JPEG_TABLES].value)
        columns = width
    else:  # bytes, whatever they stand for; by threes or fours as Pillow limits pixels
        group = samples if samples in (3, 4) else 1
        kind = {1: _BLACK_IS_ZERO, 3: _RGB, 4: _SEPARATED}[group]
        known |= {258: (8,) * group, 262: kind, 277: group}
        columns = -(-width * samples * bits // (8 * group))
    page.compression = tifffile.COMPRESSION.NONE
    page.fillorder = tifffile.FILLORDER.MSB2LSB
    if compression == _JPEG:
        page.subsampling = None

    def decompress(raw: bytes, index: int) -> bytes:
        rows = height
        if not page.is_tiled:
            rows = min(height, int(page.imagelength) - index % strips * height)
        values = _one_strip(raw, known, columns, rows)
        if compression in _FAX:
            values = np.packbits(values.astype(bool), axis=1)
        return values.tobytes()

    return decompress


def _one_strip(raw: bytes, known: dict[int, Any], columns: int, rows: int) -> NDArray[Any]:
    """A segment as a TIFF file of its own, decoded."""
    directory = ImageFileDirectory_v2()
    for tag, value in known.items():
        directory[tag] = value
    directory[256], directory[257] = columns, rows
    directory[273], directory[278], directory[279] = 0, rows, len(raw)
    if _JPEG_TABLES in known:
        directory.tagtype[_JPEG_TABLES] = 7
    head = b"II*\0\x08\0\0\0" + directory.tobytes(8)
    with Image.open(io.BytesIO(head + raw)) as image:
        return np.asarray(image)
