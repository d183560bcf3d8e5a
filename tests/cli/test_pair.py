"""`plumbline pair`: two pictures in, a lens out, and refusals in a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plumbline
from tests.cli.process import Run
from tests.render import pair

TRUTH = pair.Pair(size=(1000, 750))


@pytest.fixture(scope="module")
def pictures() -> tuple[np.ndarray, np.ndarray]:
    return pair.take(TRUTH)


@pytest.fixture
def folder(tmp_path: Path, pictures: tuple[np.ndarray, np.ndarray]) -> Path:
    for name, pixels in zip(("raw.png", "camera.png"), pictures, strict=True):
        Image.fromarray(pixels).save(tmp_path / name)
    return tmp_path


def table(name: str = "pairs.csv", n: int = 200) -> None:
    rows = np.hstack(pair.true_matches(TRUTH, n, 0.2, 1)).tolist()
    text = "x,y,X,Y\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
    Path(name).write_text(text, encoding="utf-8")


def test_two_pictures_make_the_files_of_fit_and_a_report(run: Run, folder: Path) -> None:
    done = run("pair", "raw.png", "camera.png", "-o", "lens.json", "-o", "lens.pto",
               "--report", "lens.html", "--plot", "field.photo.png")  # fmt: skip
    assert done.status == 0, done.err
    assert "matches disagree by" in done.out
    made = plumbline.read_calibration("lens.json")
    for name, value in TRUTH.lens.coefficients.items():
        assert abs(made.coefficients[name] - value) < 4 * made.standard_errors[name]
    page = (folder / "lens.html").read_text()
    assert "Matches by part of the photo" in page
    assert "Straightness of the lines" not in page
    assert (folder / "field.photo.png").is_file()
    assert run("report", "lens.json", "-o", "again.html").status == 0


def test_matched_points_from_a_table(run: Run, folder: Path) -> None:
    table()
    for words in (("raw.png",), ("--size", "1000x750")):
        done = run("pair", *words, "--points", "pairs.csv", "-o", "lens.json")
        assert done.status == 0, done.err
    assert "200 matched points" in done.out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("pair",), "name an original and a corrected picture"),
        (("pair", "raw.png"), "name an original and a corrected picture"),
        (("pair", "raw.png", "raw.png"), "are one file"),
        (("pair", "raw.png", "nothing.png"), "there is no such photo"),
        (("pair", "raw.png", "camera.png", "--size", "10x10"), "belongs to --points"),
        (("pair", "raw.png", "camera.png", "--points", "pairs.csv"), "the original alone"),
        (("pair", "--points", "pairs.csv"), "the size of the original is not known"),
        (("pair", "raw.png", "--points", "pairs.csv", "--size", "10x10"), "--size says 10x10"),
        (("pair", "raw.png", "--points", "wrong.csv"), "the columns are not x,y,X,Y"),
        (("pair", "raw.png", "--points", "text.csv"), "row 2"),
        (("pair", "raw.png", "--points", "short.csv"), "3 cells, not 4"),
        (("pair", "raw.png", "--points", "empty.csv"), "0 matches"),
        (("pair", "raw.png", "camera.png", "-o", "lens.txt"), "not written as .txt"),
        (("pair", "raw.png", "camera.png", "--free", "q"), "unknown coefficient"),
    ],
)
def test_wrong_calls_are_one_sentence(
    run: Run, folder: Path, words: tuple[str, ...], said: str
) -> None:
    table()
    Path("wrong.csv").write_text("line,x,y\n1,2,3\n")
    Path("text.csv").write_text("x,y,X,Y\n1,2,3,four\n")
    Path("short.csv").write_text("x,y,X,Y\n1,2,3\n")
    Path("empty.csv").write_text("x,y,X,Y\n")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = run(*words)
    assert done.status in {1, 2}
    assert said in done.err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
