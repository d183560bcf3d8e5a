"""Size, camera and lens from EXIF."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from plumbline.errors import ReadError
from plumbline.photos.exif import read_photo

PHOTOS = Path(__file__).parents[3] / "shared" / "data"
FULL_FRAME = np.sqrt(36**2 + 24**2)

MAKE, MODEL, ORIENTATION = 0x010F, 0x0110, 0x0112
FOCAL, EQUIVALENT, LENS_MAKE, LENS_MODEL = 0x920A, 0xA405, 0xA433, 0xA434
WIDTH, HEIGHT, X_RESOLUTION, Y_RESOLUTION, UNIT = 0xA002, 0xA003, 0xA20E, 0xA20F, 0xA210


def photo(
    path: Path,
    main: dict[int, Any] | None = None,
    exif: dict[int, Any] | None = None,
    size: tuple[int, int] = (60, 40),
) -> Path:
    """A grey JPEG with those tags."""
    tags = Image.Exif()
    for tag, value in (main or {}).items():
        tags[tag] = value
    for tag, value in (exif or {}).items():
        tags.get_ifd(0x8769)[tag] = value
    Image.new("L", size, 128).save(path, "JPEG", exif=tags)
    return path


def test_camera_lens_and_focal_length(tmp_path: Path) -> None:
    path = photo(
        tmp_path / "a.jpg",
        {MAKE: "NIKON", MODEL: "E995"},
        {FOCAL: IFDRational(82, 10), LENS_MAKE: "Sigma", LENS_MODEL: " 18-35mm\nF1.8 \x07Art "},
    )
    found = read_photo(path)
    assert (found.size, found.turned) == ((60, 40), False)
    facts = found.facts
    assert (facts.maker, facts.camera, facts.model) == ("Sigma", "NIKON E995", "18-35mm F1.8 Art")
    assert (facts.focal_mm, facts.crop_factor) == (8.2, None)


@pytest.mark.parametrize(
    ("make", "model", "camera"),
    [
        ("Canon", "Canon EOS 5D", "Canon EOS 5D"),
        ("NIKON", "E995", "NIKON E995"),
        ("", "E995", "E995"),
        ("NIKON", "", "NIKON"),
        ("", "", ""),
    ],
)
def test_names_of_cameras(tmp_path: Path, make: str, model: str, camera: str) -> None:
    facts = read_photo(photo(tmp_path / "a.jpg", {MAKE: make, MODEL: model})).facts
    assert (facts.maker, facts.camera, facts.model) == (make, camera, "")


@pytest.mark.parametrize("orientation", range(1, 9))
def test_the_orientation_is_applied(tmp_path: Path, orientation: int) -> None:
    found = read_photo(photo(tmp_path / "a.jpg", {ORIENTATION: orientation}))
    sideways = orientation >= 5
    assert found.size == ((40, 60) if sideways else (60, 40))
    assert found.turned == sideways
    assert found.stored_size == (60, 40)


def test_without_exif(tmp_path: Path) -> None:
    for name in ("a.jpg", "a.png", "a.tif", "a.webp", "a.bmp"):
        Image.new("RGB", (31, 17)).save(tmp_path / name)
        found = read_photo(tmp_path / name)
        assert found.size == (31, 17)
        assert (found.facts.focal_mm, found.facts.crop_factor, found.facts.camera) == (
            None,
            None,
            "",
        )


def test_the_crop_factor_from_the_35_mm_equivalent(tmp_path: Path) -> None:
    facts = read_photo(photo(tmp_path / "a.jpg", exif={FOCAL: 8.0, EQUIVALENT: 39})).facts
    assert facts.crop_factor == 39 / 8
    # The equivalent is rounded to whole millimetres: half of one in 39.
    assert facts.crop_factor_error == pytest.approx(0.5 / 39)


def test_the_crop_factor_from_the_sensor_is_better(tmp_path: Path) -> None:
    # 6000 pixels at 250 a mm: 24 mm by 16 mm, whose diagonal is 1.5 times smaller than 36 x 24.
    sensor = {WIDTH: 6000, HEIGHT: 4000, X_RESOLUTION: 250.0, Y_RESOLUTION: 250.0, UNIT: 4}
    facts = read_photo(photo(tmp_path / "a.jpg", exif=sensor)).facts
    assert facts.crop_factor == pytest.approx(1.5, rel=1e-12)
    assert facts.crop_factor_error is None
    agreeing = sensor | {FOCAL: 18.0, EQUIVALENT: 28}
    facts = read_photo(photo(tmp_path / "b.jpg", exif=agreeing)).facts
    assert facts.crop_factor == pytest.approx(1.5, rel=1e-12)
    contradicting = sensor | {FOCAL: 18.0, EQUIVALENT: 36}  # the photo was cropped or resized
    facts = read_photo(photo(tmp_path / "c.jpg", exif=contradicting)).facts
    assert facts.crop_factor == 2


@pytest.mark.parametrize(("unit", "mm"), [(None, 25.4), (2, 25.4), (3, 10.0), (4, 1.0)])
def test_units_of_the_resolution(tmp_path: Path, unit: int | None, mm: float) -> None:
    sensor = {WIDTH: 600, HEIGHT: 800, X_RESOLUTION: 80 * mm, Y_RESOLUTION: 80 * mm}
    if unit is not None:
        sensor[UNIT] = unit
    facts = read_photo(photo(tmp_path / "a.jpg", exif=sensor)).facts
    assert facts.crop_factor == pytest.approx(FULL_FRAME / 12.5, rel=1e-6)


@pytest.mark.parametrize(
    "exif",
    [
        {FOCAL: IFDRational(1, 0), EQUIVALENT: 35},
        {FOCAL: IFDRational(0, 0)},
        {FOCAL: IFDRational(0, 5), EQUIVALENT: 35},
        {FOCAL: 0.0, EQUIVALENT: 0},
        {EQUIVALENT: 35},
        {WIDTH: 600, HEIGHT: 400, X_RESOLUTION: IFDRational(1, 0), Y_RESOLUTION: 1.0},
        {WIDTH: 600, HEIGHT: 400, X_RESOLUTION: 1.0},
        {WIDTH: 600, HEIGHT: 400, X_RESOLUTION: 1.0, Y_RESOLUTION: 1.0, UNIT: 9},
        {WIDTH: 600, HEIGHT: 400, X_RESOLUTION: 1e-9, Y_RESOLUTION: 1e-9},
    ],
)
def test_values_that_make_no_sense_are_not_known(tmp_path: Path, exif: dict[int, Any]) -> None:
    facts = read_photo(photo(tmp_path / "a.jpg", exif=exif)).facts
    assert (facts.focal_mm, facts.crop_factor) == (None, None)


def png_header(width: int, height: int) -> bytes:
    chunk = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    )


IDAT = struct.pack(">I", 4) + b"IDAT" + b"\0" * 8


def test_what_is_no_photo_is_refused_with_a_remedy(tmp_path: Path) -> None:
    (tmp_path / "text.jpg").write_text("hello")
    (tmp_path / "empty.jpg").touch()
    (tmp_path / "bomb.png").write_bytes(png_header(60_000, 60_000) + IDAT)
    (tmp_path / "folder.jpg").mkdir()
    os.mkfifo(tmp_path / "pipe.jpg")
    (tmp_path / "loop.jpg").symlink_to("loop.jpg")
    for name, sentence in {
        "none.jpg": "there is no such photo",
        "text.jpg": "this is not a picture that can be read",
        "empty.jpg": "this is not a picture that can be read",
        "bomb.png": "more pixels than any camera",
        "folder.jpg": "this is not a file",
        "pipe.jpg": "this is not a file",
        "loop.jpg": "the photo cannot be read: Too many levels of symbolic links",
        "x" * 300: "the photo cannot be read: File name too long",
    }.items():
        with pytest.raises(ReadError) as caught:
            read_photo(tmp_path / name)
        assert caught.value.message.startswith(f"{tmp_path / name}: ")
        assert sentence in caught.value.message
        assert caught.value.hint.startswith("give a JPEG, TIFF, PNG or WebP")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
@given(data=st.data())
def test_damaged_photos_are_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    tags = {FOCAL: 8.0, EQUIVALENT: 39, WIDTH: 6000, HEIGHT: 4000, X_RESOLUTION: 250.0}
    whole = photo(tmp_path / "a.jpg", {MAKE: "NIKON", MODEL: "E995", ORIENTATION: 6}, tags)
    content = bytearray(whole.read_bytes()[:400])
    for place, value in data.draw(
        st.lists(st.tuples(st.integers(0, len(content) - 1), st.integers(0, 255)), max_size=5)
    ):
        content[place] = value
    cut = data.draw(st.integers(0, len(content)))
    (tmp_path / "b.jpg").write_bytes(content[:cut])
    caught: ReadError | None = None
    try:
        found = read_photo(tmp_path / "b.jpg")
    except ReadError as error:
        caught = error
    else:
        assert found.size[0] > 0
        assert found.size[1] > 0
    assert caught is None or caught.hint


@pytest.mark.parametrize(
    ("name", "size", "camera", "focal_mm", "crop_factor"),
    [
        # As ImageMagick's `identify -format %[EXIF:*]` lists them.
        ("photos/nikon_e995_8.2mm.jpg", (2048, 1536), "NIKON E995", 8.2, None),
        ("photos/nikon_e5700_8.9mm_portrait.jpg", (1920, 2560), "NIKON E5700", 8.9, None),
        (
            "photos/nikon_d5000_18mm_resized.jpg",
            (858, 570),
            "NIKON CORPORATION NIKON D5000",
            18,
            27 / 18,
        ),
        (
            "olympus/olympus_c250l_9.2mm.JPG",
            (1712, 1368),
            "OLYMPUS OPTICAL CO.,LTD C2500L",
            9.2,
            None,
        ),
    ],
)
def test_originals(
    name: str, size: tuple[int, int], camera: str, focal_mm: float, crop_factor: float | None
) -> None:
    path = PHOTOS / name
    if not path.is_file():
        pytest.skip("the photographs are not beside this checkout")
    found = read_photo(path)
    assert found.size == size
    assert found.facts.camera == camera
    assert found.facts.focal_mm == pytest.approx(focal_mm)
    assert found.facts.crop_factor == crop_factor


def test_a_range_of_focal_lengths_is_not_a_name(tmp_path: Path) -> None:
    xmp = b'<x:xmpmeta><rdf:Description aux:Lens="18.0-55.0 mm f/3.5-5.6"/></x:xmpmeta>'
    Image.new("RGB", (60, 40)).save(tmp_path / "a.jpg", xmp=xmp)
    assert read_photo(tmp_path / "a.jpg").facts.model == ""
    Image.new("RGB", (60, 40)).save(tmp_path / "b.jpg", xmp=xmp.replace(b"18.0", b"AF-S 18.0"))
    assert read_photo(tmp_path / "b.jpg").facts.model == "AF-S 18.0-55.0 mm f/3.5-5.6"
