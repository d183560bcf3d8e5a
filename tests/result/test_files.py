"""The result as JSON: exact there and back, and damaged in every way."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from scipy import stats

import plumbline
from plumbline.errors import ReadError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.result.writing import to_json
from plumbline.trust.bootstrap import Bootstrap
from plumbline.trust.suspect import Suspect
from tests.lenses.made import calibration as made_up, with_own_covariance
from tests.report.made import building, without_a_line
from tests.result.unchecked import from_json

THIRD = 1 / 3


def calibration(free: tuple[str, ...] = ("a", "b"), label: str = "t3") -> Calibration:
    """A calibration of two lines, made up number by number."""
    points = np.array([[0.1, 0.2], [100 * THIRD, 50.5], [99, 79]])
    lines = (Line(points, 0, label), Line(points + np.array([0, 0.25]), 1, "zwei, „größer“"))
    photos = (Photo((100, 80), "a.jpg", 0, 1.0, 2), Photo((100, 80), "ü b.jpg", 0, 1.0, 5))
    facts = LensFacts(
        maker="Sigma",
        model="18-35",
        camera="Canon EOS",
        mount="EF",
        focal_mm=18.1,
        crop_factor=1.6,
        crop_factor_error=0.02,
        hfov_deg=60.1,
        stored={"a": THIRD, "b": -0.1},
        requested=("a", "b"),
    )
    observations = Observations(
        photos, lines, (facts,), (), (Origin("folder/x.pto", "pto", b"i w100 h80"),)
    )
    values = {"a": 0.1 + 0.02, "b": -THIRD * 0.1, "c": 5e-324, "d": 1.5, "e": -0.0}
    size = len(free)
    return Calibration(
        observations=observations,
        lens=Lens(get_model("ptlens"), Frame(100, 80), values, 87.25),
        free=free,
        start=dict.fromkeys(values, 0.0) | {"d": 1.5},
        residual="corrected",
        covariance=np.eye(size) * 1e-5 + 1e-6 * THIRD,
        sigma_px=0.1,
        dof=1,
        residuals_px=(np.array([0.1, -0.2, np.inf]), np.array([1e-17, 0, 2])),
        rms_corrected_px=0.7,
        converged=False,
        reason="the fit stopped",
        remarks=("first note", "zweite „Notiz“"),
        kept=(np.array([True, True, False]), np.ones(3, dtype=np.bool_)),
        suspects=(
            Suspect(0, (2,), "stray", np.inf, np.inf, True, "pick 3 of line t3, „fort“"),
            Suspect(1, (0, 2), "duplicate", THIRD, 1.25, False, "picks 1 and 3"),
        ),
        robust=True,
        bootstrap=Bootstrap(90, 10, np.eye(size) * 2e-5, np.full((size, 2), THIRD)),
        command="plumbline fit x.pto --robust",
    )


def _off_straight(line: Line) -> NDArray[np.float64]:
    """Distances from the best line, by singular value decomposition."""
    centred = line.points_px - line.points_px.mean(axis=0)
    return centred @ np.linalg.svd(centred)[2][1]


def test_the_documented_names() -> None:
    found = json.loads(to_json([calibration()]))
    assert set(found) == {
        "format",
        "format_version",
        "plumbline",
        "model",
        "free",
        "residual",
        "coefficients",
        "standard_errors",
        "start",
        "covariance",
        "sigma_px",
        "dof",
        "rms_before_px",
        "rms_after_px",
        "rms_corrected_px",
        "largest_before_px",
        "largest_after_px",
        "quoted",
        "rival_px",
        "intervals",
        "displacement",
        "jackknife",
        "bootstrap",
        "bends",
        "model_error",
        "robust",
        "checks",
        "suspects",
        "command",
        "converged",
        "reason",
        "finding",
        "focal_px",
        "notes",
        "remarks",
        "lines",
        "pair",
        "observations",
    }
    assert (found["format"], found["format_version"]) == ("plumbline calibration", 1)
    assert found["coefficients"]["a"] == 0.1 + 0.02
    assert found["standard_errors"] == {
        name: pytest.approx((1e-5 + 1e-6 / 3) ** 0.5, rel=1e-14) for name in "ab"
    }
    first, second = calibration().observations.lines  # the third pick of the first is left out
    distances = np.concatenate(([0.0, 0.0], _off_straight(second)))
    assert first.points_px.shape == (3, 2)
    assert found["rms_before_px"] == pytest.approx(np.sqrt(np.mean(distances**2)), rel=1e-9)
    assert found["largest_before_px"] == pytest.approx(np.max(np.abs(distances)), rel=1e-9)
    assert found["largest_after_px"] == 2
    assert [line["label"] for line in found["lines"]] == ["t3", "zwei, „größer“"]
    t = stats.t.ppf(0.975, 1)
    for name, (low, high) in found["intervals"].items():
        error, value = found["standard_errors"][name], found["coefficients"][name]
        assert (low, high) == pytest.approx((value - t * error, value + t * error), rel=1e-9)
    bootstrap = found["bootstrap"]
    assert set(bootstrap) == {"fits", "failed", "covariance", "intervals", "largest_px"}
    assert bootstrap["intervals"] == {"a": [THIRD, THIRD], "b": [THIRD, THIRD]}
    assert (bootstrap["fits"], bootstrap["failed"]) == (90, 10)
    stray, twice = found["suspects"]
    assert stray == {
        "line": 0,
        "label": "t3",
        "picks": [2],
        "kind": "stray",
        "residual_px": None,
        "studentised": None,
        "left_out": True,
        "sentence": "pick 3 of line t3, „fort“",
    }
    assert (twice["residual_px"], twice["studentised"], twice["picks"]) == (THIRD, 1.25, [0, 2])
    assert [line["left_out"] for line in found["observations"]["lines"]] == [[2], []]
    assert found["observations"]["lines"][0]["residuals_px"] == [0.1, -0.2, None]
    assert found["observations"]["origins"] == [
        {
            "path": "folder/x.pto",
            "format": "pto",
            "sha256": hashlib.sha256(b"i w100 h80").hexdigest(),
        }
    ]
    assert (found["command"], found["robust"]) == ("plumbline fit x.pto --robust", True)
    for check in found["checks"]:
        assert set(check) == {"name", "passed", "finding", "remedy", "doubtful"}
    assert set(found["finding"]) == {"kind", "percent", "corner_px", "folds_at_px"}
    assert set(found["observations"]) == {"lens", "photos", "lines", "origins", "notes"}


def test_the_error_to_quote_is_the_one_of_the_summary() -> None:
    made = building()
    told = json.loads(to_json([made]))["displacement"]
    assert made.quoted is not None
    assert told["quote_px"] == made.quoted.worst_px
    (correction,) = [check for check in made.checks if check.name == "correction"]
    assert f"quote ±{told['quote_px']:#.2g} px" in correction.finding
    assert told["quote_at_px"] == made.quoted.total.worst_at_px.tolist()
    assert told["quote_px"] > told["largest_px"]


def test_a_line_left_out_as_a_whole_has_no_straightness() -> None:
    text = to_json([without_a_line()])
    lines = json.loads(text)["lines"]
    assert lines[4] == {
        "label": "5",
        "photo": 0,
        "n_points": 0,
        "rms_before_px": None,
        "rms_after_px": None,
        "largest_after_px": None,
        "bend_px": None,
    }
    assert all(line["rms_after_px"] < 0.5 for line in lines[:4] + lines[5:])
    assert to_json(from_json(text, "x.json")) == text


@pytest.mark.parametrize("count", [1, 2, 3])
def test_there_and_back_is_exact(count: int, tmp_path: Path) -> None:
    made = [calibration(free) for free in (("a", "b"), ("b",), ("a", "c", "e"))[:count]]
    text = to_json(made)
    back = from_json(text, "x.json")
    assert len(back) == count
    assert to_json(back) == text
    for old, new in zip(made, back, strict=True):
        assert new.coefficients == old.coefficients
        assert new.lens == old.lens
        assert new.observations.lenses == old.observations.lenses
        assert new.observations.photos == old.observations.photos
        assert (new.free, new.start, new.residual) == (old.free, old.start, old.residual)
        assert new.covariance.tolist() == old.covariance.tolist()
        assert [v.tolist() for v in new.residuals_px] == [v.tolist() for v in old.residuals_px]
        assert [v.tolist() for v in new.before_px] == [v.tolist() for v in old.before_px]
        assert [(o.path, o.format) for o in new.observations.origins] == [("folder/x.pto", "pto")]
        for one, two in zip(old.observations.lines, new.observations.lines, strict=True):
            assert one.points_px.tolist() == two.points_px.tolist()
            assert (one.label, one.photo) == (two.label, two.photo)
        assert (new.notes, new.reason, new.converged) == (old.notes, old.reason, old.converged)
        assert (new.sigma_px, new.dof) == (old.sigma_px, old.dof)
        assert [v.tolist() for v in new.kept] == [v.tolist() for v in old.kept]
        assert new.suspects == old.suspects
        assert (new.robust, new.command, new.version) == (True, old.command, old.version)
        assert new.bootstrap is not None
        assert old.bootstrap is not None
        assert new.bootstrap.covariance.tolist() == old.bootstrap.covariance.tolist()
        assert new.bootstrap.intervals.tolist() == old.bootstrap.intervals.tolist()
        assert (new.bootstrap.fits, new.bootstrap.failed) == (90, 10)
        assert [o.sha256 for o in new.observations.origins] == [
            o.sha256 for o in old.observations.origins
        ]
    path = plumbline.write(made, tmp_path / "x.json")
    back = from_json(path.read_text(encoding="utf-8"), str(path))
    assert back[0].coefficients == made[0].coefficients


def test_one_calibration_of_a_file_of_several_is_not_chosen_silently(tmp_path: Path) -> None:
    made = with_own_covariance(made_up(b=-0.02))
    path = plumbline.write([made, made], tmp_path / "x.json")
    with pytest.raises(ReadError, match="holds 2 calibrations") as caught:
        plumbline.read_calibration(path)
    assert "read_calibrations" in caught.value.hint
    assert len(plumbline.read_calibrations(path)) == 2
    one = plumbline.write(made, tmp_path / "y.json")
    assert plumbline.read_calibration(one).model == "ptlens"


def test_a_calibration_that_was_edited_is_not_read(tmp_path: Path) -> None:
    path = plumbline.write(with_own_covariance(made_up(b=-0.02)), tmp_path / "x.json")
    path.write_text(path.read_text().replace("-0.02", "-0.03"))
    with pytest.raises(ReadError, match="was changed since it was written"):
        plumbline.read_calibration(path)


def test_names_that_are_no_text_survive() -> None:
    made = calibration(label="caf\udce9")
    text = to_json([made])
    assert text.encode("utf-8")
    assert from_json(text, "x")[0].observations.lines[0].label == "caf\udce9"


# --- damage ---------------------------------------------------------------------------------

WHOLE: dict[str, Any] = json.loads(to_json([calibration()]))
SEVERAL: dict[str, Any] = json.loads(to_json([calibration(), calibration(("c",))]))
# Derived from the rest, and there only for other programs to read.
DERIVED = {
    "plumbline",
    "standard_errors",
    "rms_before_px",
    "rms_after_px",
    "largest_before_px",
    "largest_after_px",
    "finding",
    "lines",
    "notes",
    "before_px",
    "intervals",
    "displacement",
    "jackknife",
    "model_error",
    "checks",
    "largest_px",
    "label",
}


def places(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths to every value of a JSON text."""
    if isinstance(node, dict | list):
        items = node.items() if isinstance(node, dict) else enumerate(node)
        for key, value in items:
            if key not in DERIVED or (key in ("lines", "notes") and path):
                yield (*path, key)
                yield from places(value, (*path, key))


