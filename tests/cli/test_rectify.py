"""`plumbline rectify` and `plumbline measure`, run as a user runs them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import plumbline
from tests.ground.files import GROUND, SCENE, csv, edges, matches, photo, rows, tapes

LENS = ("--ptlens", "b=-0.02")


def test_the_whole_job(tmp_path: Path) -> None:
    path, points = photo(tmp_path), matches(tmp_path)
    done = plumbline(
        "rectify", path, "--points", points, *LENS, "--resolution", "0.1", home=tmp_path
    )
    assert done.returncode == 0, done.stderr
    for told in ("Camera: 1.6", "ground alone implies", "unevenness there", "Wrote", "± 0.02 m"):
        assert told in done.stdout
    for name in ("road_rectified.jpg", "road_rectified.jgw", "road_rectified.json"):
        assert (tmp_path / name).is_file()
    picks = csv(
        tmp_path,
        "picks.csv",
        [(*pick, f"S{i}") for i, pick in enumerate(SCENE.photo(np.array([[0, 8.0], [1, 9]])))],
    )
    saved = tmp_path / "road_rectified.json"
    done = plumbline(
        *("measure", picks, "--from", saved, "--distance", "S0,S1", "--area", "A,B,C,D"),
        *("-o", tmp_path / "measured.csv", "--json"),
        home=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    distance, area = json.loads(done.stdout)["measurements"]
    assert distance["values"][0] == pytest.approx(np.sqrt(2), abs=3e-3)
    assert distance["intervals_95"][0][0] < np.sqrt(2) < distance["intervals_95"][0][1]
    x, y = GROUND[:4].T
    truth = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
    assert area["values"][0] == pytest.approx(truth, rel=2e-3)
    assert (tmp_path / "measured.csv").read_text().count("\n") == 3
    again = plumbline("rectify", path, "--points", points, *LENS, "-q", home=tmp_path)
    assert again.returncode == 0, "its own files are replaced"


def test_tapes_and_lines(tmp_path: Path) -> None:
    points = csv(tmp_path, "picks.csv", [(x, y, n) for x, y, _, _, n in rows(GROUND[:4])])
    six = tapes(tmp_path, ["AB", "BC", "CD", "DA", "AC", "BD"])
    done = plumbline(
        *("rectify", photo(tmp_path), "--points", points, "--tapes", six, *LENS, "--no-picture"),
        *("--lines", edges(tmp_path), "--parallel", "left,right"),
        home=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert "measured" in done.stdout
    assert not (tmp_path / "road_rectified.jpg").exists()


FAILURES = {
    "three points": (["--no-picture"], rows()[:3], "3 points do not determine the plane"),
    "too large": (["--resolution", "0.00001"], rows(), "give a coarser --resolution"),
    "corners": (["--extent", "1,2,3"], rows(), "neither points, photo nor four numbers"),
    "degrees": (["--crs", "4326"], rows(), "is in degrees"),
    "two corners": (["--right-angle", "A,B"], rows(), "does not name three points"),
    "format": (["-o", "out.xyz"], rows(), "cannot be written as .xyz"),
    "lens": (["--ptlens", "q=1"], rows(), "q is not a coefficient"),
}


@pytest.mark.parametrize(("how", "lines", "match"), FAILURES.values(), ids=FAILURES.keys())
def test_failures_are_one_sentence_and_write_nothing(
    tmp_path: Path, how: list[str], lines: list[list[object]], match: str
) -> None:
    path, points = photo(tmp_path), matches(tmp_path, lines)
    before = set(tmp_path.iterdir())
    lens = () if "--ptlens" in how else LENS
    done = plumbline("rectify", path, "--points", points, *lens, *how, home=tmp_path)
    assert done.returncode == 1
    assert match in done.stderr
    assert "Traceback" not in done.stderr
    assert set(tmp_path.iterdir()) - {tmp_path / "data"} == before


@pytest.mark.parametrize(
    "name", ["road_rectified.json", "road_rectified.jpg", "road_rectified.jgw"]
)
def test_files_of_others_are_not_replaced(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    done = plumbline(
        "rectify", photo(tmp_path), "--points", matches(tmp_path), *LENS, home=tmp_path
    )
    assert done.returncode == 1
    assert "was not written by plumbline" in done.stderr
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize(
    ("how", "match"),
    [
        (["--distance", "A,Q"], "no point is named Q"),
        (["--distance", "A"], "needs 2 different points"),
        (["--area", "A,C,B,D"], "cross"),
        (["-o", "m.xml"], "not written as .xml"),
    ],
)
def test_wrong_measurements_are_refused(tmp_path: Path, how: list[str], match: str) -> None:
    path, points = photo(tmp_path), matches(tmp_path)
    plumbline("rectify", path, "--points", points, *LENS, "--no-picture", home=tmp_path)
    saved = tmp_path / "road_rectified.json"
    done = plumbline("measure", "--from", saved, *how, home=tmp_path)
    assert done.returncode == 1
    assert match in done.stderr


def test_a_pick_above_the_horizon_cannot_be_measured(tmp_path: Path) -> None:
    path, points = photo(tmp_path), matches(tmp_path)
    plumbline("rectify", path, "--points", points, *LENS, "--no-picture", home=tmp_path)
    picks = csv(tmp_path, "picks.csv", [(1000, 100, "sky")])
    done = plumbline("measure", picks, "--from", tmp_path / "road_rectified.json", home=tmp_path)
    assert done.returncode == 1
    assert "sky lies on or beyond the horizon" in done.stderr
