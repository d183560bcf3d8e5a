"""Which lens is found for a photo, and what is said where none or several are."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plumbline.errors import OptionError, PlumblineError, ReadError
from plumbline.formats.lens_files.lensfun import Distortion, LensfunLens, lensfun_xml
from plumbline.frame import Array
from plumbline.lenses.choosing import LensMatch
from plumbline.lenses.lensfun.database import common_database
from plumbline.lenses.lensfun.entry import interpolated
from plumbline.lenses.lookup import find_correction, look_up
from plumbline.lenses.profile import correction
from plumbline.lenses.request import LensRequest
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts, read_photo
from tests.lenses.library import lensfunpy
from tests.lenses.made import calibration, saved
from tests.lenses.photos import photo, real

XML = """<lensdatabase version="1">
    <mount><name>Test mount</name></mount>
    <camera>
        <maker>Maker</maker> <model>Body 1</model>
        <mount>Test mount</mount> <cropfactor>2.0</cropfactor>
    </camera>
    <lens>
        <maker>Maker</maker> <model>Zoom 10-20mm</model> <mount>Test mount</mount>
        <cropfactor>1.5</cropfactor> <aspect-ratio>3:2</aspect-ratio>
        <calibration>
            <distortion model="poly5" focal="10" k1="-0.08" k2="0.01"/>
            <distortion model="poly5" focal="14" k1="-0.03" k2="0.004"/>
            <distortion model="poly5" focal="20" k1="0.01" k2="-0.001"/>
        </calibration>
    </lens>
    <lens>
        <maker>Maker</maker> <model>Prime 35mm</model> <mount>Test mount</mount>
        <cropfactor>1.5</cropfactor>
        <calibration><distortion model="poly3" focal="35" k1="-0.01"/></calibration>
    </lens>
