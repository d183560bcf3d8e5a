"""Hugin's own programs on what plumbline writes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import plumbline
from tests.peers.tools import program, run

Array = NDArray[np.float64]

SAMPLES = Path(__file__).parents[2] / "sample_projects"
OLYMPUS = Path(__file__).parents[3] / "shared" / "data" / "olympus" / "building.pto"
PROJECTS = [SAMPLES / "building" / "building.pto", OLYMPUS]


def _copy(project: Path, folder: Path) -> Path:
    if not project.exists():
        pytest.skip(f"{project.name} of the shared data is absent")
    copy = folder / project.name
    copy.write_bytes(project.read_bytes())
    return copy


def _with_own_view(project: Path) -> Path:
    """The project with its output set to the photo's own size and field of view."""
    text = project.read_text()
    image = next(line for line in text.splitlines() if line.startswith("i "))
    fields = {name: re.search(rf" {name}([-.\d]+)", image) for name in "whv"}
    width, height, view = (match[1] for match in fields.values() if match)
    own = project.with_suffix(".own.pto")
    own.write_text(re.sub(r"(?m)^p .*$", f'p f0 w{width} h{height} v{view} n"TIFF"', text))
    return own


def _straightness(points: Array) -> Array:
    """Signed distances from the best line, by singular value decomposition."""
    centred = points - points.mean(axis=0)
    return centred @ np.linalg.svd(centred)[2][1]


@pytest.mark.parametrize("project", PROJECTS, ids=lambda path: path.parent.name)
@pytest.mark.parametrize("free", [("a", "b", "c"), ("b",), ("a", "b", "c", "d", "e")], ids=",".join)
def test_hugin_maps_the_picks_onto_lines_as_straight_as_claimed(
    project: Path, free: tuple[str, ...], tmp_path: Path
) -> None:
    pano_trafo = program("pano_trafo")
    observations = plumbline.read(_copy(project, tmp_path))
    made = plumbline.calibrate(observations, free=free)
    written = plumbline.write(made, tmp_path / "written.pto")
    given = "\n".join(
        f"{x:.9f} {y:.9f}" for line in observations.lines for x, y in line.points_px.tolist()
    )
    out = run([pano_trafo, str(_with_own_view(written)), "0"], given + "\n")
    mapped = np.array([[float(v) for v in row.split()[:2]] for row in out.splitlines()])
    ends = np.cumsum([len(line.points_px) for line in observations.lines])[:-1]
    distances = np.concatenate([_straightness(line) for line in np.split(mapped, ends)])
    rms = float(np.sqrt(np.mean(distances**2)))
    assert rms == pytest.approx(made.rms_corrected_px, abs=0.005)
    before = np.concatenate([_straightness(line.points_px) for line in observations.lines])
    assert rms < 0.5 * np.sqrt(np.mean(before**2))


def _optimised(project: Path) -> list[float]:
    """a, b, c after Hugin's optimiser, run on the variables that the project names."""
    out = project.with_suffix(".optimised.pto")
    run([program("autooptimiser"), "-n", "-o", str(out), str(project)])
    image = next(line for line in out.read_text().splitlines() if line.startswith("i "))
    found = [re.search(rf" {name}([-+.\de]+)", image) for name in "abc"]
    return [float(match[1]) for match in found if match]


def _curve(abc: list[float], r: Array) -> Array:
    a, b, c = abc
    return r * (a * r**3 + b * r**2 + c * r + 1 - a - b - c)


@pytest.mark.parametrize("project", PROJECTS, ids=lambda path: path.parent.name)
@pytest.mark.parametrize("route", ["written", "converted"])
def test_hugin_optimises_what_plumbline_writes_to_a_like_result(
    project: Path, route: str, tmp_path: Path
) -> None:
    observations = plumbline.read(_copy(project, tmp_path))
    made = plumbline.calibrate(observations, residual="corrected")
    if route == "written":
        target = plumbline.write(made, tmp_path / "written.pto")
    else:
        target = plumbline.write_points(observations, tmp_path / "converted.pto")
    theirs = _optimised(target)
    ours = [made.coefficients[name] for name in "abc"]
    assert any(theirs)
    # Hugin weighs the picks in another way, so the curves agree within the picks' noise.
    frame = observations.photos[0].frame
    r = np.linspace(0.05, frame.corner_radius, 100)
    scale = np.dot(_curve(ours, r), _curve(theirs, r)) / np.dot(
        _curve(theirs, r), _curve(theirs, r)
    )
    off_px = (_curve(ours, r) - scale * _curve(theirs, r)) * frame.radius_px
    assert np.max(np.abs(off_px)) < 4.0
    assert made.finding.corner_px != pytest.approx(0, abs=20)
