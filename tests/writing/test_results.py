"""Writing: what may be written where, and what is in it."""

from __future__ import annotations

import hashlib
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.errors import OptionError, PlumblineError, UnsupportedModelError, WriteError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import MODELS, get_model
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.writing.head import lens_name
from plumbline.writing.lensfun import label_notes
from plumbline.writing.results import resampling_notes, result_bytes

PROJECT = b'# hugin project file\r\ni w100 h80 f0 v50 a0.5 b0 c0 d0 e0 n"caf\xe9.jpg"\r\n*\r\n'
KNOWN = LensFacts(maker="Sigma", model="18-35", mount="EF", focal_mm=18.0, crop_factor=1.5)


def calibration(
    model: str = "ptlens",
    facts: LensFacts = KNOWN,
    centre: tuple[float, float] = (0.0, 0.0),
    size: tuple[int, int] = (100, 80),
    origin: Origin | None = None,
    pixel_aspect: float = 1.0,
) -> Calibration:
    made = get_model(model)
    values = {name: 0.01 * (i + 1) for i, name in enumerate(made.coefficients)}
    values |= {"d": centre[0], "e": centre[1]}
    line = Line(np.array([[1.0, 2], [30, 4.5], [50, 6]]), 0, "t3")
    photo = Photo(size, "x.jpg", pixel_aspect=pixel_aspect)
    origins = (origin,) if origin else ()
    observations = Observations((photo,), (line,), (facts,), (), origins)
    residuals = (np.array([0.1, -0.2, 0.1]),)
    return Calibration(
        observations=observations,
        lens=Lens(made, Frame(*size, pixel_aspect), values, 150.0),
        free=(made.coefficients[0],),
        start=dict.fromkeys(values, 0.0),
        residual="image",
        covariance=np.eye(1),
        sigma_px=0.1,
        dof=1,
        residuals_px=residuals,
        rms_corrected_px=0.1,
        converged=True,
        reason="done",
    )


def xml(*made: Calibration) -> ET.Element:
    return ET.fromstring(result_bytes(made, Path("x.xml")))


@pytest.mark.parametrize("suffix", [".pto", ".xml", ".json", ".PTO", ".Json"])
def test_the_format_follows_the_suffix(tmp_path: Path, suffix: str) -> None:
    path = plumbline.write(calibration(), tmp_path / f"x{suffix}")
    start = {".pto": b"# hugin", ".xml": b"<?xml", ".json": b"{"}[suffix.lower()]
    assert path.read_bytes().startswith(start)


@pytest.mark.parametrize("name", ["x.png", "x", ".pto", "x.pto.bak", ""])
def test_other_suffixes_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(WriteError, match="results are not written as") as caught:
        plumbline.write(calibration(), tmp_path / name)
    assert ".xml" in caught.value.hint
    assert list(tmp_path.iterdir()) == []


def test_a_project_comes_back_with_the_new_values_only() -> None:
    origin = Origin("a.pto", "pto", PROJECT)
    written = result_bytes([calibration(origin=origin, centre=(0, -2.5))], Path("b.pto"))
    expected = PROJECT.replace(
        b"a0.5 b0 c0 d0 e0",
        b"a%.18f b%.18f c%.18f d0 e-2.500000000000000000" % (0.01, 0.02, 0.03),
    )
    assert written == expected


def numbered(made: Calibration, number: int) -> Calibration:
    """The same of another photo of its project."""
    (photo,) = made.observations.photos
    photos = (replace(photo, number=number),)
    return replace(made, observations=replace(made.observations, photos=photos))


def test_calibrations_of_one_project_go_into_it_together() -> None:
    two = PROJECT.replace(b"*", b'i w100 h80 f0 v20 a0.25 b0 c0 n"y.jpg"\r\n*')
    made = calibration(origin=Origin("a.pto", "pto", two))
    written = result_bytes([made, numbered(made, 1)], Path("b.pto"))
    assert written.count(b" a0.010000000000000000 ") == 2
    assert written.endswith(b'n"y.jpg" d0 e0\r\n*\r\n')
    with pytest.raises(OptionError, match="two calibrations are of photo number 1") as caught:
        result_bytes([numbered(made, 1), numbered(made, 1)], Path("b.pto"))
    assert caught.value.hint


