"""Fit the lenses of a project: `plumbline fit` minus its parsing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plumbline.cli.tools.narration import named, progress_bar
from plumbline.cli.tools.report import compared

if TYPE_CHECKING:
    from rich.console import Console

    from plumbline.observations import Observations
    from plumbline.result.calibration import Calibration
    from plumbline.result.comparison import Comparison


@dataclass(frozen=True)
class Wishes:
    """How the user wants lenses fitted.

    Attributes:
        model: Name of the model, or "auto" for the one that `compare` recommends.
        free: Coefficients to fit; None by default.
        hold: Coefficients not to fit.
        start: Start vector.
        residual: Kind of residual.
        robust: Leave suspicious picks out.
        bootstrap: Number of bootstrap fits; None for no bootstrap.
    """

    model: str
    free: tuple[str, ...] | None
    hold: tuple[str, ...]
    start: Any
    residual: Any
    robust: bool
    bootstrap: int | None


def fit_lenses(
    parts: Sequence[Observations], wishes: Wishes, narration: Console
) -> list[Calibration]:
    """Fit one lens after the other.

    Raises:
        PlumblineError: as `calibrate`; the sentence says which files and photos it is about.
    """
    calibrations: list[Calibration] = []
    for part in parts:
        with named(part, len(parts)):
            calibration = _fitted(part, wishes, narration)
            if wishes.bootstrap is not None:
                calibration = _again(calibration, wishes.bootstrap, narration)
            calibrations.append(calibration)
    return calibrations


def compare_lenses(
    parts: Sequence[Observations], narration: Console, *, robust: bool
) -> list[Comparison]:
    """Compare all models on one lens after the other.

    Raises:
        PlumblineError: as `compare`; the sentence says which files and photos it is about.
    """
    comparisons: list[Comparison] = []
    for part in parts:
        with named(part, len(parts)):
            comparisons.append(compared(part, narration, robust=robust))
    return comparisons


def _fitted(part: Observations, wishes: Wishes, narration: Console) -> Calibration:
    from plumbline.fit.calibrate import AUTO, calibrate
    from plumbline.fit.choice.compare import ROWS

    how: dict[str, Any] = {
        "model": wishes.model,
        "free": wishes.free,
        "hold": wishes.hold,
        "start": wishes.start,
        "residual": wishes.residual,
        "robust": wishes.robust,
    }
    if wishes.model == AUTO:
        with progress_bar(narration, "Comparing models", len(ROWS)) as advance:
            return calibrate(part, **how, done=lambda: advance(1))
    with narration.status("Fitting…"):
        return calibrate(part, **how)


def _again(calibration: Calibration, fits: int, narration: Console) -> Calibration:
    from plumbline.fit.bootstrap import bootstrap

    with progress_bar(narration, "Bootstrap", fits) as advance:
        return bootstrap(calibration, fits, advance)
