"""What the photograph says of itself survives, by exiftool's listing before and after."""

from __future__ import annotations

import functools
import io
import json
import shutil
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageCms

import plumbline
from plumbline.lenses.request import LensRequest
from plumbline.photos.files import exif, ifd, jpeg
from plumbline.photos.files.metadata import Metadata, note_of
from tests.imaging.painted import texture
from tests.peers.tools import program, run
from tests.photos import layouts

PHOTOS = Path(__file__).parents[4] / "shared" / "data" / "photos"
SIZE = (320, 240)
BARREL = LensRequest(ptlens={"a": 0.0, "b": -0.05, "c": 0.0})
XMP = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF '
    b'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description '
    b'xmlns:dc="http://purl.org/dc/elements/1.1/" dc:format="a facade"/></rdf:RDF></x:xmpmeta>'
)
ABOUT_THE_FILE = ("File:", "ExifTool:", "SourceFile")
MAY_CHANGE = {"EXIF:Software", "EXIF:ThumbnailLength", "EXIF:ThumbnailImage"}


def listing(path: Path) -> dict[str, Any]:
    """All tags but those of the file as such."""
    found = json.loads(run([program("exiftool"), "-j", "-G", "-n", str(path)]))[0]
    return {tag: value for tag, value in found.items() if not tag.startswith(ABOUT_THE_FILE)}


def unlike(before: dict[str, Any], after: dict[str, Any]) -> set[str]:
    """Tags that were lost, changed or added."""
    return {tag for tag in before.keys() | after.keys() if before.get(tag) != after.get(tag)}


@functools.cache
def profile() -> bytes:
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def tags(orientation: int = 1) -> Image.Exif:
    made = Image.Exif()
    made[0x010F], made[0x0110], made[0x0131] = "A maker", "A camera", "Firmware 1.0"
    made[0x0112], made[0x8298] = orientation, "(c) somebody"
    made[0x011A], made[0x011B], made[0x0128] = 240.0, 240.0, 2
    detail = made.get_ifd(0x8769)
    detail[0x920A], detail[0x829A], detail[0x9003] = 35.0, 0.004, "2026:01:02 03:04:05"
    place = made.get_ifd(0x8825)
    place[1], place[2] = "N", (52.0, 30.0, 12.5)
    return made


def write(path: Path, **how: Any) -> None:
    """A photo with metadata; Pillow alone does not write all of them into PNG and TIFF."""
    photo = path.with_suffix(".jpg")
    image = Image.fromarray(texture(SIZE))
    image.save(photo, exif=tags(), icc_profile=profile(), xmp=XMP, dpi=(240, 240))
    if path.suffix != ".jpg":
        image.save(path, dpi=(240, 240), **how)
        copied = ["-all:all", "-icc_profile", "-xmp", str(path)]
        run(
            [program("exiftool"), "-q", "-overwrite_original", "-tagsfromfile", str(photo), *copied]
        )


@pytest.mark.parametrize("name", ["nikon_e995_8.2mm.jpg", "nikon_e5700_8.9mm_portrait.jpg"])
def test_a_camera_s_photo_keeps_everything(tmp_path: Path, name: str) -> None:
    if not (PHOTOS / name).exists():
        pytest.skip("the camera originals are not here")
    shutil.copy(PHOTOS / name, tmp_path / "a.jpg")
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    before, after = listing(tmp_path / "a.jpg"), listing(done.output)
    assert len(before) > 60
    assert unlike(before, after) <= MAY_CHANGE
    assert str(before["EXIF:Software"]) in str(after["EXIF:Software"])
    assert "corrected by plumbline" in after["EXIF:Software"]


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp", ".tif"])
def test_each_format_keeps_exif_xmp_profile_and_resolution(tmp_path: Path, suffix: str) -> None:
    write(tmp_path / f"a{suffix}", **({"lossless": True} if suffix == ".webp" else {}))
    done = plumbline.correct(tmp_path / f"a{suffix}", BARREL)
    before, after = listing(tmp_path / f"a{suffix}"), listing(done.output)
    assert before["EXIF:Model"] == "A camera"
    layout = {"PNG:Filter", "PNG:Compression", "EXIF:StripOffsets", "EXIF:StripByteCounts"}
    layout |= {
        "EXIF:SampleFormat",
        "EXIF:RowsPerStrip",
        "EXIF:Compression",
        "EXIF:Predictor",
        "EXIF:SubfileType",
    }
    assert unlike(before, after) <= MAY_CHANGE | layout
    with Image.open(done.output) as made:
        assert made.info["icc_profile"] == profile()


