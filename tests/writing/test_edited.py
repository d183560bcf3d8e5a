"""What someone edited by hand since plumbline wrote it is not lost."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import plumbline
from plumbline.errors import WriteError
from plumbline.files import sealed
from plumbline.writing.results import result_bytes
from tests.lenses.made import calibration
from tests.report.made import BUILDING, building


@pytest.mark.parametrize("suffix", [".xml", ".pto"])
def test_an_edited_file_is_refused_and_an_untouched_one_replaced(
    suffix: str, tmp_path: Path
) -> None:
    path = tmp_path / f"x{suffix}"
    plumbline.write(calibration(b=-0.02), path)
    plumbline.write(calibration(b=-0.03), path)
    text = path.read_text()
    for old, new in (("distortion", "tca"), ("#hugin_ptoversion 2", "#hugin_ptoversion 3")):
        if old in text:
            path.write_text(text.replace(old, new, 1))
    with pytest.raises(WriteError, match="was edited since plumbline wrote it") as caught:
        plumbline.write(calibration(b=-0.04), path)
    assert "--overwrite" in caught.value.hint
    plumbline.write(calibration(b=-0.04), path, overwrite=True)


def test_an_edited_project_is_refused(tmp_path: Path) -> None:
    source = tmp_path / "building.pto"
    shutil.copy(BUILDING, source)
    made = plumbline.calibrate(plumbline.read(source), free=("b",))
    path = plumbline.write(made, tmp_path / "fit.pto")
    plumbline.write(made, path)
    project = path.read_text()
    path.write_text(project.replace("\np f", '\nk i0 t0 p"1 2 3 4 5 6"\np f', 1))
    with pytest.raises(WriteError, match="1 line would be lost, the first 'k i0 t0"):
        plumbline.write(made, path)
    # Picks that changed in the project that was read are no edits.
    path.write_text(project)
    source.write_text(source.read_text().replace("x55.", "x56.", 1))
    again = plumbline.calibrate(plumbline.read(source), free=("b",))
    plumbline.write(again, path)


def test_points_are_converted_twice(tmp_path: Path) -> None:
    observations = plumbline.read(BUILDING)
    for name in ("p.csv", "p.pto", "p.json"):
        plumbline.write_points(observations, tmp_path / name)
        plumbline.write_points(observations, tmp_path / name)
    (tmp_path / "p.csv").write_text((tmp_path / "p.csv").read_text() + "mine,1,2\n")
    with pytest.raises(WriteError, match="was not written by plumbline"):
        plumbline.write_points(observations, tmp_path / "p.csv")


def test_the_seal_changes_nothing_else() -> None:
    assert sealed(b"no mark") == b"no mark"
    content = result_bytes([building()], Path("x.xml"))
    assert content.count(b"made by plumbline") == 1