</lensdatabase>
"""
ACM = ("k1", "k2", "k3", "k4", "k5")


@pytest.fixture(autouse=True)
def _empty_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def xml(tmp_path: Path) -> str:
    path = tmp_path / "lenses.xml"
    path.write_text(XML)
    return str(path)


def facts(size: tuple[int, int] = (2000, 1500), **more: object) -> PhotoFacts:
    """Facts of a photo taken with Body 1 at 12 mm, unless said otherwise."""
    known = {"camera": "Maker Body 1", "focal_mm": 12.0} | {
        name: more.pop(name)
        for name in ("camera", "model", "focal_mm", "crop_factor")
        if name in more
    }
    given = {"maker": "Maker", "model": "Body 1"} | more
    return PhotoFacts(size, LensFacts(**known), **given)  # type: ignore[arg-type]


def grid(size: tuple[int, int], step: int = 50) -> Array:
    y, x = np.mgrid[0 : size[1] : step, 0 : size[0] : step]
    return np.stack((x, y), axis=-1).astype(float)


def test_the_coolpix_995_is_found_by_exif_alone() -> None:
    shot = read_photo(real("nikon_e995_8.2mm.jpg"))
    found = find_correction(shot, LensRequest())
    assert "E995 & compatibles (Standard)" in found.description
    assert "k1 = −0.019966" in found.description
    corner = found.distort(np.array([0.0, 0.0]))
    # r_obs = r (1 − k1 + k1 r²) with r = 5/3 half short sides at the corner of a 4:3 photo,
    # but for half a pixel.
    centre = np.array([1023.5, 767.5])
    r = np.hypot(*centre) / 768
    expected = centre - centre * (1.019966 - 0.019966 * r**2)
    np.testing.assert_allclose(corner, expected, atol=1e-5)  # LensFun keeps k1 in 32 bits
    assert any("converter" in note for note in found.notes)


def test_the_portrait_of_the_e5700_is_found_by_exif_alone() -> None:
    found = find_correction(read_photo(real("nikon_e5700_8.9mm_portrait.jpg")), LensRequest())
    assert "E5700" in found.description
    assert found.size == (1920, 2560)


def test_the_resized_d5000_asks_which_lens_and_then_knows_that_it_was_resized() -> None:
    shot = read_photo(real("nikon_d5000_18mm_resized.jpg"))
    with pytest.raises(OptionError, match="several lenses of LensFun's database match") as error:
        find_correction(shot, LensRequest())
    assert "--lens-name" in error.value.hint
    # XMP tells of 18 to 55 mm: only such lenses are asked about.
    names = error.value.message.partition(": ")[2].split(", ")
    assert len(names) == 4
    assert all("18-55mm" in name for name in names)
    named = "AF-S DX VR Zoom-Nikkor 18-55mm f/3.5-5.6G"
    found = find_correction(shot, LensRequest(lens_name=named))
    assert "18-55mm f/3.5-5.6G VR on Nikon D5000 at 18 mm" in found.description
    assert any("resized from 4288x2848 to 858x570" in note for note in found.notes)


def test_other_sensors_are_scaled_as_by_lensfun(xml: str) -> None:
    size = (2000, 1500)
    database = lensfunpy.Database(xml=XML, load_common=False, load_bundled=False)
    lens = next(each for each in database.lenses if each.model == "Zoom 10-20mm")
    # LensFun 0.3 measures with (side − 1): a photo one pixel smaller for us, half a pixel aside.
    modifier = lensfunpy.Modifier(lens, 2.0, *size)
    modifier.initialize(12.0, 8.0, scale=1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
    theirs = modifier.apply_geometry_distortion()[::50, ::50]
    smaller = find_correction(facts((1999, 1499)), LensRequest(source=xml))
    ours = smaller.distort(grid(size) - 0.5) + 0.5
    moved = np.hypot(*np.moveaxis(ours - grid(size), -1, 0))
    assert np.max(moved) > 20
    assert np.max(np.hypot(*np.moveaxis(theirs - ours, -1, 0))) < 0.05
    wrong = find_correction(facts((1999, 1499)), LensRequest(source=xml, crop_factor=1.5))
    off = wrong.distort(grid(size) - 0.5) + 0.5 - theirs
    assert np.max(np.hypot(*np.moveaxis(off, -1, 0))) > 5


def test_the_whole_database_is_scaled_as_by_lensfun() -> None:
    """A sample of its lenses at any focal length, on sensors down to half as large.

    LensFun's single precision, with SSE's estimate of 1/r, errs by 0.1 px in the median and by
    more in corners that are bent by hundreds of pixels.
    """
    database, rng, size = common_database(), np.random.default_rng(0), (1500, 1000)
    lenses = [lens for lens in database.library.lenses if lens.calib_distortion]
    told_apart = 0
    for index in rng.choice(len(lenses), 80, replace=False):
        lens = lenses[index]
        focals = [each.focal for each in lens.calib_distortion]
        focal_mm = float(rng.uniform(min(focals), max(focals)))
        candidate = LensMatch(lens.model, (min(focals), max(focals)))
        profile = interpolated(database, lens, None, focal_mm, candidate)
        crop = lens.crop_factor * float(rng.choice([1, 1.25, 1.5, 2]))
        modifier = lensfunpy.Modifier(lens, crop, *size)
        modifier.initialize(focal_mm, 8.0, scale=1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
        theirs = modifier.apply_geometry_distortion()
        if theirs is None:
            continue
        shot = PhotoFacts((size[0] - 1, size[1] - 1), LensFacts())
        off: list[Array] = []
        for photo_crop in (crop, lens.crop_factor):
            found = correction(replace(profile, photo_crop=photo_crop), shot, LensRequest())
            ours = found.distort(grid(size) - 0.5) + 0.5
            off.append(np.hypot(*np.moveaxis(theirs[::50, ::50] - ours, -1, 0)))
        assert np.median(off[0]) < 0.15, (lens.model, focal_mm)
        assert np.max(off[0]) < 0.75, (lens.model, focal_mm)
        told_apart += np.max(off[1]) > 2
    assert told_apart > 15


def test_portrait_and_landscape_agree(xml: str) -> None:
    wide = find_correction(facts((2000, 1500)), LensRequest(source=xml))
    tall = find_correction(facts((1500, 2000)), LensRequest(source=xml))
    points = grid((2000, 1500))
    np.testing.assert_allclose(
        tall.distort(points[..., ::-1])[..., ::-1], wide.distort(points), atol=1e-9
    )


def test_out_and_back_agree(xml: str) -> None:
    found = find_correction(facts(), LensRequest(source=xml))
    np.testing.assert_allclose(
        found.undistort(found.distort(grid((2000, 1500)))), grid((2000, 1500)), atol=1e-9
    )


def test_the_lens_is_chosen_by_name(xml: str) -> None:
    request = LensRequest(source=xml, lens_name="prime 35mm", focal_mm=35.0)
    assert "Prime 35mm" in find_correction(facts(), request).description
    named = facts(focal_mm=35.0)
    assert "Prime 35mm" in find_correction(named, LensRequest(source=xml)).description


def test_a_folder_of_lensfun_files_is_one_database(xml: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "a.xml").write_text(XML)
    found = find_correction(facts(), LensRequest(source=str(folder)))
    assert "Zoom 10-20mm" in found.description
    (tmp_path / "empty").mkdir()
    with pytest.raises(ReadError, match="this folder holds no LensFun XML files"):
        find_correction(facts(), LensRequest(source=str(tmp_path / "empty")))


@pytest.mark.parametrize(
    ("focal_mm", "sentence"),
    [
        (9.2, "out of the calibrated range 10 to 20 mm: corrected as at 10 mm"),
        (21.5, "as at 20 mm"),
    ],
)
def test_just_out_of_range_is_clamped_with_a_warning(
    xml: str, focal_mm: float, sentence: str
) -> None:
    found = find_correction(facts(focal_mm=focal_mm), LensRequest(source=xml, lens_name="Zoom"))
    assert any(sentence in note for note in found.notes)


@pytest.mark.parametrize("focal_mm", [8.9, 22.1])
def test_far_out_of_range_is_refused(xml: str, focal_mm: float) -> None:
    with pytest.raises(OptionError, match=r"more than 10 % out of the calibrated range") as error:
        find_correction(facts(focal_mm=focal_mm), LensRequest(source=xml, lens_name="Zoom 10-20mm"))
    assert "--focal" in error.value.hint


def test_a_focal_length_that_is_not_known_is_asked_for(xml: str) -> None:
    with pytest.raises(OptionError, match="does not give its focal length") as error:
        find_correction(facts(focal_mm=None), LensRequest(source=xml, lens_name="Zoom 10-20mm"))
    assert "--focal" in error.value.hint


def test_no_exif_asks_for_the_camera(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="no EXIF that names its camera") as error:
        find_correction(read_photo(photo(tmp_path / "a.jpg")), LensRequest())
    assert "--camera" in error.value.hint


def test_exif_that_is_silent_can_be_told(tmp_path: Path) -> None:
    request = LensRequest(camera="Nikon E995", focal_mm=8.2)
    found = find_correction(read_photo(photo(tmp_path / "a.jpg")), request)
    assert "E995 & compatibles (Standard) on Nikon E995 at 8.2 mm" in found.description


def test_an_unknown_camera_is_told_and_like_is_never_silent(tmp_path: Path) -> None:
    shot = read_photo(photo(tmp_path / "a.jpg", make="NIKON", model="E996", focal=8.2))
    with pytest.raises(
        OptionError, match="the camera NIKON E996 is not in LensFun's database"
    ) as e:
        find_correction(shot, LensRequest())
    assert "--like" in e.value.hint
    found = find_correction(shot, LensRequest(like="Nikon E995"))
    assert "NIKON E996 is treated like the Nikon E995, as --like asks" in found.notes
    with pytest.raises(OptionError, match="the camera Nikon E12345 is not in"):
        find_correction(shot, LensRequest(like="Nikon E12345"))


def test_candidates_are_listed(tmp_path: Path) -> None:
    shot = read_photo(photo(tmp_path / "a.jpg", make="NIKON", model="E995", focal=8.2))
    names = [str(each) for each in look_up(shot, LensRequest()).candidates]
    assert "E995 & compatibles (Standard) (8.2–31 mm)" in names
    assert len(names) == 4


class TestFrames:
    """Photos that are not what their EXIF tells."""

    def test_merely_resized(self, xml: str) -> None:
        small = facts((1000, 750), exif_size=(4000, 3000))
        found = find_correction(small, LensRequest(source=xml))
        assert any("resized from 4000x3000 to 1000x750" in note for note in found.notes)
        large = find_correction(facts((4000, 3000)), LensRequest(source=xml))
        # Pixel centres: (x + 1/2) scales.
        np.testing.assert_allclose(
            (found.distort(grid((1000, 750))) + 0.5) * 4,
            large.distort((grid((1000, 750)) + 0.5) * 4 - 0.5) + 0.5,
            atol=1e-9,
        )

    def test_cropped_is_asked_about(self, xml: str) -> None:
        square = facts((1000, 1000), exif_size=(4000, 3000))
        with pytest.raises(OptionError, match="EXIF gives a picture of 4000x3000") as error:
            find_correction(square, LensRequest(source=xml))
        assert "--full-size" in error.value.hint
        assert "--crop-factor" in error.value.hint

    def test_a_digital_zoom_is_told_with_its_remedy(self, tmp_path: Path, xml: str) -> None:
        exif = Image.Exif()
        exif[0x010F], exif[0x0110] = "Maker", "Body 1"
        inner = exif.get_ifd(0x8769)
        inner[0x920A], inner[0xA404] = 12.0, 1.5
        Image.new("L", (1200, 800)).save(tmp_path / "a.jpg", exif=exif)
        shot = read_photo(tmp_path / "a.jpg")
        (note,) = find_correction(shot, LensRequest(source=xml)).notes
        assert "digital zoom of 1.5" in note
        assert note.endswith("--full-size 1800x1200")
        told = find_correction(shot, LensRequest(source=xml, full_size=(1800, 1200)))
        assert not any("zoom" in note for note in told.notes)
        for nothing in (0.0, 1.0):
            inner[0xA404] = nothing
            Image.new("L", (1200, 800)).save(tmp_path / "a.jpg", exif=exif)
            assert not find_correction(read_photo(tmp_path / "a.jpg"), LensRequest(xml)).notes

    def test_full_size_lays_the_whole_lens_over_the_middle(self, xml: str) -> None:
        square = facts((1000, 1000), exif_size=(4000, 3000))
        found = find_correction(square, LensRequest(source=xml, full_size=(2000, 1500)))
        whole = find_correction(facts((2000, 1500)), LensRequest(source=xml))
        shift = np.array([500.0, 250.0])
        points = grid((1000, 1000))
        np.testing.assert_allclose(
            found.distort(points), whole.distort(points + shift) - shift, atol=1e-9
        )

    def test_the_crop_factor_of_what_is_left_says_the_same(self, xml: str) -> None:
        square = facts((1000, 1000), exif_size=(4000, 3000))
        full = find_correction(square, LensRequest(source=xml, full_size=(2000, 1500)))
        crop = 2.0 * np.hypot(2000, 1500) / np.hypot(1000, 1000)
        found = find_correction(square, LensRequest(source=xml, crop_factor=crop))
        points = grid((1000, 1000))
        np.testing.assert_allclose(found.distort(points), full.distort(points), atol=1e-9)

    def test_a_whole_picture_smaller_than_the_photo_is_refused(self, xml: str) -> None:
        with pytest.raises(OptionError, match="smaller than the photo"):
            find_correction(facts((1000, 1000)), LensRequest(source=xml, full_size=(900, 2000)))


class TestHistory:
    """Photos that were corrected before."""

    def test_by_plumbline(self, xml: str) -> None:
        shot = facts(history="corrected by plumbline 0.1.0 (a lens)")
        notes = find_correction(shot, LensRequest(source=xml)).notes
        assert any("plumbline corrected this photo already" in note for note in notes)

    def test_by_another_program(self, tmp_path: Path, xml: str) -> None:
        path = photo(tmp_path / "a.jpg", (600, 400), make="Maker", model="Body 1", focal=12.0,
                     software="DxO PhotoLab 7")  # fmt: skip
        notes = find_correction(read_photo(path), LensRequest(source=xml)).notes
        assert any("DxO PhotoLab 7" in note and "already" in note for note in notes)

    def test_by_a_raw_developer(self, xml: str) -> None:
        shot = facts(profile_applied=True)
        notes = find_correction(shot, LensRequest(source=xml)).notes
        assert any("developed with a lens profile" in note for note in notes)

    def test_cameras_that_always_correct(self) -> None:
        shot = facts(
            (4000, 3000), camera="Olympus E-M5", focal_mm=14.0, maker="OLYMPUS", model="E-M5"
        )
        name = "Olympus M.Zuiko Digital 14-42mm f/3.5-5.6 II R"
        notes = find_correction(shot, LensRequest(camera="Olympus E-M5", lens_name=name)).notes
        assert any("Micro 4/3" in note for note in notes)

    def test_plain_software_is_no_warning(self, tmp_path: Path, xml: str) -> None:
        path = photo(tmp_path / "a.jpg", (600, 400), make="Maker", model="Body 1", focal=12.0,
                     software="Adobe Bridge CS5")  # fmt: skip
        assert not find_correction(read_photo(path), LensRequest(source=xml)).notes


def test_coefficients_typed_in() -> None:
    shot = PhotoFacts((401, 301), LensFacts())
    found = find_correction(shot, LensRequest(ptlens={"a": 0.01, "b": -0.05, "d": 3.0}))
    x = found.distort(np.array([350.5, 150.0]))[0]
    r = 150.5 / 150.5
    assert r == 1
    assert x == pytest.approx(350.5 + 3.0, abs=1e-9)  # r = 1 keeps its place but for the centre
    r = 60.2 / 150.5
    scale = 0.01 * r**3 - 0.05 * r**2 + 1.04
    assert found.distort(np.array([260.2, 150.0]))[0] == pytest.approx(203 + 60.2 * scale, abs=1e-9)


def test_contradictory_requests() -> None:
    shot = PhotoFacts((401, 301), LensFacts())
    with pytest.raises(OptionError, match="given twice"):
        find_correction(shot, LensRequest(source="a.xml", ptlens={"b": -0.01}))
    with pytest.raises(OptionError, match="k1 is not a coefficient"):
        find_correction(shot, LensRequest(ptlens={"k1": -0.01}))


def test_database_version_2_which_the_library_refuses(tmp_path: Path) -> None:
    """Adobe's model, read without the library; r in focal lengths of the photo's sensor."""
    k = {"k1": -0.08, "k2": 0.03, "k3": -0.004, "k4": 0.0007, "k5": -0.0004}
    head = LensfunLens("Maker", "Wide", "Test mount", 1.5, 4 / 3)
    path = tmp_path / "acm.xml"
    path.write_bytes(lensfun_xml(head, [Distortion("acm", 12.0, k)]))
    shot = facts(camera="No such camera", maker="No", model="such camera")
    found = find_correction(shot, LensRequest(source=str(path)))
    focal_px = 12.0 * 1.5 / np.hypot(36, 24) * np.hypot(2000, 1500)
    middle = np.array([999.5, 749.5])
    x, y = np.moveaxis(grid((2000, 1500)) - middle, -1, 0) / focal_px
    r2 = x**2 + y**2
    radial = 1 + k["k1"] * r2 + k["k2"] * r2**2 + k["k3"] * r2**3
    bent = radial + 2 * (k["k4"] * y + k["k5"] * x)
    expected = np.stack((x * bent + k["k5"] * r2, y * bent + k["k4"] * r2), axis=-1)
    np.testing.assert_allclose(
        found.distort(grid((2000, 1500))), expected * focal_px + middle, atol=1e-8
    )


def test_the_user_s_own_files_of_lensfun_come_first(tmp_path: Path) -> None:
    """In a process of its own, because the databases are loaded once."""
    folder = tmp_path / "data" / "lensfun"
    folder.mkdir(parents=True)
    own = XML.replace("Maker</maker> <model>Body 1", "Nikon</maker> <model>E995").replace(
        "Zoom 10-20mm", "Mine"
    )
    (folder / "mine.xml").write_text(own)
    (folder / "damaged.xml").write_text("<lensdatabase>")
    shot = photo(tmp_path / "a.jpg", (600, 400), make="NIKON", model="E995", focal=12.0)
    done = subprocess.run(
        [sys.executable, "-m", "plumbline", "lens", str(shot)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Used: Maker Mine on Nikon E995 at 12 mm" in done.stdout, done.stderr
    assert "damaged.xml" in done.stdout


def test_an_edited_file_is_read_again(xml: str) -> None:
    request = LensRequest(source=xml, lens_name="Prime 35mm", focal_mm=35)
    assert "k1 = −0.01," in look_up(facts(), request).profile.description
    Path(xml).write_text(XML.replace('k1="-0.01"', 'k1="-0.0234"'))
    assert "k1 = −0.0234," in look_up(facts(), request).profile.description


def test_like_is_never_left_aside_silently(xml: str, tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.02))
    with pytest.raises(OptionError, match="--like chooses a camera of a database"):
        find_correction(facts(), LensRequest(source=result, like="Maker Body 1"))
    with pytest.raises(OptionError, match="--like and --ptlens"):
        find_correction(facts(), LensRequest(ptlens={"b": -0.02}, like="Maker Body 1"))
    with pytest.raises(OptionError, match="the camera Nobody is not in"):
        find_correction(facts(), LensRequest(source=xml, like="Nobody"))
    other = facts(camera="Other", maker="Other", model="One", crop_factor=2.2)
    found = find_correction(other, LensRequest(source=xml, like="Maker Body 1"))
    assert "Other is treated like the Maker Body 1, as --like asks" in found.notes


HOSTILE = {
    "large.xml": b'<lensdatabase version="1"><lens><maker>M</maker><model>M</model><calibration>'
    b'<distortion model="poly3" focal="9" k1="1e300"/></calibration></lens></lensdatabase>',
    "empty.xml": b"",
    "binary.json": b"\x00\x01\x02",
    "broken.xml": b"<lensdatabase><lens></lensdatabase>",
    "other.xml": b"<svg/>",
    "bomb.xml": b'<!DOCTYPE x [<!ENTITY a "' + b"z" * 99 + b'">]><lensdatabase><lens>'
    b"<maker>&a;</maker><model>M</model><mount>m</mount><cropfactor>&a;</cropfactor>"
    b"</lens></lensdatabase>",
    "file.xml": b'<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/hostname">]><lensdatabase><lens>'
    b"<maker>M</maker><model>M</model><mount>m</mount><cropfactor>&a;</cropfactor></lens>"
    b"</lensdatabase>",
    "nan.xml": b'<lensdatabase version="1"><lens><maker>M</maker><model>M</model><calibration>'
    b'<distortion model="ptlens" focal="nan" a="0" b="0" c="0"/></calibration></lens>'
    b"</lensdatabase>",
    "unknown.xml": b'<lensdatabase version="1"><lens><maker>M</maker><model>M</model><calibration>'
    b'<distortion model="magic" focal="9"/></calibration></lens></lensdatabase>',
    "strange_element.xml": b'<lensdatabase version="1"><monster/></lensdatabase>',
    "version.xml": b'<lensdatabase version="9"></lensdatabase>',
    "no_lens.xml": b'<lensdatabase version="1"></lensdatabase>',
    "text.txt": b"hello",
    "lens.ini": b"[Lens]\na=x\n",
    "empty.ini": b"[Other]\n",
    "profile.txt": b"begin lens\nmultiplier: 1.5\n",
    "project.pto": b'# hugin project file\ni w100 h100 f0 v50 a=3 b0 c0 n"x.jpg"\n',
    "none.pto": b"# hugin project file\n",
    "huge.pto": b'# hugin project file\ni w100 h100 f0 v50 a1e300 b0 c0 n"x.jpg"\n',
    "moved.pto": b'# hugin project file\ni w100 h100 f0 v50 a0 b0 c0 C0,50,0,100 n"x.jpg"\n',
    "result.json": b'{"format": "plumbline calibration"}',
    "zoom.json": b'{"format": "plumbline zoom", "format_version": 1}',
    "deep.json": b'{"format": "plumbline zoom", "a": ' + b"[" * 100_000,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_damaged_files_end_in_a_sentence(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(HOSTILE[name])
    shot = facts()
    with pytest.raises(PlumblineError) as error:
        find_correction(shot, LensRequest(source=str(path)))
    assert name in error.value.message
    assert error.value.hint


@pytest.mark.parametrize(
    ("told", "expected"), [((18.0, 55.0), (18.0, 55.0)), ((55.0, 18.0), None), (None, None)]
)
def test_exif_may_tell_the_range_of_the_lens(
    tmp_path: Path, told: tuple[float, float] | None, expected: tuple[float, float] | None
) -> None:
    assert read_photo(photo(tmp_path / "a.jpg", lens_range=told)).lens_range_mm == expected


def test_converters_do_not_stand_in_for_the_lens_itself() -> None:
    """The standard lens ends at 31 mm; those with a converter reach farther."""
    shot = PhotoFacts((2048, 1536), LensFacts(camera="NIKON E995"), maker="NIKON", model="E995")
    with pytest.raises(OptionError, match="out of the calibrated range") as error:
        find_correction(shot, LensRequest(focal_mm=35.0))
    assert "Standard" in error.value.message
    candidates = look_up(shot, LensRequest(focal_mm=20.0)).candidates
    (reaching,) = [each.name for each in candidates if each.covers(35.0)]
    found = find_correction(shot, LensRequest(focal_mm=35.0, lens_name=reaching))
    assert reaching in found.description


def test_a_lens_without_distortion_is_told(xml: str) -> None:
    shot = PhotoFacts((401, 301), LensFacts())
    notes = find_correction(shot, LensRequest(ptlens={"a": 0.0, "b": 0.0})).notes
    assert notes == ("the lens has no distortion: the photo stays as it is",)
    notes = find_correction(shot, LensRequest(ptlens={"b": 0.0, "d": 5.0})).notes
    assert notes == ("the lens has no distortion: the photo is only shifted (d, e)",)
    assert not find_correction(shot, LensRequest(ptlens={"b": -0.01})).notes


def test_one_bad_file_of_a_folder_is_left_aside(xml: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "a.xml").write_text(XML)
    (folder / "b.xml").write_text("<lensdatabase>")
    (folder / "c.xml").write_text('<lensdatabase version="1"><monster/></lensdatabase>')
    found = find_correction(facts(), LensRequest(source=str(folder)))
    assert "Zoom 10-20mm" in found.description
    aside = [note for note in found.notes if "left aside" in note]
    assert [name for name in "abc" if any(f"{name}.xml" in note for note in aside)] == ["b", "c"]
    (folder / "a.xml").unlink()
    with pytest.raises(ReadError, match=r"the XML is (damaged|broken)"):
        find_correction(facts(), LensRequest(source=str(folder)))


def test_acm_in_a_file_that_does_not_say_version_2(tmp_path: Path) -> None:
    path = tmp_path / "acm.xml"
    head = LensfunLens("Maker", "Wide", "Test mount", 1.5, 4 / 3)
    content = lensfun_xml(head, [Distortion("acm", 12.0, dict.fromkeys(ACM, 0.01))]).decode()
    assert 'version="2"' in content
    path.write_text(content.replace('version="2"', 'version="1"'))
    shot = facts(camera="No such camera", maker="No", model="such camera")
    assert "acm k1 = 0.01" in find_correction(shot, LensRequest(source=str(path))).description


def test_similar_cameras_are_named_once(tmp_path: Path) -> None:
    path = tmp_path / "profile.txt"
    camera = "begin camera\nmenu_make: M\nmenu_model: One\nexif_make: M\nexif_model: {}\n"
    camera += "group: g\nmultiplier: 1\nend\n"
    lens = "begin lens\nmenu_lens: L\ngroup: g\nmultiplier: 1\ncal_abc: 9 0 0 0\nend\n"
    path.write_text(camera.format("1a") + camera.format("1b") + lens)
    with pytest.raises(OptionError, match=r"\(it has: M One\)"):
        find_correction(facts(), LensRequest(source=str(path)))
