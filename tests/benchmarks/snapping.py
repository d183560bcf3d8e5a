"""Picks snapped on rendered photographs: how near the edge, how many refused, what lens follows.

    python -m tests.benchmarks.snapping                  60 photographs, picks off by 2 px
    python -m tests.benchmarks.snapping --photos 6 --off 4

Each photograph shows every long edge of a façade by another lens, with another blur, noise and
compression (`tests.render.shots`); six picks along each are off by so many pixels. A row has the
lines that were refused, those that follow another edge of the wall (more than 1 px away on the
whole: harmless, if straight), those that bend by more than 0.3 px; the median of the bends and of
the shifts; the scatter of samples over the Cramér–Rao bound of a step with the photograph's
contrast, blur and noise (photographs without compression and sharpening only); and the largest
error of the fitted lens over the photograph with plain picks and with snapped ones, after the best
common scale and translation.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

import plumbline
from plumbline.edges.trace import Traced
from tests.render.optics import Array, View
from tests.render.plane import Camera, encoded, linear_light, take
from tests.render.scene import Edge, Picture
from tests.render.shots import long_edges, shot
from tests.truth import grid_px, unlike_px

PICKS = 6
BENT_PX = 0.3
PARALLEL_PX = 1.0
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Row:
    """What became of one photograph's lines."""

    number: int
    what: str
    lines: int
    refused: int
    parallel: int
    bent: int
    bend_px: float
    shift_px: float
    scatter: float
    corner_before_px: float
    corner_px: float
    quoted_px: float
    reasons: tuple[str, ...]


def picked(edges: list[tuple[Edge, Array]], off_px: float, view: View, seed: int) -> list[Array]:
    """Return rough picks along edges, off by a normal error in x and in y."""
    rng = np.random.default_rng([77, seed])
    last = np.array([view.width, view.height]) - 1.0
    found: list[Array] = []
    for _, points in edges:
        at = np.linspace(0.01, 0.99, PICKS) + rng.uniform(-0.06, 0.06, PICKS)
        chosen = points[(np.clip(at, 0, 1) * (len(points) - 1)).astype(int)]
        found.append(np.clip(chosen + rng.normal(0, off_px, chosen.shape), 0, last))
    return found


def across(points: Array, traced_px: Array) -> tuple[Array, Array]:
    """Return places along a true edge and signed distances from it of traced points."""
    nearest = np.argmin(
        np.hypot(*(traced_px[:, None] - points[None, ::4]).transpose(2, 0, 1)), axis=1
    )
    at = np.clip(4 * nearest, 1, len(points) - 2)
    tangent = points[at + 1] - points[at - 1]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    gap = traced_px - points[at]
    return at + np.sum(gap * tangent, axis=1), gap[:, 1] * tangent[:, 0] - gap[:, 0] * tangent[:, 1]


def bend(along: Array, gap: Array) -> tuple[float, float, float]:
    """Return how far samples bend, how far they are away on the whole, and their scatter."""
    cubic = np.polynomial.Polynomial.fit(along, gap, 3)(along)
    straight = np.polynomial.Polynomial.fit(along, cubic, 1)(along)
    scatter = 1.4826 * float(np.median(np.abs(gap - cubic)))
    return float(np.max(np.abs(cubic - straight))), float(np.median(gap)), scatter


