"""`plumbline report`, and `fit` with --report and --plot."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import pytest
from PIL import Image

from plumbline.report.figures import FIGURES
from tests.cli.process import Run

SAMPLES = Path(__file__).parents[2] / "sample_projects"


@pytest.fixture(autouse=True)
def sample(run: Run) -> None:  # run first, since it chooses the folder
    """The first sample project, in the folder that commands run in."""
    for name in ("building.pto", "facade.jpg"):
        shutil.copy(SAMPLES / "building" / name, name)


@pytest.fixture
def result(run: Run) -> str:
    """A result JSON."""
    assert run("fit", "building.pto", "-o", "building.json", "-q").status == 0
    return "building.json"


def files() -> set[str]:
    return {path.name for path in Path().iterdir()} - {"building.pto", "facade.jpg"}


def test_a_fit_with_its_report_and_a_figure(run: Run) -> None:
    words = ("fit", "building.pto", "-q", "--report", "a b.html", "--plot", "x.curve.svg")
    done = run(*words)
    assert done.status == 0
    made = ["building.fit.pto", "building.fit.xml", "a b.html", "x.curve.svg"]
    assert done.out.splitlines()[-4:] == [f"Wrote {name}" for name in made]
    assert files() == set(made)
    page = Path("a b.html").read_text()
    command = shlex.join(["plumbline", *words])
    assert f"<code>{command}</code>" in page
    assert "data:image/jpeg" in page
    assert Path("x.curve.svg").read_bytes().startswith(b"<?xml")


def test_the_json_knows_its_command_and_gives_the_same_report(run: Run) -> None:
    run("fit", "building.pto", "-q", "-o", "building.json", "--report", "first.html")
    command = "plumbline fit building.pto -q -o building.json --report first.html"
    assert json.loads(Path("building.json").read_text())["command"] == command
    done = run("report", "building.json")
    assert done == (0, "Wrote building.html\n", done.err)
    assert Path("building.html").read_bytes() == Path("first.html").read_bytes()


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_every_figure_by_name(run: Run, result: str, suffix: str) -> None:
    Path("out").mkdir()
    plots = [f"out/building.{name}.{suffix}" for name in FIGURES]
    done = run("report", result, *(word for plot in plots for word in ("--plot", plot)))
    assert done.out.splitlines() == [f"Wrote {plot}" for plot in plots]
    assert files() == {"building.json", "out"}
    if suffix == "png":
        for plot in plots:
            with Image.open(plot) as image:
                assert image.width > 600
                assert "made by plumbline" in image.info["Software"]


def test_files_of_ours_are_replaced_and_others_kept(run: Run, result: str) -> None:
    wanted = ("report", result, "--plot", "curve.svg", "--plot", "lines.png", "-o", "r.html")
    assert run(*wanted).status == 0
    names = ("curve.svg", "lines.png", "r.html")
    drawn = {name: Path(name).read_bytes() for name in names}
    for name in names:
        Path(name).write_text("mine")
        done = run(*wanted)
        assert done.status == 1
        assert f"{name}: this file exists and was not written by plumbline" in done.err
        assert Path(name).read_text() == "mine"
        Path(name).write_bytes(drawn[name])
    assert run(*wanted).status == 0
    Path("r.html").write_text("mine")
    assert run(*wanted, "--overwrite").status == 0
    assert {name: Path(name).read_bytes() for name in names} == drawn


@pytest.mark.parametrize(
    ("words", "sentence", "remedy"),
    [
        (("building.pto",), "holds the residuals and error bars", "plumbline fit POINTS -o"),
        (("facade.jpg",), "holds the residuals and error bars", "plumbline fit POINTS -o"),
        (("missing.json",), "there is no such file", "check the name"),
        (("building.json", "--photo", "no.jpg"), "there is no such photo", "give a JPEG"),
        (("building.json", "--photo", "building.pto"), "not a picture that can be read", "JPEG"),
        (("building.json", "-o", "no/r.html"), "the folder does not exist", "make it first"),
        (("other.json",), "this is not a calibration written by plumbline", "fit again"),
        (("zoom.json",), "this is a zoom lens", "give the RESULT.json of one focal length"),
    ],
)
def test_bad_input_gets_a_sentence_and_a_remedy(
    run: Run, result: str, words: tuple[str, ...], sentence: str, remedy: str
) -> None:
    Path("other.json").write_text('{"format": "something else"}')
    Path("zoom.json").write_text('{"format": "plumbline zoom"}')
    before = files()
    done = run("report", *words)
    assert done.status == 1
    assert sentence in done.err
    assert remedy in done.err
    assert files() == before


@pytest.mark.parametrize(
    "damage",
    [
        {"coefficients": {"a": 0, "b": -0.4, "c": 0, "d": 0, "e": 0}},
        {"coefficients": {"a": 0, "b": 1, "c": 0, "d": 0, "e": 0}},
        {"coefficients": {"a": 0, "b": -0.02, "c": 0, "d": 1e6, "e": 0}},
    ],
    ids=["folded", "no scale", "far away"],
)
def test_a_lens_that_is_not_that_of_its_picks(run: Run, result: str, damage: object) -> None:
    whole = json.loads(Path(result).read_text())
    assert isinstance(damage, dict)
    Path("damaged.json").write_text(json.dumps(whole | damage))
    done = run("report", "damaged.json")
    assert done.status == 1
    assert "the lens does not go with the picks" in done.err
    assert "fit again" in done.err


@pytest.mark.parametrize(
    ("name", "place", "away", "sentence"),
    [
        ("coefficients", "b", 1e-5, "does not leave the picks the residuals that are stored"),
        ("sigma_px", None, 0.01, "σ̂ is not that of the residuals"),
        ("dof", None, 40, "degrees of freedom are not those of the picks"),
        ("rms_corrected_px", None, 0.01, "error in the corrected photo"),
    ],
)
@pytest.mark.parametrize("residual", ["image", "corrected"])
def test_a_result_that_was_changed_by_hand(
    run: Run, name: str, place: str | None, away: float, sentence: str, residual: str
) -> None:
    options = ("--free", "b", "--residual", residual)
    assert run("fit", "building.pto", *options, "-o", "made.json").status == 0
    assert run("report", "made.json").status == 0
    whole = json.loads(Path("made.json").read_text())
    holder, key = (whole, name) if place is None else (whole[name], place)
    holder[key] += away
    Path("changed.json").write_text(json.dumps(whole))
    for words in (("report",), ("zoom",), ("lens", "add"), ("export", "--to", "opencv")):
        done = run(*words, "changed.json")
        assert done.status == 1, words
        assert "this result was changed since it was written" in done.err
        assert sentence in done.err
        assert "fit again" in done.err


@pytest.mark.parametrize("place", [0, 5])
def test_residuals_that_were_changed_by_hand(run: Run, result: str, place: int) -> None:
    whole = json.loads(Path(result).read_text())
    whole["observations"]["lines"][0]["residuals_px"][place] += 0.01
    Path("changed.json").write_text(json.dumps(whole))
    assert "this result was changed" in run("report", "changed.json").err


@pytest.mark.parametrize(
    ("words", "sentence", "remedy"),
    [
        (("--plot", "bend.svg"), "no figure 'bend'", "photo, lines, curve"),
        (("--plot", "curve.pdf"), "not written as .pdf", ".png, .svg"),
        (("--plot", "curve"), "files without a suffix", ".png, .svg"),
        (("--report", "report.pdf"), "not written as .pdf", ".html"),
    ],
)
def test_a_wrong_name_is_a_wrong_call_and_said_before_the_fit(
    run: Run, words: tuple[str, ...], sentence: str, remedy: str
) -> None:
    done = run("fit", "building.pto", *words)
    assert done.status == 2
    assert sentence in done.err
    assert remedy in done.err
    assert not files()


def test_a_file_that_may_not_be_written_stops_all_of_them(run: Run) -> None:
    Path("report.html").write_text("mine")
    done = run("fit", "building.pto", "--report", "report.html")
    assert done.status == 1
    assert files() == {"report.html"}


def test_inputs_are_never_overwritten(run: Run, result: str) -> None:
    Path("link.html").symlink_to("building.json")
    shutil.copy("facade.jpg", "photo.png")
    done = run("report", result, "-o", "link.html", "--overwrite")
    assert (done.status, "never overwritten" in done.err) == (1, True)
    plot = ("--photo", "photo.png", "--plot", "photo.png", "--overwrite")
    done = run("report", result, *plot)
    assert (done.status, "never overwritten" in done.err) == (1, True)


def test_without_the_photo_it_comes_with_an_empty_frame(run: Run, result: str) -> None:
    Path("facade.jpg").unlink()
    done = run("report", result)
    assert done.status == 0
    assert done.err.endswith(
        "Note: facade.jpg was not found and is not shown (--photo names it).\n"
    )
    assert "data:image/jpeg" not in Path("building.html").read_text()


def test_the_photo_may_be_elsewhere(run: Run, result: str) -> None:
    Path("photos").mkdir()
    Path("facade.jpg").rename("photos/other.jpg")
    done = run("report", result, "--photo", "photos/other.jpg")
    assert done.status == 0
    assert "Note" not in done.err
    assert "data:image/jpeg" in Path("building.html").read_text()


def test_a_result_elsewhere_finds_its_photo(run: Run, result: str) -> None:
    Path("results").mkdir()
    Path(result).rename("results/building.json")
    assert "Note" not in run("report", "results/building.json").err
    assert Path("results/building.html").exists()


def test_several_lenses_are_numbered(run: Run) -> None:
    for path in (SAMPLES / "zoom").iterdir():
        shutil.copy(path, ".")
    done = run("fit", "zoom.pto", "-q", "--report", "zoom.html", "--plot", "zoom.curve.svg")
    assert done.out.splitlines()[-4:] == [
        "Wrote zoom.html",
        "Wrote zoom.1.curve.svg",
        "Wrote zoom.2.curve.svg",
        "Wrote zoom.3.curve.svg",
    ]
    assert Path("zoom.html").read_text().count("<h2>") == 3


def test_names_that_are_no_text(run: Run) -> None:
    try:
        Path("building.pto").rename("bad\udcff.pto")
        Path("facade.jpg").rename("bad\udcff.jpg")
    except (OSError, UnicodeEncodeError):
        pytest.skip("this file system takes only names that are text")
    done = run("fit", "bad\udcff.pto", "--photo", "bad\udcff.jpg", "--report", "x.html")
    assert done.status == 0
    assert b"</html>" in Path("x.html").read_bytes()
