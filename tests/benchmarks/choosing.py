"""Does `compare` choose well? Simulated picks of many lenses, and how far off its choice is.

    python -m tests.benchmarks.choosing                      2 trials a case
    python -m tests.benchmarks.choosing --trials 10 --json choosing.json

The truth is `tests.truth`, never plumbline's own model. A case is a true lens, a layout of lines
and a level of noise. It counts where the models differ: where two of those that fit the picks
without noise are more than 0.3 px apart. For each trial of such a case stand

    error      the largest difference of the recommended curve from the truth over the photo, as
               far out as picks reach, after the best common scale and translation (homography
               where tangential terms are free): straight lines see neither
    stated     the standard error that `compare` states and says is to be quoted with what it
               recommends (`overall_error_px`), which allows for models that the picks do not rule
               out
    own        the largest standard error that the recommended fit has over the same points if its
               model is right, the larger of that for independent errors and the jackknife's

and the choice is right if the error is at most 0.1 px or twice the stated one, whichever is larger.
A trial in which `compare` raises is a miss. A row of the table has, for one family of true lenses,
the share of right choices, what it would be if the own error counted as the stated one, the median
error, the median of the stated one, the median number of coefficients, and what was recommended how
often.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from itertools import combinations, repeat
from pathlib import Path

import numpy as np

import plumbline
from plumbline.trust.displacement import displacement_errors
from tests.benchmarks.groups import FACADE, FEW, GOPRO, GRID, HALF, NOISE_PX, SLANTED, UNEVEN, lens
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import observations
from tests.truth import TANGENTIAL, Array, TrueLens, grid_px, unlike_px

RIGHT_PX, FAMILIES_PX = 0.1, 0.3
LAYOUTS = (FACADE, GRID, UNEVEN, SLANTED, HALF, FEW)
_GRID = 17
_SIZE = (3000, 2250)

FAMILIES: dict[str, tuple[TrueLens, ...]] = {
    "ptlens b": (
        TrueLens("ptlens", {"b": -0.0255}, (2048, 1536)),
        TrueLens("ptlens", {"b": -0.003}, (4032, 3024)),
        TrueLens("ptlens", {"b": 0.0165}, (4000, 3000)),
        TrueLens("ptlens", {"b": -0.0002}, (1024, 768)),
    ),
    "ptlens a, b, c": (
        lens("S120 5.2 mm"),
        lens("Sigma 14 mm"),
        lens("FC6310 drone"),
        lens("Tamron 18-400 at 70 mm"),
        lens("IXUS 220 4.3 mm"),
        GOPRO,
    ),
    "moustache": (
        lens("E 10-18 at 14 mm"),
        lens("AF-P 10-20 at 10 mm"),
        lens("M.Zuiko 14-42 at 16 mm"),
        TrueLens("radial:2,4,6", {"a2": 0.06, "a4": -0.03, "a6": 0.002}, _SIZE),
    ),
    "poly5": (
        TrueLens("poly5", {"k1": -0.030571633, "k2": 0.004658548}, (3648, 2736)),
        TrueLens("poly5", {"k1": -0.004, "k2": -0.0015}, (6000, 4000)),
    ),
    "even powers": (
        TrueLens("radial:2,4,6", {"a2": 0.02}, _SIZE),
        TrueLens("radial:2,4,6", {"a2": 0.05, "a4": 0.01}, _SIZE),
        TrueLens("radial:2,4,6", {"a2": 0.11, "a4": 0.02, "a6": 0.004}, (3000, 2000)),
    ),
    "division": (
        TrueLens("division", {"l1": -0.03}, _SIZE),
        TrueLens("division", {"l1": -0.1, "l2": -0.006}, (640, 480)),
        TrueLens("division", {"l1": -0.15}, (4000, 3000)),
    ),
    "tangential": (
        TrueLens("brown", {"k1": 0.09, "k2": 0.01, "p1": 0.0015, "p2": -0.001}, _SIZE),
        TrueLens("brown", {"k1": 0.03, "p1": 0.0003, "p2": 0.0002}, _SIZE),
        TrueLens("brown", {"k1": -0.02, "k2": 0.003, "p1": -0.004, "p2": 0.003}, _SIZE),
    ),
    "centre 10 px off": (
        lens("S120 5.2 mm", d=8.0, e=-6.0),
        TrueLens("ptlens", {"b": -0.0255, "d": -6.0, "e": 8.0}, (2048, 1536)),
    ),
    "centre 50 px off": (
        lens("IXUS 220 4.3 mm", d=-40.0, e=30.0),
        TrueLens("ptlens", {"b": -0.0255, "d": 30.0, "e": 40.0}, (2048, 1536)),
        TrueLens("division", {"l1": -0.05, "d": 50.0}, _SIZE),
    ),
}
"""True lenses, by family."""


@dataclass(frozen=True)
class Trial:
    """What `compare` made of one set of picks.

    Attributes:
        family: Of the true lens.
        case: The true lens, the layout and the noise.
        row: What was recommended; empty where it raised.
        coefficients: Number of its coefficients.
        error_px: Its largest error over the range of the picks.
        stated_px: What `compare` says is to be quoted with it.
        own_px: What the recommended fit has there if its model is right.
        failure: The sentence of what it raised.
    """

    family: str
    case: str
    row: str = ""
    coefficients: int = 0
    error_px: float = np.inf
    stated_px: float = 0.0
    own_px: float = 0.0
    failure: str = ""

    @property
    def right(self) -> bool:
        """Whether the choice is good enough."""
        return self.error_px <= max(RIGHT_PX, 2 * self.stated_px)

    @property
    def right_alone(self) -> bool:
        """Whether it would be with its own error."""
        return self.error_px <= max(RIGHT_PX, 2 * self.own_px)


def cases() -> Iterator[tuple[str, Group]]:
    """Every case with its family."""
    for family, lenses in FAMILIES.items():
        for number, true in enumerate(lenses):
            for layout in LAYOUTS:
                for noise_px in NOISE_PX:
                    yield family, Group(f"{family} {number}", true, layout, noise_px)


def range_px(group: Group) -> Array:
    """Points all over the photo, as far from its centre as picks reach, shape (n, 2)."""
    middle = (np.array(group.lens.size) - 1) / 2
    grid = grid_px(group.lens.size, _GRID)
    reached = np.max(np.hypot(*(group.true_px - middle).T))
    return grid[np.hypot(*(grid - middle).T) <= reached]


def families_differ(group: Group) -> bool:
    """Whether two models that fit the picks without noise are more than 0.3 px apart."""
    rows = plumbline.compare(observations(group, group.true_px)).candidates
    points = range_px(group)
    fits = [(row.calibration, row.free) for row in rows if row.calibration and not row.failure]
    ideal = [(made.lens.undistort_or_nan(points), {*free}) for made, free in fits]
    return any(
        unlike_px(one, other, perspective=bool({"p1", "p2"} & (free | freed))) > FAMILIES_PX
        for (one, free), (other, freed) in combinations(ideal, 2)
    )


def error_px(group: Group, made: plumbline.Calibration) -> float:
    """The largest difference of a fit from the truth over the range of the picks."""
    points = range_px(group)
    of_truth = {n for n in TANGENTIAL.get(group.lens.name, ()) if group.lens.all_coefficients[n]}
    perspective = bool(of_truth | ({"p1", "p2"} & {*made.free}))
    want, found = group.lens.undistort(points), made.lens.undistort_or_nan(points)
    if not np.all(np.isfinite(found)):
        return np.inf
    return unlike_px(want, found, perspective=perspective)


def own_px(group: Group, made: plumbline.Calibration) -> float:
    """The largest standard error that a fit has of its own over the range of the picks."""
    points = range_px(group)
    covariances = [made.covariance]
    if made.jackknife is not None:
        covariances.append(made.jackknife.covariance)
    stated = [
        displacement_errors(made.lens, made.free, each, points, points) for each in covariances
    ]
    return max(float(np.max(each)) for each in stated if each is not None)


def trial(family: str, group: Group, picks_px: Array) -> Trial:
    """Let `compare` choose for one set of picks, and judge the choice."""
    try:
        found = plumbline.compare(observations(group, picks_px))
    except plumbline.PlumblineError as error:
        return Trial(family, group.name, failure=error.message)
    taken = found.candidates[found.recommended]
    made = found.calibration
    numbers = error_px(group, made), taken.overall_error_px or 0.0, own_px(group, made)
    return Trial(family, group.name, taken.name, len(taken.free), *numbers)


def trials(family: str, group: Group, number: int) -> list[Trial]:
    """The trials of one case; none where the models do not differ."""
    if not families_differ(group):
        return []
    return [trial(family, group, picks) for picks in group.picks_px(number)]


def share_right(made: Sequence[Trial]) -> float:
    """The share of right choices."""
    return float(np.mean([each.right for each in made]))


def share_right_alone(made: Sequence[Trial]) -> float:
    """What it would be with the fits' own errors."""
    return float(np.mean([each.right_alone for each in made]))