def bound_px(clear: Array, camera: Camera, points: Array, length_px: float) -> float:
    """Return the Cramér–Rao bound of a sample over so many pixels of a step edge.

    The information of a step of height C blurred by σ in noise s is C² / (2 √π σ s²) a pixel
    of its length. It is that of luminance, which edges are measured in: equal noise in three
    colours is 0.75 of it there.
    """
    middle = points[len(points) // 8 : -len(points) // 8 : 8]
    tangent = points[len(points) // 8 + 1 :: 8][: len(middle)] - middle
    normal = tangent[:, ::-1] * [1, -1] / np.linalg.norm(tangent, axis=1, keepdims=True)
    sides = [
        clear[tuple(np.rint((middle + away * normal)[:, ::-1]).astype(int).clip(0).T)]
        for away in (-4.0, 4.0)
    ]
    height = np.median((sides[1] - sides[0]) @ LUMINANCE)
    far = np.hypot(*(middle - camera.view.centre).T) / np.hypot(*camera.view.centre)
    blur = camera.blur_px[0] + (camera.blur_px[1] - camera.blur_px[0]) * np.median(far**2)
    noise = np.hypot(camera.noise, 1 / np.sqrt(12)) * np.linalg.norm(LUMINANCE)
    per_px = height**2 / (2 * np.sqrt(np.pi) * blur * noise**2)
    return float(1 / np.sqrt(per_px * length_px))


def corner_error_px(view: View, made: plumbline.Calibration) -> float:
    """Return the largest error of a calibration over the photo."""
    points = grid_px((view.width, view.height), 15)
    return unlike_px(view.undistort(points), made.lens.undistort(points))


def row(number: int, off_px: float, size: tuple[int, int]) -> Row:
    """Snap one photograph's picks."""
    camera, wall = shot(number, size=size)
    view = camera.view
    edges = long_edges(view, wall)
    picture: Picture = take(camera, wall)
    picks = picked(edges, off_px, view, number)
    observations = plumbline.Observations.from_arrays(picks, (view.width, view.height))
    made = plumbline.snap(observations, np.ascontiguousarray(picture[..., ::-1]))
    plain = not camera.quality and not camera.sharpening
    clear = encoded(linear_light(camera, wall)).astype(np.float64) if plain else None
    bends, shifts, scatters = list[float](), list[float](), list[float]()
    for (edge, points), traced in zip(edges, made.lines, strict=True):
        if not traced.found:
            continue
        bent, shift, scatter = bend(*across(points, traced.points_px))
        bends.append(bent)
        shifts.append(abs(shift))
        if clear is not None and "pier" in edge.name and abs(shift) < PARALLEL_PX:
            least = bound_px(clear, camera, points, _length(traced))
            scatters.append(scatter / least)
    fits = [plumbline.calibrate(each) for each in (observations, made.observations)]
    quoted = fits[1].quoted_displacement
    return Row(
        number,
        _what(camera),
        len(edges),
        sum(not traced.found for traced in made.lines),
        sum(shift > PARALLEL_PX for shift in shifts),
        sum(each > BENT_PX for each in bends),
        float(np.median(bends)) if bends else np.nan,
        float(np.median(shifts)) if shifts else np.nan,
        float(np.median(scatters)) if scatters else np.nan,
        corner_error_px(view, fits[0]),
        corner_error_px(view, fits[1]),
        np.nan if quoted is None else quoted.worst_px,
        tuple(traced.refusal for traced in made.lines if not traced.found),
    )


def _length(traced: Traced) -> float:
    """Return the pixels of the edge in one sample."""
    steps = np.hypot(*np.diff(traced.points_px, axis=0).T)
    return float(np.median(steps))


def _what(camera: Camera) -> str:
    jpeg = f"q{camera.quality}" + (" 420" if camera.sampling_420 else "") if camera.quality else ""
    sharp = "sharp" if camera.sharpening else ""
    return (
        f"{camera.view.lens.lens[-14:]:14} {camera.view.width}x{camera.view.height} "
        f"{camera.blur_px[0]:.1f}-{camera.blur_px[1]:.1f} n{camera.noise:g} "
        f"e{camera.exposure:g} {jpeg:7} {sharp:5}"
    )


HEADER = (
    f"{'photograph':62} {'lines':>5} {'ref':>4} {'par':>4} {'bent':>4} {'bend':>6} {'shift':>6} "
    f"{'x bound':>7} {'picks':>7} {'snapped':>8} {'quoted':>7}"
)


def shown(one: Row) -> str:
    """Return a row of the table."""
    return (
        f"{one.number:3} {one.what:58} {one.lines:5} {one.refused:4} {one.parallel:4} {one.bent:4} "
        f"{one.bend_px:6.3f} {one.shift_px:6.3f} {one.scatter:7.2f} {one.corner_before_px:7.2f} "
        f"{one.corner_px:8.3f} {one.quoted_px:7.3f}"
    )


def summed_up(rows: list[Row]) -> list[str]:
    """Return the sentences under the table."""
    lines = sum(one.lines for one in rows)
    share = [100 * sum(getattr(one, name) for one in rows) / lines for name in ("refused", "bent")]
    errors = np.array([one.corner_px for one in rows])
    scatter = np.array([one.scatter for one in rows])
    scatter = scatter[np.isfinite(scatter)]
    return [
        f"{lines} lines: {share[0]:.1f} % refused (at most 5: {_met(share[0] <= 5)}), "
        f"{share[1]:.2f} % bent by more than {BENT_PX} px (none: {_met(share[1] == 0)})",
        f"scatter over bound: median {np.median(scatter):.2f}, worst {np.max(scatter):.2f} "
        f"(at most 1.5: {_met(bool(np.max(scatter) <= 1.5))})"
        if len(scatter)
        else "no photograph without compression: the scatter is not compared",
        f"corner error: median {np.median(errors):.3f} px (at most 0.05: "
        f"{_met(bool(np.median(errors) <= 0.05))}), worst {np.max(errors):.3f} px (at most 0.3: "
        f"{_met(bool(np.max(errors) <= 0.3))}); plain picks "
        f"{np.median([one.corner_before_px for one in rows]):.2f} px",
    ]


def _met(true: bool) -> str:
    return "met" if true else "NOT MET"


def main() -> None:
    """Run the photographs and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--photos", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--off", type=float, default=2.0, help="pixels that picks are off by")
    parser.add_argument("--width", type=int, default=1500)
    chosen = parser.parse_args()
    size = (chosen.width, 2 * chosen.width // 3)
    print(HEADER)
    rows: list[Row] = []
    for number in range(chosen.first, chosen.first + chosen.photos):
        rows.append(row(number, chosen.off, size))
        print(shown(rows[-1]), flush=True)
        for reason in sorted(set(rows[-1].reasons)):
            print("      refused:", reason)
    print("\n".join(summed_up(rows)))


if __name__ == "__main__":
    main()
