"""Every kind of picture file, in and out, read back by another program's decoder."""

from __future__ import annotations

import contextlib
import io
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, TiffImagePlugin

import plumbline
from plumbline.errors import OptionError
from plumbline.lenses.request import LensRequest
from tests.imaging.painted import texture

SIZE = (150, 100)
NOTHING = LensRequest(ptlens={"a": 0.0, "b": 0.0, "c": 0.0})
BARREL = LensRequest(ptlens={"a": 0.0, "b": -0.05, "c": 0.0})


def _pixels(channels: int, kind: Any) -> NDArray[Any]:
    rng = np.random.default_rng(channels)
    shape = (SIZE[1], SIZE[0]) if channels == 1 else (SIZE[1], SIZE[0], channels)
    return rng.integers(0, np.iinfo(kind).max, shape, dtype=kind, endpoint=True)


def _read(path: Path) -> NDArray[Any]:
    """Pixels as Pillow has them, or OpenCV's in the same order where it must."""
    pixels: Any = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if pixels.dtype == np.uint8:
        return np.asarray(Image.open(path))
    return pixels[..., [2, 1, 0, 3][: pixels.shape[2]]] if pixels.ndim == 3 else pixels


def _write(path: Path, pixels: NDArray[Any]) -> None:
    if pixels.dtype == np.uint16 and pixels.ndim == 3:
        order = [2, 1, 0, 3][: pixels.shape[2]]
        assert cv2.imwrite(str(path), pixels[..., order])
    else:
        how: dict[str, Any] = {"lossless": True} if path.suffix == ".webp" else {}
        Image.fromarray(pixels).save(path, **how)


def _tags(image: Image.Image) -> Any:
    assert isinstance(image, TiffImagePlugin.TiffImageFile)
    return image.tag_v2


CASES = [
    *((suffix, channels, np.uint8) for suffix in (".png", ".tif") for channels in (1, 2, 3, 4)),
    *((suffix, channels, np.uint16) for suffix in (".png", ".tif") for channels in (1, 3, 4)),
    (".webp", 3, np.uint8),
    (".webp", 4, np.uint8),
    (".bmp", 3, np.uint8),
    (".ppm", 3, np.uint8),
]


@pytest.mark.parametrize(("suffix", "channels", "kind"), CASES)
def test_lossless_files_keep_every_value(
    tmp_path: Path, suffix: str, channels: int, kind: Any
) -> None:
    pixels = _pixels(channels, kind)
    if channels == 4:
        pixels[..., 3] = np.maximum(pixels[..., 3], 1)  # WebP drops colours that none can see
    _write(tmp_path / f"a{suffix}", pixels)
    done = plumbline.correct(tmp_path / f"a{suffix}", NOTHING, interpolation="nearest")
    assert done.output == tmp_path / f"a_corrected{suffix}"
    found = _read(done.output)
    assert found.dtype == kind
    assert np.array_equal(found, pixels)


@pytest.mark.parametrize("channels", [1, 3])
def test_jpeg_keeps_its_kind(tmp_path: Path, channels: int) -> None:
    pixels = texture(SIZE, channels)
    pixels = pixels[..., 0] if channels == 1 else pixels
    Image.fromarray(pixels).save(tmp_path / "a.jpg", quality=95, subsampling=0)
    found = _read(plumbline.correct(tmp_path / "a.jpg", NOTHING).output)
    assert found.shape == pixels.shape
    assert np.mean(np.abs(found.astype(int) - pixels)) < 2


@pytest.mark.parametrize("sampling", [0, 1, 2])
def test_jpeg_keeps_its_sampling(tmp_path: Path, sampling: int) -> None:
    from PIL import JpegImagePlugin

    for progressive in (False, True):
        image = Image.fromarray(texture(SIZE))
        image.save(tmp_path / "a.jpg", subsampling=sampling, progressive=progressive)
        with Image.open(plumbline.correct(tmp_path / "a.jpg", BARREL).output) as made:
            assert JpegImagePlugin.get_sampling(made) == sampling
            assert bool(made.info.get("progressive")) == progressive


def test_quality_changes_the_size(tmp_path: Path) -> None:
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg")
    sizes = [
        plumbline.correct(tmp_path / "a.jpg", BARREL, quality=quality).output.stat().st_size
        for quality in (30, 95)
    ]
    assert sizes[0] < sizes[1] / 2
    default = plumbline.correct(tmp_path / "a.jpg", BARREL).output.stat().st_size
    assert default == sizes[1]


@pytest.mark.parametrize("suffix", [".jpg", ".tif"])
def test_inks_stay_inks(tmp_path: Path, suffix: str) -> None:
    pixels = texture(SIZE, 4)
    image = Image.frombytes("CMYK", SIZE, pixels.tobytes())
    how: dict[str, Any] = {"quality": 95} if suffix == ".jpg" else {}
    image.save(tmp_path / f"a{suffix}", **how)
    with Image.open(plumbline.correct(tmp_path / f"a{suffix}", NOTHING).output) as made:
        assert made.mode == "CMYK"
        assert np.mean(np.abs(np.asarray(made).astype(int) - pixels)) < 3


