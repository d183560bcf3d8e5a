"""LensFun databases, read: against LensFun's own library, and damaged on purpose."""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import Source
from plumbline.formats.lens_files.lensfun import Distortion, LensfunLens, lensfun_xml
from plumbline.formats.lens_files.lensfun_reading import read_lensfun
from tests.lenses.library import lensfunpy

LENS = (
    '<lensdatabase version="1"><lens><maker>M</maker><model>Z</model><mount>A</mount>{}'
    "<calibration>{}</calibration></lens></lensdatabase>"
)


def read(head: str = "", entries: str = "") -> object:
    return read_lensfun(Source("db.xml", LENS.format(head, entries).encode()))


def test_the_embedded_database_reads_as_by_the_library() -> None:
    compared = 0
    folder = Path(lensfunpy.__file__).parent / "db_files"
    for file in sorted(folder.glob("*.xml")):
        content = file.read_bytes()
        ours = read_lensfun(Source(str(file), content)).lenses
        library = lensfunpy.Database(paths=[str(file)], load_common=False, load_bundled=False)
        theirs = {
            (each.maker, each.model, tuple(each.mounts), round(each.crop_factor, 3)): each
            for each in library.lenses
        }
        for lens in ours:
            same = theirs.get((lens.maker, lens.model, lens.mounts, round(lens.crop_factor, 3)))
            if same is None:
                continue  # the library joins entries of one name, or trims it
            for entry, other in zip(
                lens.distortions,
                sorted(same.calib_distortion, key=attrgetter("focal")),
                strict=False,
            ):
                assert entry.focal_mm == pytest.approx(other.focal, rel=1e-6)
                values = list(entry.coefficients.values())
                assert values == pytest.approx(other.terms[: len(values)], abs=1e-6)
                compared += 1
    assert compared > 4000


def test_what_is_written_is_read_again() -> None:
    head = LensfunLens("Maker & Co", "Zoom <1>", "Generic", 1.534, 4 / 3, (0.01, -0.02))
    entries = [
        Distortion("acm", 18.0, dict.fromkeys(("k1", "k2", "k3", "k4", "k5"), 0.01)),
        Distortion("ptlens", 24.0, {"a": 0.01, "b": -0.05, "c": 0.02}),
    ]
    found = read_lensfun(Source("db.xml", lensfun_xml(head, entries)))
    assert found.version == 2
    (lens,) = found.lenses
    assert (lens.maker, lens.model, lens.mounts) == ("Maker & Co", "Zoom <1>", ("Generic",))
    assert lens.crop_factor == 1.534
    assert lens.aspect_ratio == pytest.approx(4 / 3, rel=1e-8)
    assert lens.centre == (0.01, -0.02)
    assert list(lens.distortions) == entries


def test_defaults_and_aspect_ratios() -> None:
    def lens(head: str) -> tuple[float, float]:
        content = LENS.format(head, "").encode()
        (found,) = read_lensfun(Source("db.xml", content)).lenses
        return found.crop_factor, found.aspect_ratio

    assert lens("") == (1.0, 1.5)
    assert lens("<aspect-ratio>4:3</aspect-ratio>")[1] == pytest.approx(4 / 3)
    assert lens("<aspect-ratio>1.25</aspect-ratio>")[1] == 1.25


@pytest.mark.parametrize(
    ("head", "entries", "sentence"),
    [
        ("<cropfactor>0</cropfactor>", "", "cropfactor is not above zero"),
        ("<cropfactor>inf</cropfactor>", "", "not a finite number"),
        ("<aspect-ratio>4:0</aspect-ratio>", "", "aspect ratio is impossible"),
        ("<aspect-ratio>x</aspect-ratio>", "", "stands where the aspect ratio belongs"),
        ('<center x="a" y="0"/>', "", "stands where the value of x belongs"),
        ("", '<distortion model="magic" focal="1"/>', "'magic' is not known"),
        ("", '<distortion model="poly3" k1="1"/>', "has no focal"),
        ("", '<distortion model="poly3" focal="-1" k1="1"/>', "not above zero"),
        ("", '<distortion model="poly3" focal="1" k1="nan"/>', "not a finite number"),
    ],
)
def test_damage_is_told_with_its_line(head: str, entries: str, sentence: str) -> None:
    with pytest.raises(ReadError) as error:
        read(head, entries)
    assert sentence in error.value.message
    assert error.value.line == 1
    assert error.value.hint


def test_entities_are_not_expanded_and_no_file_is_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_text("1.5")
    content = (
        f'<!DOCTYPE x [<!ENTITY a SYSTEM "{secret.as_uri()}">]>'
        + LENS.format("<cropfactor>&a;</cropfactor>", "")
    ).encode()
    with pytest.raises(ReadError, match="declares entities"):
        read_lensfun(Source("db.xml", content))
