"""Draw reports and figures with their comparison of models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from plumbline.cli.tools.narration import progress_bar

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console

    from plumbline.observations import Observations
    from plumbline.result.calibration import Calibration
    from plumbline.result.comparison import Comparison


def draw(
    calibrations: Sequence[Calibration],
    report: str | None,
    plots: Sequence[str],
    narration: Console,
    **where: Any,
) -> tuple[dict[Path, bytes], list[str]]:
    """A report with its comparison of models, and single figures, as `report_contents`."""
    from plumbline.report.writing import comparisons_of, refuse_targets, report_contents

    inputs = [where.get("source"), where.get("photo")]
    refuse_targets(calibrations, report, plots, inputs, overwrite=where.get("overwrite", False))
    wanted = calibrations if report is not None else ()
    comparisons, failed = comparisons_of(
        wanted, lambda part: compared(part, narration, robust=False)
    )
    with narration.status("Drawing…"):
        drawn, notes = report_contents(
            calibrations, report, plots, comparisons=comparisons, **where
        )
    return drawn, [*notes, *failed]


def compared(part: Observations, narration: Console, *, robust: bool) -> Comparison:
    """Compare all models, with a progress bar."""
    from plumbline.fit.choice.compare import ROWS, compare

    with progress_bar(narration, "Comparing models", len(ROWS)) as advance:
        return compare(part, lambda: advance(1), robust=robust)