@pytest.mark.parametrize(
    "second",
    [Origin("b.pto", "pto", PROJECT), Origin("a.pto", "pto", b"i w100 h80 v50\n"), None],
)
def test_no_project_gets_the_lens_of_another(second: Origin | None) -> None:
    other = calibration("poly3", origin=second)
    pair = [calibration(origin=Origin("a.pto", "pto", PROJECT)), numbered(other, 1)]
    for made in (pair, pair[::-1]):
        written = result_bytes(made, Path("c.pto")).decode()
        records = [line for line in written.splitlines() if line.startswith("i ")]
        values = [re.findall(r" ([abc])(\S+)", record) for record in records]
        told = [{name: float(value) for name, value in each} for each in values]
        wanted = [{"a": 0.01, "b": 0.02, "c": 0.03}, {"a": 0.0, "b": 0.01, "c": 0.0}]
        assert told == (wanted if made is pair else wanted[::-1])
        assert "made by plumbline" in written


def test_poly3_is_ptlens_with_b_alone() -> None:
    written = result_bytes([calibration("poly3")], Path("b.pto"))
    assert b" a0 b0.010000000000000000 c0 d0 e0 " in written


@pytest.mark.parametrize("model", [name for name in MODELS if name not in ("ptlens", "poly3")])
def test_models_that_hugin_does_not_know(model: str) -> None:
    with pytest.raises(UnsupportedModelError, match="Hugin project cannot hold") as caught:
        result_bytes([calibration(model)], Path("b.pto"))
    assert ".json" in caught.value.hint


@pytest.mark.parametrize("model", list(MODELS))
def test_models_of_lensfun(model: str) -> None:
    made = calibration(model)
    if model not in ("ptlens", "poly3", "poly5", "acm"):
        with pytest.raises(UnsupportedModelError, match="LensFun does not know"):
            xml(made)
        return
    (entry,) = xml(made).iter("distortion")
    assert entry.attrib["model"] == model
    for index, name in enumerate(get_model(model).coefficients):
        assert float(entry.attrib[name]) == pytest.approx(0.01 * (index + 1), rel=1e-7)


def test_the_head_of_a_lens() -> None:
    lens = xml(calibration(centre=(4.0, -8.0))).find("lens")
    assert lens is not None
    texts = {child.tag: child.text for child in lens}
    assert texts["maker"] == "Sigma"
    assert texts["model"] == "18-35"
    assert texts["mount"] == "EF"
    assert texts["cropfactor"] == "1.5"
    assert texts["aspect-ratio"] == "1.25"
    centre = lens.find("center")
    assert centre is not None
    assert centre.attrib == {"x": "0.1", "y": "-0.2"}  # half the short side is 40 px


def test_pixels_that_are_not_square() -> None:
    made = calibration(centre=(4.0, -8.0), pixel_aspect=1.5)
    lens = xml(made).find("lens")
    assert lens is not None
    assert lens.findtext("aspect-ratio") == "1.875"
    centre = lens.find("center")
    assert centre is not None
    assert centre.attrib == {"x": "0.15", "y": "-0.2"}
    assert b"i w150 h80 " in result_bytes([made], Path("b.pto"))
    assert b" d6.000000000000000000 e-8" in result_bytes([made], Path("b.pto"))
    (note,) = resampling_notes(made.observations)
    assert note == (
        "the Hugin project is for x.jpg resampled to 150x80, where its pixels are square"
    )
    assert resampling_notes(calibration().observations) == []