@pytest.mark.parametrize("mode", ["P", "1"])
def test_palettes_and_black_and_white_become_shades(tmp_path: Path, mode: str) -> None:
    image = Image.fromarray(texture(SIZE)).convert(mode)
    image.save(tmp_path / "a.png")
    with Image.open(plumbline.correct(tmp_path / "a.png", BARREL).output) as made:
        assert made.mode == ("RGB" if mode == "P" else "L")


def test_a_transparent_colour_becomes_alpha(tmp_path: Path) -> None:
    pixels = texture(SIZE)
    pixels[20:40, 30:60] = (1, 2, 3)
    Image.fromarray(pixels).save(tmp_path / "a.png", transparency=(1, 2, 3))
    found = _read(plumbline.correct(tmp_path / "a.png", NOTHING, interpolation="nearest").output)
    assert found.shape[2] == 4
    assert np.all(found[20:40, 30:60, 3] == 0)
    assert found[0, 0, 3] == 255


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_transparent_borders_are_transparent(tmp_path: Path, suffix: str) -> None:
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg")
    pincushion = LensRequest(ptlens={"a": 0.0, "b": 0.1, "c": 0.0})
    done = plumbline.correct(
        tmp_path / "a.jpg", pincushion, tmp_path / f"b{suffix}", border="transparent"
    )
    with Image.open(done.output) as made:
        assert made.mode == "RGBA"
        alpha = np.asarray(made)[..., 3]
    assert alpha[0, 0] == 0
    assert alpha[50, 75] == 255
    assert set(np.unique(alpha)) == {0, 255}
    if suffix == ".tif":
        with Image.open(done.output) as made:
            assert _tags(made)[338] == (2,)  # straight, not premultiplied


def test_what_a_format_cannot_hold_is_refused(tmp_path: Path) -> None:
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg")
    _write(tmp_path / "deep.png", _pixels(3, np.uint16))
    _write(tmp_path / "clear.png", _pixels(4, np.uint8))
    cases: list[tuple[str, str, dict[str, Any], str]] = [
        ("a.jpg", "b.jpg", {"border": "transparent"}, "transparent"),
        ("clear.png", "b.jpg", {}, "transparent"),
        ("deep.png", "b.jpg", {}, "16 bits"),
        ("deep.png", "b.webp", {}, "16 bits"),
        ("a.jpg", "b.xyz", {}, "cannot be written"),
        ("a.jpg", "b", {}, "cannot be written"),
    ]
    for source, target, settings, what in cases:
        with pytest.raises(OptionError, match=what):
            plumbline.correct(tmp_path / source, BARREL, tmp_path / target, **settings)
        assert not (tmp_path / target).exists()


@pytest.mark.parametrize("compression", ["raw", "tiff_lzw", "tiff_adobe_deflate", "packbits"])
def test_tiff_keeps_its_compression(tmp_path: Path, compression: str) -> None:
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.tif", compression=compression)
    with Image.open(plumbline.correct(tmp_path / "a.tif", NOTHING).output) as made:
        assert made.info["compression"] == compression
        assert np.array_equal(np.asarray(made), texture(SIZE))


def test_big_endian_16_bit_tiff(tmp_path: Path) -> None:
    pixels = _pixels(1, np.uint16)
    _tiff_by_hand(tmp_path / "a.tif", pixels, ">")
    done = plumbline.correct(tmp_path / "a.tif", NOTHING, interpolation="nearest")
    assert np.array_equal(_read(done.output), pixels)
    with Image.open(done.output) as made:
        assert _tags(made)[305].startswith("a camera; corrected by plumbline")
        assert float(_tags(made)[282]) == 240.0


def _tiff_by_hand(path: Path, pixels: NDArray[np.uint16], order: str) -> None:
    height, width = pixels.shape
    data = pixels.astype(order + "u2").tobytes()
    text, ratio = b"a camera\0\0", struct.pack(order + "II", 240, 1)
    at_text, at_ratio = 8 + len(data), 8 + len(data) + len(text)
    entries = [
        (256, 3, 1, width), (257, 3, 1, height), (258, 3, 1, 16), (259, 3, 1, 1), (262, 3, 1, 1),
        (273, 4, 1, 8), (277, 3, 1, 1), (278, 3, 1, height), (279, 4, 1, len(data)),
        (282, 5, 1, at_ratio), (283, 5, 1, at_ratio), (296, 3, 1, 2), (305, 2, 9, at_text),
    ]  # fmt: skip
    directory = struct.pack(order + "H", len(entries))
    for tag, kind, count, value in entries:
        packed = struct.pack(
            order + ("HH" if kind == 3 else "I"), *((value, 0) if kind == 3 else (value,))
        )
        directory += struct.pack(order + "HHI", tag, kind, count) + packed
    magic = b"MM\0*" if order == ">" else b"II*\0"
    offset = at_ratio + 8
    whole = magic + struct.pack(order + "I", offset) + data + text + ratio + directory + bytes(4)
    path.write_bytes(whole)