def parent(whole: Any, path: tuple[Any, ...]) -> Any:
    for key in path[:-1]:
        whole = whole[key]
    return whole


def damaged(whole: Any) -> ReadError | None:
    """The error that comes out, after everything that was read was also used."""
    try:
        for made in from_json(json.dumps(whole), "x.json"):
            assert made.lines
            assert made.standard_errors.keys() == set(made.free)
            assert made.finding
            assert to_json([made])
    except ReadError as error:
        return error
    return None


REPLACEMENTS: list[Any] = [
    None,
    "",
    "text",
    -1,
    0,
    1e308,
    10**400,
    True,
    [],
    {},
    [[]],
    [None],
    {"a": 1},
    float("nan"),
    float("inf"),
]


LATER = (
    *("exif_make", "exif_model", "suspects", "robust", "bootstrap", "command"),
    *("left_out", "sha256", "taken", "serial", "corrected_px", "pair", "quoted", "rival_px"),
    *("bends", "bend_px"),
)


@pytest.mark.parametrize("path", list(places(WHOLE)), ids=lambda path: ".".join(map(str, path)))
def test_every_value_deleted_or_replaced(path: tuple[Any, ...]) -> None:
    whole = copy.deepcopy(WHOLE)
    del parent(whole, path)[path[-1]]
    error = damaged(whole)
    later = path[-1] in LATER  # older files lack them
    unknown = "lens" in path[:-1]  # what is not known of a lens may be absent
    if isinstance(path[-1], str) and not unknown and not later:
        assert error is not None
    assert error is None or (error.message.startswith("x.json: ") and error.hint)
    for value in REPLACEMENTS:
        whole = copy.deepcopy(WHOLE)
        parent(whole, path)[path[-1]] = value
        error = damaged(whole)
        assert error is None or (error.message.startswith("x.json: ") and error.hint)
        if value != value or value == float("inf"):
            assert error is not None


