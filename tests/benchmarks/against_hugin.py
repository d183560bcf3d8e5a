"""plumbline and Hugin's optimiser on the same simulated picks: how far off is the photo?

    python -m tests.benchmarks.against_hugin                40 trials a group
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
from tests.benchmarks.groups import ALIKE
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import fit_trials, observations, of
from tests.truth import Array

TARGET = 0.78
WRONG = 8.0
"""Times the bound at which a fit counts as one in a wrong minimum."""

GROUPS = tuple(group for group in ALIKE if group.model == "ptlens" and group.free is None)
"""All groups of `tests.benchmarks.coverage` with a, b, c free: none is picked out."""


@dataclass(frozen=True)
class Row:
    """Both programs on one group; errors in pixels, one for each trial.

    Attributes:
        group: Its name.
        picks: Mean number of picks on a line.
        bound_px: The least root mean square error.
        ours_px: Of plumbline.
        theirs_px: Of Hugin.
    """

    group: str
    picks: float
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
    picks_a_line = group.n_points / len(group.lines)
    return Row(group.name, picks_a_line, bound(group).rms_px, *map(tuple, errors))


def _errors_px(group: Group, fits: Sequence[dict[str, float]]) -> list[float]:
    """Root mean square over the grid, for each trial; infinite where a lens folds in the photo."""
    field = field_px(group.lens, coefficients(fits), group.model)
    errors = np.sqrt(np.mean(np.sum(field**2, axis=-1), axis=-1))
    return np.where(np.isfinite(errors), errors, np.inf).tolist()


def rms(values: Sequence[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def pooled(rows: Sequence[Row]) -> float:
    """The ratio of the two programs' root mean square errors, in units of every group's bound.

    Taken over the trials in which neither ended in a wrong minimum.
    """
    sums = np.zeros(2)
    for one in rows:
        both = np.array([one.ours_px, one.theirs_px])[:, one.sane] / one.bound_px
        sums += np.mean(both**2, axis=1)
    return float(np.sqrt(sums[0] / sums[1]))


def _by_picks(rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """The groups by the number of picks on a line, which decides how much Hugin gives away."""
    bands = ((0, 7), (7, 13), (13, 1000))
    found = [
        (f"{low} to {high - 1} picks a line", [row for row in rows if low <= row.picks < high])
        for low, high in bands
    ]
    return [(what, some) for what, some in found if some]


def main() -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=40)
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
    kept = [one for one in rows if sum(one.sane) * 2 >= len(one.sane)]
    lost = [one.group for one in rows if one not in kept]
    print("left out for wrong minima:", "; ".join(lost) or "none")
    for what, some in (("all", kept), *_by_picks(kept)):
        print(f"pooled ratio of {len(some)} groups, {what}: {pooled(some):.3f}")
    verdict = "met" if pooled(kept) <= TARGET else "NOT MET"
    print(f"at most {TARGET}: {verdict}")
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
