"""Picks snapped on a rendered photograph, whose edges are known in closed form."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import plumbline
from plumbline.edges.photograph import load
from plumbline.edges.rough_lens import one_coefficient, polynomial
from plumbline.photos.turning import turned_upright
from tests.benchmarks.snapping import across, bend, corner_error_px, picked
from tests.edges.drawn import SIZE, drawn, picks, step, stored
from tests.render.optics import Array
from tests.render.plane import Camera, take
from tests.render.scene import Edge
from tests.render.shots import long_edges, shot
from tests.truth import TrueLens

SMALL = (900, 600)


@lru_cache(maxsize=1)
def rendered() -> tuple[Camera, list[tuple[Edge, Array]], NDArray[Any]]:
    """A photograph of a façade (red, green, blue) and twelve of its edges."""
    camera, wall = shot(0, size=SMALL)
    camera = replace(camera, noise=1.0, quality=0, sharpening=0.0)
    edges = long_edges(camera.view, wall)
    return camera, edges[:: max(1, len(edges) // 12)], take(camera, wall)


def rough(off_px: float = 2.0) -> plumbline.Observations:
    camera, edges, _ = rendered()
    return plumbline.Observations.from_arrays(picked(edges, off_px, camera.view, 3), SMALL)


def test_rough_picks_end_on_the_edges_and_in_the_right_lens() -> None:
    camera, edges, picture = rendered()
    made = plumbline.snap(rough(), picture[..., ::-1])
    assert made.n_snapped == len(edges)
    found = [
        bend(*across(points, line.points_px))
        for (_, points), line in zip(edges, made.lines, strict=True)
    ]
    assert max(bent for bent, _, _ in found) < 0.2
    assert np.median([abs(shift) for _, shift, _ in found]) < 0.05
    before = corner_error_px(camera.view, plumbline.calibrate(rough()))
    after = corner_error_px(camera.view, plumbline.calibrate(made.observations))
    assert after < 0.1 < 0.5 < before


def test_a_line_without_an_edge_keeps_its_picks_and_the_notes_count() -> None:
    _, _, picture = rendered()
    before = rough()
    lost = replace(before.lines[0], points_px=np.array([[300.0, 300], [320, 340], [340, 380]]))
    given = replace(before, lines=(lost, *before.lines[1:]))
    made = plumbline.snap(given, picture[..., ::-1])
    assert not made.lines[0].found
    np.testing.assert_array_equal(made.observations.lines[0].points_px, lost.points_px)
    number = len(given.lines)
    assert f"{number - 1} of {number} lines snapped to the photo's edges" in made.observations.notes
    assert any(note.startswith("line 1 keeps its picks: ") for note in made.observations.notes)


def test_a_photo_of_another_size_is_refused() -> None:
    with pytest.raises(plumbline.OptionError, match="450x300 pixels, but the picks"):
        plumbline.snap(rough(), rendered()[2][::2, ::2, ::-1])


@pytest.mark.parametrize("light", [np.zeros, np.ones])
def test_a_photo_without_edges_snaps_nothing(light: Any) -> None:
    made = plumbline.snap(rough(), (255 * light(SMALL[::-1])).astype(np.uint8))
    assert made.n_snapped == 0
    assert made.observations.n_points == rough().n_points


def test_a_photo_of_ten_pixels() -> None:
    given = plumbline.Observations.from_arrays([[[1, 1], [4, 5], [9, 9]]], (10, 10))
    made = plumbline.snap(given, np.zeros((10, 10), np.uint8))
    assert made.lines[0].refusal == "the picks are less than 12 px apart"


def test_two_lenses_are_snapped_one_at_a_time() -> None:
    both = plumbline.Observations.side_by_side([rough(), rough()])
    with pytest.raises(plumbline.OptionError, match="several lenses"):
        plumbline.snap(both, rendered()[2])


def test_an_array_that_is_no_picture() -> None:
    with pytest.raises(plumbline.OptionError, match="not a picture"):
        plumbline.snap(rough(), np.zeros((600, 900, 5)))


@pytest.mark.parametrize("depth", ["uint8", "uint16"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_photos_that_exif_turns_are_seen_upright(
    depth: str, orientation: int, tmp_path: Path
) -> None:
    seen = stored(drawn(step))
    back = {1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 6: 8, 7: 7, 8: 6}[orientation]  # its inverse
    pixels = np.ascontiguousarray(turned_upright(seen, back))
    exif = Image.Exif()
    exif[0x0112] = orientation
    path = tmp_path / "turned.png"
    values = pixels if depth == "uint8" else pixels.astype(np.uint16) * 257
    Image.fromarray(values).save(path, exif=exif)
    with Image.open(path) as image:
        assert image.getexif()[0x0112] == orientation
    found = load(path, SIZE)
    np.testing.assert_array_equal(found.pixels >> (8 if depth == "uint16" else 0), seen)
    given = plumbline.Observations.from_arrays([picks(off=1.0)], SIZE)
    assert plumbline.snap(given, path).n_snapped == 1


def test_the_photo_beside_the_points_is_found(tmp_path: Path) -> None:
    Image.fromarray(stored(drawn(step))).save(tmp_path / "wall.png")
    rows = "".join(f"a,{x},{y},wall.png\n" for x, y in picks(off=1.0))
    (tmp_path / "picks.csv").write_text("line,x,y,photo\n" + rows)
    observations = plumbline.read(tmp_path / "picks.csv")
    assert plumbline.snap(observations).n_snapped == 1
    (tmp_path / "wall.png").unlink()
    with pytest.raises(plumbline.OptionError, match=r"wall\.png is not beside"):
        plumbline.snap(observations)


@pytest.mark.parametrize("l1", [-0.12, 0.06])
def test_the_rough_lens_is_right_where_the_truth_is_its_own(l1: float) -> None:
    lens = TrueLens("division", {"l1": l1, "l2": 0.0}, (1500, 1000))
    lines = lens.lines(14, 30)
    first = one_coefficient(lines, plumbline.Frame(1500, 1000))
    assert first.lens.coefficients["l1"] == pytest.approx(l1, abs=1e-5)
    assert max(polynomial(lines, first).line_rms_px) < 0.3  # the other family's own error


def test_the_rough_lens_is_not_led_astray_by_a_wrong_line() -> None:
    lens = TrueLens("ptlens", {"a": 0.01, "b": -0.06, "c": 0.0}, (1500, 1000))
    lines = lens.lines(14, 30, noise_px=0.1)
    lines[3][:15] += [0.0, 25.0]
    found = polynomial(lines, one_coefficient(lines, plumbline.Frame(1500, 1000)))
    good = [rms for number, rms in enumerate(found.line_rms_px) if number != 3]
    assert max(good) < 0.3
    assert found.line_rms_px[3] > 10 * max(good)
