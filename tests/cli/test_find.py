"""`plumbline find`, and `fit` of a photo alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from tests.cli.process import Run
from tests.edges.test_find import SIZE, found


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A photo of a façade."""
    path = tmp_path / "wall.png"
    Image.fromarray(found()[1]).save(path)
    return path


def test_find_writes_points_and_a_drawing(run: Run, photo: Path) -> None:
    done = run("find", "wall.png")
    assert done.status == 0
    assert "the correction they give is uncertain by 0." in done.out
    assert "Next: look at wall.found.jpg, then plumbline fit wall.found.json" in done.out
    back = plumbline.read(photo.with_name("wall.found.json"))
    assert back.photos[0].size == SIZE
    assert len(back.lines) == len(found()[2].lines)
    with Image.open(photo.with_name("wall.found.jpg")) as drawing:
        assert drawing.size == SIZE
    assert run("find", "wall.png").status == 0  # its own files may be written again


def test_fit_of_a_photo_alone_says_that_nobody_looked(run: Run, photo: Path) -> None:
    done = run("fit", "wall.png", "-o", "r.json")
    assert done.status == 0
    assert "nobody has checked them" in " ".join(done.out.split())
    made = plumbline.read_calibration(photo.with_name("r.json"))
    assert made.sigma_px < 0.2
    assert json.loads(photo.with_name("r.json").read_text())


def test_a_photo_that_tells_no_lens_is_not_fitted(run: Run, tmp_path: Path) -> None:
    Image.fromarray(np.zeros((200, 300, 3), np.uint8)).save(tmp_path / "black.jpg")
    done = run("fit", "black.jpg")
    assert done.status == 1
    assert "it shows no long straight edge" in done.err
    assert "pick lines by hand" in done.err
    done = run("find", "black.jpg")
    assert done.status == 0
    assert "no long straight edge" in done.out
    assert not (tmp_path / "black.found.json").exists()


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        (("find", "no.png"), 1, "there is no such"),
        (("find", "text.png"), 1, "picture"),
        (("find", "wall.png", "-o", "x.xml"), 2, "points are not written as .xml"),
        (("find", "wall.png", "--overlay", "x.gif"), 2, "drawings are not written as .gif"),
        (("find", "wall.png", "--overlay", "wall.png"), 1, "never overwritten"),
        (("find", "wall.png", "-o", "mine.csv"), 1, "was not written by plumbline"),
        (("fit", "wall.png", "--grid", "3x3"), 2, "a photo without picks does not use --grid"),
        (("fit", "wall.png", "--snap"), 2, "a photo without picks does not use --snap"),
    ],
)
def test_bad_input(run: Run, photo: Path, words: tuple[str, ...], status: int, says: str) -> None:
    photo.with_name("text.png").write_text("no picture")
    photo.with_name("mine.csv").write_text("precious")
    before = photo.read_bytes()
    done = run(*words)
    assert done.status == status
    assert says in done.err
    assert photo.read_bytes() == before
    assert photo.with_name("mine.csv").read_text() == "precious"