@pytest.mark.parametrize("source", [".jpg", ".png", ".webp", ".tif"])
@pytest.mark.parametrize("target", [".jpg", ".png", ".webp", ".tif"])
def test_metadata_change_formats_with_the_picture(tmp_path: Path, source: str, target: str) -> None:
    if source == target:
        return
    write(tmp_path / f"a{source}")
    done = plumbline.correct(tmp_path / f"a{source}", BARREL, tmp_path / f"b{target}")
    after = listing(done.output)
    assert after["EXIF:Make"] == "A maker"
    assert after["EXIF:FocalLength"] == 35
    assert after["EXIF:Copyright"] == "(c) somebody"
    assert abs(after["EXIF:GPSLatitude"] - 52.5034722) < 1e-6
    assert after["XMP:Format"] == "a facade"
    assert after["ICC_Profile:ColorSpaceData"] == "RGB "
    assert after["EXIF:XResolution"] == 240
    assert after["EXIF:Software"].startswith("Firmware 1.0; corrected by plumbline")


def test_a_photo_without_metadata_gets_the_note(tmp_path: Path) -> None:
    for suffix in (".jpg", ".png", ".webp", ".tif"):
        Image.fromarray(texture(SIZE)).save(tmp_path / f"a{suffix}")
        after = listing(plumbline.correct(tmp_path / f"a{suffix}", BARREL).output)
        assert after["EXIF:Software"].startswith("corrected by plumbline")
        assert "b = -0.05" in after["EXIF:Software"]


def test_the_orientation_and_the_pixels_stay_consistent(tmp_path: Path) -> None:
    upright = texture(SIZE)
    Image.fromarray(upright).save(tmp_path / "upright.png")
    expected = plumbline.correct(tmp_path / "upright.png", BARREL, interpolation="linear").output
    exif_of = tags(6)
    Image.fromarray(np.rot90(upright, 1)).save(tmp_path / "turned.png", exif=exif_of)
    done = plumbline.correct(tmp_path / "turned.png", BARREL, interpolation="linear").output
    from PIL import ImageOps

    with Image.open(done) as found, Image.open(expected) as wanted:
        assert found.getexif()[0x0112] == 6
        shown = np.asarray(ImageOps.exif_transpose(found)).astype(int)
        assert np.mean(np.abs(shown - np.asarray(wanted))) < 0.2


def _block_with_thumbnail(thumbnail: bytes) -> bytes:
    pointer = struct.pack("<I", 200)
    first = [ifd.Field(0x010F, 2, b"A maker\0")]
    second = [
        ifd.Field(0x0103, 3, struct.pack("<H", 6)),
        ifd.Field(0x0201, 4, struct.pack("<I", 400)),
        ifd.Field(0x0202, 4, struct.pack("<I", len(thumbnail))),
    ]
    head = b"II*\0" + struct.pack("<I", 8) + ifd.directory_bytes(first, 8, "<", 200)
    assert pointer == struct.pack("<I", 200)
    block = head.ljust(200, b"\0") + ifd.directory_bytes(second, 200, "<")
    return block.ljust(400, b"\0") + thumbnail


