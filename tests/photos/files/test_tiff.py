"""Every kind of TIFF that tifffile's writer makes: right, or refused by name."""

from __future__ import annotations

import io
import itertools
import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray
from PIL import Image, ImageOps

import plumbline
from plumbline.errors import ReadError
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import read_photo
from tests.photos import layouts

NOTHING = LensRequest(ptlens={"a": 0.0, "b": 0.0, "c": 0.0})
SIZE = (70, 50)
CHANNELS = {"minisblack": 1, "miniswhite": 1, "rgb": 3, "separated": 4}


def pixels_of(channels: int, kind: Any, planar: bool = False) -> NDArray[Any]:
    shape = (SIZE[1], SIZE[0]) if channels == 1 else (SIZE[1], SIZE[0], channels)
    rng = np.random.default_rng(channels)
    found = rng.integers(0, np.iinfo(kind).max, shape, dtype=kind, endpoint=True)
    return np.moveaxis(found, -1, 0) if planar and channels > 1 else found


def corrected(path: Path, target: str = "b.tif") -> NDArray[Any]:
    """The pixels of the result, by tifffile's and libtiff's word alike."""
    done = plumbline.correct(path, NOTHING, path.parent / target, interpolation="nearest")
    found: Any = cv2.imread(str(done.output), cv2.IMREAD_UNCHANGED)
    if target.endswith(".png"):
        return found[..., [2, 1, 0, 3][: found.shape[2]]] if found.ndim == 3 else found
    if found.dtype == np.uint8:  # OpenCV multiplies colours by alpha
        return np.asarray(Image.open(done.output))
    return found[..., [2, 1, 0, 3][: found.shape[2]]] if found.ndim == 3 else found


KINDS = [
    *itertools.product(
        CHANNELS,
        (np.uint8, np.uint16),
        ("contig", "separate"),
        (None, "zlib"),
        ("<", ">"),
        (None, (16, 32)),
        (False, True),
    )
]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_layouts(tmp_path: Path, kind: tuple[Any, ...]) -> None:
    photometric, dtype, planar, compression, order, tile, big = kind
    channels = CHANNELS[photometric]
    if channels == 1 and planar == "separate":
        return
    if photometric == "separated" and dtype is np.uint16:
        return  # no other decoder at hand reads the result; see test_sixteen_bit_inks
    pixels = pixels_of(channels, dtype, planar == "separate")
    how: dict[str, Any] = {"planarconfig": planar} if channels > 1 else {}
    if compression and dtype is np.uint8:
        how["predictor"] = True
    with tifffile.TiffWriter(tmp_path / "a.tif", bigtiff=big, byteorder=order) as file:
        file.write(pixels, photometric=photometric, compression=compression, tile=tile,
                   rowsperstrip=None if tile else 7, metadata=None, **how)  # fmt: skip
    plain = pixels_of(channels, dtype)
    if photometric == "miniswhite":
        plain = np.iinfo(dtype).max - plain
    assert np.array_equal(corrected(tmp_path / "a.tif"), plain)


def test_sixteen_bit_inks(tmp_path: Path) -> None:
    pixels = pixels_of(4, np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="separated", metadata=None)
    done = plumbline.correct(tmp_path / "a.tif", NOTHING, interpolation="nearest")
    assert np.array_equal(tifffile.imread(done.output), pixels)


