"""`plumbline snap` and `fit --snap`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from tests.cli.process import Run
from tests.edges.test_snap import SMALL, rendered, rough


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A photo and rough picks of it."""
    Image.fromarray(rendered()[2]).save(tmp_path / "wall.png")
    plumbline.write_points(rough(), tmp_path / "picks.csv")
    return tmp_path


def test_snap_writes_points_that_fit_reads_without_being_told_their_size(
    run: Run, project: Path
) -> None:
    done = run("snap", "picks.csv", "--photo", "wall.png", "-o", "picks.json")
    number = len(rough().lines)
    assert done.status == 0
    assert f"Wrote picks.json: {number} of {number} lines snapped" in done.out
    assert "Next: plumbline fit picks.json" in done.out
    assert sum(each.startswith("line ") for each in done.out.splitlines()) == number
    back = plumbline.read(project / "picks.json")
    assert back.photos[0].size == SMALL
    assert back.photos[0].name == "wall.png"
    direct = plumbline.snap(rough(), project / "wall.png").observations
    for one, other in zip(back.lines, direct.lines, strict=True):
        np.testing.assert_allclose(one.points_px, other.points_px, atol=1e-9)
    assert run("fit", "picks.json", "-q").status == 0
    assert run("snap", "picks.csv", "--photo", "wall.png", "-o", "picks.json").status == 0


def test_the_default_output_stands_beside_the_points(run: Run, project: Path) -> None:
    done = run("snap", "picks.csv", "--photo", "wall.png", "-q")
    assert done.status == 0
    assert (project / "picks.snapped.json").is_file()
    assert len(done.out.splitlines()) == 2


def test_fit_snaps_first_and_the_summary_counts(run: Run, project: Path) -> None:
    done = run("fit", "picks.csv", "--photo", "wall.png", "--snap", "-o", "r.json")
    number = len(rough().lines)
    assert done.status == 0
    assert f"{number} of {number} lines snapped to the photo's edges" in done.out
    made = plumbline.read_calibration(project / "r.json")
    assert made.sigma_px < 0.2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("snap", "picks.csv", "--size", "900x600"), "the photo of the picks is not beside"),
        (("snap", "picks.csv", "--photo", "no.png"), "there is no such photo"),
        (("snap", "picks.csv", "--photo", "picks.csv"), "picture"),
        (("snap", "picks.csv", "--photo", "small.png"), "lie outside the 450x300 photo"),
        (("snap", "picks.csv", "--photo", "wall.png", "-o", "wall.png.csv"), ""),
        (("fit", "picks.csv", "--size", "900x600", "--snap"), "is not beside the points"),
    ],
)
def test_bad_input_ends_in_a_sentence(
    run: Run, project: Path, words: tuple[str, ...], says: str
) -> None:
    Image.new("L", (450, 300)).save(project / "small.png")
    (project / "wall.png.csv").write_text("precious")
    done = run(*words)
    assert done.status == 1
    assert done.err.startswith("Error: ")
    assert says in done.err
    assert (project / "wall.png.csv").read_text() == "precious"


def test_a_wrong_suffix_is_a_wrong_call(run: Run, project: Path) -> None:
    assert run("snap", "picks.csv", "--photo", "wall.png", "-o", "x.xml").status == 2
