"""Calibrations of many lenses of which none may fail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from plumbline import Calibration, Observations, PlumblineError, calibrate_many


def all_calibrated(
    observations: Sequence[Observations], *how: Any, **more: Any
) -> list[Calibration]:
    """What `calibrate_many` makes; the first error is raised."""
    made: list[Calibration] = []
    for each in calibrate_many(observations, *how, **more):
        if isinstance(each, PlumblineError):
            raise each
        made.append(each)
    return made
