"""Dense samples of edges that bend by themselves: are the error bars true, and is the fit better?

    python -m tests.benchmarks.dense                    60 trials a group
    python -m tests.benchmarks.dense --only shared --trials 100

Every edge of every trial has white noise of 0.08 px and a bend of its own: waves, smooth curves,
kinks, arcs, steps; none of them drawn from a covariance that the fit knows. In some groups lines
bend unequally, in others parallel neighbours share the bend. A row has

    plain %    points of a 9 × 9 grid over the photo where the ordinary fit's error is within 1.96
               standard errors for independent picks, after the best common scale and translation
    own %      the same of the fit made, by its own covariance
    quoted %   the same by the picks' part of the error that is quoted
    ols, fit   root mean square error over the grid of the ordinary fit and of the one made
    share      one over the other
    bends      share of the trials in which bends were told from noise
    σ̂, bend    median noise and bend (rms) that the fit finds; the noise is 0.08 px

The truth is `tests.truth`, never plumbline's own model.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

import plumbline
from plumbline.fit.outcome import lens_of
from plumbline.fit.problem import prepare
from plumbline.fit.program.solve import solve
from plumbline.models import get_model
from plumbline.trust.covariance import covariance_of
from plumbline.trust.displacement import displacement_errors, grid_px
from plumbline.trust.nuisances import DECENTRING, RADIAL
from plumbline.trust.straightness import edges_bend_px
from plumbline.trust.student import widening
from tests.benchmarks.field import coefficients, field_px
from tests.benchmarks.groups import lens
from tests.benchmarks.simulated import Group, Layout
from tests.benchmarks.trials import observations
from tests.truth import Array

NOISE_PX = 0.08
_CLEAR_PX = 0.7
"""Noise that the layout is made for, so that no bend leaves the photo."""

Curve = Callable[[Array, np.random.Generator], Array]


def waves(share: Array, rng: np.random.Generator) -> Array:
    """Three sine waves of 0.15 to 1.2 of the line."""
    periods = rng.uniform(0.15, 1.2, 3)
    phases = rng.uniform(0, 2 * np.pi, 3)
    sizes = rng.standard_normal(3)
    return np.asarray(np.sin(2 * np.pi * share[:, None] / periods + phases) @ sizes)


def gauss(share: Array, rng: np.random.Generator, width: float = 0.3) -> Array:
    """A Gaussian process whose covariance is itself a Gaussian: smoother than the fit reckons."""
    gap = (share[:, None] - share) / width
    covariance = np.exp(-0.5 * gap**2) + 1e-9 * np.eye(len(share))
    return np.asarray(np.linalg.cholesky(covariance) @ rng.standard_normal(len(share)))


def ripples(share: Array, rng: np.random.Generator) -> Array:
    """The same over a tenth of the line."""
    return gauss(share, rng, 0.1)


def kinks(share: Array, rng: np.random.Generator) -> Array:
    """Boards end to end, each a little askew: straight between three to eight knots."""
    knots = np.sort(np.concatenate(([0.0, 1.0], rng.uniform(0, 1, rng.integers(2, 7)))))
    return np.interp(share, knots, rng.standard_normal(len(knots)))


def arcs(share: Array, rng: np.random.Generator) -> Array:
    """One bow, or an S."""
    t = 2 * share - 1
    return rng.standard_normal() * (1 - t**2) + rng.standard_normal() * (t**3 - t)


def steps(share: Array, rng: np.random.Generator) -> Array:
    """Bricks side by side, each a little off."""
    number = int(rng.integers(5, 20))
    return rng.standard_normal(number)[np.minimum((share * number).astype(int), number - 1)]


CURVES: dict[str, Curve] = {
    each.__name__: each for each in (waves, gauss, ripples, kinks, arcs, steps)
}


class Case(NamedTuple):
    """A group of trials.

    Attributes:
        group: Lens and lines.
        curve: The kind of bend.
        bend_px: Its root mean square.
        uneven: Standard deviation of the logarithm of a line's own amplitude.
        shared: Whether neighbours of a pair bend alike.
    """

    group: Group
    curve: str
    bend_px: float
    uneven: float = 0.0
    shared: bool = False

    @property
    def name(self) -> str:
        """For people."""
        told = f"{self.group.lens_name}, {self.group.layout.name}: {self.curve} {self.bend_px:g} px"
        return told + (", uneven" if self.uneven else "") + (", shared" if self.shared else "")


def _group(name: str, layout: Layout) -> Group:
    return Group(name, lens(name), layout, _CLEAR_PX)


FACADE = Layout("24 lines of 32", 24, 32, 32)
FEW = Layout("12 lines of 100", 12, 100, 100)
MIXED = Layout("30 lines of 20 to 60", 30, 20, 60, slanted=True)
JOINTS = Layout("16 joints, both sides", 32, 32, 48, paired=True, gap=0.015)

CASES = (
    Case(_group("S120 5.2 mm", FACADE), "waves", 0.0),
    Case(_group("Sigma 14 mm", FACADE), "waves", 0.05),
    Case(_group("E 10-18 at 14 mm", FACADE), "kinks", 0.1),
    Case(_group("S120 5.2 mm", FACADE), "waves", 0.2),
    Case(_group("S120 5.2 mm", FACADE), "gauss", 0.2),
    Case(_group("S120 5.2 mm", FACADE), "waves", 0.2, 1.0),
    Case(_group("G7 X 8.8 mm", FEW), "waves", 0.2),
    Case(_group("G7 X 8.8 mm", FEW), "gauss", 0.2, 1.0),
    Case(_group("Sigma 14 mm", MIXED), "ripples", 0.2, 1.0),
    Case(_group("FC6310 drone", MIXED), "kinks", 0.2, 1.0),
    Case(_group("FC6310 drone", FACADE), "arcs", 0.2),
    Case(_group("Sigma 14 mm", FACADE), "steps", 0.5),
    Case(_group("E 10-18 at 14 mm", FEW), "kinks", 0.5),
    Case(_group("S120 5.2 mm", MIXED), "gauss", 1.0),
    Case(_group("G7 X 8.8 mm", FACADE), "waves", 1.0, 1.0),
    Case(_group("S120 5.2 mm", JOINTS), "waves", 0.2, 0.0, True),
    Case(_group("Sigma 14 mm", JOINTS), "kinks", 0.2, 1.0, True),
    Case(_group("G7 X 8.8 mm", JOINTS), "gauss", 0.5, 0.0, True),
)


@dataclass(frozen=True)
class Row:
    """What came of one group; shares from 0 to 1."""

    name: str
    bend_px: float
    failures: int
    plain: float
    own: float
    quoted: float
    ordinary_px: float
    fitted_px: float
    seen: float
    sigma_px: float
    found_px: float


def picks(case: Case, trial: int) -> Array:
    """Samples of one trial, shape (n, 2)."""
    group, rng = case.group, case.group.rng(f"{case.name} dense", trial)
    parts: list[Array] = []
    bends: list[Array] = []
    for number, line in enumerate(group.lines):
        share = (line.places_px - line.places_px[0]) / np.ptp(line.places_px)
        twin = number - 2  # both sides of a joint stand two lines apart, see `Layout.paired`
        if case.shared and number % 4 >= 2:
            own = line.places_px - group.lines[twin].places_px[0]
            of_twin = group.lines[twin].places_px - group.lines[twin].places_px[0]
            bends.append(np.interp(own, of_twin, bends[twin]))
        else:
            size = np.exp(case.uneven * rng.standard_normal() - case.uneven**2)
            bends.append(size * unit(CURVES[case.curve], share, rng) * case.bend_px)
        parts.append(bends[-1])
    across_px = np.concatenate(parts)[:, None] * group.across
    return group.true_px + across_px + NOISE_PX * rng.standard_normal(group.true_px.shape)


def unit(curve: Curve, share: Array, rng: np.random.Generator) -> Array:
    """A bend whose root mean square is 1 over many of its kind."""
    return curve(share, rng) / _usual(curve)


def _usual(curve: Curve) -> float:
    if curve.__name__ not in _USUAL:
        rng, share = np.random.default_rng(5), np.linspace(0, 1, 64)
        squares = [np.mean(curve(share, rng) ** 2) for _ in range(400)]
        _USUAL[curve.__name__] = float(np.sqrt(np.mean(squares)))
    return _USUAL[curve.__name__]


_USUAL: dict[str, float] = {}


def row(case: Case, trials: int) -> Row:
    """Fit a group's trials and compare with the truth."""
    within: list[list[float]] = []
    squares: list[list[float]] = []
    seen: list[bool] = []
    found: list[list[float]] = []
    failures = 0
    for trial in range(trials):
        observed = observations(case.group, picks(case, trial))
        try:
            made = plumbline.calibrate(observed)
            plain = ordinary(made)
            wrong_px = [error_px(case.group, each) for each in (plain, made)]
            claims = [own_px(plain), own_px(made), quoted_px(made)]
        except plumbline.PlumblineError:
            failures += 1
            continue
        errors = (wrong_px[0], wrong_px[1], wrong_px[1])
        within.append([float(np.mean(e <= 1.96 * c)) for e, c in zip(errors, claims, strict=True)])
        squares.append([float(np.mean(each**2)) for each in wrong_px])
        seen.append(made.bends is not None)
        found.append([made.sigma_px, edges_bend_px(made.lines) or 0.0])
    plain, own, quoted = (np.sum(within, axis=0) / trials).tolist()
    ordinary_px, fitted_px = np.sqrt(np.mean(squares, axis=0)).tolist()
    sigma_px, found_px = np.median(found, axis=0).tolist()
    return Row(
        name=case.name,
        bend_px=case.bend_px,
        failures=failures,
        plain=plain,
        own=own,
        quoted=quoted,
        ordinary_px=ordinary_px,
        fitted_px=fitted_px,
        seen=float(np.mean(seen)),
        sigma_px=sigma_px,
        found_px=found_px,
    )


