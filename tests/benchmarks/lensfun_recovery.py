"""Recover every rectilinear ptlens lens of a LensFun database from straight lines, from zero.

    python -m tests.benchmarks.lensfun_recovery             all lenses, table and JSON
    python -m tests.benchmarks.lensfun_recovery --every 50  one in fifty

Each distinct entry that does not fold inside the photo becomes 16 straight lines, distorted by
the formula written here (not plumbline's), and is calibrated from a = b = c = 0, without noise
and with 0.3 px of it. Without noise a fit is exact if its curve is within 1e-6 px of the truth
all over the photo. With noise it is in the right minimum if σ̂ is the noise and the truth lies
where the covariance says it may: the squared Mahalanobis distance of the three coefficients has
a mean of 3, and one above 45 has a chance of 1e-9.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]
from numpy.typing import NDArray

import plumbline
from tests.many import all_calibrated

Array = NDArray[np.float64]

DATABASES = (Path("/usr/share/lensfun/version_1"), Path("/usr/share/lensfun"))
ACTION_CAMERAS = (
    (0.06335, -0.18432, -0.13009),
    (0.01359, -0.06034, -0.10618),
    (0.1064, -0.2871, -0.1011),
)
WIDTH = 3000
N_LINES, N_POINTS = 16, 12


@dataclass(frozen=True)
class Entry:
    """A lens of the database: its coefficients and the aspect ratio of its photos."""

    name: str
    abc: tuple[float, float, float]
    aspect: float

    @property
    def size(self) -> tuple[int, int]:
        """A photo of that shape."""
        return WIDTH, round(WIDTH / self.aspect)


def database() -> Path | None:
    """The folder of Debian's LensFun database, or None where it is not installed."""
    return next((folder for folder in DATABASES if any(folder.glob("*.xml"))), None)


def read_database(folder: Path) -> list[Entry]:
    """The distinct ptlens entries of all rectilinear lenses."""
    found: dict[tuple[tuple[float, float, float], float], Entry] = {}
    for file in sorted(folder.glob("*.xml")):
        for lens in etree.parse(file).getroot().iter("lens"):
            if (lens.findtext("type") or "rectilinear") != "rectilinear":
                continue
            aspect = _aspect(lens.findtext("aspect-ratio"))
            for element in lens.iter("distortion"):
                if element.get("model") == "ptlens":
                    a, b, c = (float(element.get(n) or 0) for n in "abc")
                    name = f"{lens.findtext('model')} {element.get('focal')} mm"
                    found.setdefault(((a, b, c), aspect), Entry(name, (a, b, c), aspect))
    return list(found.values())


def _aspect(text: str | None) -> float:
    if not text:
        return 1.5
    over, _, under = text.partition(":")
    return float(over) / float(under or 1)


def factor(abc: Sequence[float], r: Array) -> Array:
    """r_obs / r_ideal of the ptlens model, for the ideal radius."""
    a, b, c = abc
    return a * r**3 + b * r**2 + c * r + 1 - a - b - c


def ideal_corner(entry: Entry) -> float | None:
    """Ideal radius of the photo's corner in half short sides; None if the model folds first."""
    width, height = entry.size
    corner = float(np.hypot(width, height)) / min(width, height)
    r = np.linspace(0, 8 * corner, 200_001)
    observed = r * factor(entry.abc, r)
    falls = np.flatnonzero(np.diff(observed) <= 0)
    reach = falls[0] if len(falls) else len(r) - 1
    if observed[reach] <= corner * 1.0005:
        return None
    return float(np.interp(corner, observed[: reach + 1], r[: reach + 1]))


