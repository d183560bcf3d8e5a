"""Edges found without picks on rendered photographs: which are vouched for, and is that honest?

    python -m tests.benchmarks.finding                  30 photographs
    python -m tests.benchmarks.finding --photos 5

Photographs of `tests.render.shots` that no other benchmark uses, and one of curves alone. A row has
the edges found; the error that is quoted; the true largest error of the lens fitted to them over
the photograph, after the best common scale and translation; both as a ratio; the processor's time;
and why the photograph was not vouched for.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import cv2
import numpy as np

import plumbline
from tests.benchmarks.snapping import corner_error_px
from tests.render.plane import take
from tests.render.scene import Picture
from tests.render.shots import shot

FIRST = 200


@dataclass(frozen=True)
class Row:
    """What was found in one photograph."""

    number: int
    what: str
    edges: int
    vouched: bool
    quoted_px: float
    error_px: float
    seconds: float
    reason: str


def row(number: int, size: tuple[int, int]) -> Row:
    """Find the edges of one photograph, and fit them."""
    camera, wall = shot(FIRST + number, size=size)
    picture = np.ascontiguousarray(take(camera, wall)[..., ::-1])
    start = time.process_time()
    found = plumbline.find_edges(picture)
    seconds = time.process_time() - start
    try:
        made = plumbline.calibrate(found.observations)
        error = corner_error_px(camera.view, made)
    except plumbline.PlumblineError:
        error = np.inf
    return Row(
        number,
        f"{camera.view.lens.lens[-14:]:14} {camera.view.width}x{camera.view.height}",
        len(found.lines),
        found.verdict.vouched,
        found.verdict.error_px,
        error,
        seconds,
        found.verdict.reason,
    )


def curves(size: tuple[int, int], seed: int = 0) -> Picture:
    """Return a picture of arcs alone, as of arches, cables and pipes."""
    rng = np.random.default_rng(seed)
    width, height = size
    picture = np.full((height, width, 3), 150, np.uint8)
    for _ in range(40):
        centre = (int(rng.uniform(-0.3, 1.3) * width), int(rng.uniform(-0.3, 1.3) * height))
        radius = int(rng.uniform(0.25, 0.9) * width)
        colour = tuple(int(value) for value in rng.integers(20, 240, 3))
        cv2.circle(picture, centre, radius, colour, int(rng.integers(2, 12)), cv2.LINE_AA)
    blurred = cv2.GaussianBlur(picture, (0, 0), 0.8)
    noisy = blurred + rng.normal(0, 1.5, picture.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


HEADER = (
    f"{'photograph':32} {'edges':>5} {'vouched':>7} {'quoted':>8} {'true':>8} {'ratio':>6} "
    f"{'s':>5}  reason"
)


def shown(one: Row) -> str:
    """Return a row of the table."""
    ratio = one.error_px / one.quoted_px
    return (
        f"{one.number:3} {one.what:28} {one.edges:5} {'yes' if one.vouched else 'no':>7} "
        f"{one.quoted_px:8.3f} {one.error_px:8.3f} {ratio:6.2f} {one.seconds:5.1f}  {one.reason}"
    )


def summed_up(rows: list[Row]) -> list[str]:
    """Return the sentences under the table."""
    vouched = [one for one in rows if one.vouched]
    told = [f"{len(vouched)} of {len(rows)} vouched for (at least 2 of 3)"]
    if vouched:
        errors = [one.error_px for one in vouched]
        held = np.mean([one.error_px <= 2 * one.quoted_px for one in vouched])
        told.append(
            f"of these {100 * held:.0f} % within twice the quoted error (at least 95: "
            f"{'met' if held >= 0.95 else 'NOT MET'}); error: median {np.median(errors):.3f} px "
            f"(at most 0.1: {'met' if np.median(errors) <= 0.1 else 'NOT MET'}), worst "
            f"{np.max(errors):.3f} px"
        )
    return told


def main() -> None:
    """Run the photographs and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--photos", type=int, default=30)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--width", type=int, default=1500)
    chosen = parser.parse_args()
    size = (chosen.width, 2 * chosen.width // 3)
    print(HEADER)
    rows: list[Row] = []
    for number in range(chosen.first, chosen.first + chosen.photos):
        rows.append(row(number, size))
        print(shown(rows[-1]), flush=True)
    print("\n".join(summed_up(rows)))
    verdict = plumbline.find_edges(curves(size)).verdict
    print(
        "curves alone:",
        f"NOT MET, vouched for to {verdict.error_px:.2f} px"
        if verdict.vouched
        else f"refused, {verdict.reason}",
    )


if __name__ == "__main__":
    main()
