"""plumbline and Hugin's optimiser on the same simulated picks: how far off is the photo?

    python -m tests.benchmarks.against_hugin                60 trials a group
    python -m tests.benchmarks.against_hugin --trials 10

Each row has the root mean square field error over a 9 × 9 grid of the photo, after the best common
scale and translation, of both programs with a, b, c free, and of the best that is possible (the
Cramér-Rao bound). The pooled figure takes every group's errors in units of its bound, so that no
group weighs more than another. A fit of either program that ends in a wrong minimum is named, and
the trials in which neither does are pooled once more without the others.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import plumbline
from tests.benchmarks.field import bound, coefficients, field_px
from tests.benchmarks.groups import (
    DENSE,
    FACADE,
    FEW,
    GOPRO,
    GRID,
    HALF,
    SLANTED,
    UNEVEN,
    lens,
)
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import fit_trials, observations, of
from tests.truth import Array

TARGET = 0.78
WRONG = 8.0
"""Times the bound at which a fit counts as one in a wrong minimum."""

GROUPS = (
    Group("S120 5.2 mm", lens("S120 5.2 mm"), FACADE, 0.3),
    Group("G7 X 8.8 mm", lens("G7 X 8.8 mm"), GRID, 0.5),
    Group("Sigma 14 mm", lens("Sigma 14 mm"), UNEVEN, 0.3),
    Group("AF-P 10-20 at 10 mm", lens("AF-P 10-20 at 10 mm"), SLANTED, 0.5),
    Group("E 10-18 at 14 mm", lens("E 10-18 at 14 mm"), FACADE, 0.5),
    Group("FC6310 drone", lens("FC6310 drone"), GRID, 0.3),
    Group("Tamron 18-400 at 70 mm", lens("Tamron 18-400 at 70 mm"), HALF, 0.5),
    Group("Mavic Pro", lens("Mavic Pro"), FEW, 0.3),
    Group("IXUS 220 4.3 mm", lens("IXUS 220 4.3 mm"), DENSE, 1.0),
    Group("GoPro Hero3+", GOPRO, GRID, 0.5),
)


@dataclass(frozen=True)
class Row:
    """Both programs on one group; errors in pixels, one for each trial.

    Attributes:
        group: Its name.
        bound_px: The least root mean square error.
        ours_px: Of plumbline.
        theirs_px: Of Hugin.
    """

    group: str
    bound_px: float
    ours_px: tuple[float, ...]
    theirs_px: tuple[float, ...]

    @property
    def sane(self) -> list[bool]:
        """In which trials neither program ended in a wrong minimum."""
        most = WRONG * self.bound_px
        pairs = zip(self.ours_px, self.theirs_px, strict=True)
        return [ours <= most and theirs <= most for ours, theirs in pairs]


def optimised(group: Group, points_px: Array, folder: Path) -> dict[str, float]:
    """Hugin's a, b, c for one trial's picks."""
    project = plumbline.write_points(observations(group, points_px), folder / "picks.pto")
    out = folder / "optimised.pto"
    command = ["autooptimiser", "-n", "-o", str(out), str(project)]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    image = next(line for line in out.read_text().splitlines() if line.startswith("i "))
    found = {name: re.search(rf" {name}([-+.\de]+)", image) for name in "abc"}
    return {name: float(match[1]) for name, match in found.items() if match} | {"d": 0.0, "e": 0.0}


def row(group: Group, trials: int) -> Row:
    """Both programs on the same picks.

    Raises:
        RuntimeError: a fit of plumbline's failed; nothing may be left out silently.
    """
    picks = group.picks_px(trials)
    fitted = fit_trials(group, picks)
    if fitted.failures:
        raise RuntimeError(f"{group.name}: {fitted.failures[0]}")

    def theirs(points: Array) -> dict[str, float]:
        with tempfile.TemporaryDirectory() as folder:
            return optimised(group, points, Path(folder))

    with ThreadPoolExecutor(2) as pool:
        hugin = list(pool.map(theirs, picks))
    errors = [_errors_px(group, each) for each in (of(fitted.good), hugin)]
    return Row(group.name, bound(group).rms_px, *map(tuple, errors))


def _errors_px(group: Group, fits: Sequence[dict[str, float]]) -> list[float]:
    """Root mean square over the grid, for each trial; infinite where a lens folds in the photo."""
    field = field_px(group.lens, coefficients(fits), group.model)
    errors = np.sqrt(np.mean(np.sum(field**2, axis=-1), axis=-1))
    return np.where(np.isfinite(errors), errors, np.inf).tolist()


def rms(values: Sequence[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def pooled(rows: Sequence[Row], *, sane: bool) -> float:
    """The ratio of the two programs' root mean square errors, in units of every group's bound."""
    sums = np.zeros(2)
    for one in rows:
        chosen = np.array(one.sane) if sane else np.full(len(one.ours_px), fill_value=True)
        for index, errors in enumerate((one.ours_px, one.theirs_px)):
            relative = np.array(errors)[chosen] / one.bound_px
            sums[index] += np.mean(relative**2) if len(relative) else 0.0
    return float(np.sqrt(sums[0] / sums[1]))


def main() -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    if shutil.which("autooptimiser") is None:
        print("Hugin's autooptimiser is not installed (Debian: hugin-tools): nothing to compare")
        return
    print(f"{'group':42} {'bound px':>8} {'ours px':>8} {'Hugin px':>8} {'ratio':>6}  wrong minima")
    rows: list[Row] = []
    for group in GROUPS:
        rows.append(one := row(group, chosen.trials))
        ours, theirs = rms(one.ours_px), rms(one.theirs_px)
        wrong = [sum(e > WRONG * one.bound_px for e in es) for es in (one.ours_px, one.theirs_px)]
        print(
            f"{one.group:42} {one.bound_px:8.3f} {ours:8.3f} {theirs:8.3f} {ours / theirs:6.3f}  "
            f"ours {wrong[0]}, Hugin {wrong[1]}",
            flush=True,
        )
    print(f"pooled ratio, every trial: {pooled(rows, sane=False):.3f}")
    ratio = pooled(rows, sane=True)
    verdict = "met" if ratio <= TARGET else "NOT MET"
    print(f"pooled ratio, neither in a wrong minimum: {ratio:.3f}; at most {TARGET}: {verdict}")
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