def ordinary(made: plumbline.Calibration) -> plumbline.Calibration:
    """The ordinary fit of the same picks."""
    problem = prepare(made.observations, get_model(made.model), made.free, (), None, "image")
    found = lens_of(problem, solve(problem.model, problem.task))
    plain = replace(made, lens=found, bends=None)
    covariance, sigma_px = covariance_of(plain.linearised, made.dof)
    return replace(plain, covariance=covariance, sigma_px=sigma_px)


def error_px(group: Group, made: plumbline.Calibration) -> Array:
    """Errors over the grid, shape (81,)."""
    field = field_px(group.lens, coefficients([made.coefficients]), made.model)[0]
    return np.asarray(np.hypot(*field.T))


def own_px(made: plumbline.Calibration) -> Array:
    """Standard errors over the grid by the covariance, shape (81,)."""
    found = displacement_errors(made.lens, made.free, made.covariance, grid_px(made.lens))
    if found is None:
        raise plumbline.DegenerateLinesError("the model folds inside the photo")
    return found


def quoted_px(made: plumbline.Calibration) -> Array:
    """The picks' part of the error that is quoted, over the grid, shape (81,)."""
    own, steady, wide = own_px(made), made.trust.steadiness, made.jackknife_displacement
    if steady is None or wide is None:
        return own * widening(made.dof)
    wrong = any(made.trust.besides.unlike(kind) for kind in (RADIAL, DECENTRING))
    pooled = steady.pooled(own, wide.errors_px, by_lines=steady.alarmed and not wrong)
    return np.maximum(own * widening(made.dof), pooled)


