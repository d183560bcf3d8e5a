"""Is the quoted error true for lenses outside the fitted family?

    python -m tests.benchmarks.outside                       100 trials a group
    python -m tests.benchmarks.outside --trials 20 --only centre

ptlens' a, b, c are fitted to lenses that are not of that family: their centre is off by a share of
half the shorter side, they are decentred, or their curve is another. Every trial draws the
direction of what is off and the noise of the picks. A row has, for one lens, layout and noise:

    true px    median of the largest error within the range of the picks, after the best common
               scale and translation
    quote px   median of the error that plumbline quotes
    own px     median of what independent picking errors alone make
    within %   trials in which the true error is below twice the quoted one
    told %     trials in which the first line of the summary doubts the model

At least 90 % within is wanted of every group. The groups "in the family" show what the allowance
for other lenses costs where there is nothing to allow for.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

import plumbline
from tests.benchmarks.groups import FACADE, FEW, GRID
from tests.benchmarks.simulated import Group, Layout
from tests.truth import Array, TrueLens

SIZE = (3000, 2000)
HALF_PX = min(SIZE) / 2
WANTED = 0.90
STRONG = {"a": 0.03458, "b": -0.14652, "c": -0.00567}
INNER = Layout("inner 70 %", 16, 12, 12, reach=0.7)


@dataclass(frozen=True)
class Stereographic(TrueLens):
    """r_obs = 2 f tan(θ/2) with tan θ = r_ideal / f: between a rectilinear lens and a fisheye.

    Attributes:
        reach: f in units of half the shorter side.
    """

    reach: float = field(default=2.0, kw_only=True)

    def undistort(self, points_px: ArrayLike) -> Array:
        """In closed form: r_ideal = r_obs / (1 − (r_obs / 2f)²)."""
        return self._scaled(points_px, lambda r: 1 / (1 - (r / 2 / self.reach) ** 2))

    def distort(self, points_px: ArrayLike) -> Array:
        """In closed form: r_obs = 2 f tan(arctan(r_ideal / f) / 2)."""

        def factor(r: Array) -> Array:
            small = np.maximum(r, 1e-12)
            return 2 * self.reach * np.tan(np.arctan(small / self.reach) / 2) / small

        return self._scaled(points_px, factor)

    def _scaled(self, points_px: ArrayLike, factor: Callable[[Array], Array]) -> Array:
        middle = (np.array(self.size) - 1) / 2
        p = (np.asarray(points_px, dtype=np.float64) - middle) / self.unit_px
        r = np.hypot(p[..., 0], p[..., 1])[..., None]
        return p * factor(r) * self.unit_px + middle


def _turned(size: float, seed: int) -> tuple[float, float]:
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    return float(size * np.cos(angle)), float(size * np.sin(angle))


def _off_centre(share: float) -> Callable[[int], TrueLens]:
    def lens(seed: int) -> TrueLens:
        d, e = _turned(share * HALF_PX, seed)
        return TrueLens("ptlens", STRONG | {"d": d, "e": e}, SIZE)

    return lens


def _decentred(size: float) -> Callable[[int], TrueLens]:
    def lens(seed: int) -> TrueLens:
        p1, p2 = _turned(size, seed)
        return TrueLens("brown", {"k1": 0.09, "k2": 0.01, "k3": 0.0, "p1": p1, "p2": p2}, SIZE)

    return lens


MOUSTACHE = {"a2": 0.12, "a4": -0.05, "a6": 0.012, "a8": -0.0008}

LENSES: dict[str, Callable[[int], TrueLens]] = {
    "in the family, strong": lambda _: TrueLens("ptlens", STRONG, SIZE),
    "in the family, mild": lambda _: TrueLens("ptlens", {"b": -0.02, "a": 0.0, "c": 0.0}, SIZE),
    "centre off by 0.7 %": _off_centre(0.007),
    "centre off by 1.5 %": _off_centre(0.015),
    "centre off by 3 %": _off_centre(0.03),
    "p1, p2 of 0.001": _decentred(0.001),
    "p1, p2 of 0.002": _decentred(0.002),
    "division": lambda _: TrueLens("division", {"l1": -0.12, "l2": -0.01}, SIZE),
    "moustache of four powers": lambda _: TrueLens("radial:2,4,6,8", MOUSTACHE, SIZE),
    "stereographic": lambda _: Stereographic("ptlens", {"a": 0.0, "b": 0.0, "c": 0.0}, SIZE),
}
LAYOUTS = (GRID, FACADE, INNER, FEW)
NOISES_PX = 0.2, 0.6


@dataclass(frozen=True)
class Trial:
    """One fit; all in pixels."""

    true_px: float
    quoted_px: float
    own_px: float
    told: bool

    @property
    def within(self) -> bool:
        """Whether the true error is below twice the quoted one."""
        return self.true_px < 2 * self.quoted_px


@dataclass(frozen=True)
class Row:
    """What came of a group; a trial that failed is kept in view and not within."""

    name: str
    trials: tuple[Trial, ...]
    failures: tuple[str, ...]

    @property
    def within(self) -> float:
        """Share of trials within twice the quoted error."""
        return sum(each.within for each in self.trials) / (len(self.trials) + len(self.failures))


def true_px(lens: TrueLens, made: plumbline.Calibration) -> float:
    """The largest error within the range of the picks, as far as lines can tell."""
    points = made.trust.range_px
    found, want = made.lens.undistort(points), lens.undistort(points)
    found, want = found - found.mean(axis=0), want - want.mean(axis=0)
    scale = np.sum(found * want) / np.sum(found**2)
    return float(np.max(np.hypot(*(scale * found - want).T)))


def trial(name: str, layout: Layout, noise_px: float, number: int) -> Trial | str:
    """Draw one lens and its picks, fit a, b, c and compare."""
    lens = LENSES[name](number)
    group = Group(f"{name} {number}", lens, layout, noise_px)
    picks = np.clip(group.picks_px(1)[0], 0, np.array(SIZE) - 1.0)
    try:
        made = plumbline.calibrate(plumbline.Observations.from_arrays(group.by_line(picks), SIZE))
    except plumbline.PlumblineError as error:
        return error.message
    if made.quoted is None or made.trust.steadiness is None:
        return "no error is quoted"
    own_px = made.trust.steadiness.own_px
    return Trial(true_px(lens, made), made.quoted.worst_px, own_px, bool(made.doubt))


def row(name: str, layout: Layout, noise_px: float, trials: int) -> Row:
    """All trials of one group."""
    every = [trial(name, layout, noise_px, number) for number in range(trials)]
    return Row(
        f"{name}, {layout.name}, {noise_px:g} px",
        tuple(each for each in every if isinstance(each, Trial)),
        tuple(each for each in every if isinstance(each, str)),
    )


HEAD = f"{'group':48} {'fails':>5} {'true px':>8} {'quote px':>8} {'own px':>7} within %  told %"


def shown(one: Row) -> str:
    """One line of the table."""
    if not one.trials:
        return f"{one.name:48} {len(one.failures):5}  {one.failures[0]}"
    figures = np.median([(t.true_px, t.quoted_px, t.own_px) for t in one.trials], axis=0)
    told = 100 * np.mean([t.told for t in one.trials])
    return (
        f"{one.name:48} {len(one.failures):5} {figures[0]:8.2f} {figures[1]:8.2f} "
        f"{figures[2]:7.2f} {100 * one.within:8.0f} {told:7.0f}"
    )


def main() -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--only", default="", help="groups whose name contains this")
    chosen = parser.parse_args()
    print(HEAD)
    below: list[str] = []
    for name in LENSES:
        for layout in LAYOUTS:
            for noise_px in NOISES_PX:
                if chosen.only not in f"{name}, {layout.name}, {noise_px:g} px":
                    continue
                one = row(name, layout, noise_px, chosen.trials)
                print(shown(one), flush=True)
                if one.within < WANTED:
                    below.append(one.name)
    print(f"\ngroups below {100 * WANTED:.0f} %: {', '.join(below) or 'none'}")


if __name__ == "__main__":
    main()
