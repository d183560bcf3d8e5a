"""Pairs: matched points and rendered pictures against the lens that bent them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plumbline
from plumbline.errors import OptionError, PairError
from plumbline.result.pair import PairCalibration, observed_px
from tests.render import board, pair

SMALL = (1000, 750)
PLAIN = replace(board.KIT, a=0.0, b=0.0, c=0.0)


def apart_px(made: PairCalibration, truth: pair.Pair) -> np.ndarray:
    """How far the fitted lens is off the true one at the matches, but for scale and shift."""
    kept = np.concatenate(made.kept)
    at = observed_px(made.observations)[kept]
    ideal, true = made.lens.undistort(at), truth.view.undistort(at)
    one, none = np.ones(len(at)), np.zeros(len(at))
    rows = np.stack(
        [np.stack([ideal[:, 0], one, none], 1), np.stack([ideal[:, 1], none, one], 1)], axis=1
    )
    best = np.linalg.lstsq(rows.reshape(-1, 3), true.ravel(), rcond=None)[0]
    return np.linalg.norm(rows @ best - true, axis=1)


@pytest.mark.parametrize("lens", board.LENSES)
def test_matched_points_give_the_lens_back(lens: str) -> None:
    """Without noise, to rounding; a quarter of the matches are wrong by up to 200 px."""
    truth = pair.Pair(lens=board.LENSES[lens])
    seen, corrected = pair.true_matches(truth, 600, 0.0, 1)
    rng = np.random.default_rng(2)
    wrong = rng.random(len(seen)) < 0.25
    corrected[wrong] += rng.uniform(-200, 200, (int(wrong.sum()), 2))
    made = plumbline.calibrate_pair(points=(seen, corrected), size=truth.size)
    for name, value in truth.lens.coefficients.items():
        assert made.coefficients[name] == pytest.approx(value, abs=1e-6)
    assert made.scale == pytest.approx(1.05, abs=1e-7)
    assert np.concatenate(made.kept).sum() == np.count_nonzero(~wrong)


@pytest.mark.parametrize(
    ("model", "free"),
    [("ptlens", "abcde"), ("poly5", ("k1", "k2")), ("brown", ("k1", "k2", "k3"))],
)
def test_other_models_and_centres(model: str, free: tuple[str, ...]) -> None:
    truth = pair.Pair()
    points = pair.true_matches(truth, 500, 0.1, 3)
    made = plumbline.calibrate_pair(points=points, size=truth.size, model=model, free=free)
    assert set(made.free) == set(free)
    assert apart_px(made, truth).max() < 1.0
    if "d" in made.free:
        assert abs(made.coefficients["d"]) < 4 * made.standard_errors["d"]


def test_intervals_hold_the_truth() -> None:
    """Coefficients of 150 noisy sets of matches; 95 % ± 3 standard errors of such a count."""
    truth = pair.Pair(size=SMALL)
    held = []
    for seed in range(50):
        points = pair.true_matches(truth, 300, 0.3, seed)
        made = plumbline.calibrate_pair(points=points, size=truth.size)
        held += [
            low < truth.lens.coefficients[name] < high
            for name, (low, high) in made.intervals.items()
        ]
    assert 0.86 <= np.mean(held) <= 1.0


def test_two_pictures_give_the_lens(tmp_path: object) -> None:
    truth = pair.Pair()
    made = plumbline.calibrate_pair(*pair.take(truth))
    assert sum(int(kept.sum()) for kept in made.kept) >= 500
    assert apart_px(made, truth).max() < 0.1
    assert made.scale == pytest.approx(1.05, abs=2e-4)
    assert made.converged
    assert made.jackknife is not None
    assert made.displacement is not None
    assert made.rms_after_px < 0.4 < 4 < made.rms_before_px


def test_pictures_of_different_sizes() -> None:
    truth = pair.Pair(size=SMALL, corrected_size=(700, 560), scale=0.8, shift=(3.0, 4.0))
    made = plumbline.calibrate_pair(*pair.take(truth))
    assert apart_px(made, truth).max() < 0.2
    assert made.scale == pytest.approx(0.8, abs=1e-3)


def test_a_pair_reads_back(tmp_path: object) -> None:
    from pathlib import Path

    truth = pair.Pair()
    made = plumbline.calibrate_pair(points=pair.true_matches(truth, 300, 0.2, 5), size=truth.size)
    path = plumbline.write(made, Path(str(tmp_path)) / "pair.json")
    back = plumbline.read_calibration(path)
    assert isinstance(back, PairCalibration)
    assert back.coefficients == made.coefficients
    assert (back.scale, back.place_px) == (made.scale, made.place_px)
    assert back.notes == made.notes
    text = path.read_text().replace('"scale": 1.0', '"scale": 1.1')
    path.write_text(text)
    with pytest.raises(plumbline.ReadError, match="changed since it was written"):
        plumbline.read_calibration(path)


@pytest.mark.parametrize(
    ("truth", "words"),
    [
        (pair.Pair(size=SMALL, scene=77), "different scenes"),
        (pair.Pair(size=SMALL, turn=5.0), "turned by"),
        (pair.Pair(size=SMALL, lens=PLAIN), "a scale .* and a shift alone"),
    ],
)
def test_pictures_that_are_no_pair(truth: pair.Pair, words: str) -> None:
    with pytest.raises(PairError, match=words):
        plumbline.calibrate_pair(*pair.take(truth))


def test_pictures_that_are_the_same_mirrored_plain_or_covered() -> None:
    raw, corrected = pair.take(pair.Pair(size=SMALL))
    with pytest.raises(PairError, match="identical"):
        plumbline.calibrate_pair(raw, raw)
    with pytest.raises(PairError, match="mirrored"):
        plumbline.calibrate_pair(raw, np.ascontiguousarray(corrected[:, ::-1]))
    with pytest.raises(PairError, match="turned by"):
        plumbline.calibrate_pair(raw, np.ascontiguousarray(np.rot90(corrected)))
    with pytest.raises(PairError, match="too plain"):
        plumbline.calibrate_pair(np.full_like(raw, 90), corrected)
    covered = np.full_like(corrected, 120)
    covered[:300, :400] = corrected[:300, :400]
    with pytest.raises(PairError, match=r"all at the top and left, between .* not covered"):
        plumbline.calibrate_pair(raw, covered)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({}, "takes two pictures"),
        ({"points": (np.zeros((5, 2)), np.zeros((5, 2)))}, "size of the original"),
        ({"points": (np.zeros((5, 3)), np.zeros((5, 3))), "size": SMALL}, "have shape"),
        ({"points": (np.zeros((5, 2)), np.zeros((4, 2))), "size": SMALL}, "more points of one"),
        ({"points": (np.full((5, 2), 1e4), np.zeros((5, 2))), "size": SMALL}, "outside"),
        ({"points": (np.full((5, 2), np.nan), np.zeros((5, 2))), "size": SMALL}, "not finite"),
        ({"points": (np.zeros((5, 2)), np.zeros((5, 2))), "size": SMALL, "free": "q"}, "'q'"),
        ({"points": (np.zeros((5, 2)), np.zeros((5, 2))), "size": SMALL, "free": ""}, "no coeff"),
    ],
)
def test_wrong_calls(how: dict[str, object], words: str) -> None:
    with pytest.raises(OptionError, match=words):
        plumbline.calibrate_pair(**how)  # pyright: ignore[reportArgumentType]


def test_few_points_are_refused() -> None:
    truth = pair.Pair()
    seen, corrected = pair.true_matches(truth, 40, 0.1, 5)
    with pytest.raises(PairError, match="only 40 agree"):
        plumbline.calibrate_pair(points=(seen, corrected), size=truth.size)
    with pytest.raises(PairError, match="only 0 agree"):
        plumbline.calibrate_pair(points=(seen[:20], corrected[:20]), size=truth.size)