def _thumbnail(size: tuple[int, int]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(texture(size, seed=9)).save(buffer, "JPEG", quality=90)
    return buffer.getvalue()


@pytest.mark.parametrize(("size", "kept"), [((160, 120), True), ((160, 160), False)])
def test_the_thumbnail_is_refreshed_or_dropped(
    tmp_path: Path, size: tuple[int, int], kept: bool
) -> None:
    old = _thumbnail(size)
    Image.fromarray(texture(SIZE)).save(
        tmp_path / "a.jpg", exif=b"Exif\0\0" + _block_with_thumbnail(old)
    )
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    block = jpeg.read_metadata(done.output.read_bytes())[0].exif
    _, following = ifd.read_directory(block, ifd.first_directory(block))
    assert bool(following) == kept
    if not kept:
        return
    found = {field.tag: field.data for field in ifd.read_directory(block, following)[0]}
    start, size_ = (struct.unpack("<I", found[tag])[0] for tag in (0x0201, 0x0202))
    with (
        Image.open(io.BytesIO(block[start : start + size_])) as fresh,
        Image.open(done.output) as photo,
    ):
        assert fresh.size == size
        shown = np.asarray(photo.resize(size, Image.Resampling.BOX)).astype(int)
        assert np.mean(np.abs(np.asarray(fresh).astype(int) - shown)) < 8


def test_nothing_in_an_exif_block_moves() -> None:
    block = _block_with_thumbnail(_thumbnail((160, 120)))
    made = exif.annotated(block, "a note", lambda old: old).block
    assert made[8 : len(block)] == block[8:]
    fields, following = ifd.read_directory(made, ifd.first_directory(made))
    assert following == 200
    assert {field.tag: field.data for field in fields} == {
        0x010F: b"A maker\0",
        0x0131: b"a note\0",
    }


def test_a_damaged_exif_block_is_kept_and_said_so(tmp_path: Path) -> None:
    broken = b"Exif\0\0II*\0" + struct.pack("<I", 8) + b"\xff\xff" + bytes(20)
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg", exif=broken)
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    assert any("damaged" in note for note in done.notes)
    assert jpeg.read_metadata(done.output.read_bytes())[0].exif == broken[6:]


@pytest.mark.parametrize("thumbnail", [False, True])
@pytest.mark.parametrize("order", "<>")
def test_exif_of_every_size_up_to_the_segment_s_limit(
    tmp_path: Path, thumbnail: bool, order: str
) -> None:
    """All of it is kept, the note beside it where it is full; the next run knows the result."""
    small = _thumbnail((160, 120)) if thumbnail else b""
    for size in (300 + len(small), 20_000, 65_300, 65_400, *range(65_495, 65_528)):
        if size > 65_400 and size % 4 and size < 65_520:
            continue
        filling = size - len(_sized_block(0, small, order))
        block = _sized_block(filling, small, order)
        assert len(block) == size
        Image.fromarray(texture((64, 48))).save(tmp_path / "a.png")
        layouts.photo(tmp_path / "a.jpg", block, (160, 120))
        plumbline.correct(tmp_path / "a.jpg", BARREL)
        done = plumbline.correct(tmp_path / "a.jpg", BARREL)  # over the first result
        found = _fields_of(done.output)
        assert found[0x010F].rstrip(b"\0") == b"A maker"
        assert found[0x927C] == b"\xaa" * filling
        if thumbnail:
            assert b"corrected by plumbline" in found[0x0131]
        told = any("noted in a comment" in note for note in done.notes)
        assert told == (b"corrected by plumbline" not in found.get(0x0131, b""))
        assert any("already" in note for note in plumbline.correct(done.output, BARREL).notes)


def _sized_block(filling: int, thumbnail: bytes, order: str) -> bytes:
    """An EXIF block with maker notes of a size, and a thumbnail."""
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", 8)
    at_notes = 8 + 2 + 3 * 12 + 4 + 8
    at_exif = at_notes + filling
    at_second = at_exif + 2 + 12 + 4
    main = struct.pack(order + "H", 3)
    main += struct.pack(order + "HHII", 0x010F, 2, 8, at_notes - 8)
    main += struct.pack(order + "HHIHH", 0x0112, 3, 1, 1, 0)
    main += struct.pack(order + "HHII", 0x8769, 4, 1, at_exif)
    main += struct.pack(order + "I", at_second if thumbnail else 0) + b"A maker\0"
    block = head + main + b"\xaa" * filling + struct.pack(order + "H", 1)
    block += struct.pack(order + "HHII", 0x927C, 7, filling, at_notes) + bytes(4)
    if not thumbnail:
        return block
    pointers = struct.pack(order + "H", 2)
    start = at_second + 2 + 24 + 4
    pointers += struct.pack(order + "HHII", 0x0201, 4, 1, start)
    pointers += struct.pack(order + "HHII", 0x0202, 4, 1, len(thumbnail)) + bytes(4)
    return block + pointers + thumbnail


def _fields_of(path: Path) -> dict[int, bytes]:
    """IFD0's and EXIF's fields, by Pillow's word for those it reads."""
    block = jpeg.read_metadata(path.read_bytes())[0].exif
    fields, _ = ifd.read_directory(block, ifd.first_directory(block))
    with Image.open(path) as image:
        assert str(image.getexif()[0x010F]).rstrip("\0") == "A maker"
    return {f.tag: f.data for field in fields for f in (field, *field.children)}


@pytest.mark.parametrize("size", [(1, 0, 1, 0), (0x010E, 2, 12, 5000), (0x010E, 99, 1, 0)])
def test_broken_fields_are_left_out_and_told(tmp_path: Path, size: tuple[int, ...]) -> None:
    entry = struct.pack("<HHII", *size)
    maker = struct.pack("<HHII", 0x010F, 2, 8, 8 + 2 + 24 + 4)
    block = b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", 2) + maker + entry + bytes(4)
    layouts.photo(tmp_path / "a.jpg", block + b"A maker\0")
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    assert "1 broken field of EXIF left out" in done.notes
    found = listing(done.output)
    assert found["EXIF:Make"] == "A maker"
    assert "EXIF:ImageDescription" not in found
    assert "Warning" not in "".join(found)
    plumbline.correct(tmp_path / "a.jpg", BARREL)  # over its own result


IPTC_RECORDS = b"\x1c\x02\x78\x00\x09A caption"


def _with_iptc(path: Path) -> None:
    resource = b"8BIM\x04\x04\0\0" + struct.pack(">I", len(IPTC_RECORDS)) + IPTC_RECORDS
    payload = b"Photoshop 3.0\0" + resource
    Image.fromarray(texture(SIZE)).save(path, comment="a remark")
    data = path.read_bytes()
    segment = struct.pack(">HH", 0xFFED, len(payload) + 2) + payload
    path.write_bytes(data[:2] + segment + data[2:])


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_iptc_and_comments_go_along_or_are_told_of(tmp_path: Path, suffix: str) -> None:
    _with_iptc(tmp_path / "a.jpg")
    done = plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / f"b{suffix}")
    if suffix == ".webp":
        assert "WEBP does not hold IPTC and a comment of the original: not kept" in done.notes
        return
    told = run([program("exiftool"), "-IPTC:Caption-Abstract", "-Comment", "-ImageDescription",
                str(done.output)])  # fmt: skip
    assert "A caption" in told
    assert "a remark" in told
    back = plumbline.correct(done.output, BARREL, tmp_path / "c.jpg")
    told = run([program("exiftool"), "-IPTC:Caption-Abstract", "-Comment", "-ImageDescription",
                str(back.output)])  # fmt: skip
    assert "A caption" in told
    assert "a remark" in told