def lines_of(entry: Entry, corner: float) -> list[Array]:
    """Observed points, in pixels, on 16 ideal straight lines, half of them in each direction."""
    width, height = entry.size
    radius = min(width, height) / 2
    centre = np.array([(width - 1) / 2, (height - 1) / 2])
    t = np.linspace(-1.2 * corner, 1.2 * corner, 4001)
    lines: list[Array] = []
    for index in range(N_LINES):
        upright = index % 2 == 1
        half = np.array([width, height]) / 2 / radius
        offset = (index // 2 + 0.5) / (N_LINES / 2) * 2 - 1
        place = offset * 0.97 * half[0 if upright else 1]
        r = np.linspace(0, corner, 20_001)
        place = np.sign(place) * np.interp(abs(place), r * factor(entry.abc, r), r)
        tilt = 0.04 * np.cos(index)
        along, across = t, place + tilt * t
        ideal = np.stack((across, along) if upright else (along, across), axis=1)
        rr = np.hypot(ideal[:, 0], ideal[:, 1])
        ideal = ideal[rr <= corner]
        rr = rr[rr <= corner]
        observed = centre + radius * ideal * factor(entry.abc, rr)[:, None]
        inside = np.all((observed >= 0) & (observed <= [width - 1, height - 1]), axis=1)
        good = observed[inside]
        lines.append(good[np.linspace(0, len(good) - 1, N_POINTS).round().astype(int)])
    return lines


def curve_error_px(entry: Entry, found: Sequence[float], corner: float) -> float:
    """Largest difference of two ptlens curves over the photo, in observed pixels."""
    r = np.linspace(0, corner, 400)
    difference = r * (factor(found, r) - factor(entry.abc, r))
    return float(np.max(np.abs(difference))) * min(entry.size) / 2


def observations(
    entries: Iterable[tuple[Entry, float]], noise_px: float, seed: int = 20261
) -> list[plumbline.Observations]:
    """Picks of every lens, with noise of that standard deviation."""
    rng = np.random.default_rng(seed)
    made: list[plumbline.Observations] = []
    for entry, corner in entries:
        lines = [
            np.clip(p + rng.normal(0, noise_px, p.shape), 0, np.array(entry.size) - 1)
            if noise_px
            else p
            for p in lines_of(entry, corner)
        ]
        made.append(plumbline.Observations.from_arrays(lines, entry.size))
    return made


@dataclass(frozen=True)
class Outcome:
    """What came of all lenses.

    Attributes:
        entries: Distinct entries looked at.
        folding: Those left out because they fold inside the photo.
        worst_px: Largest curve error without noise.
        inexact: Names of lenses with more than 1e-6 px of it.
        wrong_minima: Names of lenses whose noisy fit is not the truth within its own errors.
        seconds: Time of the two batches.
    """

    entries: int
    folding: int
    worst_px: float
    inexact: list[str]
    wrong_minima: list[str]
    seconds: float


def run(entries: Sequence[Entry], *, noise_px: float = 0.3) -> Outcome:
    """Calibrate every entry without and with noise."""
    usable = [(entry, corner) for entry in entries if (corner := ideal_corner(entry))]
    began = time.perf_counter()
    exact = all_calibrated(observations(usable, 0.0))
    noisy = all_calibrated(observations(usable, noise_px))
    seconds = time.perf_counter() - began
    errors = [
        curve_error_px(entry, [made.coefficients[n] for n in "abc"], corner)
        for (entry, corner), made in zip(usable, exact, strict=True)
    ]
    inexact = [
        f"{entry.name} {entry.abc}: {error:.2g} px"
        for (entry, _), error in zip(usable, errors, strict=True)
        if not error <= 1e-6
    ]
    wrong = [
        f"{entry.name} {entry.abc}: {made.rms_after_px:.3f} px"
        for (entry, _), made in zip(usable, noisy, strict=True)
        if _is_wrong(entry, made, noise_px)
    ]
    return Outcome(len(entries), len(entries) - len(usable), max(errors), inexact, wrong, seconds)


def _is_wrong(entry: Entry, made: plumbline.Calibration, noise_px: float) -> bool:
    """Whether a noisy fit ended elsewhere than in the minimum that belongs to the truth."""
    off = np.array([made.coefficients[n] for n in "abc"]) - np.array(entry.abc)
    distance = float(off @ np.linalg.solve(made.covariance, off))
    return not made.converged or made.sigma_px > 1.35 * noise_px or distance > 45


def main() -> None:
    """Run on the installed database."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="take one entry in so many")
    parser.add_argument("--output", type=Path, help="write the figures as JSON here")
    chosen = parser.parse_args()
    folder = database()
    if folder is None:
        parser.exit(1, "LensFun's database is not installed (Debian: liblensfun-data-v1)\n")
    entries = read_database(folder)[:: chosen.every]
    entries += [Entry("action camera", abc, 4 / 3) for abc in ACTION_CAMERAS]
    outcome = run(entries)
    rows = {
        "entries": outcome.entries,
        "folding inside the photo, left out": outcome.folding,
        "largest curve error without noise, px": outcome.worst_px,
        "above 1e-6 px": len(outcome.inexact),
        "wrong minima with 0.3 px noise": len(outcome.wrong_minima),
        "seconds": round(outcome.seconds, 1),
    }
    for name, value in rows.items():
        print(f"{name:40} {value:.3g}" if isinstance(value, float) else f"{name:40} {value}")
    for line in [*outcome.inexact[:20], *outcome.wrong_minima[:20]]:
        print("  ", line)
    if chosen.output:
        chosen.output.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