@given(data=st.data())
def test_several_values_replaced_at_once(data: st.DataObject) -> None:
    whole = copy.deepcopy(data.draw(st.sampled_from([WHOLE, SEVERAL])))
    for _ in range(data.draw(st.integers(1, 4))):
        every = list(places(whole))
        if not every:
            break
        path = data.draw(st.sampled_from(every))
        value = data.draw(st.sampled_from(REPLACEMENTS))
        parent(whole, path)[path[-1]] = copy.deepcopy(value)
    error = damaged(whole)
    assert error is None or error.hint


HEAD = '{"format": "plumbline calibration", "format_version": 1, "plumbline": "9.9",'


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "damaged"),
        ("{", "damaged"),
        ("[" * 100_000, "nested too deeply"),
        ("[]", "not a calibration written by plumbline"),
        ("null", "not a calibration written by plumbline"),
        ('{"format": "other"}', "not a calibration written by plumbline"),
        ('{"format": "plumbline calibration"}', "'format_version' is missing"),
        (f'{HEAD.replace("1,", "2,")} "model": 1}}', "by plumbline 9.9, which is newer"),
        (f'{HEAD} "x": 1}}', "'model' is missing"),
        (f'{HEAD} "calibrations": 5}}', "calibrations should be a list, not a whole number"),
        (f'{HEAD} "calibrations": []}}', "calibrations should be a list of length >= 1"),
        (f'{HEAD} "calibrations": [5]}}', "calibrations[0] should be a group of names and values"),
    ],
)
def test_other_texts(text: str, sentence: str) -> None:
    with pytest.raises(ReadError, match=r"^x\.json(, row 1)?: ") as caught:
        from_json(text, "x.json")
    assert sentence in caught.value.message
    assert caught.value.hint


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("sigma_px", "text"),
        ("sigma_px", None),
        ("covariance", "text"),
        ("covariance", [[1.0, 2.0], [3.0]]),
        ("observations.lines.0.photo", "x"),
        ("observations.photos.0.size", [1, 2, 3]),
        ("observations.lens", 5),
        ("observations", []),
        ("start", "text"),
        ("suspects.0.line", 99),
        ("free", None),
    ],
)
def test_damage_is_told_without_the_words_of_python(path: str, value: Any) -> None:
    error = damaged(change(path, value))
    assert error is not None
    jargon = "float|int|str|tuple|dict|NoneType|object|index|indices|unpack|attribute|iterable|key"
    assert not re.search(rf"\b({jargon})\b|shape \(|array element", error.message)


