"""Files for LensFun bear its own words, and are what LensFun then takes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import lensfunpy
import pytest

import plumbline
from plumbline.observations.facts import LensFacts
from plumbline.writing.labels import spelt
from tests.report.made import building

EOS = LensFacts(
    maker="Canon",
    model="EF24-105mm f/4L IS USM",
    camera="Canon EOS 6D",
    crop_factor=1.01,
    focal_mm=50.0,
)


def test_a_lens_that_lensfun_has_is_spelt_as_there_and_named() -> None:
    """The words are those of slr-canon.xml in LensFun 0.3.4."""
    found = spelt(EOS)
    assert (found.facts.maker, found.facts.mount) == ("Canon", "Canon EF")
    assert found.facts.model == "Canon EF 24-105mm f/4L IS USM"
    assert found.facts.crop_factor == 1.005
    (note,) = found.notes
    assert "has this lens, Canon EF 24-105mm f/4L IS USM, at 24 to 105 mm" in note


@pytest.mark.parametrize(
    ("given", "maker", "mount"),
    [
        (LensFacts(maker="NIKON CORPORATION", camera="NIKON D800"), "Nikon", "Nikon F AF"),
        (replace(EOS, model="EF 7mm f/1.0 unknown"), "Canon", "Canon EF"),
        (replace(EOS, model="own lens", mount="canon ef"), "Canon", "Canon EF"),
        (replace(EOS, model="own lens", mount="M42"), "Canon", "M42"),
        (LensFacts(maker="A maker", model="A lens", camera="No camera"), "A maker", ""),
        (LensFacts(), "", ""),
    ],
)
def test_maker_and_mount_of_other_lenses(given: LensFacts, maker: str, mount: str) -> None:
    found = spelt(given)
    assert (found.facts.maker, found.facts.mount, found.notes) == (maker, mount, ())
    assert found.facts.model == given.model


def test_what_is_installed_outranks_the_bundled_lens(tmp_path: Path) -> None:
    made = building()
    ours = replace(made, observations=replace(made.observations, lenses=(EOS,)))
    file = plumbline.write(ours, tmp_path / "ours.xml")
    Library: Any = getattr(lensfunpy, "Database")  # noqa: B009 - it brings no types
    folder = Path(lensfunpy.__file__).parent / "db_files"
    bundled = sorted(map(str, folder.glob("*.xml")))
    for files, expected in ((bundled, False), ([*bundled, str(file)], True)):
        library = Library(paths=files, load_common=False, load_bundled=False)
        (camera,) = library.find_cameras("Canon", "Canon EOS 6D")[:1]
        lens = library.find_lenses(camera, None, EOS.model)[0]
        assert lens.model == "Canon EF 24-105mm f/4L IS USM"
        terms = lens.interpolate_distortion(50.0).terms
        own = [made.coefficients[name] for name in "abc"]
        assert (terms == pytest.approx(own, abs=1e-6)) is expected
