"""Every sample project, run as its README says, comes out at the lens it was rendered with."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAMPLES = Path(__file__).parents[1] / "sample_projects"
PHOTO = SAMPLES / "facade_photo"
"""The one without picks."""

FOLDERS = sorted(path.parent for path in SAMPLES.glob("*/expected.json") if path.parent != PHOTO)


def _run(folder: Path, arguments: list[str]) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "plumbline", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def _ideal(abc: dict[str, float], observed: Array) -> Array:
    """Ideal radii of observed ones by bisection, independently of plumbline."""
    low, high = np.zeros_like(observed), np.full_like(observed, 4.0)
    for _ in range(80):
        r = (low + high) / 2
        below = r * (abc["a"] * r**3 + abc["b"] * r**2 + abc["c"] * r + 1 - sum(abc.values()))
        low, high = np.where(below < observed, r, low), np.where(below < observed, high, r)
    return (low + high) / 2


def _furthest_apart_px(truth: dict[str, float], found: dict[str, float], size: list[int]) -> float:
    """Largest difference of two lenses over the photo after the best common scale."""
    width, height = size
    radius_px = min(size) / 2
    observed = np.linspace(0.02, 1, 200) * np.hypot(width, height) / 2 / radius_px
    want, have = _ideal(truth, observed), _ideal(found, observed)
    scale = (want @ have) / (have @ have)
    return float(np.max(np.abs(want - scale * have))) * radius_px


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_a_sample_project_comes_out_at_its_truth(folder: Path, tmp_path: Path) -> None:
    work = tmp_path / folder.name
    shutil.copytree(folder, work, ignore=shutil.ignore_patterns("*.fit.*"))
    expected = json.loads((folder / "expected.json").read_text())
    before = set(work.iterdir())
    result: dict[str, Any] = json.loads(_run(work, [*expected["command"], "--json"]))
    assert {path.name for path in set(work.iterdir()) - before} == set(expected["outputs"])
    lenses = expected.get("lenses", [expected])
    found = result.get("calibrations", [result])
    assert len(found) == len(lenses)
    for want, have in zip(lenses, found, strict=True):
        lines = have["observations"]["lines"]
        if "n_lines" in want:  # how many points of a pair match is not known beforehand
            assert len(lines) == want["n_lines"]
            assert sum(len(line["points_px"]) for line in lines) == want["n_points"]
        assert have["converged"]
        # σ̂ of n degrees of freedom spreads by 1/√(2n); four of those, and the photo's corners
        # stretch what the picks' noise looks like by a few percent.
        spread = 4 / np.sqrt(2 * have["dof"]) + 0.05
        if "noise_px" in expected:  # corners and matches are found, not picked
            assert have["sigma_px"] == pytest.approx(expected["noise_px"], rel=spread)
        size = have["observations"]["photos"][0]["size"]
        truth = want["truth"]["coefficients"]
        abc = {name: have["coefficients"][name] for name in "abc"}
        assert _furthest_apart_px(truth, abc, size) < expected["curve_within_px"]
        assert _furthest_apart_px(truth, dict.fromkeys("abc", 0.0), size) > 5


def test_the_photo_without_picks_comes_out_at_its_truth(tmp_path: Path) -> None:
    work = tmp_path / PHOTO.name
    shutil.copytree(PHOTO, work)
    expected = json.loads((PHOTO / "expected.json").read_text())
    before = set(work.iterdir())
    result: dict[str, Any] = json.loads(_run(work, [*expected["command"], "--json"]))
    assert {path.name for path in set(work.iterdir()) - before} == set(expected["outputs"])
    found = result.get("calibrations", [result])[0]
    size = found["observations"]["photos"][0]["size"]
    truth = expected["truth"]["coefficients"]
    abc = {name: found["coefficients"][name] for name in "abc"}
    assert _furthest_apart_px(truth, abc, size) < expected["curve_within_px"]
    assert _furthest_apart_px(truth, dict.fromkeys("abc", 0.0), size) > 5


def test_every_folder_is_a_sample() -> None:
    folders = {path for path in SAMPLES.iterdir() if path.is_dir()}
    assert folders == {*FOLDERS, PHOTO, SAMPLES / "road"}  # which has tests of its own
    names = {
        *("board", "building", "facade_csv", "facade_photo", "grid_winmorph"),
        *("pair", "road", "zoom"),
    }
    assert {path.name for path in folders} == names


def test_readmes_show_the_command_that_is_tested() -> None:
    for folder in (*FOLDERS, PHOTO):
        command = json.loads((folder / "expected.json").read_text())["command"]
        assert "plumbline " + " ".join(command) in (folder / "README.md").read_text()
