"""Plumbline's own JSON: what is written is read back, and a result's points are read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.errors import PlumblineError, ReadError
from plumbline.formats.base import Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts

RNG = np.random.default_rng(3)
LINES = tuple(
    Line(
        np.column_stack(
            [
                np.linspace(20, 780, 9),
                y + ((np.linspace(-1, 1, 9)) ** 2) * (y - 300) / 60 + RNG.normal(0, 0.2, 9),
            ]
        ),
        photo,
        label,
    )
    for y, photo, label in ((20.0, 0, "eaves"), (500.5, 0, "kerb"), (550, 1, "eaves"), (40, 1, "é"))
)
FACTS = LensFacts(
    maker="Müller", focal_mm=9.2, crop_factor=4.843, stored={"a": 0.03}, requested=("a", "b")
)
WHOLE = Observations(
    (
        Photo((800, 600), "a.jpg", pixel_aspect=1.25),
        Photo((800, 600), "b.jpg", 1, 1.25, 1),
    ),
    LINES,
    (FACTS, LensFacts(projection="circular fisheye")),
    ("a note",),
    (Origin("picks.csv", "csv", b"line,x,y"),),
)


def read(content: bytes | dict[str, Any]) -> Observations:
    data = content if isinstance(content, bytes) else json.dumps(content).encode()
    source = Source("points.json", data)
    assert FORMATS["json"].recognises(source)
    return FORMATS["json"].read(source)


def test_what_is_written_is_read_back() -> None:
    back = read(FORMATS["json"].write(WHOLE))
    assert [(p.name, p.size, p.lens, p.pixel_aspect) for p in back.photos] == [
        (p.name, p.size, p.lens, p.pixel_aspect) for p in WHOLE.photos
    ]
    assert back.lenses == WHOLE.lenses
    for line, again in zip(WHOLE.lines, back.lines, strict=True):
        assert again.points_px.tobytes() == line.points_px.tobytes()
        assert (again.label, again.photo) == (line.label, line.photo)
    checksum = WHOLE.origins[0].sha256
    assert back.notes == ("a note", f"the points were read from picks.csv (SHA-256 {checksum})")


def test_the_points_of_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    arrays = [line.points_px for line in LINES[:2]]
    arrays.append(np.column_stack([arrays[0][::-1, 1] * 0.5 + 5, np.linspace(30, 570, 9)]))
    first = plumbline.calibrate(Observations.from_arrays(arrays, (800, 600)), free=("b",))
    plumbline.write(first, "r.json")
    again = plumbline.calibrate(plumbline.read("r.json"), free=("b",))
    assert again.coefficients == pytest.approx(first.coefficients, rel=1e-9)
    assert again.standard_errors == pytest.approx(first.standard_errors, rel=1e-9)
    plumbline.write_points(plumbline.read("r.json"), "p.json")
    assert plumbline.read("p.json").n_points == 27
    plumbline.write_points(plumbline.read("r.json"), "p.json")  # its own file, replaced
    plumbline.write_points(plumbline.read("r.json"), "p.csv")
    assert plumbline.read("p.csv", size=(800, 600)).n_points == 27


def test_left_out_picks_are_read_and_told() -> None:
    content = json.loads(FORMATS["json"].write(WHOLE))
    content["format"] = "plumbline calibration"
    content["observations"]["lines"][0]["left_out"] = [1, 2]
    back = read(content)
    assert len(back.lines[0].points_px) == 9
    assert "2 picks that the result left out are taken again" in back.notes


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("lines", 0, "photo"), 2, "observations.lines[0].photo is 2, and there are 2"),
        (("lines", 0, "photo"), 0.5, "lines[0].photo"),
        (("lines", 1, "points_px", 3), [1], "lines[1].points_px[3] is not an x and a y"),
        (("lines", 1, "points_px", 3, 0), "x", "lines[1].points_px[3] is 'x' where a number"),
        (("lines", 1, "points_px", 3, 0), 1e200, "lines[1].points_px[3] is impossibly large"),
        (("lines",), [], "holds no line"),
        (("photos", 0, "size"), [1, 2, 3], "photos[0].size"),
        (("photos", 0, "size"), [-1, 2], "impossible"),
        (("photos", 1, "lens"), 7, "photos[1].lens is 7"),
        (("lenses", 0, "focal_mm"), -1, "lenses[0].focal_mm is not above zero"),
        (("lenses", 0, "stored"), [], "lenses[0].stored is a list"),
        (("lenses",), [], "photos[0].lens is 0, and there are 0"),
    ],
)
def test_damage_names_the_place(place: tuple[Any, ...], value: object, message: str) -> None:
    content = json.loads(FORMATS["json"].write(WHOLE))
    inner: Any = content["observations"]
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    with pytest.raises(PlumblineError) as caught:
        read(content)
    assert message in caught.value.message
    assert caught.value.hint


def test_names_of_later_versions_are_passed_over() -> None:
    content = json.loads(FORMATS["json"].write(WHOLE))
    content["new"] = 1
    content["observations"]["lines"][0]["weights"] = [1] * 9
    assert read(content).n_points == WHOLE.n_points
    content["format_version"] = 2
    with pytest.raises(ReadError, match="written by a newer plumbline"):
        read(content)