@pytest.mark.parametrize(
    "compression", ["tiff_lzw", "packbits", "jpeg", "group4", "tiff_ccitt", "group3"]
)
@pytest.mark.parametrize("mode", ["L", "RGB", "CMYK", "1", "RGBA"])
@pytest.mark.parametrize("orientation", [1, 6])
def test_compressions_of_libtiff(
    tmp_path: Path, compression: str, mode: str, orientation: int
) -> None:
    """As Pillow writes and reads them."""
    if (mode == "1") != (compression in ("group3", "group4", "tiff_ccitt")):
        return
    if compression == "jpeg" and mode == "RGBA":
        return
    image = Image.fromarray(pixels_of(3, np.uint8)).convert("RGBA").convert(mode)
    image.save(tmp_path / "a.tif", compression=compression, tiffinfo={274: orientation})
    with Image.open(tmp_path / "a.tif") as stored:
        wanted = np.asarray(stored.convert("L") if mode == "1" else stored).copy()
    done = plumbline.correct(tmp_path / "a.tif", NOTHING, interpolation="nearest")
    with Image.open(done.output) as made:
        assert made.getexif().get(274, 1) == 1 if orientation == 1 else True
        shown = np.asarray(made)
    assert shown.shape == wanted.shape
    assert np.array_equal(shown, wanted)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("target", ["b.tif", "b.png"])
def test_orientations(
    tmp_path: Path, orientation: int, dtype: Any, channels: int, target: str
) -> None:
    """The picture is turned once: pixels as stored, with their tag."""
    pixels = pixels_of(channels, dtype)
    kind = "minisblack" if channels == 1 else "rgb"
    alpha: dict[str, Any] = {"extrasamples": ["unassalpha"]} if channels == 4 else {}
    tag = (274, 3, 1, orientation, True)
    tifffile.imwrite(
        tmp_path / "a.tif", pixels, photometric=kind, extratags=[tag], metadata=None, **alpha
    )
    upright = (SIZE[1], SIZE[0]) if orientation >= 5 else SIZE
    assert read_photo(tmp_path / "a.tif").size == upright
    done = plumbline.correct(
        tmp_path / "a.tif", NOTHING, tmp_path / target, interpolation="nearest"
    )
    if target == "b.tif":
        with tifffile.TiffFile(done.output) as file:
            page = file.pages.first
            assert page.tags[274].value == orientation
        done.output.write_bytes(_upright(done.output))
        found = _stored(done.output)
    else:
        with Image.open(done.output) as image:
            assert image.getexif()[274] == orientation
        found = _stored(done.output)
    assert np.array_equal(found, pixels)


def _stored(path: Path) -> NDArray[Any]:
    """The pixels as stored, by Pillow, or by OpenCV where Pillow lacks 16 bits."""
    flags = cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION
    found: Any = cv2.imread(str(path), flags)
    if found.dtype == np.uint8:
        return np.asarray(Image.open(path))
    return found[..., [2, 1, 0, 3][: found.shape[2]]] if found.ndim == 3 else found


def _upright(path: Path) -> bytes:
    """The file with its orientation tag set to 1, so that no decoder turns it."""
    data = io.BytesIO(path.read_bytes())
    with tifffile.TiffFile(data) as file:
        at = file.pages.first.tags[274].valueoffset
    whole = data.getvalue()
    return whole[:at] + struct.pack("<H", 1) + whole[at + 2 :]


