"""One edge between rough picks, held against edges drawn in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from plumbline.edges.trace import Traced, condensed, trace
from plumbline.errors import OptionError
from tests.edges.drawn import SIZE, drawn, edge_y, groove, picks, step


def gap(traced: Traced) -> np.ndarray:
    """Vertical distances from the drawn edge."""
    return traced.points_px[:, 1] - edge_y(traced.points_px[:, 0])


@pytest.mark.parametrize("off", [0.0, 1.0, 3.0])
def test_a_step_is_found_to_a_hundredth_of_a_pixel(off: float) -> None:
    traced = trace(drawn(step), picks(off=off), scatter_px=max(off, 1.0))
    assert (traced.refusal, traced.kind) == ("", "rising")
    assert traced.support > 0.95
    assert np.abs(gap(traced)).max() < 0.01
    assert traced.width_px == pytest.approx(0.8, abs=0.1)


def test_a_step_the_other_way_round_and_a_steep_one() -> None:
    fallen = trace(drawn(lambda d: step(-d)), picks(off=1))
    assert (fallen.found, fallen.kind) == (True, "falling")
    steep = trace(drawn(step).T, picks(off=1)[:, ::-1])
    swapped = steep.points_px[:, ::-1]
    assert np.abs(swapped[:, 1] - edge_y(swapped[:, 0])).max() < 0.01


@pytest.mark.parametrize("blur", [0.6, 1.0, 1.6])
def test_a_groove_s_middle_is_found_whatever_the_blur(blur: float) -> None:
    traced = trace(drawn(lambda d: groove(d, 2.6, blur)), picks(off=1))
    assert (traced.refusal, traced.kind) == ("", "dark")
    assert np.abs(gap(traced)).max() < 0.01


def test_a_wire_is_a_bright_groove() -> None:
    traced = trace(drawn(lambda d: 0.9 - groove(d)), picks(off=1))
    assert (traced.refusal, traced.kind) == ("", "bright")
    assert np.abs(gap(traced)).max() < 0.01


def test_standard_errors_are_the_scatter_that_noise_makes() -> None:
    traced = trace(drawn(step, noise=0.05), picks(off=1))
    scatter = float(np.std(gap(traced)))
    assert 0.02 < scatter < 0.2
    assert float(np.median(traced.errors_px)) == pytest.approx(scatter, rel=0.3)


def test_a_chequerboard_s_edge_changes_sign() -> None:
    light = drawn(step)
    x = np.arange(SIZE[0])
    light[:, x // 60 % 2 == 1] = (0.9 - light)[:, x // 60 % 2 == 1]
    traced = trace(light, picks(off=1))
    assert (traced.refusal, traced.kind) == ("", "either")
    assert np.abs(gap(traced)).max() < 0.03


def test_an_interrupted_edge_is_one_line() -> None:
    light = drawn(step)
    for start in (80, 230, 400):
        light[:, start : start + 70] = 0.3
    traced = trace(light, picks(off=1))
    assert traced.found
    assert 0.5 < traced.support < 0.75
    assert np.abs(gap(traced)).max() < 0.05
    assert not np.any((traced.points_px[:, 0] > 90) & (traced.points_px[:, 0] < 140))


def test_another_edge_near_by_is_a_rival_and_can_be_asked_for() -> None:
    light = drawn(lambda d: step(d) + 0.2 * step(d - 6))
    near = trace(light, picks(off=0.5))
    assert np.abs(np.median(gap(near))) < 0.05
    assert len(near.rivals) >= 1
    other = trace(light, picks(off=0.5), rival=1)
    assert np.median(gap(other)) == pytest.approx(6, abs=0.1)


def test_blur_that_grows_along_the_edge_does_not_bend_it() -> None:
    x, y = np.meshgrid(np.arange(600.0), np.arange(400.0))
    blur = 0.6 + 1.2 * np.abs(x - 300) / 300
    light = (0.05 + 0.9 * step((y - edge_y(x)) / blur, 1.0)).astype(np.float32)
    assert np.abs(gap(trace(light, picks(off=1)))).max() < 0.02


@pytest.mark.parametrize(
    ("light", "reason"),
    [
        (np.zeros((400, 600), np.float32), "no edge"),
        (np.random.default_rng(0).random((400, 600), dtype=np.float32), "edge"),
        (drawn(lambda d: step(d - 40)), "no edge"),
        (np.minimum(4 * drawn(step), 1.0), "clipped"),
    ],
    ids=["black", "noise", "far", "clipped"],
)
def test_refusals_tell_the_reason(light: np.ndarray, reason: str) -> None:
    traced = trace(light, picks(off=1))
    assert reason in traced.refusal
    assert not traced.found
    assert traced.points_px.shape == (0, 2)


def test_an_edge_that_forks_is_ambiguous() -> None:
    x, y = np.meshgrid(np.arange(600.0), np.arange(400.0))
    apart = 0.012 * x
    light = 0.2 + 0.3 * step(y - edge_y(x) - apart) + 0.3 * step(y - edge_y(x) + apart)
    traced = trace(light.astype(np.float32), picks(), scatter_px=3)
    assert "either may be meant" in traced.refusal
    chosen = trace(light.astype(np.float32), picks(), scatter_px=3, choosing=True)
    assert chosen.found
    assert "either may be meant" in chosen.doubt
    assert chosen.rivals


def test_few_samples_say_what_many_said() -> None:
    traced = trace(drawn(step, noise=0.05), picks(off=1))
    few = condensed(traced, 20)
    assert len(few.points_px) == 20
    assert np.abs(gap(few)).max() < np.abs(gap(traced)).max()
    expected = np.median(traced.errors_px) / np.sqrt(len(traced.points_px) / 20)
    assert np.median(few.errors_px) == pytest.approx(expected, rel=0.2)
    assert condensed(few, 500) is few


@pytest.mark.parametrize("wrong", [[[1, 2]], [[1, 2, 3]] * 3, [[1, np.nan], [2, 3]]])
def test_picks_that_are_none(wrong: list[list[float]]) -> None:
    with pytest.raises(OptionError, match="picks"):
        trace(drawn(step), np.array(wrong, dtype=float))


def test_picks_beyond_the_photo_or_all_at_one_place_are_refused() -> None:
    beyond = trace(drawn(step), picks() + np.array([2000.0, 0.0]))
    same = trace(drawn(step), np.array([[30.0, 40.0]] * 3))
    assert beyond.refusal
    assert same.refusal