HEAD = (
    f"{'group':60} {'fails':>5} {'plain %':>7} {'own %':>6} {'quoted %':>8} {'ols px':>7} "
    f"{'fit px':>7} {'share':>6} {'bends':>6} {'σ̂':>6} {'bend':>6}"
)


def shown(one: Row) -> str:
    """One line of the table."""
    return (
        f"{one.name:60} {one.failures:5} {100 * one.plain:7.1f} {100 * one.own:6.1f} "
        f"{100 * one.quoted:8.1f} {one.ordinary_px:7.3f} {one.fitted_px:7.3f} "
        f"{one.fitted_px / one.ordinary_px:6.2f} {one.seen:6.2f} {one.sigma_px:6.3f} "
        f"{one.found_px:6.3f}"
    )


def targets(rows: list[Row]) -> list[str]:
    """Each target with its figure and whether it is met."""
    covered = np.array([one.quoted for one in rows])
    shares = [one.fitted_px / one.ordinary_px for one in rows if one.bend_px == 0.2]
    mean, worst = float(covered.mean()), float(covered.min())
    share = float(np.exp(np.mean(np.log(shares)))) if shares else np.nan
    return [
        f"mean coverage of the quoted error, 93 to 97 %: {100 * mean:.1f} "
        f"{_met(0.93 <= mean <= 0.97)}",
        f"worst group, at least 88 %: {100 * worst:.1f} {_met(worst >= 0.88)}",
        f"error over the ordinary fit's where edges bend by 0.2 px, at most 0.6: {share:.2f} "
        f"{_met(share <= 0.6)}",
    ]


def _met(true: bool) -> str:
    return "met" if true else "NOT MET"


def main() -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument("--only", default="", help="groups whose name contains this")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    print(HEAD)
    rows: list[Row] = []
    for case in CASES:
        if chosen.only in case.name:
            rows.append(row(case, chosen.trials))
            print(shown(rows[-1]), flush=True)
    print("\n".join(targets(rows)))
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(one) for one in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
