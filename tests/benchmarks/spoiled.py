"""A robust fit among bad picks, against a fit that was told which picks are good.

    python -m tests.benchmarks.spoiled                  200 trials of every spoiler and group
    python -m tests.benchmarks.spoiled --trials 20

10 % and 25 % of the picks are moved by 8 to 100 px, or given to the neighbouring line. A row has
the root mean square field error over a 9 × 9 grid of the photo, pooled over the trials, over that
of the informed fit, the same of the medians, the share of the picks displaced by more than 5 σ
across their line that are named as suspects, and that of the good picks that are named.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Sequence, Set as AbstractSet
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import plumbline
from tests.benchmarks.field import coefficients, field_px
from tests.benchmarks.groups import FACADE, FRAMES, GRID, SLANTED, UNEVEN, lens
from tests.benchmarks.simulated import Group
from tests.benchmarks.spoiling import SPOILERS, Spoiled, across_px
from tests.benchmarks.trials import observations
from tests.truth import Array

FitRobust = Callable[
    [plumbline.Observations], tuple[plumbline.Calibration, AbstractSet[tuple[int, int]]]
]
"""A fit, and the picks it names as suspects: the number of the line and of the pick on it."""

SHARES = (0.10, 0.25)
MOST_ERROR = {0.10: 1.2, 0.25: 1.3}
MOST_GOOD_NAMED = {0.10: 0.01, 0.25: 0.02}
LEAST_NAMED = 0.95
DISPLACED = 5.0
"""Standard deviations across its line at which a pick must be named."""

GROUPS = (
    Group("S120 5.2 mm", lens("S120 5.2 mm"), GRID, 0.3),
    Group("E 10-18 at 14 mm", lens("E 10-18 at 14 mm"), SLANTED, 0.5),
    Group("Mavic Pro", lens("Mavic Pro"), UNEVEN, 0.5),
    Group("G7 X 8.8 mm", lens("G7 X 8.8 mm"), FACADE, 0.3),
    Group("Sigma 14 mm", lens("Sigma 14 mm"), FRAMES, 0.5),
)


@dataclass(frozen=True)
class Row:
    """One spoiler on one group.

    Attributes:
        group: Its name.
        spoiler: What was done to the picks.
        share: Of the picks.
        failures: Sentences of the trials that raised: of infinite error, naming nothing.
        folded: Fits that fold in the photo; their error is infinite.
        ratio: Root mean square error over that of the informed fit.
        median: The same of the medians.
        worst: Largest error of one trial, over the informed fit's root mean square.
        displaced: How many picks were displaced.
        good: How many picks were good.
        named: Share of the displaced picks that were named.
        good_named: Share of the good picks that were.
    """

    group: str
    spoiler: str
    share: float
    failures: tuple[str, ...]
    folded: int
    ratio: float
    median: float
    worst: float
    displaced: int
    good: int
    named: float
    good_named: float

    @property
    def met(self) -> bool:
        """Whether it meets all targets, without a failure."""
        return (
            self.ratio <= MOST_ERROR[self.share]
            and self.named >= LEAST_NAMED
            and self.good_named < MOST_GOOD_NAMED[self.share]
        )


def pooled(rows: Sequence[Row]) -> Row:
    """All groups of one spoiler and share together, every group's error over its own level."""
    displaced, good = (np.array([getattr(row, n) for row in rows]) for n in ("displaced", "good"))
    return Row(
        group="all groups",
        spoiler=rows[0].spoiler,
        share=rows[0].share,
        failures=tuple(sentence for row in rows for sentence in row.failures),
        folded=sum(row.folded for row in rows),
        ratio=float(np.sqrt(np.mean([row.ratio**2 for row in rows]))),
        median=float(np.median([row.median for row in rows])),
        worst=max(row.worst for row in rows),
        displaced=int(displaced.sum()),
        good=int(good.sum()),
        named=float(displaced @ [row.named for row in rows] / displaced.sum()),
        good_named=float(good @ [row.good_named for row in rows] / good.sum()),
    )


def shown(row: Row) -> str:
    """One line of the table."""
    return (
        f"{row.group:34} {row.spoiler:18} {row.share:5.0%} {len(row.failures):5} {row.folded:5} "
        f"{row.ratio:7.3f} {row.median:7.3f} {row.worst:8.2f} {100 * row.named:7.2f} "
        f"{100 * row.good_named:6.2f}  {'met' if row.met else 'NOT MET'}"
    )


