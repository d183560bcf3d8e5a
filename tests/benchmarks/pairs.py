"""How pairs are fitted: rendered pictures against their truth, and what intervals cover.

Run: python -m tests.benchmarks.pairs [fits] [rendered pairs]
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np

import plumbline
from plumbline.pairs.matching import match
from plumbline.photos.brightness import brightness
from plumbline.result.pair import observed_px
from tests.render import board, pair

NOISE_PX = 0.3


@dataclass(frozen=True)
class Row:
    """One rendered pair.

    Attributes:
        matches: How many were fitted.
        rms_px: Their residuals.
        largest_px: Largest error of the curve at the matches, but for scale and shift.
        scale_error: Of the scale.
        seconds: Time taken.
    """

    matches: int
    rms_px: float
    largest_px: float
    scale_error: float
    seconds: float


def rendered(truth: pair.Pair) -> Row:
    """Take and fit one pair."""
    pictures = pair.take(truth)
    begun = time.perf_counter()
    made = plumbline.calibrate_pair(*pictures)
    seconds = time.perf_counter() - begun
    at = observed_px(made.observations)[np.concatenate(made.kept)]
    ideal, true = made.lens.undistort(at), truth.view.undistort(at)
    one, none = np.ones(len(at)), np.zeros(len(at))
    rows = [np.stack([ideal[:, 0], one, none], 1), np.stack([ideal[:, 1], none, one], 1)]
    design = np.stack(rows, axis=1)
    best = np.linalg.lstsq(design.reshape(-1, 3), true.ravel(), rcond=None)[0]
    largest = float(np.linalg.norm(design @ best - true, axis=1).max())
    error = made.scale - truth.scale
    return Row(len(at), made.rms_after_px, largest, error, seconds)


def covered(lens: str, fits: int) -> float:
    """Share of 95 % intervals of a, b, c that hold the truth; a tenth of the matches is wrong."""
    truth = pair.Pair(lens=board.LENSES[lens])
    held: list[bool] = []
    for seed in range(fits):
        seen, corrected = pair.true_matches(truth, 400, NOISE_PX, seed)
        rng = np.random.default_rng(10_000 + seed)
        wrong = rng.random(len(seen)) < 0.1
        corrected[wrong] += rng.uniform(-200, 200, (int(wrong.sum()), 2))
        made = plumbline.calibrate_pair(points=(seen, corrected), size=truth.size)
        for name, (low, high) in made.intervals.items():
            held.append(low < truth.lens.coefficients[name] < high)
    return float(np.mean(held))


def covered_in_pictures(lens: str, pairs: int) -> float:
    """The same of small rendered pairs, matched and refined."""
    held: list[bool] = []
    for seed in range(pairs):
        truth = pair.Pair(lens=board.LENSES[lens], size=(640, 480), seed=seed)
        made = plumbline.calibrate_pair(*pair.take(truth))
        for name, (low, high) in made.intervals.items():
            held.append(low < truth.lens.coefficients[name] < high)
    return float(np.mean(held))


def main() -> None:
    """Print all."""
    fits, pairs = (int(n) for n in [*sys.argv[1:], *("300", "40")[len(sys.argv) - 1 :]])
    print("lens      matches  rms px  largest px  scale error  seconds")
    for name, lens in board.LENSES.items():
        row = rendered(pair.Pair(lens=lens))
        print(
            f"{name:8}  {row.matches:7,}  {row.rms_px:6.2f}  {row.largest_px:10.3f}  "
            f"{row.scale_error:+11.5f}  {row.seconds:7.1f}"
        )
    first, _ = pair.take(pair.Pair())
    _, other = pair.take(pair.Pair(seed=2))
    try:
        match(brightness(first), brightness(other))
    except plumbline.PairError as error:
        print(f"two scenes: {error.message}")
    for name in board.LENSES:
        print(f"{name}: {100 * covered(name, fits):.1f} % of the intervals of {fits} fits hold it")
    for name in board.LENSES:
        share = 100 * covered_in_pictures(name, pairs)
        print(f"{name}: {share:.1f} % of the intervals of {pairs} rendered pairs hold it")


if __name__ == "__main__":
    main()
