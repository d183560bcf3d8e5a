"""The one door to results: what was edited is refused by every reader, and old files still read."""

from __future__ import annotations

import ast
import copy
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.errors import ReadError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.lenses.stored_files import stored_lenses
from plumbline.result.files import consistent_results
from plumbline.result.writing import to_json
from plumbline.writing.files import export_file
from plumbline.writing.zoom import read_zoom_lens
from tests.truth import scale

PACKAGE = Path(plumbline.__file__).parent
SIZE = (3000, 2000)


def picked() -> plumbline.Observations:
    """Twelve lines bent by ptlens b = -0.03, with picks that err by a third of a pixel."""
    rng = np.random.default_rng(11)
    t = np.linspace(0.04, 0.96, 9)
    flat = [np.column_stack((t * 2999, np.full(9, y))) for y in np.linspace(80, 1900, 6)]
    upright = [np.column_stack((np.full(9, x), t * 1999)) for x in np.linspace(90, 2900, 6)]
    middle = np.array([1499.5, 999.5])
    lines: list[Any] = []
    for ideal in (*flat, *upright):
        away = (ideal - middle) / 1000
        bent = away * scale("poly3", {"k1": -0.03}, np.hypot(*away.T))[:, None] * 1000 + middle
        lines.append(bent + rng.normal(0, 0.33, bent.shape))
    return plumbline.Observations.from_arrays(lines, size=SIZE)


@pytest.fixture(scope="module")
def text() -> str:
    return to_json([plumbline.calibrate(picked(), free=("b", "c"))])


def edited(text: str, path: str, change: Callable[[Any], Any]) -> str:
    whole = json.loads(text)
    *above, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    at = whole
    for key in above:
        at = at[key]
    at[last] = change(at[last])
    return json.dumps(whole)


FIGURES = [
    "coefficients.b",
    "coefficients.d",
    "sigma_px",
    "dof",
    "covariance.0.0",
    "covariance.1.1",
    "standard_errors.b",
    "intervals.c.0",
    "rms_before_px",
    "rms_after_px",
    "rms_corrected_px",
    "largest_before_px",
    "largest_after_px",
    "finding.percent",
    "finding.corner_px",
    "lines.3.rms_after_px",
    "lines.3.n_points",
    "displacement.quote_px",
    "displacement.largest_px",
    "displacement.errors_px.5",
    "jackknife.covariance.0.0",
    "jackknife.dof",
    "model_error.largest_px",
    "observations.lines.2.points_px.4.0",
    "observations.lines.2.points_px.4.1",
    "observations.lines.2.before_px.4",
    "observations.lines.2.residuals_px.4",
]


@pytest.mark.parametrize("path", FIGURES)
def test_an_edited_figure_is_refused(text: str, path: str) -> None:
    assert consistent_results(text, "x.json")
    changed = edited(text, path, lambda value: value * 2 if isinstance(value, int) else value + 0.5)
    with pytest.raises(ReadError, match="was changed since it was written") as caught:
        consistent_results(changed, "x.json")
    assert "plumbline fit" in caught.value.hint
    derived = path.partition(".")[0] in ("lines", "displacement", "intervals", "finding")
    if derived:
        *above, last = path.split(".")
        named = ".".join(above).replace(".3", "[3]")
        place = f"{named}[{last}]" if last.isdigit() else f"{named}.{last}"
        assert place in caught.value.message


def test_another_kind_of_distortion_is_refused(text: str) -> None:
    with pytest.raises(ReadError, match=r"finding\.kind"):
        consistent_results(edited(text, "finding.kind", lambda _: "pincushion"), "x.json")


def read_by_python(path: str) -> object:
    return plumbline.read_calibration(path)


def read_as_a_lens(path: str) -> object:
    return stored_lenses(Source(path, read_bytes(path)))


def read_by_export(path: str) -> object:
    return export_file(path, "imagemagick", None, None, {})


