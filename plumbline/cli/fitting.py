"""Fit the lenses of a project: `plumbline fit` minus its parsing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from plumbline.cli.option_types import AUTO
from plumbline.cli.pipeline import name_the_source
from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.trust_checks import suspects_check

if TYPE_CHECKING:
    from collections.abc import Generator
    from pathlib import Path

    from rich.console import Console

    from plumbline.calibration import Calibration
    from plumbline.comparison import Comparison
    from plumbline.observations import Observations


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
        with _named(part, len(parts)):
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
        with _named(part, len(parts)):
            made.append(_compared(part, narration, robust=robust))
    return made


def draw(
    calibrations: Sequence[Calibration],
    report: str | None,
    plots: Sequence[str],
    narration: Console,
    **where: Any,
) -> tuple[dict[Path, bytes], list[str]]:
    """A report with its comparison of models, and single figures, as `report_contents`."""
    from plumbline.report.writing import report_contents

    comparisons: list[Comparison | None] = []
    failed: list[str] = []
    for made in calibrations if report is not None else ():
        try:
            comparisons.append(_compared(made.kept_observations, narration, robust=False))
        except PlumblineError as error:
            comparisons.append(None)
            failed.append(f"models are not compared in the report: {error.message}")
    with narration.status("Drawing…"):
        drawn, notes = report_contents(
            calibrations, report, plots, comparisons=comparisons, **where
        )
    return drawn, [*notes, *failed]


def _compared(part: Observations, narration: Console, *, robust: bool) -> Comparison:
    from plumbline.fit.compare import ROWS, compare

    with _progress(narration, "Comparing models", len(ROWS)) as advance:
        return compare(part, lambda: advance(1), robust=robust)


def _fitted(part: Observations, wishes: Wishes, narration: Console) -> Calibration:
    model, free, notes = wishes.model, wishes.free, list[str]()
    if model == AUTO:
        comparison = _compared(part, narration, robust=wishes.robust)
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
                finding = suspects_check(replace(other, robust=False)).finding
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

    with _progress(narration, "Bootstrap", fits) as advance:
        return bootstrap(made, fits, advance)


def _progress(
    narration: Console, what: str, total: int
) -> AbstractContextManager[Callable[[int], object]]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Remaining())

    @contextmanager
    def running() -> Generator[Callable[[int], object]]:
        hidden = not narration.is_terminal
        with Progress(*columns, console=narration, transient=True, disable=hidden) as progress:
            task = progress.add_task(what, total=total)
            yield lambda steps: progress.advance(task, steps)

    return running()


@contextmanager
def _named(part: Observations, n_parts: int) -> Generator[None]:
    try:
        yield
    except PlumblineError as error:
        raise name_the_source(error, part, n_parts) from None
