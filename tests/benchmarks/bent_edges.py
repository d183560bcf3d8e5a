"""Edges that bend by themselves: do the line-by-line jackknife's intervals hold the truth?

    python -m tests.benchmarks.bent_edges               100 trials a group
    python -m tests.benchmarks.bent_edges --only dense --bend 0

Every edge of every trial bends smoothly by 0.5 px (`--bend`), to a side and in a shape of its own,
beside the noise of the picks. A row has the coverage of the 95 % intervals (Student t) of the
coefficients and of the displacement over a 9 × 9 grid of the photo (see
`tests.benchmarks.coverage`), first of the errors that take the picks for independent, then of the
jackknife's; the median ratio of the jackknife's standard error of a coefficient to the other; the
share of the trials in which the summary warns of it, since the ratio of both largest errors is more
than chance makes of lines that lie so (`plumbline.trust.steadiness`), which is the alarm's power
here and its false alarms with `--bend 0`; and both coverages of the larger of the two errors.
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
from tests.benchmarks.coverage import summed_up
from tests.benchmarks.groups import ALIKE
from tests.benchmarks.simulated import Group
from tests.benchmarks.spoiling import bent
from tests.benchmarks.trials import Fitted, fit_trials
from tests.many import all_calibrated
from tests.truth import Array

LEAST = 0.90


class Jackknifed(NamedTuple):
    """What a jackknife says of one calibration.

    Attributes:
        covariance: Of the free coefficients, in their order.
        dof: Degrees of freedom of its Student t.
    """

    covariance: Array
    dof: int


Jackknife = Callable[[plumbline.Calibration], Jackknifed]


@dataclass(frozen=True)
class Row:
    """Both kinds of errors on one group; shares from 0 to 1.

    Attributes:
        group: Its name.
        failures: Sentences of the trials that failed; each is a miss in every coverage.
        plain: Coverage of the coefficients by errors that take the picks for independent.
        plain_band: The same of the displacement.
        jackknife: Coverage of the coefficients by the jackknife's errors.
        jackknife_band: The same of the displacement.
        ratio: Median ratio of both standard errors.
        quoted: Share of the trials in which the summary warns that errors are common to lines.
        rule: Coverage of the coefficients by the larger of both errors.
        rule_band: The same of the displacement.
    """

    group: str
    failures: tuple[str, ...]
    plain: float
    plain_band: float
    jackknife: float
    jackknife_band: float
    ratio: float
    quoted: float
    rule: float
    rule_band: float


def leave_one_out(made: plumbline.Calibration) -> Jackknifed:
    """The textbook's jackknife over lines (Tukey 1958), by refits without one line at a time."""
    lines = made.observations.lines
    fewer = [
        replace(made.observations, lines=(*lines[:left], *lines[left + 1 :]))
        for left in range(len(lines))
    ]
    fits = all_calibrated(fewer, made.model, free=made.free)
    found = np.array([[fit.coefficients[name] for name in made.free] for fit in fits])
    gap = found - found.mean(axis=0)
    return Jackknifed((len(lines) - 1) / len(lines) * gap.T @ gap, len(lines) - 1)


def own(made: plumbline.Calibration) -> Jackknifed:
    """The jackknife of the calibration itself, in one Gauss–Newton step a line."""
    if made.jackknife is None:
        raise plumbline.DegenerateLinesError("the fit needs each of its lines")
    return Jackknifed(made.jackknife.covariance, made.jackknife.dof)


def row(group: Group, trials: int, jackknife: Jackknife, bend_px: float = 0.5) -> Row:
    """Fit a group's trials on bent edges and see which errors cover the truth."""
    fitted = fit_trials(group, bent(group, group.picks_px(trials), bend_px))
    plain = summed_up(group, fitted)
    ratios: list[Array] = []
    by_jackknife: list[plumbline.Calibration] = []
    by_rule: list[plumbline.Calibration] = []
    numbers: list[int] = []
    warned: list[bool] = []
    failures = list(fitted.failures)
    for number, made in zip(fitted.numbers, fitted.good, strict=True):
        try:
            covariance, dof = jackknife(made)
        except plumbline.PlumblineError as error:
            failures.append((number, f"the jackknife failed: {error.message}"))
            continue
        numbers.append(number)
        ratios.append(np.sqrt(np.diag(covariance) / np.diag(made.covariance)))
        by_jackknife.append(replace(made, covariance=covariance, dof=dof))
        by_rule.append(by_jackknife[-1] if made.quotes_jackknife else made)
        warned.append(any(c.name == "line by line" and not c.passed for c in made.checks))
    jack, rule = (
        summed_up(group, Fitted(fitted.trials, tuple(told), tuple(numbers), tuple(failures)))
        for told in (by_jackknife, by_rule)
    )
    return Row(
        group=group.name,
        failures=jack.failures,
        plain=plain.coverage or 0.0,
        plain_band=plain.band,
        jackknife=jack.coverage or 0.0,
        jackknife_band=jack.band,
        ratio=float(np.median(ratios)),
        quoted=float(np.mean(warned)),
        rule=rule.coverage or 0.0,
        rule_band=rule.band,
    )


def main(jackknife: Jackknife = own) -> None:
    """Run all groups and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--only", default="", help="groups whose name contains this")
    parser.add_argument("--bend", type=float, default=0.5, help="how far edges bend, pixels")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    print(
        f"{'group':54} {'fails':>5} {'plain %':>8} {'band %':>7} {'jack %':>7} {'band %':>7} "
        f"{'ratio':>6} {'quoted %':>8} {'so %':>6} {'band %':>6}"
    )
    rows: list[Row] = []
    for group in ALIKE:
        if chosen.only not in group.name:
            continue
        rows.append(one := row(group, chosen.trials, jackknife, chosen.bend))
        print(
            f"{one.group:54} {len(one.failures):5} {100 * one.plain:8.1f} "
            f"{100 * one.plain_band:7.1f} {100 * one.jackknife:7.1f} "
            f"{100 * one.jackknife_band:7.1f} {one.ratio:6.2f} {100 * one.quoted:8.1f} "
            f"{100 * one.rule:6.1f} {100 * one.rule_band:6.1f}",
            flush=True,
        )
        for sentence in one.failures[:3]:
            print("    failed,", sentence)
    for what, values in (
        ("coefficients", [row.jackknife for row in rows]),
        ("displacement", [row.jackknife_band for row in rows]),
    ):
        verdict = "met" if np.mean(values) >= LEAST else "NOT MET"
        print(
            f"mean coverage of the {what} by the jackknife: {np.mean(values):.3f}, worst group "
            f"{min(values):.3f}; at least {LEAST}: {verdict}"
        )
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")


if __name__ == "__main__":
    main()