def read_by_export_as_it_is(path: str) -> object:
    return export_file(path, "json", None, None, {})


def read_by_zoom(path: str) -> object:
    return read_zoom_lens([path], "linear", 3, {})


READERS = [read_by_python, read_as_a_lens, read_by_export, read_by_export_as_it_is, read_by_zoom]


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("path", ["coefficients.b", "covariance.0.0", "rms_after_px"])
def test_every_reader_comes_through_the_door(
    text: str, reader: Callable[[str], object], path: str, tmp_path: Path
) -> None:
    file = tmp_path / "x.json"
    file.write_text(edited(text, path, lambda value: value + 0.5))
    with pytest.raises(ReadError, match="was changed since it was written"):
        reader(str(file))


def test_there_is_no_second_door() -> None:
    inner = {"calibration_of", "read_records"}
    users = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and inner & {alias.name for alias in node.names}
    }
    assert users == {"result/files.py"}


def test_every_model_and_residual_comes_through() -> None:
    observations = picked()
    for model in plumbline.MODELS:
        name = "radial:2,4" if model == "radial" else model
        focal = {"focal_px": 3000.0} if model in ("opencv", "acm") else {}
        lines = [line.points_px for line in observations.lines]
        known = plumbline.Observations.from_arrays(lines, size=SIZE, **focal)  # pyright: ignore[reportArgumentType]
        for residual in ("image", "corrected"):
            made = plumbline.calibrate(known, model=name, residual=residual)
            assert consistent_results(to_json([made]), "x.json")[0].free == made.free


def test_a_file_of_the_first_days_still_reads(text: str) -> None:
    whole = json.loads(text)
    later = ("intervals", "displacement", "jackknife", "model_error", "checks", "bootstrap")
    for name in (*later, "suspects", "robust", "command", "lines", "finding", "notes"):
        del whole[name]
    for line in whole["observations"]["lines"]:
        del line["left_out"], line["before_px"]
    for name in ("exif_make", "exif_model"):
        del whole["observations"]["lens"][name]
    (back,) = consistent_results(json.dumps(whole), "x.json")
    (new,) = consistent_results(text, "x.json")
    assert back.coefficients == new.coefficients
    assert back.checks == new.checks


def test_names_of_later_versions_are_passed_over(text: str) -> None:
    whole = json.loads(text)
    later = copy.deepcopy(whole) | {"plumbline": "99.1", "new": {"deep": [1]}}
    later["observations"]["lens"]["colour"] = "black"
    later["observations"]["lines"][0]["edge"] = [0.1]
    later["jackknife"]["covariance"] = [[1.0, 0.0], [0.0, 1.0]]  # computed better there, perhaps
    (back,) = consistent_results(json.dumps(later), "x.json")
    assert back.version == "99.1"
    with pytest.raises(ReadError, match=r"written by plumbline 99\.1, which is newer") as caught:
        consistent_results(json.dumps(later | {"format_version": 2}), "x.json")
    assert caught.value.hint == "update plumbline"


def test_errors_name_the_place_in_the_file(text: str) -> None:
    cases = [
        ("observations.lines.2.photo", "x", "observations.lines[2].photo should be a whole number"),
        ("observations.lines.2.points_px.4", [1.0], "observations.lines[2].points_px[4] should be"),
        ("observations.lens.focal_mm", "9,2", "observations.lens.focal_mm should be a number"),
        ("observations.lens.crop_factor", 1e200, "observations.lens.crop_factor is a number out"),
        ("sigma_px", -1.0, "sigma_px should be a number >= 0"),
    ]
    for path, value, sentence in cases:
        with pytest.raises(ReadError) as caught:
            consistent_results(edited(text, path, lambda _, v=value: v), "x.json")
        assert sentence in caught.value.message


def test_help_loads_no_schema() -> None:
    code = (
        "import sys; sys.argv = ['plumbline', '--help']\n"
        "from plumbline.cli import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print([name for name in ('msgspec', 'numpy', 'jax') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