def informed(group: Group, spoiled: Spoiled) -> plumbline.Calibration:
    """The plain fit of the good picks alone; a line left with fewer than three goes."""
    lines = zip(group.by_line(spoiled.points_px), np.split(~spoiled.bad, group.ends), strict=True)
    kept = [points[good] for points, good in lines if np.count_nonzero(good) >= 3]
    picked = plumbline.Observations.from_arrays(kept, group.lens.size)
    return plumbline.calibrate(picked, group.model, free=group.free)


def compare(group: Group, spoiler: str, share: float, trials: int, fit_robust: FitRobust) -> Row:
    """Run the trials of one spoiler on one group."""
    drawn: list[Spoiled] = []
    named: list[NDArray[np.bool_]] = []
    errors: list[tuple[float, float]] = []
    failures: list[str] = []
    for trial, points in enumerate(group.picks_px(trials)):
        rng = group.rng(f"{spoiler} {share}", trial)
        spoiled = SPOILERS[spoiler](group, points, share, rng)
        informed_px = _error_px(group, informed(group, spoiled))
        drawn.append(spoiled)
        try:
            robust, suspects = fit_robust(observations(group, spoiled.points_px))
        except plumbline.PlumblineError as error:
            failures.append(f"trial {trial}: {error.message}")
            errors.append((np.inf, informed_px))
            named.append(np.zeros(group.n_points, dtype=bool))
        else:
            errors.append((_error_px(group, robust), informed_px))
            named.append(_flags(group, suspects))
    bad, displaced, flags = _judged(group, drawn, named)
    ours, told = (np.array(column) for column in zip(*errors, strict=True))
    level = np.sqrt(np.mean(told**2))
    return Row(
        group=group.name,
        spoiler=spoiler,
        share=share,
        failures=tuple(failures),
        folded=int(np.count_nonzero(~np.isfinite(ours))) - len(failures),
        ratio=float(np.sqrt(np.mean(ours**2)) / level),
        median=float(np.median(ours) / np.median(told)),
        worst=float(np.max(ours) / level),
        displaced=int(np.count_nonzero(displaced)),
        good=int(np.count_nonzero(~bad)),
        named=float(np.mean(flags[displaced])),
        good_named=float(np.mean(flags[~bad])),
    )


def _error_px(group: Group, fit: plumbline.Calibration) -> float:
    field = field_px(group.lens, coefficients([fit.coefficients]), group.model)
    error = float(np.sqrt(np.mean(np.sum(field**2, axis=-1))))
    return error if np.isfinite(error) else np.inf  # a lens that folds in the photo


def _flags(group: Group, suspects: Iterable[tuple[int, int]]) -> NDArray[np.bool_]:
    """Which of all picks are named, shape (n,)."""
    starts = np.array([0, *group.ends.tolist()])
    flags = np.zeros(group.n_points, dtype=bool)
    for line, pick in suspects:
        flags[starts[line] + pick] = True
    return flags


def _judged(
    group: Group, drawn: Sequence[Spoiled], named: Sequence[NDArray[np.bool_]]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Which picks of all trials were bad, displaced, and named, shape (trials, n) each."""
    points: Array = np.stack([each.points_px for each in drawn])
    bad, flags = np.stack([each.bad for each in drawn]), np.stack(named)
    return bad, bad & (across_px(group, points) > DISPLACED * group.noise_px), flags


def plain(
    picked: plumbline.Observations,
) -> tuple[plumbline.Calibration, AbstractSet[tuple[int, int]]]:
    """The plain fit, which names nothing: what happens without protection."""
    return plumbline.calibrate(picked), frozenset()


def robust(
    picked: plumbline.Observations,
) -> tuple[plumbline.Calibration, AbstractSet[tuple[int, int]]]:
    """The robust fit, and the picks it names; not the rest of a line it leaves out as a whole."""
    made = plumbline.calibrate(picked, robust=True)
    named = [each for each in made.suspects if each.left_out and each.kind != "no line"]
    return made, {(each.line, pick) for each in named for pick in each.picks}


def main(fit_robust: FitRobust = robust) -> None:
    """Run every spoiler on every group and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    print(
        f"{'group':34} {'spoiler':18} {'share':>5} {'fails':>5} {'folds':>5} "
        f"{'ratio':>7} {'median':>7} {'worst':>8} {'named %':>7} {'good %':>6}"
    )
    rows: list[Row] = []
    for group in GROUPS:
        for spoiler in SPOILERS:
            for share in SHARES:
                rows.append(one := compare(group, spoiler, share, chosen.trials, fit_robust))
                print(shown(one), flush=True)
                for sentence in one.failures[:3]:
                    print("    failed,", sentence)
    for spoiler in SPOILERS:
        for share in SHARES:
            print(shown(pooled([r for r in rows if (r.spoiler, r.share) == (spoiler, share)])))
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
