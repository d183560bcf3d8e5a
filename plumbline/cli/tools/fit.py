"""Fit the lenses of a project: `plumbline fit` minus its parsing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from plumbline.cli.option_types import AUTO
from plumbline.cli.tools.narration import named, progress_bar
from plumbline.cli.tools.report import compared
from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.trust.verdicts import suspects_check

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
    made: list[Calibration] = []
    for part in parts:
        with named(part, len(parts)):
            calibration = _fitted(part, wishes, narration)
            if wishes.bootstrap is not None:
                calibration = _again(calibration, wishes.bootstrap, narration)
            made.append(calibration)
    return made


def compare_lenses(
    parts: Sequence[Observations], narration: Console, *, robust: bool
) -> list[Comparison]:
    """Compare all models on one lens after the other.

    Raises:
        PlumblineError: as `compare`; the sentence says which files and photos it is about.
    """
    made: list[Comparison] = []
    for part in parts:
        with named(part, len(parts)):
            made.append(compared(part, narration, robust=robust))
    return made


def _fitted(part: Observations, wishes: Wishes, narration: Console) -> Calibration:
    model, free, notes = wishes.model, wishes.free, list[str]()
    if model == AUTO:
        comparison = compared(part, narration, robust=wishes.robust)
        chosen = comparison.candidates[comparison.recommended]
        model, free = chosen.model, chosen.free
        notes = [
            f"{chosen.name} was chosen: {comparison.reason}",
            comparison.quote,
            comparison.beyond,
        ]
    with narration.status("Fitting…"):
        from plumbline.fit.calibrate import calibrate

        how: dict[str, Any] = {
            "model": model,
            "free": free,
            "hold": wishes.hold,
            "start": wishes.start,
            "residual": wishes.residual,
        }
        try:
            made = calibrate(part, **how, robust=wishes.robust)
        except DegenerateLinesError as error:
            if not wishes.robust and (other := without_wrong_picks(part, **how)) is not None:
                finding = suspects_check(replace(other, robust=False).trust).finding
                error.hint = f"{finding}: --robust fits the others"
            raise
    return replace(made, remarks=(*made.remarks, *filter(None, notes)))


def without_wrong_picks(part: Observations, **how: Any) -> Calibration | None:
    """The robust fit where the plain one is refused; None if it finds no lens either."""
    from plumbline.fit.calibrate import calibrate

    try:
        made = calibrate(part, **how, robust=True)
    except PlumblineError:
        return None
    return made if made.converged else None


def _again(made: Calibration, fits: int, narration: Console) -> Calibration:
    from plumbline.fit.bootstrap import bootstrap

    with progress_bar(narration, "Bootstrap", fits) as advance:
        return bootstrap(made, fits, advance)