def _gain_map(path: Path, *, video: bytes = b"") -> None:
    """As phones write them: XMP that tells of a second JPEG behind the first."""
    second = _thumbnail((40, 30))
    packet = (
        b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF '
        b'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description '
        b'xmlns:dc="http://purl.org/dc/elements/1.1/" '
        b'xmlns:hdrgm="http://ns.adobe.com/hdr-gain-map/1.0/" '
        b'xmlns:Container="http://ns.google.com/photos/1.0/container/" '
        b'xmlns:Item="http://ns.google.com/photos/1.0/container/item/" '
        b'dc:format="a facade" hdrgm:Version="1.0"><Container:Directory><rdf:Seq><rdf:li '
        b'rdf:parseType="Resource"><Container:Item Item:Semantic="GainMap" Item:Length="%d"/>'
        b"</rdf:li></rdf:Seq></Container:Directory></rdf:Description></rdf:RDF></x:xmpmeta>"
    ) % len(second)
    Image.fromarray(texture(SIZE)).save(path, xmp=packet)
    path.write_bytes(path.read_bytes() + second + video)


@pytest.mark.parametrize("video", [b"", b"\0\0\0\x18ftypmp42" + bytes(40)])
def test_a_gain_map_goes_with_its_promise_and_is_told_of(tmp_path: Path, video: bytes) -> None:
    _gain_map(tmp_path / "a.jpg", video=video)
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    what = "a gain map and a video" if video else "a gain map"
    assert any(note.startswith(f"{what} behind the photo") for note in done.notes)
    data = done.output.read_bytes()
    for word in (b"GainMap", b"hdrgm", b"Container", b"ftyp"):
        assert word not in data
    assert listing(done.output)["XMP:Format"] == "a facade"
    assert data.count(b"\xff\xd8\xff") == 1