def test_only_the_first_of_several_pictures_is_taken_and_said_so(tmp_path: Path) -> None:
    first, second = Image.fromarray(texture(SIZE)), Image.fromarray(texture(SIZE, seed=1))
    first.save(tmp_path / "a.tif", save_all=True, append_images=[second])
    done = plumbline.correct(tmp_path / "a.tif", NOTHING)
    assert any("first of 2" in note for note in done.notes)
    assert np.array_equal(_read(done.output), texture(SIZE))


def test_the_difference_is_white_where_nothing_moved(tmp_path: Path) -> None:
    Image.fromarray(texture((600, 400))).save(tmp_path / "a.png")
    done = plumbline.correct(tmp_path / "a.png", BARREL, difference=True)
    assert done.difference is not None
    assert done.difference == tmp_path / "a_corrected_difference.png"
    found = _read(done.difference)
    before = np.asarray(Image.open(tmp_path / "a.png").convert("L")).astype(int)
    after = np.asarray(Image.open(done.output).convert("L")).astype(int)
    assert found.ndim == 2
    assert np.max(np.abs(found - (255 - np.abs(before - after)))) <= 2
    y, x = np.mgrid[:400, :600]
    still = np.abs(np.hypot(x - 299.5, y - 199.5) - 200) < 1.0
    assert found[still].min() > 235
    assert found.min() < 180


def test_a_compressed_text_bomb_is_no_bomb(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    Image.fromarray(texture(SIZE)).save(buffer, "PNG")
    data = buffer.getvalue()
    body = b"Comment\0\0" + zlib.compress(bytes(50_000_000))
    chunk = struct.pack(">I", len(body)) + b"zTXt" + body
    chunk += struct.pack(">I", zlib.crc32(b"zTXt" + body))
    (tmp_path / "a.png").write_bytes(data[:33] + chunk + data[33:])
    with contextlib.suppress(plumbline.PlumblineError):
        plumbline.correct(tmp_path / "a.png", NOTHING)


@pytest.mark.parametrize("sampling", [0, 2])
def test_inks_keep_their_sampling(tmp_path: Path, sampling: int) -> None:
    image = Image.frombytes("CMYK", SIZE, texture(SIZE, 4).tobytes())
    image.save(tmp_path / "a.jpg", quality=95, subsampling=sampling)
    factors: list[Any] = []
    for path in (tmp_path / "a.jpg", plumbline.correct(tmp_path / "a.jpg", BARREL).output):
        with Image.open(path) as made:
            factors.append([layer[1:3] for layer in made.layer])  # type: ignore[attr-defined]
    assert (len(set(factors[0])) == 1) == (sampling == 0)
    assert (len(set(factors[1])) == 1) == (sampling == 0)


@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.9])
def test_a_half_missing_jpeg_is_refused(
    tmp_path: Path, share: float, channels: int, progressive: bool
) -> None:
    """Its pixels end early, with the mark of the end behind them."""
    pixels = texture(SIZE, channels)
    image = Image.fromarray(pixels[..., 0] if channels == 1 else pixels, None)
    if channels == 4:
        image = Image.frombytes("CMYK", SIZE, pixels.tobytes())
    image.save(tmp_path / "a.jpg", quality=90, progressive=progressive)
    plumbline.correct(tmp_path / "a.jpg", BARREL)
    data = (tmp_path / "a.jpg").read_bytes()
    start = data.index(b"\xff\xda")
    (tmp_path / "b.jpg").write_bytes(data[: start + int(share * (len(data) - start))] + b"\xff\xd9")
    with pytest.raises(
        plumbline.PlumblineError, match=r"a part of its pixels is missing|its end is missing"
    ):
        plumbline.correct(tmp_path / "b.jpg", BARREL)
    assert not (tmp_path / "b_corrected.jpg").exists()


def test_a_photo_with_an_even_border_is_not_taken_for_half_missing(tmp_path: Path) -> None:
    for progressive in (False, True):
        pixels = texture((640, 480))
        pixels[300:] = 128
        Image.fromarray(pixels).save(tmp_path / "a.jpg", quality=90, progressive=progressive)
        plumbline.correct(tmp_path / "a.jpg", BARREL)


@pytest.mark.parametrize(
    ("head", "name"),
    [
        (b"\0\0\0\x18ftypheic", "HEIC"),
        (b"\0\0\0\x18ftypavif", "AVIF"),
        (b"\0\0\0\x18ftypcrx ", "CR3"),
        (b"II*\0\x10\0\0\0CR\2\0", "CR2"),
        (b"IIU\0", "RW2"),
        (b"IIRO", "ORF"),
        (b"FUJIFILMCCD-RAW 0201", "RAF"),
        (b"8BPS", "PSD"),
    ],
)
def test_kinds_that_are_not_read_are_refused_by_name(
    tmp_path: Path, head: bytes, name: str
) -> None:
    (tmp_path / "a.jpg").write_bytes(head + bytes(400))
    with pytest.raises(plumbline.PlumblineError, match=name) as error:
        plumbline.correct(tmp_path / "a.jpg", BARREL)
    assert "without lens correction" in error.value.hint