def test_the_aspect_ratio_is_the_photos() -> None:
    rounded = xml(calibration(facts=replace(KNOWN, aspect_ratio=1 / 1.26)))
    assert rounded.findtext("lens/aspect-ratio") == "1.26"
    for ratio in (1.5, 0.0, -1.25):
        with pytest.raises(OptionError, match=r"contradicts the photo's 1\.25") as caught:
            xml(calibration(facts=replace(KNOWN, aspect_ratio=ratio)))
        assert caught.value.hint


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"focal_mm": None}, "the focal length is not known"),
        ({"crop_factor": None}, "the crop factor is not known"),
    ],
)
def test_measured_values_are_never_invented(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(OptionError, match=sentence) as caught:
        xml(calibration(facts=replace(KNOWN, **changes)))
    assert "--" in caught.value.hint


def test_the_focal_length_from_the_field_of_view() -> None:
    # 36 mm across for a 3:2 sensor of crop factor 1; twice the focal length: 53.13 degrees.
    facts = replace(
        KNOWN, focal_mm=None, crop_factor=1.0, hfov_deg=float(np.degrees(2 * np.arctan(0.5)))
    )
    (entry,) = xml(calibration(facts=facts, size=(300, 200))).iter("distortion")
    assert float(entry.attrib["focal"]) == pytest.approx(36.0, rel=1e-8)


def zoom(**other: Any) -> list[Calibration]:
    return [calibration(), calibration(facts=replace(KNOWN, focal_mm=35.0), **other)]


def test_several_focal_lengths_of_one_lens() -> None:
    root = xml(*zoom())
    assert [entry.attrib["focal"] for entry in root.iter("distortion")] == ["18", "35"]
    assert len(list(root.iter("lens"))) == 1


def test_rounded_crop_factors_of_a_zoom_are_one() -> None:
    made = [
        calibration(facts=replace(KNOWN, crop_factor=27 / 18, crop_factor_error=0.5 / 27)),
        calibration(
            facts=replace(KNOWN, focal_mm=35.0, crop_factor=53 / 35, crop_factor_error=0.5 / 53)
        ),
    ]
    assert xml(*made).findtext("lens/cropfactor") == "1.51428571"
    (note,) = label_notes(made)
    assert note.startswith("the crop factor 1.514 ")
    assert "good to 0.9 %" in note
    unknown = calibration(facts=replace(KNOWN, focal_mm=50.0, crop_factor=None))
    with pytest.raises(OptionError, match="the crop factor is not known"):
        xml(*made, unknown)


def test_one_centre_off_the_middle_serves_several_focal_lengths() -> None:
    made = [
        calibration(centre=(4, 2)),
        calibration(facts=replace(KNOWN, focal_mm=35.0), centre=(4, 2)),
    ]
    assert xml(*made).find("lens/center") is not None


@pytest.mark.parametrize(
    ("second", "sentence"),
    [
        (calibration(facts=replace(KNOWN, model="other", focal_mm=35.0)), "several lenses, 18-35"),
        (
            calibration(facts=replace(KNOWN, focal_mm=35.0), size=(120, 80)),
            "differ in their aspect",
        ),
        (calibration(facts=replace(KNOWN, focal_mm=35.0), centre=(1, 0)), "has one centre"),
        (calibration(facts=replace(KNOWN, crop_factor=1.6, focal_mm=35.0)), "crop factors differ"),
        (calibration(), "the same focal length"),
    ],
)
def test_what_is_not_one_lens_is_refused(second: Calibration, sentence: str) -> None:
    with pytest.raises(OptionError, match=sentence) as caught:
        xml(calibration(), second)
    assert caught.value.hint


def test_labels_fall_back_openly() -> None:
    origin = Origin("some/folder/my---lens.v2.pto", "pto", PROJECT)
    nameless = calibration(facts=LensFacts(focal_mm=18.0, crop_factor=1.5), origin=origin)
    lens = xml(nameless).find("lens")
    assert lens is not None
    texts = [lens.findtext(tag) for tag in ("maker", "model", "mount")]
    assert texts == ["Unknown", "my---lens.v2", "Generic"]
    flags = [
        flag
        for flag in ("--maker", "--lens-name", "--mount")
        for n in label_notes([nameless])
        if flag in n
    ]
    assert flags == ["--maker", "--lens-name", "--mount"]
    content = result_bytes([nameless], Path("x.xml")).decode()
    assert "<!-- made by plumbline" in content
    assert "written as Generic" in content
    camera = calibration(facts=replace(KNOWN, model="", camera="NIKON E995"))
    assert lens_name(camera.observations.lenses[0]) == "NIKON E995 lens"
    assert label_notes([calibration()]) == []


@pytest.mark.parametrize("name", ["a--b", "a\x1b[31m\n", "caf\udce9", "-", "--", "<&>"])
def test_odd_file_names_do_not_break_the_profile(name: str) -> None:
    facts = LensFacts(focal_mm=18.0, crop_factor=1.5)
    assert xml(calibration(facts=facts, origin=Origin(name + ".csv", "csv", b"x")))
    assert json.loads(
        result_bytes([calibration(origin=Origin(name, "csv", b"x"))], Path("x.json"))
    )["observations"]["origins"] == [
        {"path": name, "format": "csv", "sha256": hashlib.sha256(b"x").hexdigest()}
    ]


def test_existing_files(tmp_path: Path) -> None:
    (tmp_path / "x.xml").write_text("<lensdatabase/>")
    with pytest.raises(WriteError, match="was not written by plumbline"):
        plumbline.write(calibration(), tmp_path / "x.xml")
    assert (tmp_path / "x.xml").read_text() == "<lensdatabase/>"
    plumbline.write(calibration(), tmp_path / "x.xml", overwrite=True)
    for suffix in (".xml", ".json", ".pto"):  # its own files, now and again
        plumbline.write(calibration(), tmp_path / f"x{suffix}")
        plumbline.write(calibration(), tmp_path / f"x{suffix}")


def test_a_fitted_centre_alone_marks_the_project_as_ours(tmp_path: Path) -> None:
    origin = Origin("a.pto", "pto", PROJECT)
    made = calibration(origin=origin, centre=(1.5, 0))
    values = dict(made.coefficients) | {"a": 0.0, "b": 0.0, "c": 0.0}
    centred = replace(made, lens=replace(made.lens, coefficients=values))
    plumbline.write(centred, tmp_path / "x.pto")
    plumbline.write(centred, tmp_path / "x.pto")


def test_the_input_is_never_overwritten(tmp_path: Path) -> None:
    source = tmp_path / "a.pto"
    source.write_bytes(PROJECT)
    made = calibration(origin=Origin(str(source), "pto", PROJECT))
    for call in (
        lambda: plumbline.write(made, source, overwrite=True),
        lambda: plumbline.write([calibration(), made], source, overwrite=True),
        lambda: plumbline.write_points(made.observations, source, overwrite=True),
    ):
        with pytest.raises(WriteError, match="never overwritten"):
            call()
    assert source.read_bytes() == PROJECT


# --- points ---------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".csv", ".pto", ".json"])
def test_points_read_back(tmp_path: Path, suffix: str) -> None:
    observations = calibration().observations
    path = plumbline.write_points(observations, tmp_path / f"p{suffix}")
    back = plumbline.read(path, size=(100, 80))
    assert [line.points_px.tolist() for line in back.lines] == [[[1, 2], [30, 4.5], [50, 6]]]


def test_a_csv_does_not_mix_lenses(tmp_path: Path) -> None:
    one = calibration().observations
    both = Observations.side_by_side([one, one])
    with pytest.raises(OptionError, match="the lines are of 2 lenses") as caught:
        plumbline.write_points(both, tmp_path / "p.csv")
    assert "--image" in caught.value.hint
    assert list(tmp_path.iterdir()) == []
    back = plumbline.read(plumbline.write_points(both, tmp_path / "p.pto"))
    assert [photo.lens for photo in back.photos] == [0, 1]
    plumbline.write_points(replace(both, lines=both.lines[:1]), tmp_path / "p.csv")


def test_points_have_no_other_formats(tmp_path: Path) -> None:
    for name in ("p.xml", "p.txt", "p"):
        with pytest.raises(PlumblineError, match="points are not written as") as caught:
            plumbline.write_points(calibration().observations, tmp_path / name)
        assert caught.value.hint


def test_points_do_not_replace_files_of_others(tmp_path: Path) -> None:
    (tmp_path / "p.csv").write_text("precious")
    with pytest.raises(WriteError):
        plumbline.write_points(calibration().observations, tmp_path / "p.csv")
    assert (tmp_path / "p.csv").read_text() == "precious"
    plumbline.write_points(calibration().observations, tmp_path / "p.csv", overwrite=True)


def test_a_fit_without_a_result_goes_into_json_alone(tmp_path: Path) -> None:
    made = replace(calibration(), converged=False)
    for suffix in (".pto", ".xml"):
        with pytest.raises(plumbline.UnsettledError, match="the fit did not converge") as caught:
            plumbline.write(made, tmp_path / f"x{suffix}")
        assert "check that every pick is on its line" in caught.value.hint
    written = plumbline.write(made, tmp_path / "x.json")
    assert json.loads(written.read_text())["converged"] is False
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]
