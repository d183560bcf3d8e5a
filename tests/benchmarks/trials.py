"""Fit the trials of a simulated group, failures kept apart and in view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import plumbline
from tests.benchmarks.simulated import Group
from tests.truth import Array

_AT_ONCE = 250


@dataclass(frozen=True)
class Fitted:
    """What came of a group's trials.

    Attributes:
        trials: How many there were.
        good: The calibrations of those that did not fail.
        numbers: The numbers of those trials.
        failures: The number and the sentence of those that did.
    """

    trials: int
    good: tuple[plumbline.Calibration, ...]
    numbers: tuple[int, ...]
    failures: tuple[tuple[int, str], ...]


def observations(group: Group, points_px: Array) -> plumbline.Observations:
    """Picks of all lines, shape (n, 2), as plumbline takes them."""
    return plumbline.Observations.from_arrays(
        group.by_line(points_px), group.lens.size, pixel_aspect=group.lens.aspect
    )


def fit_trials(group: Group, picks_px: Array, *, robust: bool = False) -> Fitted:
    """Fit every trial; one that raises or does not settle is a failure.

    Args:
        group: The group.
        picks_px: Picks of the trials, shape (trials, n, 2).
        robust: Whether suspicious picks are left out.
    """
    outcomes: list[plumbline.Calibration | plumbline.PlumblineError] = []
    for first in range(0, len(picks_px), _AT_ONCE):
        some = [observations(group, points) for points in picks_px[first : first + _AT_ONCE]]
        outcomes += plumbline.calibrate_many(some, group.model, free=group.free, robust=robust)
    good: list[plumbline.Calibration] = []
    numbers: list[int] = []
    failures: list[tuple[int, str]] = []
    for number, outcome in enumerate(outcomes):
        if isinstance(outcome, plumbline.PlumblineError):
            failures.append((number, outcome.message))
        elif not outcome.converged:
            failures.append((number, outcome.reason))
        else:
            good.append(outcome)
            numbers.append(number)
    return Fitted(len(outcomes), tuple(good), tuple(numbers), tuple(failures))


def of(fits: Sequence[plumbline.Calibration]) -> list[dict[str, float]]:
    """The coefficients of many calibrations."""
    return [fit.coefficients for fit in fits]
