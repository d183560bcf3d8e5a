"""Edges found without picks, on rendered photographs and on pictures without straight edges."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import plumbline
from plumbline.edges.find import Found
from plumbline.edges.gathering import gathered, voted_lens
from plumbline.edges.judging import borders_missing, clusters, judged
from plumbline.edges.overlay import drawn
from plumbline.edges.segments import segments
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from tests.benchmarks.finding import curves
from tests.benchmarks.snapping import across, bend, corner_error_px
from tests.render.plane import Camera, take
from tests.render.scene import Picture
from tests.render.shots import long_edges, shot
from tests.truth import TrueLens

SIZE = (1200, 800)
FRAME = plumbline.Frame(*SIZE)


@lru_cache(maxsize=1)
def found() -> tuple[Camera, Picture, Found]:
    """What is found in a photograph of a façade."""
    camera, wall = shot(1, size=SIZE)
    picture = take(camera, wall)
    return camera, picture, plumbline.find_edges(np.ascontiguousarray(picture[..., ::-1]))


def test_a_facade_tells_its_lens_without_a_hand() -> None:
    camera, _, made = found()
    assert made.verdict.vouched
    assert len(made.lines) >= 20
    error = corner_error_px(camera.view, plumbline.calibrate(made.observations))
    assert error < 2 * made.verdict.error_px < 0.4
    assert any("nobody has checked them" in note for note in made.observations.notes)


def test_what_is_found_are_the_wall_s_edges() -> None:
    camera, _, made = found()
    _, wall = shot(1, size=SIZE)
    edges = [points for _, points in long_edges(camera.view, wall, 0.1)]
    known = 0
    for line in made.lines:
        gaps = [bend(*across(points, line.points_px)) for points in edges]
        known += any(bent < 0.2 and abs(shift) < 1 for bent, shift, _ in gaps)
    assert 2 * known > len(made.lines)  # the others are of windows, which are not listed


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((10, 10), np.uint8),
        np.zeros((600, 900, 3), np.uint8),
        np.random.default_rng(0).integers(0, 255, (300, 400), dtype=np.uint8),
    ],
    ids=["ten pixels", "black", "noise"],
)
def test_a_picture_without_edges(picture: Picture) -> None:
    made = plumbline.find_edges(picture)
    assert made.lines == ()
    assert made.verdict.reason == "it shows no long straight edge"
    assert not made.verdict.vouched


def test_curves_alone_are_refused() -> None:
    assert not plumbline.find_edges(curves(SIZE)).verdict.vouched


def test_the_rim_of_a_fisheye_s_picture_does_not_vote() -> None:
    y, x = np.mgrid[:800, :1200]
    inside = np.hypot(x - 599.5, y - 399.5) < 380
    ends, _ = segments(np.where(inside, 0.6, 0.0).astype(np.float32))
    assert len(ends) == 0


@pytest.mark.parametrize("b", [-0.06, 0.03])
def test_pieces_vote_for_the_lens_and_are_gathered_into_whole_lines(b: float) -> None:
    lens = TrueLens("poly3", {"k1": b}, SIZE)
    lines = lens.lines(16, 21)
    rng = np.random.default_rng(2)
    pieces = [
        np.stack((line[:-1], line[1:]), axis=1)[rng.random(len(line) - 1) < 0.7] for line in lines
    ]
    ends = np.concatenate(pieces) + rng.normal(0, 0.3, (sum(map(len, pieces)), 2, 2))
    ends = ends[np.argsort(-np.hypot(*(ends[:, 1] - ends[:, 0]).T))]
    made = gathered(ends, voted_lens(ends, FRAME, 1.0), 1.0)
    long = [line for line in made if line.cover > 0.4 and len(line.members) >= 10]
    assert len(long) >= 12  # of 16; chance leaves some lines fewer than ten pieces


def _upright_and_level(number: int, wave_px: float, seed: int = 0) -> list[np.ndarray]:
    """Straight lines through a plain lens, that all bend in one way of their own."""
    rng = np.random.default_rng(seed)
    lines: list[np.ndarray] = []
    for index in range(number):
        along = np.linspace(30, SIZE[index % 2] - 30, 30)
        share = (along - along[0]) / np.ptp(along)
        wave = wave_px * rng.standard_normal() * np.sin(np.pi * share)
        at = 30 + (SIZE[1 - index % 2] - 60) * (index // 2) / (number // 2 - 1)
        across = at + wave + 0.02 * rng.standard_normal(30)
        pair = (along, across) if index % 2 == 0 else (across, along)
        lines.append(np.stack(pair, axis=-1))
    return lines


def test_the_quoted_error_grows_with_what_edges_bend_by_themselves() -> None:
    errors = [judged(_upright_and_level(14, wave), FRAME).error_px for wave in (0.0, 0.2, 1.0)]
    assert errors[0] < 0.1 < errors[1] < errors[2]
    assert errors[2] > 3 * errors[1]


def test_families_that_disagree_are_told_from_families_that_do_not() -> None:
    lens = TrueLens("poly3", {"k1": 0.02}, SIZE)
    rng = np.random.default_rng(3)
    lines = [line + 0.02 * rng.standard_normal(line.shape) for line in _upright_and_level(14, 0.0)]
    bent = [lens.distort(line) if index % 2 else line for index, line in enumerate(lines)]
    assert judged(lines, FRAME).error_px < 0.2
    assert judged(bent, FRAME).error_px > 2
    assert not judged(bent, FRAME).vouched


def test_neighbours_on_one_structure_are_a_cluster() -> None:
    zero = {"l1": 0.0, "l2": 0.0, "d": 0.0, "e": 0.0}
    lens = Lens(get_model("division"), FRAME, zero)
    x = np.linspace(50, 1100, 20)
    rows = [np.stack((x, np.full(20, y)), axis=-1) for y in (100.0, 110.0, 400.0, 415.0, 700.0)]
    number = clusters(rows, lens)
    assert number[0] == number[1] != number[2] == number[3] != number[4]


def test_borders_without_a_long_line() -> None:
    x = np.linspace(100, 1100, 20)
    top = np.stack((x, np.full(20, 50.0)), axis=-1)
    short = np.stack((np.linspace(500, 600, 20), np.full(20, 760.0)), axis=-1)
    assert borders_missing([top, short], FRAME) == ["bottom", "left", "right"]
    assert borders_missing([], FRAME) == ["top", "bottom", "left", "right"]


def test_the_drawing_shows_the_edges() -> None:
    _, picture, made = found()
    plain = np.ascontiguousarray(picture[..., ::-1])
    shown = drawn(plain, made.lines)
    assert shown.shape == plain.shape
    x, y = np.rint(made.lines[0].points_px[40:60]).astype(int).T
    assert np.abs(shown[y, x].astype(int) - plain[y, x]).max() > 60
    assert drawn(plain[..., 0].astype(np.uint16) * 257, ()).shape == plain.shape
