"""Whether the camera corrected the photo itself, and with which lens, in notes built by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.lenses.lookup import find_correction
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import read_photo
from plumbline.photos.maker_notes import read_maker_notes
from tests.lenses.photos import real
from tests.peers.tools import program, run
from tests.photos import layouts
from tests.photos.layouts import block, canon, nikon, olympus, panasonic, pentax, sony

SWITCHES: dict[str, tuple[str, Any, Any]] = {
    "Nikon": ("NIKON", nikon(1), nikon(0)),
    "Sony": ("SONY", sony(2), sony(0)),
    "Canon": ("Canon", canon("", setting=1), canon("", setting=0)),
    "Canon, applied": ("Canon", canon("", applied=1), canon("", applied=0)),
    "Olympus": ("OLYMPUS", olympus("x", 1), olympus("x", 0)),
    "Olympus, old": ("OLYMPUS", olympus("x", 1, old=True), olympus("x", 0, old=True)),
    "Pentax": ("PENTAX", pentax(1), pentax(0)),
    "Pentax, old": ("PENTAX", pentax(1, old=True), pentax(0, old=True)),
}


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("maker", SWITCHES)
def test_on_and_off(tmp_path: Path, maker: str, order: str) -> None:
    make, on, off = SWITCHES[maker]
    path = layouts.photo(tmp_path / "a.jpg", block(make, "A camera", notes=on, order=order))
    assert read_photo(path).in_camera == f"{read_photo(path).in_camera.partition(' is ')[0]} is on"
    assert read_photo(path).in_camera.startswith(maker.partition(",")[0])
    path = layouts.photo(tmp_path / "b.jpg", block(make, "A camera", notes=off, order=order))
    assert read_photo(path).in_camera == ""
    assert read_photo(path).not_in_camera.endswith(" is off")


@pytest.mark.parametrize(
    ("maker", "tag"),
    [
        ("Nikon", "AutoDistortionControl"),
        ("Sony", "DistortionCorrectionSetting"),
        ("Canon", "DistortionCorrectionSetting"),
        ("Olympus", "DistortionCorrection"),
        ("Pentax", "DistortionCorrection"),
    ],
)
def test_exiftool_reads_the_same(tmp_path: Path, maker: str, tag: str) -> None:
    make, on, _ = SWITCHES[maker]
    model = "PENTAX K-5" if make == "PENTAX" else "A camera"
    path = layouts.photo(tmp_path / "a.jpg", block(make, model, notes=on))
    assert "On" in run([program("exiftool"), f"-{tag}", str(path)]) or maker == "Sony"


def test_the_photo_is_warned_of(tmp_path: Path) -> None:
    exif = block("NIKON", "E995", layouts.focal(8.2), nikon(1))
    notes = find_correction(
        read_photo(layouts.photo(tmp_path / "a.jpg", exif)), LensRequest()
    ).notes
    assert any("the camera corrected the distortion itself" in note for note in notes)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(
    ("make", "notes", "lens"),
    [
        ("Canon", canon("EF70-200mm f/2.8L IS USM"), "EF70-200mm f/2.8L IS USM"),
        ("OLYMPUS", olympus("OLYMPUS M.12-40mm F2.8"), "OLYMPUS M.12-40mm F2.8"),
        ("OLYMPUS", olympus("OLYMPUS 14-45mm Lens", old=True), "OLYMPUS 14-45mm Lens"),
        ("Panasonic", panasonic("LUMIX G VARIO 14-42/F3.5-5.6"), "LUMIX G VARIO 14-42/F3.5-5.6"),
    ],
)
def test_lenses_that_stand_as_text(
    tmp_path: Path, make: str, notes: Any, lens: str, order: str
) -> None:
    path = layouts.photo(tmp_path / "a.jpg", block(make, "A camera", notes=notes, order=order))
    found = read_photo(path)
    assert found.facts.model == lens
    assert found.lens_told_by == "the maker notes"


def test_exif_s_own_name_of_the_lens_comes_first(tmp_path: Path) -> None:
    own = [(0xA434, 2, layouts.text("EF85mm f/1.4L IS USM"))]
    path = layouts.photo(tmp_path / "a.jpg", block("Canon", "EOS", own, canon("EF50mm f/1.8")))
    found = read_photo(path)
    assert (found.facts.model, found.lens_told_by) == ("EF85mm f/1.4L IS USM", "")


@pytest.mark.parametrize("order", "<>")
def test_nikon_tells_the_range(tmp_path: Path, order: str) -> None:
    notes = nikon(lens=(18, 70, 3.5, 4.5))
    path = layouts.photo(tmp_path / "a.jpg", block("NIKON", "NIKON D70", (), notes, order))
    assert read_photo(path).lens_range_mm == (18, 70)


@pytest.mark.parametrize("name", ["nikon_e995_8.2mm.jpg", "nikon_e5700_8.9mm_portrait.jpg"])
def test_old_cameras_tell_nothing(name: str) -> None:
    assert read_photo(real(name)).in_camera == ""


def test_any_bytes_are_survived() -> None:
    random = np.random.default_rng(1)
    for make, on, _ in SWITCHES.values():
        exif = block(make, "A camera", notes=on)
        whole = exif[exif.index(on(exif.find(on(0, "<")[:6]), "<")[:6]) :]
        for end in range(len(whole)):
            read_maker_notes(whole[:end], exif, make)
        for _ in range(100):
            broken = bytearray(whole)
            for place in random.integers(0, len(whole), 6):
                broken[place] = random.integers(0, 256)
            read_maker_notes(bytes(broken), exif[: -len(whole)] + bytes(broken), make)
