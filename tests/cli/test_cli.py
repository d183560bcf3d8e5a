"""The command line: what it prints, writes and refuses, and with which status."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from plumbline.cli import VERBS, command, options
from plumbline.fit import bootstrap
from plumbline.formats.known import POINT_FORMATS
from plumbline.models import MODELS
from tests.cli.process import Run

WIDTH, HEIGHT = 600, 400
SIZE = ("--size", f"{WIDTH}x{HEIGHT}")
FOCAL = ("--focal", "20", "--crop-factor", "1.5")
B = -0.02

Lines = dict[str, list[tuple[float, float]]]


def observed(points: np.ndarray[Any, Any], b: float = B) -> np.ndarray[Any, Any]:
    """Where a lens with that b shows ideal points: q (b |q|² + 1 − b), q in half short sides."""
    centre = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    q = (points - centre) / (HEIGHT / 2)
    return centre + q * (b * (q**2).sum(-1, keepdims=True) + 1 - b) * HEIGHT / 2


def grid(n_lines: int = 16, n_points: int = 8, b: float = B, seed: int = 1) -> Lines:
    """Rows and columns as that lens shows them, picked with an error of 0.1 px."""
    rng = np.random.default_rng(seed)
    found: Lines = {}
    half = n_lines // 2
    for index in range(n_lines):
        along = np.linspace(20, WIDTH - 20, n_points)
        across = np.full(n_points, 15 + (HEIGHT - 30) * (index + 0.5) / half)
        if index >= half:
            along = np.linspace(20, HEIGHT - 20, n_points)
            across = np.full(n_points, 20 + (WIDTH - 40) * (index - half + 0.5) / (n_lines - half))
        pair = (along, across) if index < half else (across, along)
        points = observed(np.stack(pair, axis=-1), b) + rng.normal(0, 0.1, (n_points, 2))
        found[f"edge {index}"] = [(x, y) for x, y in points.tolist()]
    return found


def csv(lines: Lines, name: str = "picks.csv") -> str:
    rows = [f"{label},{x!r},{y!r}" for label, points in lines.items() for x, y in points]
    Path(name).write_text("line,x,y\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return name


def image(**values: object) -> str:
    tokens: dict[str, object] = {"w": WIDTH, "h": HEIGHT, "f": 0, "v": 50, "a": 0, "b": 0, "c": 0}
    return "i " + " ".join(f"{n}{v}" for n, v in (tokens | values).items()) + ' n"x.jpg"\n'


def points(lines: Lines, photo: int = 0, first: int = 3) -> str:
    rows: list[str] = []
    for kind, picked in enumerate(lines.values(), first):
        for (x, y), (x2, y2) in zip(picked, reversed(picked), strict=True):
            rows.append(f"c n{photo} N{photo} x{x!r} y{y!r} X{x2!r} Y{y2!r} t{kind}\n")
    return "".join(rows)


def pto(name: str = "building.pto", *, head: str = "", v: str = "v a0 b0 c0\n") -> str:
    text = (
        "# hugin project file\n#-hugin  cropFactor=1.5\n" + (head or image()) + v + points(grid())
    )
    Path(name).write_bytes(text.encode())
    return name


def files() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def distortions(name: str) -> list[dict[str, str]]:
    return [dict(entry.attrib) for entry in ET.parse(name).iter("distortion")]


# --- the main job ---------------------------------------------------------------------------


def test_a_project_becomes_a_project_and_a_profile(run: Run) -> None:
    done = run("fit", pto())
    assert done.status == 0
    assert done.err == ""
    assert done.out.startswith("Barrel distortion: −")
    for word in ("before", "after", "± std. error", "t3", "σ̂", "start"):
        assert word in done.out
    assert done.out.endswith("Wrote building.fit.pto\nWrote building.fit.xml\n")
    assert files() == ["building.fit.pto", "building.fit.xml", "building.pto"]
    before, after = Path("building.pto").read_text(), Path("building.fit.pto").read_text()
    assert [a for a, b in zip(before.splitlines(), after.splitlines(), strict=True) if a != b] == [
        image().rstrip()
    ]


def test_the_truth_lies_within_the_error_bars(run: Run) -> None:
    run("fit", csv(grid()), *SIZE, "--free", "b", "-o", "x.json")
    found = json.loads(Path("x.json").read_text())
    assert abs(found["coefficients"]["b"] - B) < 4 * found["standard_errors"]["b"]
    assert found["standard_errors"]["b"] < 2e-4
    assert found["coefficients"]["a"] == found["coefficients"]["c"] == 0
    assert found["dof"] == 16 * 8 - 2 * 16 - 1
    assert found["rms_after_px"] == pytest.approx(0.1 * (95 / 128) ** 0.5, rel=0.25)
    # At the corner r = |q|: percent relative to the centre's 1 - b.
    corner = float(np.hypot(WIDTH, HEIGHT) / HEIGHT)
    low, high = (100 * B * r**2 / (1 - B) for r in (corner * 1.1, corner * 0.9))
    assert low < found["finding"]["percent"] < high
    assert found["finding"]["kind"] == "barrel"


def test_json_goes_to_stdout_and_narration_to_stderr(run: Run) -> None:
    done = run("fit", pto(), "--json", "-o", "x.json")
    assert (done.status, done.err) == (0, "Wrote x.json\n")
    assert done.out == Path("x.json").read_text()
    found = json.loads(done.out)
    assert {
        "coefficients",
        "standard_errors",
        "covariance",
        "sigma_px",
        "dof",
        "rms_before_px",
        "rms_after_px",
        "rms_corrected_px",
        "converged",
        "reason",
    } <= set(found)


def test_notes_on_files_are_no_part_of_the_result(run: Run) -> None:
    words = ("--json", "-o", "x.json", "-o", "x.xml", "-o", "x.pto")
    done = run("fit", pto(), *words, "--maker", "me", "--mount", "EF")
    assert done.status == 0
    assert done.out == Path("x.json").read_text()
    assert done.err.splitlines() == [
        "Note: the lens is named after the file of the points: building (--lens-name).",
        "Wrote x.json",
        "Wrote x.xml",
        "Wrote x.pto",
    ]
    shown = run("fit", "building.pto", *words[1:]).out.splitlines()
    at = [i for i, line in enumerate(shown) if "(--lens-name)" in line]
    assert len(at) == 1
    assert "• the mount is not known" in shown[at[0] + 1]
    assert shown[at[0] + 2] == "Wrote x.json"


def test_pixels_that_are_not_square_are_told(run: Run) -> None:
    name = csv(grid())
    note = "the Hugin project is for the photo resampled to 720x400, where its pixels are square"
    assert note in run("fit", name, *SIZE, "--pixel-aspect", "6:5").out
    assert note in run("convert", name, "p.pto", *SIZE, "--pixel-aspect", "6:5").err
    assert "resampled" not in run("convert", name, "p.csv", *SIZE, "--pixel-aspect", "6:5").err
    assert "i w720 h400 " in Path("p.pto").read_text()


def test_quiet_prints_the_finding_and_the_files(run: Run) -> None:
    done = run("fit", pto(), "-q")
    first, quote, *notes, pto_line, xml_line = done.out.splitlines()
    assert first.startswith("Barrel distortion")
    assert quote.startswith("quote ±")
    assert [pto_line, xml_line] == ["Wrote building.fit.pto", "Wrote building.fit.xml"]
    assert all("not known" in note or "named after" in note for note in notes)


def test_many_lines_are_listed_only_when_asked_for(run: Run) -> None:
    name = csv(grid(26, 4))
    short, long = run("fit", name, *SIZE), run("fit", name, *SIZE, "-v")
    assert "the 24 of 26 lines with the largest residuals" in short.out
    assert sum(f"edge {i} " in short.out for i in range(26)) == 24
    assert all(f"edge {i} " in long.out for i in range(26))


def test_narrow_terminals_lose_no_digit(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "20")
    done = run("fit", pto())
    assert done.status == 0
    assert "…" not in done.out
    assert run("models").status == 0


# --- outputs --------------------------------------------------------------------------------


def test_several_outputs(run: Run) -> None:
    done = run("fit", pto(), "-o", "a.json", "-o", "b.xml", "-o", "c.pto")
    assert done.status == 0
    assert files() == ["a.json", "b.xml", "building.pto", "c.pto"]


def test_earlier_outputs_are_replaced(run: Run) -> None:
    for _ in range(2):
        assert run("fit", pto()).status == 0
        assert run("fit", "building.pto", "-o", "x.json").status == 0
    assert run("fit", "building.pto", "--free", "b").status == 0
    assert distortions("building.fit.xml")[0]["a"] == "0"


@pytest.mark.parametrize("mine", ["building.fit.pto", "building.fit.xml"])
def test_files_of_others_are_not_replaced_and_nothing_is_written(run: Run, mine: str) -> None:
    pto()
    Path(mine).write_text("precious")
    done = run("fit", "building.pto")
    assert (done.status, done.out) == (1, "")
    assert done.err.startswith(f"Error: {mine}: this file exists and was not written by plumbline.")
    assert "--overwrite" in done.err
    assert Path(mine).read_text() == "precious"
    assert files() == sorted(["building.pto", mine])
    assert run("fit", "building.pto", "--overwrite").status == 0
    assert Path(mine).read_text() != "precious"


def test_the_input_is_never_overwritten(run: Run) -> None:
    content = Path(pto()).read_bytes()
    done = run("fit", "building.pto", "-o", "building.pto", "--overwrite")
    assert done.status == 1
    assert "never overwritten" in done.err
    assert run("convert", "building.pto", "building.pto", "--overwrite").status == 1
    assert Path("building.pto").read_bytes() == content
    assert files() == ["building.pto"]


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("none/x.pto", "none/x.pto: the folder does not exist"),
        ("building.pto/x.pto", "building.pto/x.pto: the file cannot be written: Not a directory"),
        ("folder.pto", "folder.pto: this is not a regular file"),
        ("x" * 300 + ".pto", "the file cannot be written: File name too long"),
    ],
)
def test_outputs_that_cannot_be_written(run: Run, output: str, sentence: str) -> None:
    pto()
    Path("folder.pto").mkdir()
    done = run("fit", "building.pto", "-o", "good.json", "-o", output)
    assert (done.status, done.out) == (1, "")
    assert sentence in done.err
    assert files() == ["building.pto", "folder.pto"]


def test_a_full_disk_leaves_nothing_behind(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    pto()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    done = run("fit", "building.pto")
    assert done.status == 1
    assert "building.fit.pto: the file cannot be written: No space left on device." in done.err
    assert files() == ["building.pto"]


@pytest.mark.parametrize(
    ("model", "suffixes"),
    [
        ("ptlens", [".pto", ".xml"]),
        ("poly3", [".pto", ".xml"]),
        ("poly5", [".xml"]),
        ("acm", [".xml"]),
        ("brown", [".json"]),
        ("division", [".json"]),
        ("radial:2", [".json"]),
        ("opencv", [".json"]),
    ],
)
def test_what_a_model_is_written_as_by_default(run: Run, model: str, suffixes: list[str]) -> None:
    done = run(
        "fit",
        pto(),
        "--model",
        model,
        "--free",
        {"ptlens": "b", "division": "l1", "radial:2": "a2"}.get(model, "k1"),
    )
    assert done.status == 0
    assert files() == sorted([*(f"building.fit{suffix}" for suffix in suffixes), "building.pto"])
    for suffix in {".pto", ".xml"} - set(suffixes):
        assert f"building.fit{suffix} was not written: " in done.out


@pytest.mark.parametrize("model", ["opencv", "acm"])
def test_models_in_focal_lengths_need_one(run: Run, model: str) -> None:
    done = run("fit", csv(grid()), *SIZE, "--model", model)
    assert done.status == 1
    assert f"the model {model} measures in focal lengths, and none is known" in done.err
    assert "--focal-px" in done.err
    assert files() == ["picks.csv"]


def test_without_focal_length_no_profile_and_a_note(run: Run) -> None:
    done = run("fit", csv(grid()), *SIZE)
    assert done.status == 0
    assert files() == ["picks.csv", "picks.fit.pto"]
    assert "picks.fit.xml was not written: " in done.out
    assert "--crop-factor" in done.out
    asked = run("fit", "picks.csv", *SIZE, "-o", "x.json", "-o", "x.xml")
    assert asked.status == 1
    assert files() == ["picks.csv", "picks.fit.pto"]


def test_labels_and_measures_in_the_profile(run: Run) -> None:
    words = [
        "--maker",
        "Carl & Co",
        "--lens-name",
        "18 <x>",
        "--mount",
        "EF",
        "--aspect-ratio",
        "3:2",
    ]
    assert run("fit", csv(grid()), *SIZE, *FOCAL, *words).status == 0
    lens = ET.parse("picks.fit.xml").find("lens")
    assert lens is not None
    texts = [
        lens.findtext(tag) for tag in ("maker", "model", "mount", "cropfactor", "aspect-ratio")
    ]
    assert texts == ["Carl & Co", "18 <x>", "EF", "1.5", "1.5"]
    assert distortions("picks.fit.xml")[0]["focal"] == "20"


def test_labels_that_are_not_known_are_told(run: Run) -> None:
    done = run("fit", csv(grid()), *SIZE, *FOCAL)
    for flag in ("--maker", "--lens-name", "--mount"):
        assert flag in done.out
    assert ET.parse("picks.fit.xml").findtext("lens/mount") == "Generic"


def test_the_photo_tells_size_and_lens(run: Run) -> None:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "NIKON", "E995"
    exif.get_ifd(0x8769).update({0x920A: 8.0, 0xA405: 38})
    Image.new("L", (WIDTH, HEIGHT)).save("p.jpg", exif=exif)
    done = run("fit", csv(grid()), "--photo", "p.jpg")
    assert done.status == 0
    root = ET.parse("picks.fit.xml")
    assert root.findtext("lens/model") == "NIKON E995 lens"
    assert root.findtext("lens/cropfactor") == "4.75"
    assert distortions("picks.fit.xml")[0]["focal"] == "8"
    assert 'n"p.jpg"' in Path("picks.fit.pto").read_text()


# --- several photos, files and lenses -------------------------------------------------------


def two_lenses() -> str:
    text = "#-hugin cropFactor=1.5\n" + image(v=50) + "#-hugin cropFactor=1.5\n" + image(v=30)
    text += points(grid(8)) + points(grid(8, b=0.01, seed=2), 1)
    Path("zoom.pto").write_text(text)
    return "zoom.pto"


def test_several_lenses_are_fitted_each_for_itself(run: Run) -> None:
    done = run("fit", two_lenses(), "--json", "--free", "b")
    assert done.status == 0
    found = json.loads(done.out)["calibrations"]
    assert [round(each["coefficients"]["b"], 2) for each in found] == [-0.02, 0.01]
    entries = distortions("zoom.fit.xml")
    assert [round(float(entry["b"]), 2) for entry in entries] == [-0.02, 0.01]
    assert float(entries[0]["focal"]) < float(entries[1]["focal"])
    shown = run("fit", "zoom.pto", "-q")
    assert "Barrel" in shown.out
    assert "Pincushion" in shown.out


def test_one_photo_is_selected(run: Run) -> None:
    done = run("fit", two_lenses(), "--json", "--image", "1", "--free", "b")
    assert round(json.loads(done.out)["coefficients"]["b"], 2) == 0.01
    before, after = (Path(f"zoom{s}.pto").read_text().splitlines() for s in ("", ".fit"))
    assert [i for i, (old, new) in enumerate(zip(before, after, strict=True)) if old != new] == [3]
    none = run("fit", "zoom.pto", "--image", "2")
    assert (none.status, none.out) == (1, "")
    assert "zoom.pto: there is no photo number 2; there are 2" in none.err


def test_the_photo_that_is_named_belongs_to_the_one_that_is_selected(run: Run) -> None:
    exif = Image.Exif()
    exif.get_ifd(0x8769).update({0x920A: 8.0})
    Image.new("L", (WIDTH, HEIGHT)).save("p.jpg", exif=exif)
    words = ("fit", two_lenses(), "--photo", "p.jpg", "--free", "b", "--json", "-o", "x.json")
    lens = json.loads(run(*words, "--image", "1").out)["observations"]["lens"]
    assert lens["focal_mm"] == 8
    whole = json.loads(run(*words).out)["calibrations"]
    assert [made["observations"]["lens"]["focal_mm"] for made in whole] == [None, None]
    assert "--image" in whole[0]["notes"][0]


def test_a_photo_is_selected_in_each_of_several_files(run: Run) -> None:
    text = Path(two_lenses()).read_text()
    Path("more.pto").write_text(image(v=9) + image(v=30) + points(grid(8, b=0.01, seed=3), 1))
    assert run("fit", "zoom.pto", "more.pto").status == 1  # these are of several lenses
    done = run("fit", "zoom.pto", "more.pto", "--image", "1", "--free", "b", "--json")
    found = json.loads(done.out)
    assert found["dof"] == 128 - 32 - 1
    assert [photo["number"] for photo in found["observations"]["photos"]] == [1, 1]
    assert Path("zoom.pto").read_text() == text


def test_several_lenses_are_not_mixed_in_a_csv(run: Run) -> None:
    done = run("convert", two_lenses(), "x.csv")
    assert (done.status, done.out) == (1, "")
    assert "zoom.pto: the lines are of 2 lenses, which a CSV cannot keep apart" in done.err
    assert "--image N" in done.err
    assert files() == ["zoom.pto"]
    assert run("convert", "zoom.pto", "x.csv", "--image", "1").status == 0
    assert run("convert", "zoom.pto", "x.pto").status == 0


def test_a_photo_without_lines_is_not_selected(run: Run) -> None:
    Path("a.pto").write_text(image() + image() + points(grid()))
    done = run("fit", "a.pto", "--image", "1")
    assert done.status == 1
    assert "photo number 1 has no straight lines" in done.err
    assert "photos with lines: 0" in done.err


@pytest.mark.parametrize("flag", ["--focal", "--focal-px"])
def test_a_fact_of_one_lens_is_not_given_to_several(run: Run, flag: str) -> None:
    done = run("fit", two_lenses(), flag, "20")
    assert done.status == 1
    assert f"{flag} is given once, but the project has 2 lenses" in done.err


def test_several_files_are_fitted_jointly(run: Run) -> None:
    first, second = csv(grid(8), "a.csv"), csv(grid(8, seed=2), "b.csv")
    done = run("fit", first, second, *SIZE, "--json", "--free", "b")
    found = json.loads(done.out)
    assert found["dof"] == 128 - 32 - 1
    assert [o["path"] for o in found["observations"]["origins"]] == ["a.csv", "b.csv"]
    assert files() == ["a.csv", "a.fit.pto", "b.csv"]


def test_a_file_named_twice_would_count_twice(run: Run) -> None:
    csv(grid())
    Path("link.csv").symlink_to("picks.csv")
    for other in ("picks.csv", "./picks.csv", "link.csv"):
        done = run("fit", "picks.csv", other, *SIZE)
        assert (done.status, done.out) == (1, "")
        assert f"{other}: this file is named twice" in done.err


# --- bad input ------------------------------------------------------------------------------


def through_the_centre() -> Lines:
    centre = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    found: Lines = {}
    for index in range(16):
        angle = np.pi * index / 16
        steps = np.linspace(-190, 190, 8)[:, None]
        made = centre + steps * np.array([np.cos(angle), np.sin(angle)])
        found[str(index)] = [(x, y) for x, y in made.tolist()]
    return found


def short_cluster() -> Lines:
    rng = np.random.default_rng(5)
    made = {str(i): np.stack((300 + np.arange(8), np.full(8, 200 + 2 * i)), -1) for i in range(16)}
    return {
        k: [(x, y) for x, y in (v + rng.normal(0, 0.1, (8, 2))).tolist()] for k, v in made.items()
    }


def test_a_missing_file(run: Run) -> None:
    done = run("fit", "none.pto")
    assert done == (
        1,
        "",
        "Error: none.pto: there is no such file.\n  check the name and the folder.\n",
    )


@pytest.mark.parametrize(
    ("content", "words", "sentence"),
    [
        (b"", (), "bad.pto: the file is empty"),
        (bytes(range(256)) * 10, (), "bad.pto: the file is binary"),
        (b"i w600 h400 f0 v5", (), "bad.pto: there is no straight line in this project"),
        (image() + "c n0 N0 x1 y1 X2\n", (), "bad.pto, row 2: the control point lacks Y"),
        (image(w=0) + points(grid()), (), "bad.pto, row 1: the image has no size"),
        ("i f0\n" + points(grid()), (), "bad.pto, row 1: the image has no size"),
        (
            image() + points({"": [(1, 1), (2, 2), (600, 3)]}),
            (),
            "bad.pto, row 4: the point (600,",
        ),
        (
            image() + points({"": [(1, 1), (2, 2), (3, -1)]}),
            (),
            "bad.pto, row 4: the point (3, -1)",
        ),
        (image(a="nan") + points(grid()), (), "bad.pto, row 1: 'nan' is not a finite number"),
        (image(v="inf") + points(grid()), (), "bad.pto, row 1: 'inf' is not a finite number"),
        (image(b="x") + points(grid()), (), "bad.pto, row 1: 'x' stands where the value of b"),
        (
            image() + "c n0 N0 x1 y1 X2 Yz t3\n",
            (),
            "bad.pto, row 2: 'z' stands where a coordinate",
        ),
        (image() + points({"": [(1, 1), (2, 2)]}), (), "bad.pto: no line with at least 3 distinct"),
        (
            image() + points({"": [(1, 1), (2, 2), (3, 4)]}),
            (),
            "bad.pto: 3 points on 1 line cannot",
        ),
        (
            image() + points(through_the_centre()),
            (),
            "bad.pto: the lines carry no information about the distortion: every line runs",
        ),
        (image() + points(short_cluster()), (), "bad.pto: the lines carry no information"),
        (image(a="=0") + points(grid()), (), "bad.pto, row 1: 'a=0' does not refer to an earlier"),
        (image(a="=1") + image() + points(grid()), (), "bad.pto, row 1: 'a=1' does not refer"),
        (image() + points(grid()), ("--hold", "a,b,c"), "bad.pto: every coefficient is held"),
        (image(f=3) + points(grid()), (), "bad.pto: the photo is marked as full-frame fisheye"),
        (image(f=2) + points(grid()), (), "bad.pto: the photo is marked as circular fisheye"),
        (image(f=4) + points(grid()), (), "bad.pto: the photo is marked as equirectangular"),
        (image(g=3) + points(grid()), (), "bad.pto: the project shears the photo (g = 3)"),
        (image() + "c n0 N0 x1 y1 X2 Y2 t0\n", (), "no straight line in this project among its 1"),
        (image() + points(grid()), ("--size", "800x400"), "bad.pto: contradictory sizes"),
        (image() + points(grid()), ("--format", "csv"), "bad.pto"),
        (image() + points(grid()), ("--photo", "none.jpg"), "none.jpg: there is no such photo"),
        (
            image() + points(grid()),
            ("--photo", "bad.pto"),
            "bad.pto: this is not a picture that can",
        ),
        (image() + points(grid()), ("--aspect-ratio", "4:3"), "the aspect ratio 1.333 contradicts"),
    ],
)
def test_bad_input_is_one_sentence_with_a_remedy(
    run: Run, content: str | bytes, words: tuple[str, ...], sentence: str
) -> None:
    Path("bad.pto").write_bytes(content if isinstance(content, bytes) else content.encode())
    done = run("fit", "bad.pto", *words)
    assert (done.status, done.out) == (1, "")
    first, second = done.err.splitlines()
    assert first.startswith("Error: ")
    assert sentence in first
    assert second.startswith("  ")
    assert "Traceback" not in done.err
    assert files() == ["bad.pto"]


def test_a_fit_that_collapses_is_refused(run: Run) -> None:
    lines = {label: picked[:4] for label, picked in list(grid(16, 8, b=-0.3, seed=3).items())[:8]}
    done = run("fit", csv(lines), *SIZE, "--model", "brown", "--free", "k1,k2,k3,p1,p2,d,e")
    assert done.status == 1
    assert done.err.startswith("Error: picks.csv: the ")
    assert files() == ["picks.csv"]


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (
            image() + "v v0 b0\n" + points(grid()),
            "the field of view (v), which straight lines do not",
        ),
        (
            image()
            + "".join(
                points({"": [p]}, first=i)
                for i, each in enumerate(grid().values(), 3)
                for p in each
            ),
            "one point on both ends",
        ),
        (image() + points(grid()) + points({"": [(9, 9), (8, 8)]}, first=30), "set aside"),
        (image() + "c n0 N0 x1 y1 X2 Y2 t1\n" + points(grid()), "1 control point of other kinds"),
        (image(a=0.5) + points(grid()), "not used: the file's a = 0.5; the fit starts at 0"),
        (image(d=3) + points(grid()), "held: the project's distortion centre d = 3 px"),
    ],
)
def test_what_is_left_aside_is_told(run: Run, text: str, note: str) -> None:
    Path("a.pto").write_text(text)
    done = run("fit", "a.pto")
    assert done.status == 0
    assert note in " ".join(done.out.split())


def test_entities_of_xml_are_not_read(run: Run) -> None:
    Path("secret").write_text("1,1;2,2;3,4")
    Path("a.xml").write_text(
        '<!DOCTYPE a [<!ENTITY x SYSTEM "secret">]><annotations><version>1.1</version>'
        '<image id="0" name="a" width="9" height="9"><polyline label="&x;" points="1,1;2,2;3,4"/>'
        "</image></annotations>"
    )
    done = run("fit", "a.xml")
    assert (done.status, done.out) == (1, "")
    assert "1,1;2,2" not in done.err
    assert files() == ["a.xml", "secret"]


def test_names_from_files_do_nothing_to_the_terminal(run: Run) -> None:
    evil = "\x1b[31m[red]bold\x07"
    lines = dict(zip([f"{evil}{i}" for i in range(16)], grid().values(), strict=True))
    Path("x.pto").write_text(image().replace("x.jpg", evil) + points(grid()))
    for done in (
        run("fit", csv(lines, "a\n\x1b[31m[x].csv"), *SIZE),
        run("fit", "none\n\x1b[31m[x].pto"),
        run("fit", "x.pto"),
        run("convert", "x.pto", "y\x1b[31m.csv"),
    ):
        assert "\x1b[31m" not in done.out + done.err
        assert "\x07" not in done.out + done.err


# --- the call itself ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("fit",),
        ("fti", "x.pto"),
        ("fit", "x.pto", "--nonsense"),
        ("fit", "x.pto", "--size", "big"),
        ("fit", "x.pto", "--size", "5"),
        ("fit", "x.pto", "--size", "0x5"),
        ("fit", "x.pto", "--start", "a"),
        ("fit", "x.pto", "--start", "a=x"),
        ("fit", "x.pto", "--start", "a=nan"),
        ("fit", "x.pto", "--start", ""),
        ("fit", "x.pto", "--free", ","),
        ("fit", "x.pto", "--image", "-1"),
        ("fit", "x.pto", "--image", "x"),
        ("fit", "x.pto", "--focal", "0"),
        ("fit", "x.pto", "--focal", "nan"),
        ("fit", "x.pto", "--crop-factor", "-1"),
        ("fit", "x.pto", "--aspect-ratio", "4:0"),
        ("fit", "x.pto", "--residual", "none"),
        ("fit", "x.pto", "--order", "spiral"),
        ("fit", "x.pto", "--grid", "3,4"),
        ("fit", "x.pto", "--grid", "1x4"),
        ("fit", "x.pto", "--pixel-aspect", "1000"),
        ("fit", "x.pto", "--bootstrap", "5"),
        ("fit", "x.pto", "--bootstrap", "10000000"),
        ("fit", "x.pto", "--format", "pdf"),
        ("fit", "x.pto", "--model", "magic"),
        ("fit", "x.pto", "--model", "radial:0"),
        ("check", "x.pto", "--model", "auto"),
        ("fit", "x.pto", "--free", "k1"),
        ("fit", "x.pto", "--hold", "q"),
        ("fit", "x.pto", "--start", "q=1"),
        ("check", "x.pto", "--free", "zz"),
        ("fit", "x.pto", "--model", "auto", "--free", "b"),
        ("fit", "x.pto", "--model", "auto", "--start", "file"),
        ("fit", "x.pto", "-o", "x.png"),
        ("fit", "x.pto", "--report", "r.pdf"),
        ("fit", "x.pto", "--plot", "nosuch.svg"),
        ("report", "x.json", "--plot", "curve.pdf"),
        ("report", "x.json", "-o", "r.pdf"),
        ("convert", "x.pto", "x.svg"),
        ("zoom", "x.json", "y.json", "-o", "z.csv"),
        ("zoom", "x.json", "y.json", "--plot", "z.pdf"),
        ("convert", "x.pto"),
        ("models", "x"),
    ],
)
def test_a_wrong_call_is_2(words: tuple[str, ...]) -> None:
    done = CliRunner().invoke(command, words)
    assert done.exit_code == 2
    assert "Usage: " in done.output
    assert "no such file" not in done.output  # it is said before anything is read


@pytest.mark.parametrize("verb", list(VERBS))
@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_every_verb_explains_itself(verb: str, flag: str) -> None:
    done = CliRunner().invoke(command, [verb, flag])
    assert done.exit_code == 0
    assert done.output.startswith("Usage: ")
    assert f"\n  plumbline {verb}" in done.output.replace("    ", "  ")
    found = command.get_command(click.Context(command), verb)
    assert found is not None
    assert found.get_short_help_str(200) == VERBS[verb]
    assert found.help is not None
    assert found.help.startswith(VERBS[verb])
    overview = CliRunner().invoke(command, [flag]).output
    assert VERBS[verb] in " ".join(overview.split())


def test_the_formats_in_the_help_are_those_there_are() -> None:
    shown = " ".join(CliRunner().invoke(command, ["fit", "--help"]).output.split())
    assert "Format of the points: " + ", ".join(POINT_FORMATS) + "." in shown


FLAGS = """
--photo --size --image --format --grid --order --model --free --hold --start --residual --maker
--lens-name --mount --focal --focal-px --crop-factor --aspect-ratio --pixel-aspect --output
--overwrite --json --verbose --quiet --help
"""


def test_flags_have_one_spelling() -> None:
    shown = CliRunner().invoke(command, ["fit", "--help"]).output
    for flag in FLAGS.split():
        assert flag in shown


def test_version() -> None:
    done = CliRunner().invoke(command, ["--version"])
    assert done.output.startswith("plumbline ")


def test_models_are_listed(run: Run) -> None:
    done = run("models")
    assert done.status == 0
    for name in MODELS:
        assert name.partition(":")[0] in done.out


# --- convert --------------------------------------------------------------------------------


def test_points_go_to_hugin_and_back(run: Run) -> None:
    lines = grid()
    done = run("convert", csv(lines), "p.pto", *SIZE)
    assert done.status == 0
    assert done.out == "Wrote p.pto: 128 points on 16 lines.\nNext: plumbline fit p.pto\n"
    assert run("convert", "p.pto", "back.csv").status == 0
    rows = [row.split(",") for row in Path("back.csv").read_text().splitlines()[1:]]
    found = sorted((float(x), float(y)) for _, x, y in rows)
    assert found == sorted(point for picked in lines.values() for point in picked)
    fits = [
        run("fit", name, *SIZE, "--json", "-o", "x.json").out
        for name in ("picks.csv", "p.pto", "back.csv")
    ]
    first, *others = (json.loads(text)["coefficients"] for text in fits)
    assert all(other == pytest.approx(first, abs=1e-9) for other in others)


def test_converting_refuses_like_fitting(run: Run) -> None:
    csv(grid())
    Path("p.csv").write_text("precious")
    for words, sentence in {
        ("none.csv", "x.pto"): "there is no such file",
        ("picks.csv", "x.pto"): "the size of the photo is not known",
        ("picks.csv", "p.csv", *SIZE): "exists and was not written by plumbline",
        ("picks.csv", "none/x.csv", *SIZE): "the folder does not exist",
        ("picks.csv", "x.csv", *SIZE, "--image", "1"): "there is no photo number 1",
    }.items():
        done = run("convert", *words)
        assert (done.status, done.out) == (1, "")
        assert sentence in done.err
    assert files() == ["p.csv", "picks.csv"]
    assert run("convert", "picks.csv", "p.csv", *SIZE, "--overwrite").status == 0


# --- as a process ---------------------------------------------------------------------------


def process(*words: str, **how: Any) -> subprocess.CompletedProcess[bytes]:
    environment = os.environ | how.pop("env", {})
    return subprocess.run(
        [sys.executable, "-m", "plumbline", *words],
        capture_output="stdout" not in how,
        check=False,
        env=environment,
        timeout=120,
        **how,
    )


def test_help_needs_neither_numpy_nor_jax() -> None:
    code = (
        "import sys; from plumbline.cli import main\n"
        "sys.argv = ['plumbline', '--help']\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "assert not {'numpy', 'jax', 'rich'} & set(sys.modules), set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_one_error_as_a_process(tmp_path: Path) -> None:
    done = process("fit", "none.pto", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, b"")
    assert done.stderr.startswith(b"Error: none.pto: there is no such file.\n  ")


@pytest.mark.parametrize(
    "environment",
    [
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        {"PYTHONIOENCODING": "ascii"},
        {"PLUMBLINE_CACHE_DIR": os.devnull},
    ],
    ids=["LANG=C", "ascii", "cache is not a folder"],
)
def test_poor_surroundings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, environment: dict[str, str]
) -> None:
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"b\xff\xe9.csv")
    csv(grid(), "picks.csv")
    Path("picks.csv").rename(name)
    done = process("fit", name, *SIZE, "--focal", "20", "--crop-factor", "1.5", env=environment)
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert os.path.exists(os.fsdecode(b"b\xff\xe9.fit.xml"))  # noqa: PTH110 - no text, as named


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_an_output_that_is_full_or_closed() -> None:
    with Path("/dev/full").open("wb") as full:
        done = process("models", stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr.startswith(b"Error: the output cannot be written: No space left")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("words", [("models",), ("check", "x.pto"), ("fit", "x.pto", "-q")])
def test_a_reader_that_has_seen_enough(tmp_path: Path, words: tuple[str, ...]) -> None:
    (tmp_path / "x.pto").write_text(image() + points(grid()))
    reading, writing = os.pipe()
    os.close(reading)
    done = process(*words, stdout=writing, stderr=subprocess.PIPE, cwd=tmp_path)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, b"")


def test_progress_leaves_nothing_where_there_is_no_terminal(tmp_path: Path) -> None:
    (tmp_path / "x.pto").write_text(image() + points(grid()))
    done = process("fit", "x.pto", "--bootstrap", "50", "--report", "x.html", cwd=tmp_path)
    assert done.returncode == 0
    assert b"\n\n" not in done.stderr
    assert not done.stderr.startswith(b"\n")


@pytest.mark.parametrize("delay", [0.4, 1.2])
def test_an_interrupt_ends_without_a_traceback(tmp_path: Path, delay: float) -> None:
    # An empty cache: compiling takes seconds, so the interrupt falls in the midst of it.
    (tmp_path / "x.pto").write_text(image() + points(grid()))
    running = subprocess.Popen(
        [sys.executable, "-m", "plumbline", "fit", "x.pto"],
        cwd=tmp_path,
        env=os.environ | {"PLUMBLINE_CACHE_DIR": str(tmp_path / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    time.sleep(delay)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=120)
    assert b"Traceback" not in err
    assert b"Abort" not in err
    # Python ends by the signal itself where it fell into code made from text; shells say 130.
    assert running.returncode in (130, -signal.SIGINT)
    assert err.endswith(b"Stopped; only the files named above were written.\n")
    assert out == b""
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "cache") == ["x.pto"]


def test_help_and_the_fit_agree_on_how_many_bootstrap_fits_make_sense() -> None:
    """The limits stand twice, since those of the fit would load JAX for a --help."""
    limits = options._BOOTSTRAP  # pyright: ignore[reportPrivateUsage]
    assert limits == (bootstrap._LEAST, bootstrap._MOST)  # pyright: ignore[reportPrivateUsage]
