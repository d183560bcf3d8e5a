"""Are plumbline's error bars true? Simulated picks, fitted again and again.

    python -m tests.benchmarks.coverage                     1,000 trials a group
    python -m tests.benchmarks.coverage --trials 100 --only GoPro --json coverage.json

The truth is `tests.truth`, never plumbline's own model. A row has, for one group:

    fails      trials that raised or did not settle; each counts as a miss in both coverages
    coeff %    free coefficients whose 95 % interval (Student t) holds the truth
    band %     points of a 9 × 9 grid over the photo where the displacement's error is within the
               95 % limit of its standard error, both after the best common scale and translation
    σ̂²/σ²      mean of the estimated variance of one pick over the true one
    var/CRB    mean squared error of the field over the grid, over its Cramér-Rao bound

The standard error of a displacement is the root of the summed variances of its two components,
so the length of the error over it is Student's t only where the error has one direction, as for a
lens held at the photo's centre. Elsewhere, with variances in the ratio w : 1 - w along the two
principal directions, its square is a mixture of chi squares over an independent σ̂²/σ², and the
limit is that mixture's 95 % point, w taken from the Cramér-Rao bound and not from plumbline.

The pooled variance is the mean of var/CRB over the groups, so that none weighs more than another.
The last groups are of another family than the one fitted: there are no true coefficients to cover,
the displacement is off by the model's error, which no error bar here holds, and they are shown but
not judged.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import t as student

import plumbline
from plumbline.trust.displacement import displacement_errors
from tests.benchmarks.field import (
    GRID,
    bound,
    coefficients,
    field_px,
    leaves_perspective,
    names_of,
)
from tests.benchmarks.groups import ALIKE, UNLIKE
from tests.benchmarks.simulated import Group
from tests.benchmarks.trials import Fitted, fit_trials, of
from tests.truth import Array, grid_px

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Row:
    """What came of one group; shares from 0 to 1.

    Attributes:
        group: Its name.
        n_points: Number of picks.
        n_lines: Number of lines.
        trials: Number of trials.
        failures: Sentences of those that failed.
        unbanded: Fits whose model folds in the photo, so that there is no band.
        coverage: Of the coefficients' intervals; None where the family is not the true one.
        band: Of the displacement's band.
        variance: Mean σ̂² over σ².
        field: Mean squared field error over its bound; None as for `coverage`.
        field_px: Root mean square field error, pixels.
        claimed_px: What the fits claim it to be, root mean square.
    """

    group: str
    n_points: int
    n_lines: int
    trials: int
    failures: tuple[str, ...]
    unbanded: int
    coverage: float | None
    band: float
    variance: float
    field: float | None
    field_px: float
    claimed_px: float


def limit(share: float, dof: int) -> float:
    """The 95 % point of the length of a two-dimensional error over its standard error.

    With u the direction in standard coordinates, the length over it is χ²₂, so that the
    probability is the mean over all u of the distribution function of F(2, dof), in closed form.

    Args:
        share: Part of the variance that lies along one principal direction.
        dof: Degrees of freedom of the estimated variance.
    """
    angles = (np.arange(2000) + 0.5) / 2000 * np.pi
    stretch = share * np.cos(angles) ** 2 + (1 - share) * np.sin(angles) ** 2

    def missing(length: float) -> float:
        outside = (1 + length**2 / stretch / dof) ** (-dof / 2)
        return float(np.mean(outside)) - (1 - CONFIDENCE)

    return cast(float, brentq(missing, 0.1, 100.0))


def row(group: Group, trials: int) -> Row:
    """Fit a group's trials and compare with the truth."""
    return summed_up(group, fit_trials(group, group.picks_px(trials)))


def summed_up(group: Group, fitted: Fitted) -> Row:
    """Compare the fits of a group's trials with the truth."""
    fits = fitted.good
    field = field_px(
        group.lens,
        coefficients(of(fits)),
        group.model,
        perspective=leaves_perspective(group),
    )
    squared = np.sum(field**2, axis=-1)
    claims = _claims(group, fits)
    banded = np.isfinite(claims[:, 0])
    alike = group.true_family
    within = np.sqrt(squared) <= _limits(group, fits) * claims
    return Row(
        group=group.name,
        n_points=group.n_points,
        n_lines=len(group.lines),
        trials=fitted.trials,
        failures=tuple(f"trial {number}: {why}" for number, why in fitted.failures),
        unbanded=int(np.count_nonzero(~banded)),
        coverage=_covered(group, fits) / fitted.trials if alike else None,
        band=float(np.sum(np.mean(within, axis=1))) / fitted.trials,
        variance=float(np.mean([fit.sigma_px**2 for fit in fits])) / group.noise_px**2,
        field=float(np.mean(squared)) / bound(group).rms_px ** 2 if alike else None,
        field_px=float(np.sqrt(np.mean(squared))),
        claimed_px=float(np.sqrt(np.mean(claims[banded] ** 2))),
    )