@pytest.mark.parametrize("bits", [1, 2, 4])
@pytest.mark.parametrize("palette", [False, True])
def test_few_bits(tmp_path: Path, bits: int, palette: bool) -> None:
    rng = np.random.default_rng(bits)
    values = rng.integers(0, 2**bits, (SIZE[1], SIZE[0]), dtype=np.uint8)
    table = rng.integers(0, 2**16, (3, 2**bits), dtype=np.uint16)
    rows = _bit_rows(values, bits)
    _bilevel(tmp_path / "a.tif", rows, bits, table if palette else None)
    found = corrected(tmp_path / "a.tif")
    if palette:
        assert np.array_equal(found, np.moveaxis(table[:, values] >> 8, 0, -1))
    else:
        assert np.array_equal(found, values.astype(int) * 255 // (2**bits - 1))


def _bit_rows(values: NDArray[np.uint8], bits: int) -> bytes:
    spread = (values[..., None] >> np.arange(bits - 1, -1, -1)) & 1
    return np.packbits(spread.reshape(len(values), -1).astype(np.uint8), axis=1).tobytes()


def _bilevel(path: Path, rows: bytes, bits: int, table: NDArray[np.uint16] | None) -> None:
    """A file by hand: no writer at hand makes 2 and 4 bits."""
    entries: list[layouts.Entry] = [
        (256, 3, struct.pack("<H", SIZE[0])),
        (257, 3, struct.pack("<H", SIZE[1])),
        (258, 3, struct.pack("<H", bits)),
        (259, 3, struct.pack("<H", 1)),
        (262, 3, struct.pack("<H", 1 if table is None else 3)),
        (273, 4, struct.pack("<I", 8)),
        (277, 3, struct.pack("<H", 1)),
        (278, 3, struct.pack("<H", SIZE[1])),
        (279, 4, struct.pack("<I", len(rows))),
    ]
    if table is not None:
        entries.append((320, 3, table.astype("<u2").tobytes()))
    at = 8 + len(rows) + len(rows) % 2
    head = b"II*\0" + struct.pack("<I", at) + rows.ljust(at - 8, b"\0")
    path.write_bytes(head + layouts.packed(entries, at, "<"))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_premultiplied_colours_are_divided(tmp_path: Path, dtype: Any) -> None:
    full = np.iinfo(dtype).max
    straight = pixels_of(4, dtype).astype(float)
    straight[..., 3] = np.maximum(straight[..., 3], full // 4)
    stored = straight.copy()
    stored[..., :3] *= stored[..., 3:] / full
    tifffile.imwrite(tmp_path / "a.tif", np.rint(stored).astype(dtype), photometric="rgb",
                     extrasamples=["assocalpha"], metadata=None)  # fmt: skip
    found = corrected(tmp_path / "a.tif").astype(float)
    assert np.max(np.abs(found - straight)) <= 4  # half a step divided by an alpha of 1/4, twice
    with tifffile.TiffFile(tmp_path / "b.tif") as file:
        assert [int(each) for each in file.pages.first.extrasamples] == [2]


def test_a_further_channel_is_left_out_and_told(tmp_path: Path) -> None:
    pixels = pixels_of(5, np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", planarconfig="contig",
                     extrasamples=["unassalpha", "unspecified"], metadata=None)  # fmt: skip
    done = plumbline.correct(tmp_path / "a.tif", NOTHING, interpolation="nearest")
    assert any("1 further channel of the TIFF" in note for note in done.notes)
    assert np.array_equal(np.asarray(Image.open(done.output)), pixels[..., :4])


@pytest.mark.parametrize(
    ("pixels", "how", "sentence"),
    [
        (np.zeros((9, 9, 3), np.int8), {"photometric": "rgb"}, "signed integers"),
        (np.zeros((9, 9, 3), np.int16), {"photometric": "rgb"}, "signed integers"),
        (np.zeros((9, 9, 3), np.float32), {"photometric": "rgb"}, "32-bit float"),
        (np.zeros((9, 9), np.float64), {"photometric": "minisblack"}, "32-bit float"),
        (np.zeros((9, 9), np.uint32), {"photometric": "minisblack"}, "32 bits a sample"),
        (np.zeros((9, 9, 3), np.uint8), {"photometric": "cielab"}, r"L\*a\*b"),
        (np.zeros((9, 9, 3), np.uint8), {"photometric": "ycbcr"}, "YCbCr"),
        (np.zeros((9, 9), np.uint16), {"photometric": "cfa"}, "raw file"),
        (np.zeros((9, 9, 3), np.uint16), {"photometric": "linear_raw"}, "raw file"),
    ],
)  # fmt: skip
def test_what_cannot_be_corrected_is_refused_by_name(
    tmp_path: Path, pixels: NDArray[Any], how: dict[str, Any], sentence: str
) -> None:
    tifffile.imwrite(tmp_path / "a.tif", pixels, metadata=None, **how)
    with pytest.raises(ReadError, match=sentence) as error:
        plumbline.correct(tmp_path / "a.tif", NOTHING)
    assert error.value.hint
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.tif"]


def test_a_raw_file_is_told_by_its_thumbnail(tmp_path: Path) -> None:
    small, whole = np.zeros((9, 12, 3), np.uint8), np.zeros((90, 120), np.uint16)
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(small, photometric="rgb", subfiletype=1, subifds=1, metadata=None)
        file.write(whole, photometric="cfa", metadata=None)
    version = (50706, 1, 4, b"\1\4\0\0", True)
    tifffile.imwrite(
        tmp_path / "b.dng", small, photometric="rgb", extratags=[version], metadata=None
    )
    for name in ("a.tif", "b.dng"):
        with pytest.raises(ReadError, match="this is a raw file"):
            read_photo(tmp_path / name)


def test_a_thumbnail_before_the_photo_is_passed_over(tmp_path: Path) -> None:
    whole = pixels_of(3, np.uint8)
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(whole[::8, ::8], photometric="rgb", subfiletype=1, metadata=None)
        file.write(whole, photometric="rgb", metadata=None)
    assert read_photo(tmp_path / "a.tif").size == SIZE
    assert np.array_equal(corrected(tmp_path / "a.tif"), whole)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("big", [False, True])
def test_iptc_profile_xmp_and_exif_are_kept(tmp_path: Path, order: str, big: bool) -> None:
    iptc = b"\x1c\x02\x78\x00\x0bThe caption\0\0\0\0"
    packet = b"<x:xmpmeta xmlns:x='adobe:ns:meta/'></x:xmpmeta>"
    profile = b"not a profile, but bytes to keep"
    tags: list[Any] = [
        (33723, 4, len(iptc) // 4, iptc, True),  # as Photoshop has it: long integers
        (700, 1, len(packet), packet, True),
        (271, 2, 0, "A maker", True),
    ]
    with tifffile.TiffWriter(tmp_path / "a.tif", bigtiff=big, byteorder=order) as file:  # type: ignore[arg-type]
        file.write(pixels_of(3, np.uint8), photometric="rgb", extratags=tags, iccprofile=profile,
                   resolution=(240, 240), metadata=None)  # fmt: skip
    done = plumbline.correct(tmp_path / "a.tif", NOTHING)
    assert not any("metadata" in note for note in done.notes)
    with tifffile.TiffFile(done.output) as file:
        found = file.pages.first.tags
        assert bytes(found[33723].value) == iptc
        assert bytes(found[700].value) == packet
        assert bytes(found[34675].value) == profile
        assert found[271].value == "A maker"
        assert found[282].value == (240, 1)


@pytest.mark.parametrize("cut", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("compression", ["raw", "tiff_lzw", "tiff_adobe_deflate"])
def test_a_file_cut_short_is_refused(tmp_path: Path, compression: str, cut: float) -> None:
    Image.fromarray(pixels_of(3, np.uint8)).save(tmp_path / "a.tif", compression=compression)
    data = (tmp_path / "a.tif").read_bytes()
    (tmp_path / "a.tif").write_bytes(data[: int(cut * len(data))])
    with pytest.raises(ReadError):
        plumbline.correct(tmp_path / "a.tif", NOTHING)


def test_upright_as_other_programs_show_it(tmp_path: Path) -> None:
    """ImageOps turns by the tag; the corrected file looks as the original does."""
    tag = (274, 3, 1, 6, True)
    tifffile.imwrite(
        tmp_path / "a.tif",
        pixels_of(3, np.uint8),
        photometric="rgb",
        extratags=[tag],
        metadata=None,
    )
    done = plumbline.correct(
        tmp_path / "a.tif", NOTHING, tmp_path / "b.png", interpolation="nearest"
    )
    with Image.open(done.output) as image:
        shown = np.asarray(ImageOps.exif_transpose(image))
    assert np.array_equal(shown, np.rot90(pixels_of(3, np.uint8), -1))
