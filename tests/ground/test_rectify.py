"""Rectifying from files: what is read, what is refused, what is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.errors import DegenerateLinesError, OptionError, PlumblineError, ReadError
from plumbline.ground.stored import (
    StoredRectification,
    read_rectification,
    rectification_json,
)
from tests.ground.files import (
    EQUIVALENT_MM,
    GROUND,
    LENS,
    SCENE,
    csv,
    edges,
    matches,
    photo,
    rectified,
    rows,
    tapes,
)
from tests.lenses.made import calibration, saved

CHECKS = np.array([[0.5, 7.0], [-1.0, 20.0], [2.0, 30.0]])


def met(found: plumbline.Rectification) -> float:
    """How far the places of independent checks are from the truth."""
    return float(np.max(np.abs(found.to_ground(SCENE.photo(CHECKS)) - CHECKS)))


def test_exact_points_give_the_exact_ground(tmp_path: Path) -> None:
    assert met(rectified(tmp_path)) < 5e-3  # EXIF's focal length, 1 % off, pulls a little


def test_the_focal_length_comes_from_exif(tmp_path: Path) -> None:
    implied = rectified(tmp_path).findings.implied
    assert implied is not None
    assert implied.told_px is not None
    diagonal = float(np.hypot(2048, 1536))
    paraxial = 1.02  # 1 − b: the gauge of the a, b, c model
    wanted = round(EQUIVALENT_MM) * diagonal / float(np.hypot(36, 24)) / paraxial
    assert implied.told_px == pytest.approx(wanted, rel=1e-6)


def test_a_focal_length_that_is_held_stays(tmp_path: Path) -> None:
    found = rectified(tmp_path, focal_px=SCENE.focal * 1.02, sigma_focal=0.0)
    assert found.camera.focal_px == pytest.approx(SCENE.focal, rel=1e-6)
    assert met(found) < 1e-4


def test_tapes_take_the_place_of_coordinates(tmp_path: Path) -> None:
    points = csv(tmp_path, "picks.csv", [(x, y, n) for x, y, _, _, n in rows(GROUND[:4])])
    six = tapes(tmp_path, ["AB", "BC", "CD", "DA", "AC", "BD"])
    found = rectified(tmp_path, points, tapes=six, focal_px=SCENE.focal * 1.02)
    # the first point at 0, 0 and the second on the X axis: here a shift, as A and B are level
    assert np.max(np.abs(found.places_m - (GROUND[:4] - GROUND[0]))) < 1e-3


def test_a_parallel_column_and_an_option_say_the_same(tmp_path: Path) -> None:
    by_option = rectified(tmp_path, lines=edges(tmp_path), parallel=(("left", "right"),))
    lines = edges(tmp_path, "line,x,y,parallel", ["lane"])
    by_column = rectified(tmp_path, lines=lines)
    assert np.allclose(by_option.covariance, by_column.covariance, rtol=1e-6, atol=1e-12)
    pick = SCENE.photo(np.array([[0.0, 25.0]]))
    plain = rectified(tmp_path).covariances(pick)
    assert np.trace(by_option.covariances(pick)[0]) < np.trace(plain[0])


def test_the_horizon_helps(tmp_path: Path) -> None:
    far = SCENE.photo(np.column_stack((np.linspace(-4e5, 4e5, 9), np.full(9, 1e6))))
    lines = csv(tmp_path, "sky.csv", [("sky", *pick) for pick in far.tolist()], "line,x,y")
    pick = SCENE.photo(np.array([[0.0, 25.0]]))
    points = matches(tmp_path, rows(np.array([[-1, 6.0], [1, 6], [1, 9], [-1, 9.5]])))
    plain = rectified(tmp_path, points)
    helped = rectified(tmp_path, points, lines=lines, horizon="sky")
    assert np.trace(helped.covariances(pick)[0]) < 0.8 * np.trace(plain.covariances(pick)[0])
    assert met(helped) < met(plain)


@pytest.mark.parametrize("names", [("b",), ("d", "e")])
def test_refined_coefficients_are_said(tmp_path: Path, names: tuple[str, ...]) -> None:
    """Well surveyed points all over a floor; usual ones do not tell the lens's centre."""
    scene = SCENE.with_(pitch=20)
    shares = [(0.02, 0.98), (0.98, 0.98), (0.98, 0.15), (0.02, 0.15), (0.5, 0.5), (0.5, 0.15)]
    shares += [(x, y) for x in (0.1, 0.3, 0.7, 0.9) for y in (0.2, 0.4, 0.6, 0.8, 0.95)]
    from tests.ground.test_camera import camera_of

    ground = camera_of(scene).ground(np.array(shares) * [2047, 1535])
    points = csv(
        tmp_path,
        "points.csv",
        [(*p, *g) for p, g in zip(scene.photo(ground).tolist(), ground.tolist(), strict=True)],
    )
    sure = {"flatness_m": 0.002, "sigma_ground_m": 0.002, "sigma_pick_px": 0.1}
    found = rectified(tmp_path, points, refine=names, **sure)
    if "d" in names:
        with pytest.raises(OptionError, match="centre well enough: ± "):
            rectified(tmp_path, points, refine=names)
    assert [name for name, _, _ in found.findings.refined] == list(names)
    truth = {"b": -0.02, "d": 0.0, "e": 0.0}
    for name, value, error in found.findings.refined:
        assert abs(value - truth[name]) < 3 * error