def _covered(group: Group, fits: Sequence[plumbline.Calibration]) -> float:
    """Sum over the fits of the share of free coefficients whose interval holds the truth."""
    names = names_of(group)
    truth = np.array([group.lens.all_coefficients[name] for name in names])
    found = np.array([[fit.coefficients[name] for name in names] for fit in fits])
    errors = np.array([[fit.standard_errors[name] for name in names] for fit in fits])
    widest = np.array([student.ppf((1 + CONFIDENCE) / 2, fit.dof) for fit in fits])
    return float(np.sum(np.mean(np.abs(found - truth) <= widest[:, None] * errors, axis=1)))


def _claims(group: Group, fits: Sequence[plumbline.Calibration]) -> NDArray[np.float64]:
    """The displacement's standard errors that the fits claim, shape (fits, GRID²)."""
    points = grid_px(group.lens.size, GRID)
    none = np.full(len(points), np.nan)
    claimed = [displacement_errors(f.lens, f.free, f.covariance, points) for f in fits]
    return np.stack([none if each is None else each for each in claimed])


def _limits(group: Group, fits: Sequence[plumbline.Calibration]) -> Array:
    """The 95 % limits at the grid's points in standard errors, shape (fits, GRID²)."""
    shares = np.ones(GRID**2)
    if group.true_family:
        main = np.linalg.eigvalsh(bound(group).field_px2)
        shares = np.round(main[:, 1] / np.sum(main, axis=1), 6)

    def limits(dof: int) -> list[float]:
        known = {share: limit(share, dof) for share in set(shares.tolist())}
        return [known[share] for share in shares.tolist()]

    of_dof = {dof: limits(dof) for dof in {fit.dof for fit in fits}}
    return np.array([of_dof[fit.dof] for fit in fits])


HEAD = (
    f"{'group':54} {'points':>6} {'lines':>5} {'fails':>5} {'coeff %':>7} {'band %':>6} "
    f"{'σ̂²/σ²':>6} {'var/CRB':>7} {'rms px':>7}"
)


def shown(one: Row) -> str:
    """One line of the table."""
    coverage = "" if one.coverage is None else f"{100 * one.coverage:.1f}"
    field = "" if one.field is None else f"{one.field:.3f}"
    return (
        f"{one.group:54} {one.n_points:6} {one.n_lines:5} {len(one.failures):5} {coverage:>7} "
        f"{100 * one.band:6.1f} {one.variance:6.3f} {field:>7} {one.field_px:7.3f}"
    )


def targets(rows: Sequence[Row]) -> list[tuple[str, float, bool]]:
    """Each target with its figure and whether it is met; of groups of the fitted family."""
    covered = [(row.coverage, row.band) for row in rows if row.coverage is not None]
    both = np.array(covered)
    mean, worst = both.mean(axis=0).tolist(), both.min(axis=0).tolist()
    variance = float(np.mean([row.variance for row in rows if row.coverage is not None]))
    field = float(np.mean([row.field for row in rows if row.field is not None]))
    found: list[tuple[str, float, bool]] = []
    for index, what in enumerate(("coefficients", "displacement band")):
        good = 0.94 <= mean[index] <= 0.96
        found.append((f"mean coverage of the {what}, 0.94 to 0.96", mean[index], good))
        good = worst[index] >= 0.92
        found.append((f"worst group's coverage of the {what}, at least 0.92", worst[index], good))
    found.append(("mean σ̂²/σ², 0.98 to 1.02", variance, abs(variance - 1) <= 0.02))
    what = "pooled field variance over its bound, 0.97 to 1.03"
    return [*found, (what, field, abs(field - 1) <= 0.03)]


def main() -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--only", default="", help="groups whose name contains this")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    groups = [group for group in (*ALIKE, *UNLIKE) if chosen.only in group.name]
    rows: list[Row] = []
    print(HEAD)
    for group in groups:
        rows.append(row(group, chosen.trials))
        print(shown(rows[-1]), flush=True)
        for sentence in rows[-1].failures[:5]:
            print("    failed,", sentence)
    alike = [row for row in rows if row.coverage is not None]
    print(f"\n{len(rows)} groups of {chosen.trials} trials, {len(alike)} of the fitted family")
    failed, unbanded = sum(len(row.failures) for row in rows), sum(row.unbanded for row in rows)
    print(f"failures: {failed}; fits without a band: {unbanded}")
    if alike:
        for what, figure, met in targets(rows):
            print(f"{what:60} {figure:.4f}  {'met' if met else 'NOT MET'}")
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