def test_a_motion_photo_keeps_its_video(tmp_path: Path) -> None:
    """Its place is told from the end of the file, which stays as it was."""
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg", xmp=XMP)
    video = b"\0\0\0\x18ftypmp42" + bytes(range(200))
    (tmp_path / "a.jpg").write_bytes((tmp_path / "a.jpg").read_bytes() + video)
    done = plumbline.correct(tmp_path / "a.jpg", BARREL)
    assert done.output.read_bytes().endswith(video)
    other = plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / "b.png")
    assert any("data behind the picture" in note for note in other.notes)


def test_xmp_that_jpeg_cannot_hold_is_told_of(tmp_path: Path) -> None:
    for length, fits in ((65504, True), (65505, False)):  # 65533 less XMP's head of 29
        packet = b"<x:xmpmeta xmlns:x='adobe:ns:meta/'>".ljust(length - 12) + b"</x:xmpmeta>"
        Image.fromarray(texture(SIZE)).save(tmp_path / "a.webp", xmp=packet)
        done = plumbline.correct(tmp_path / "a.webp", BARREL, tmp_path / "b.jpg")
        assert any("XMP is too long" in note for note in done.notes) is not fits
        with Image.open(done.output) as made:
            assert made.info.get("xmp", b"") == (packet if fits else b"")


def test_a_long_profile_takes_several_segments(tmp_path: Path) -> None:
    long = profile() + bytes(200_000)
    data = jpeg.with_metadata(_thumbnail((64, 48)), Metadata(icc=long), "")
    (tmp_path / "a.jpg").write_bytes(data)
    with Image.open(tmp_path / "a.jpg") as image:
        assert image.info["icc_profile"] == long


def test_a_second_correction_is_warned_of(tmp_path: Path) -> None:
    write(tmp_path / "a.jpg")
    first = plumbline.correct(tmp_path / "a.jpg", BARREL)
    assert not any("already" in note for note in first.notes)
    again = plumbline.correct(first.output, BARREL)
    assert any("already" in note for note in again.notes)


@pytest.mark.parametrize(
    ("description", "told"),
    [
        ("ptlens, from /anywhere/lenses/building.json", "ptlens, from building.json"),
        ("ptlens, from lenses/building.json", "ptlens, from building.json"),
        ("ptlens, from C:\\Users\\me\\building.json", "ptlens, from building.json"),
        ("EF-S 18-55mm f/3.5-5.6 IS at 18 mm", "EF-S 18-55mm f/3.5-5.6 IS at 18 mm"),
        ("Nikkor 18-55mm f/3.5-5.6G VR at 18 mm", "Nikkor 18-55mm f/3.5-5.6G VR at 18 mm"),
        ("Objektiv für\nWeitwinkel", "Objektiv f?r Weitwinkel"),
    ],
)
def test_the_note_tells_the_lens_and_not_the_user_s_folders(description: str, told: str) -> None:
    assert note_of(description).endswith(f"({told})")