def test_what_the_points_do_not_tell_is_not_refined(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=r"do not determine b well enough: b = .* ± ") as error:
        rectified(tmp_path, refine=("b",))
    assert "radially" in error.value.hint


def test_four_points_are_said_to_be_checked_by_the_focal_length_alone(tmp_path: Path) -> None:
    found = rectified(tmp_path, matches(tmp_path, rows(GROUND[:4])))
    assert any("only the focal length checks them" in note for note in found.findings.notes)


def test_every_standard_error_is_printed(tmp_path: Path) -> None:
    told = {each.what: each.value for each in rectified(tmp_path).findings.settings}
    assert told["unevenness of the plane"] == "± 0.02 m"
    assert told["a pick"].startswith("± 0.5 px")
    assert told["a coordinate on the ground"] == "± 0.01 m"


def test_a_saved_rectification_reads_back(tmp_path: Path) -> None:
    found = rectified(tmp_path, tapes=tapes(tmp_path, ["AB"]))
    data = rectification_json(StoredRectification(found, "road.jpg", "0" * 64, "plumbline …"))
    path = tmp_path / "road.json"
    path.write_bytes(data)
    back = read_rectification(path)
    assert back.rectification.findings == found.findings
    assert np.array_equal(back.rectification.covariance, found.covariance)
    picks = SCENE.photo(CHECKS)
    assert np.array_equal(back.rectification.to_ground(picks), found.to_ground(picks))
    assert np.array_equal(back.rectification.covariances(picks), found.covariances(picks))
    again = StoredRectification(back.rectification, back.photo, back.photo_sha256, back.command)
    assert rectification_json(again) == data


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('"plumbline rectification"', '"something else"', "not a rectification"),
        ('"focal_px": 2', '"focal_px": -2', "must be above 0"),
        ('"covariance": [', '"covariance": [[1.0],', "does not have|is damaged"),
        ('"model": "ptlens"', '"model": "fisheye"', "damaged"),
        ('"size": [', '"size": [0,', "damaged"),
        ('"format_version": 1', '"format_version": 2', "written by a newer plumbline"),
    ],
)
def test_a_changed_rectification_is_refused(tmp_path: Path, old: str, new: str, match: str) -> None:
    data = rectification_json(StoredRectification(rectified(tmp_path), "road.jpg", "0" * 64))
    path = tmp_path / "road.json"
    assert old.encode() in data
    path.write_bytes(data.replace(old.encode(), new.encode(), 1))
    with pytest.raises(ReadError, match=match):
        read_rectification(path)


def swapped(first: int, second: int, lines: list[tuple[float, float, float, float, str]]) -> object:
    """The places of two rows exchanged."""
    made = [list(line) for line in lines]
    made[first][2:4], made[second][2:4] = made[second][2:4], made[first][2:4]
    return made


BAD_POINTS = {
    "too few": (rows()[:3], DegenerateLinesError, "3 points do not determine the plane"),
    "on one line": (
        rows(np.array([[0, 5.0], [0.5, 10], [1, 15], [3, 8]])),
        DegenerateLinesError,
        "A, B and C lie on one line",
    ),
    "crossed": (swapped(2, 3, rows()[:4]), OptionError, "crossed order.*C with D"),
    "exchanged": (swapped(0, 5, rows()), OptionError, "A with F"),
    "mirrored": (
        [(x, y, -east, north, n) for x, y, east, north, n in rows()],
        OptionError,
        "the other way round",
    ),
    "axes exchanged": (
        [(x, y, north, east, n) for x, y, east, north, n in rows()],
        OptionError,
        "the other way round",
    ),
    "beyond the horizon": (
        [*rows()[:4], (1000.0, 200.0, 0.0, 60.0, "H")],
        PlumblineError,
        "H lies .*horizon|horizon",
    ),
    "two picks": ([*rows(), (*rows()[0][:2], 9.0, 9.0, "Z")], ReadError, "same pick as A"),
    "two places": ([*rows(), (1000.0, 900.0, *rows()[1][2:4], "Z")], ReadError, "same place as B"),
    "two names": ([*rows(), (1000.0, 900.0, 1.0, 8.0, "A")], ReadError, "two points are named 'A'"),
    "outside": ([*rows(), (3000.0, 900.0, 1.0, 8.0, "Z")], OptionError, "Z at 3000, 900 lies out"),
    "no number": ([*rows(), ("ten", 900.0, 1.0, 8.0, "Z")], ReadError, "'ten' stands where"),
    "half a place": ([*rows(), (1000.0, 900.0, "", 8.0, "Z")], ReadError, "'' stands where"),
    "infinite": ([*rows(), (1000.0, 900.0, "inf", 8.0, "Z")], ReadError, "'inf' stands where"),
}


