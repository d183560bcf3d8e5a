"""A photo in each maker's EXIF layout: the lens that is found is lensfunpy's own answer."""

from __future__ import annotations

import stat
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import plumbline
from plumbline.errors import OptionError
from plumbline.imaging.batch import Work, with_lens_names
from plumbline.imaging.targets import photo_targets
from plumbline.lenses.lookup import look_up
from plumbline.lenses.request import LensRequest
from plumbline.photos import exiftool
from plumbline.photos.exif import read_photo
from tests.lenses.library import lensfunpy
from tests.peers.tools import program
from tests.photos import layouts
from tests.photos.layouts import block, canon, focal, nikon, olympus, panasonic

LENS_MODEL = 0xA434


@pytest.fixture(autouse=True)
def _empty_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


# make, model, focal length, lens in EXIF, maker notes, lens as lensfunpy is asked for it
MAKERS: dict[str, tuple[str, str, float, str, Any, str]] = {
    "Canon": ("Canon", "Canon EOS 6D", 85, "EF85mm f/1.8 USM", None, "EF85mm f/1.8 USM"),
    "Canon, notes": (
        *("Canon", "Canon EOS 450D", 100, ""),
        *(canon("EF70-200mm f/2.8L IS USM"), "EF70-200mm f/2.8L IS USM"),
    ),
    "Nikon, range": (
        *("NIKON CORPORATION", "NIKON D70", 70, "", nikon(lens=(18, 70, 3.5, 4.5))),
        "AF-S DX Zoom-Nikkor 18-70mm f/3.5-4.5G IF-ED",
    ),
    "Sony": ("SONY", "ILCE-7M3", 24, "FE 24-105mm F4 G OSS", None, "FE 24-105mm F4 G OSS"),
    "Olympus, notes": (
        *("OLYMPUS IMAGING CORP.", "E-M5", 14, ""),
        *(olympus("OLYMPUS M.14-42mm F3.5-5.6 II R"), "OLYMPUS M.14-42mm F3.5-5.6 II R"),
    ),
    "Panasonic, notes": (
        *("Panasonic", "DMC-G3", 20, ""),
        *(panasonic("LUMIX G 20/F1.7"), "LUMIX G 20/F1.7"),
    ),
    "Pentax": (
        *("PENTAX", "PENTAX K-5", 35, "smc PENTAX-DA 35mm F2.4 AL", None),
        "smc PENTAX-DA 35mm F2.4 AL",
    ),
    "Fujifilm": ("FUJIFILM", "X-T1", 35, "XF35mmF1.4 R", None, "XF35mmF1.4 R"),
}


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("maker", MAKERS)
def test_the_lens_is_lensfun_s(
    tmp_path: Path, maker: str, order: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")  # without exiftool
    make, model, mm, lens, notes, asked = MAKERS[maker]
    own: list[layouts.Entry] = [(LENS_MODEL, 2, layouts.text(lens))] if lens else []
    exif = block(make, model, [*focal(mm, order), *own], notes, order)
    photo = read_photo(layouts.photo(tmp_path / "a.jpg", exif))
    library = lensfunpy.Database(load_common=False, load_bundled=True)
    camera = library.find_cameras(make, model)[0]
    theirs = library.find_lenses(camera, None, asked)[0]
    wanted = theirs.interpolate_distortion(mm).terms
    profile = look_up(photo, LensRequest()).profile
    assert theirs.model in profile.description
    for value, term in zip(profile.coefficients, wanted, strict=False):
        assert value == pytest.approx(term, abs=1e-6)


def test_a_lens_of_other_numbers_is_never_taken(tmp_path: Path) -> None:
    """LensFun's first answer for this lens is a zoom that ends at 300 mm."""
    own: list[layouts.Entry] = [(LENS_MODEL, 2, layouts.text("EF300mm f/4L IS USM"))]
    exif = block("Canon", "Canon EOS 5D Mark III", [*focal(300), *own])
    photo = read_photo(layouts.photo(tmp_path / "a.jpg", exif))
    with pytest.raises(OptionError, match="for smaller sensors only") as error:
        look_up(photo, LensRequest())
    assert "plumbline fit" in error.value.hint


def test_part_of_the_sensor(tmp_path: Path) -> None:
    """Full frame in APS-C mode: the middle of the image circle, by EXIF's equivalent."""
    own: list[layouts.Entry] = [(LENS_MODEL, 2, layouts.text("FE 24-105mm F4 G OSS"))]
    found = {
        equivalent: look_up(
            read_photo(
                layouts.photo(
                    tmp_path / "a.jpg",
                    block("SONY", "ILCE-7M3", [*focal(24, equivalent=equivalent), *own]),
                )
            ),
            LensRequest(),
        ).profile
        for equivalent in (24, 36)
    }
    assert found[24].photo_crop == pytest.approx(1)
    assert found[36].photo_crop == pytest.approx(1.5)
    assert any("APS-C mode" in note for note in found[36].notes)
    assert not any("APS-C mode" in note for note in found[24].notes)


@pytest.mark.parametrize(("year", "warned"), [("2001", False), ("2015", True), ("", True)])
def test_compact_cameras_correct_by_themselves(tmp_path: Path, year: str, warned: bool) -> None:
    taken: list[layouts.Entry] = (
        [(0x9003, 2, layouts.text(f"{year}:01:02 03:04:05"))] if year else []
    )
    exif = block("Panasonic", "DMC-LX7", [*focal(4.7), *taken])
    notes = look_up(
        read_photo(layouts.photo(tmp_path / "a.jpg", exif)), LensRequest()
    ).profile.notes
    assert any("correct the distortion of their JPEGs themselves" in n for n in notes) is warned


CANON_LENSES = {  # numbers of ExifTool's Canon.pm, %canonLensTypes, with the focal lengths
    "85mm": ((155, 85, 85), 85, "Canon EF 85mm f/1.8 USM"),
    "50mm": ((198, 50, 50), 50, "Canon EF 50mm f/1.4 USM"),
    "70-200": ((224, 70, 200), 100, "Canon EF 70-200mm f/2.8L IS USM"),
    "17-40": ((231, 17, 40), 20, "Canon EF 17-40mm f/4L USM"),
    "24-105": ((237, 24, 105), 35, "Canon EF 24-105mm f/4L IS USM"),
}


def test_exiftool_is_asked_once_for_a_whole_batch(tmp_path: Path) -> None:
    program("exiftool")
    paths: dict[Path, str] = {}
    for name, (number, mm, lens) in CANON_LENSES.items():
        path = tmp_path / f"{name}.jpg"
        layouts.photo(
            path, block("Canon", "Canon EOS 6D", focal(mm), canon("", lens_number=number))
        )
        paths[path] = lens
    told = exiftool.lens_names(list(paths))
    assert told == paths
    for path, name in told.items():
        assert read_photo(path).facts.model == ""
        photo = exiftool.with_lens_name(read_photo(path), path)
        assert (photo.facts.model, photo.lens_told_by) == (name, "exiftool")
        assert name in look_up(photo, LensRequest()).profile.description


def test_one_process_and_its_names_are_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, tools = tmp_path / "in", tmp_path / "bin"
    folder.mkdir()
    tools.mkdir()
    fake = tools / "exiftool"
    fake.write_text(
        f"#!{sys.executable}\nimport json, sys\n"
        f"open({str(tmp_path / 'calls')!r}, 'a').write('x')\n"
        "paths = [row for row in sys.stdin.read().splitlines() if row.endswith('.jpg')]\n"
        "lens = 'Canon EF 85mm f/1.8 USM'\n"
        "print(json.dumps([{'SourceFile': p, 'LensID': lens} for p in paths]))\n"
    )
    fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tools))
    for name in ("a.jpg", "b.jpg", "c.jpg"):
        layouts.photo(folder / name, block("Canon", "Canon EOS 6D", focal(85)))
    outcomes = plumbline.correct_many([folder], None, tmp_path / "out")
    assert [each.state for each in outcomes] == ["corrected"] * 3
    for each in outcomes:
        assert each.corrected is not None
        assert "EF 85mm f/1.8 USM" in each.corrected.description
        assert each.corrected.description.endswith("(lens named by exiftool)")
    assert (tmp_path / "calls").read_text() == "x"
    named = with_lens_names(
        photo_targets([folder], tmp_path / "o"), Work(LensRequest(lens_name="x"))
    )
    assert named.lens_names is None
    assert (tmp_path / "calls").read_text() == "x"


@pytest.mark.parametrize("output", ["", "no json", "[1, 2]", '[{"SourceFile": 3}]', "exit"])
def test_an_exiftool_that_fails_is_as_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, output: str
) -> None:
    fake = tmp_path / "exiftool"
    does = "sys.exit(3)" if output == "exit" else f"print({output!r})"
    fake.write_text(f"#!{sys.executable}\nimport sys\n{does}\n")
    fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tmp_path))
    Image.new("L", (30, 20)).save(tmp_path / "a.jpg")
    assert exiftool.lens_names([tmp_path / "a.jpg"]) == {}
