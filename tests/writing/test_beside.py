"""What is written beside the points when no file is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import plumbline
from plumbline.errors import UnsettledError, WriteError
from tests.writing.test_results import calibration


def test_project_and_profile_are_written_beside_the_points(tmp_path: Path) -> None:
    source = tmp_path / "roof.csv"
    written, notes = plumbline.write_beside(calibration(), source)
    assert [path.name for path in written] == ["roof.fit.pto", "roof.fit.xml"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["roof.fit.pto", "roof.fit.xml"]
    assert not [note for note in notes if "not written" in note]


def test_a_model_that_neither_holds_goes_into_json(tmp_path: Path) -> None:
    written, notes = plumbline.write_beside(calibration("division"), tmp_path / "roof.csv")
    assert [path.name for path in written] == ["roof.fit.json"]
    assert len([note for note in notes if "was not written" in note]) == 2


def test_all_or_nothing(tmp_path: Path) -> None:
    (tmp_path / "roof.fit.xml").write_text("<mine/>")
    with pytest.raises(WriteError, match="was not written by plumbline"):
        plumbline.write_beside(calibration(), tmp_path / "roof.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["roof.fit.xml"]
    unsettled = replace(calibration(), converged=False)
    with pytest.raises(UnsettledError):
        plumbline.write_beside(unsettled, tmp_path / "other.csv")