@pytest.mark.parametrize(("lines", "kind", "match"), BAD_POINTS.values(), ids=BAD_POINTS.keys())
def test_bad_points_are_refused_in_one_sentence(
    tmp_path: Path, lines: list[list[object]], kind: type[PlumblineError], match: str
) -> None:
    with pytest.raises(kind, match=match) as error:
        rectified(tmp_path, matches(tmp_path, lines))
    assert error.value.hint
    assert "\n" not in error.value.message


def test_a_cyclic_exchange_shows_by_the_focal_length(tmp_path: Path) -> None:
    """All four places moved on by one keep their order round; the camera then is absurd."""
    lines = rows(GROUND[:4])
    moved = [(x, y, *lines[(i + 1) % 4][2:4], n) for i, (x, y, _, _, n) in enumerate(lines)]
    try:
        found = rectified(tmp_path, matches(tmp_path, moved))
    except PlumblineError:
        return
    implied = found.findings.implied
    assert found.findings.contradictory or implied is None or not implied.agrees


BAD_TAPES = {
    "unknown": ([("A", "Q", 3.0)], "no point is named 'Q'"),
    "itself": ([("A", "A", 3.0)], "from A to itself"),
    "negative": ([("A", "B", -3.0)], "-3 is not a length"),
    "no number": ([("A", "B", "long")], "'long' stands where"),
    "columns": ([("A", "B")], "2 columns"),
    "triangle": ([("A", "B", 2.8), ("B", "E", 5.7), ("A", "E", 9.7)], "no triangle has the sides"),
    "empty": ([], "no tapes|empty"),
}


@pytest.mark.parametrize(("lines", "match"), BAD_TAPES.values(), ids=BAD_TAPES.keys())
def test_bad_tapes_are_refused_in_one_sentence(
    tmp_path: Path, lines: list[list[object]], match: str
) -> None:
    with pytest.raises(ReadError, match=match):
        rectified(tmp_path, tapes=csv(tmp_path, "tapes.csv", lines, "from,to,metres"))


BAD_REQUESTS = {
    "unknown line": ({"parallel": (("left", "middle"),)}, "no line is named 'middle'"),
    "one line": ({"parallel": (("left",),)}, "only line of its parallel set"),
    "two sets": ({"parallel": (("left", "right"), ("left", "right"))}, "two parallel sets"),
    "no horizon": ({"horizon": "sky"}, "no line is named 'sky'"),
    "unknown corner": ({"right_angles": (("A", "B", "Q"),)}, "no point is named Q"),
    "same corner": ({"right_angles": (("A", "B", "A"),)}, "three different points"),
    "coefficient": ({"refine": ("k1",)}, "k1 is not a coefficient"),
    "half a centre": ({"refine": ("d",)}, "together"),
    "no error": ({"flatness_m": 0.0}, "above 0"),
    "no world": ({"aerial": "aerial.png"}, "no world file aerial.pgw"),
}


@pytest.mark.parametrize(("request_", "match"), BAD_REQUESTS.values(), ids=BAD_REQUESTS.keys())
def test_bad_requests_are_refused_in_one_sentence(
    tmp_path: Path, request_: dict[str, Any], match: str
) -> None:
    lines = {"lines": edges(tmp_path)} if {"parallel", "horizon"} & set(request_) else {}
    with pytest.raises(PlumblineError, match=match):
        rectified(tmp_path, **lines, **request_)


def test_places_may_be_pixels_of_an_aerial_picture(tmp_path: Path) -> None:
    """With a rotated world file; rows of the aerial picture run down."""
    turn, metres = np.radians(30), 0.05
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    matrix = spin @ np.diag([metres, -metres])
    origin = np.array([-20.0, 30.0])
    pixels = (GROUND - origin) @ np.linalg.inv(matrix).T
    (a, b), (d, e) = matrix.tolist()
    world = "".join(f"{value!r}\n" for value in (a, d, b, e, *origin.tolist()))
    (tmp_path / "aerial.jgw").write_text(world)
    seen = SCENE.photo(GROUND).tolist()
    lines = [(*p, *q) for p, q in zip(seen, pixels.tolist(), strict=True)]
    points = csv(tmp_path, "points.csv", lines)
    found = rectified(tmp_path, points, aerial=str(tmp_path / "aerial.jpg"))
    assert met(found) < 5e-3


def test_another_photo_is_not_the_lens_s(tmp_path: Path) -> None:
    """A result calibrated at another focal length, or in pictures of another shape."""
    for made, match in (
        (calibration(size=(3000, 2000), b=-0.02), "sides are as"),
        (calibration(focal_mm=20.0, b=-0.02), "20 mm"),
    ):
        lens = saved(tmp_path / "lens.json", made)
        with pytest.raises(OptionError, match=match):
            plumbline.rectify(photo(tmp_path), matches(tmp_path), lens)


def test_the_lens_is_needed(tmp_path: Path) -> None:
    with pytest.raises(PlumblineError):
        plumbline.rectify(photo(tmp_path, exif=False), matches(tmp_path))
    assert plumbline.rectify(photo(tmp_path, exif=False), matches(tmp_path), LENS) is not None