def test_a_text_that_breaks_off_is_told_with_its_row() -> None:
    with pytest.raises(ReadError, match="the file is damaged: its text is not JSON from here on"):
        from_json('{\n"format": ', "x.json")


def test_every_truncation() -> None:
    text = to_json([calibration()]).rstrip()
    for end in range(0, len(text), 7):
        with pytest.raises(ReadError):
            from_json(text[:end], "x.json")


def change(path: str, value: Any) -> dict[str, Any]:
    whole = copy.deepcopy(WHOLE)
    keys: list[Any] = [int(key) if key.isdigit() else key for key in path.split(".")]
    parent(whole, tuple(keys))[keys[-1]] = value
    return whole


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("free", ["a"]),
        ("free", ["a", "a"]),
        ("free", ["a", "k1"]),
        ("model", "nonsense"),
        ("model", "poly3"),
        ("residual", "none"),
        ("converged", "false"),
        ("covariance.0.0", -1.0),
        ("start", {"a": 0.0}),
        ("observations.lines.0.photo", 2),
        ("observations.lines.0.photo", -1),
        ("observations.lines.0.points_px", [[1, 1], [2, 2]]),
        ("observations.lines.0.points_px", [[1, 1], [1, 1], [2, 2]]),
        ("observations.lines.0.points_px.0", [-50, 0]),
        ("observations.lines.0.residuals_px", [0.5, 0.5]),
        ("observations.photos.0.size", [0, 80]),
        ("observations.photos", []),
        ("observations.lines.0.residuals_px", [0.5, 0.5, float("inf")]),
        ("observations.lines.0.residuals_px", [None, 0.5, 0.5]),
        ("observations.lines.0.left_out", [3]),
        ("observations.lines.0.left_out", [-1]),
        ("observations.lines.0.left_out", ["x"]),
        ("observations.lines.0.left_out", 2),
        ("dof", 0),
        ("dof", -3),
        ("sigma_px", -0.1),
        ("suspects.0.line", 2),
        ("suspects.0.line", -1),
        ("suspects.0.picks", [3]),
        ("suspects.0.picks", [-1]),
        ("suspects.0.picks", []),
        ("suspects.0.picks", "2"),
        ("suspects.0.kind", "nonsense"),
        ("suspects.0.kind", ["stray"]),
        ("suspects.0.left_out", "no"),
        ("suspects", {"line": 0}),
        ("robust", "no"),
        ("bootstrap.covariance", [[1.0]]),
        ("bootstrap.covariance.0.0", -1.0),
        ("bootstrap.intervals", {"a": [0, 1]}),
        ("bootstrap.intervals.a", [0, 1, 2]),
        ("bootstrap.fits", -1),
        ("bootstrap.failed", -1),
        ("bootstrap", 7),
    ],
)
def test_contradictions_are_found(path: str, value: Any) -> None:
    error = damaged(change(path, value))
    assert error is not None
    assert "damaged" in error.message
    assert error.hint


def test_a_calibration_that_was_read_is_not_mixed_up_with_its_project(tmp_path: Path) -> None:
    made = replace(calibration(), remarks=(), converged=True)
    path = plumbline.write(made, tmp_path / "x.json")
    (back,) = from_json(path.read_text(encoding="utf-8"), str(path))
    # The project's bytes are not in the JSON: a new project is written.
    project = plumbline.write(back, tmp_path / "y.pto").read_text()
    assert "# made by plumbline" in project
    assert project.count("\nc n") == 6