@pytest.mark.parametrize("target", ["b.tif", "b.jpg"])
@pytest.mark.parametrize("source", ["a.jpg", "a.tif"])
def test_maker_notes_that_cannot_be_moved_are_left_out(
    tmp_path: Path, source: str, target: str
) -> None:
    made = tags()
    made.get_ifd(0x8769)[0x927C] = b"Nikon\0" + bytes(range(100))
    image = Image.fromarray(texture(SIZE))
    image.save(tmp_path / "a.jpg", exif=made)
    image.save(tmp_path / "a.tif")
    data = (tmp_path / "a.tif").read_bytes()
    below = (
        ifd.Field(0x920A, 5, struct.pack("<II", 35, 1)),
        ifd.Field(0x927C, 7, b"Nikon\0" + bytes(range(100))),
    )
    fields = ifd.read_directory(data, ifd.first_directory(data))[0]
    directory = ifd.directory_bytes([*fields, ifd.Field(34665, 4, bytes(4), below)], len(data), "<")
    head = data[:4] + struct.pack("<I", len(data)) + data[8:]
    (tmp_path / "a.tif").write_bytes(head + directory)
    done = plumbline.correct(tmp_path / source, BARREL, tmp_path / target)
    kept = (source, target) == ("a.jpg", "b.jpg")
    with Image.open(done.output) as found:
        inner = found.getexif().get_ifd(0x8769)
    assert (0x927C in inner) == kept
    assert inner[0x920A] == 35
    assert sum("maker notes were left out" in note for note in done.notes) == (not kept)


def test_tiff_has_strips_of_a_sensible_size(tmp_path: Path) -> None:
    Image.fromarray(texture((1200, 900))).save(tmp_path / "a.tif")
    done = plumbline.correct(tmp_path / "a.tif", BARREL)
    with Image.open(done.output) as found:
        rows: Any = found.tag_v2[278]  # type: ignore[attr-defined]
        row_bytes = np.asarray(found)[0].nbytes
    assert 2**15 < rows * row_bytes <= 2**16


def test_an_empty_directory_of_the_original_is_left_out(tmp_path: Path) -> None:
    """As that of GPS which some cameras write; its offset would point anywhere."""
    empty = b"\0" * 6
    block = ifd.new_block([ifd.Field(0x010F, 2, b"A maker\0")])
    at = ifd.first_directory(block)
    one = block[at + 2 : at + 14]
    gps = struct.pack("<HHII", 34853, 4, 1, 8)
    start = 8 + len(empty)
    directory = struct.pack("<H", 2) + one[:8] + struct.pack("<I", start + 30) + gps + bytes(4)
    whole = block[:4] + struct.pack("<I", start) + empty + directory + b"A maker\0"
    Image.fromarray(texture(SIZE)).save(tmp_path / "a.jpg", exif=b"Exif\0\0" + whole)
    done = plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / "b.tif")
    with Image.open(done.output) as found:
        assert found.getexif()[0x010F] == "A maker"
        assert 34853 not in found.getexif()
    again = plumbline.correct(done.output, BARREL, tmp_path / "c.tif")
    assert not any("damaged" in note for note in again.notes)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_block_of_another_size_is_upright(order: str) -> None:
    """Built by hand: IFD0 with an orientation and a link to EXIF's own directory."""
    first = struct.pack(order + "HHHI", 2, 0x0112, 3, 1) + struct.pack(order + "HH", 6, 0)
    first += struct.pack(order + "HHIII", 0x8769, 4, 1, 38, 0)
    own = struct.pack(order + "HHHIIHHII", 2, 0xA002, 4, 1, 4000, 0xA003, 4, 1, 3000)
    mark = b"II*\0" if order == "<" else b"MM\0*"
    block = mark + struct.pack(order + "I", 8) + first + own + struct.pack(order + "I", 0)
    found = Image.Exif()
    found.load(b"Exif\0\0" + exif.of_another_size(block, (70, 90)))
    assert found[0x0112] == 1
    assert (found.get_ifd(0x8769)[0xA002], found.get_ifd(0x8769)[0xA003]) == (70, 90)
    assert exif.of_another_size(b"", (1, 1)) == b""
