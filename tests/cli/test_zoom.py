"""`plumbline zoom`, run as a user runs it."""

from __future__ import annotations

from pathlib import Path

import pytest

from plumbline.result.files import read_calibration
from tests.cli.process import plumbline
from tests.lenses.made import calibration, saved


@pytest.fixture
def results(tmp_path: Path) -> list[str]:
    coefficients = {10.0: -0.03, 14.0: -0.01, 20.0: 0.004, 28.0: 0.01}
    return [
        saved(tmp_path / f"{focal:g}.json", calibration(b=b, focal_mm=focal))
        for focal, b in coefficients.items()
    ]


def test_a_table_what_is_needed_and_every_file(results: list[str], tmp_path: Path) -> None:
    files = ["zoom.json", "zoom.xml", "lenses.txt"]
    outputs = [part for name in files for part in ("-o", tmp_path / name)]
    done = plumbline("zoom", *results, *outputs, "--plot", tmp_path / "z.svg", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "4 calibrations at 4 focal lengths, 10 to 28 mm" in done.stdout
    error = read_calibration(results[0]).standard_errors["b"]
    assert f"−0.030000 ± {error:.6f}" in done.stdout
    assert "another calibration is most needed at" in done.stdout
    for name in (*files, "z.svg"):
        assert (tmp_path / name).stat().st_size > 100
    # Its own files it replaces, others not.
    assert plumbline("zoom", *results, *outputs, home=tmp_path).returncode == 0
    (tmp_path / "zoom.xml").write_text("<mine/>")
    done = plumbline("zoom", *results, *outputs, home=tmp_path)
    assert done.returncode == 1
    assert (tmp_path / "zoom.xml").read_text() == "<mine/>"


def test_the_polynomial_is_printed(results: list[str], tmp_path: Path) -> None:
    done = plumbline("zoom", *results, "--method", "polynomial", "--degree", "2", home=tmp_path)
    assert "b(f) = " in done.stdout
    assert "f²" in done.stdout
    done = plumbline("zoom", *results, "--method", "polynomial", "--degree", "4", home=tmp_path)
    assert done.returncode == 1
    assert "needs 5 focal lengths, and there are 4" in done.stderr
    done = plumbline("zoom", *results, "--degree", "2", home=tmp_path)
    assert done.returncode == 2
    assert "--method hermite does not use --degree" in done.stderr


def test_specimens_are_pooled_and_their_scatter_shown(tmp_path: Path) -> None:
    errors = {"b": 0.001, "d": 2.0, "e": 2.0}
    results = [
        saved(tmp_path / f"{d}.json", calibration(b=-0.02, d=d, errors=errors)) for d in (0.0, 30.0)
    ]
    done = plumbline("zoom", *results, home=tmp_path)
    assert "2 calibrations at 8.2 mm scatter" in done.stdout
    assert "centres up to 30.0 px apart" in done.stdout


@pytest.mark.parametrize("content", ["{}", "begin lens", ""])
def test_files_that_are_no_results(tmp_path: Path, content: str) -> None:
    (tmp_path / "x.json").write_text(content)
    done = plumbline("zoom", tmp_path / "x.json", home=tmp_path)
    assert done.returncode == 1
    assert "x.json: this is not a calibration written by plumbline." in done.stderr
    assert "plumbline fit POINTS -o result.json" in done.stderr