def shown(family: str, made: Sequence[Trial]) -> str:
    """One line of the table."""
    rows = Counter(each.row or "raised" for each in made)
    often = ", ".join(f"{name} {number}" for name, number in rows.most_common())
    medians = np.median([(e.error_px, e.stated_px, e.coefficients) for e in made], axis=0)
    off, said, coefficients = (float(each) for each in medians)
    shares = f"{100 * share_right(made):7.1f} {100 * share_right_alone(made):7.1f}"
    return f"{family:18} {len(made):6} {shares} {off:8.2f} {said:9.2f} {coefficients:7.1f}  {often}"


def main() -> None:
    """Run all cases and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=2)
    parser.add_argument("--only", default="", help="families whose name contains this")
    parser.add_argument("--json", type=Path, help="write the figures here")
    options = parser.parse_args()
    listed = [(family, group) for family, group in cases() if options.only in family]
    with ThreadPoolExecutor(2) as pool:
        made = list(pool.map(trials, *zip(*listed, strict=True), repeat(options.trials)))
    every = [each for some in made for each in some]
    counted = sum(bool(some) for some in made)
    heads = f"{'right %':>7} {'alone %':>7} {'error px':>8} {'stated px':>9} {'coeffs':>7}"
    print(f"{'truth':18} {'trials':>6} {heads}  recommended")
    for family in dict.fromkeys(family for family, _ in listed):
        if mine := [each for each in every if each.family == family]:
            print(shown(family, mine))
    for each in every:
        if each.failure:
            print(f"    raised, {each.case}: {each.failure}")
    print(f"\n{len(listed)} cases, in {counted} of which the models differ by {FAMILIES_PX} px")
    share = share_right(every)
    print(f"right: {100 * share:.1f} % of {len(every)} trials, at least 95 % wanted: ", end="")
    print("met" if share >= 0.95 else "NOT MET")
    print(f"with the fits' own errors it would be {100 * share_right_alone(every):.1f} %")
    if options.json:
        options.json.write_text(json.dumps([asdict(each) for each in every], indent=2) + "\n")


if __name__ == "__main__":
    main()
