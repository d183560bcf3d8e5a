"""The road of the samples, rectified as its README says, comes out at the truth within its bars."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.render import road

SAMPLE = Path(__file__).parents[1] / "sample_projects" / "road"
TRUTH: dict[str, Any] = json.loads((SAMPLE / "truth.json").read_text())
BY_POINTS = ["rectify", "road.jpg", "--points", "points.csv"]
BY_TAPES = ["rectify", "road.jpg", "--points", "picks.csv", "--tapes", "tapes.csv"]
LANES = ["--lines", "edges.csv", "--parallel", "left,right"]
COMMANDS = {
    "points": BY_POINTS,
    "points and lanes": [*BY_POINTS, *LANES],
    "tapes and lanes": [*BY_TAPES, *LANES],
}


def run(folder: Path, arguments: list[str]) -> str:
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


@pytest.mark.parametrize("name", COMMANDS)
def test_the_mark_is_as_long_as_it_is(name: str, tmp_path: Path) -> None:
    work = tmp_path / "road"
    shutil.copytree(SAMPLE, work)
    told = run(work, [*COMMANDS[name], "--no-picture"])
    assert "✗" not in told
    saved = json.loads((work / "road_rectified.json").read_text())
    camera, truth = saved["camera"], TRUTH["camera"]
    assert camera["place_m"][2] == pytest.approx(truth["height"], abs=0.06)
    assert camera["pitch_deg"] == pytest.approx(truth["pitch_deg"], abs=0.8)
    assert camera["focal_px"] == pytest.approx(truth["focal_px"], rel=0.03)
    measure = ["measure", "marks.csv", "--from", "road_rectified.json", "--distance", "S1,S2"]
    (length,) = json.loads(run(work, [*measure, "--json"]))["measurements"]
    low, high = length["intervals_95"][0]
    assert low < TRUTH["mark_length"] < high
    assert high - low < 1.2


def test_lanes_shorten_the_bars(tmp_path: Path) -> None:
    bars: list[float] = []
    for name in ("points", "points and lanes"):
        work = tmp_path / name
        shutil.copytree(SAMPLE, work)
        run(work, [*COMMANDS[name], "--no-picture"])
        measure = ["measure", "marks.csv", "--from", "road_rectified.json", "--place", "S2"]
        (place,) = json.loads(run(work, [*measure, "--json"]))["measurements"]
        bars.append(place["ellipse_95"]["long_m"])
    assert bars[1] < bars[0]


def test_the_readme_shows_the_commands_that_are_tested() -> None:
    readme = (SAMPLE / "README.md").read_text()
    for command in COMMANDS.values():
        assert "plumbline " + " ".join(command) in readme


def test_the_texts_are_those_of_the_renderer() -> None:
    for name, text in road.texts().items():
        assert (SAMPLE / name).read_text(encoding="utf-8") == text, name


def test_the_renderer_sees_its_own_road() -> None:
    """Rays of where places are seen meet these places."""
    model = road.Road()
    places = np.array(list(road.CROSSES.values()))
    seen = road.seen(model, places)
    found, down = road.place_of_rays(model, road.VIEW.rays(seen[None]))
    assert down.all()
    assert np.max(np.abs(found[0] - places)) < 0.01
