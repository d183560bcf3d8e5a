"""Check the picks of a project: `plumbline check` minus its parsing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

from plumbline.cli.tools.fit import without_wrong_picks
from plumbline.cli.tools.narration import name_the_source
from plumbline.errors import PlumblineError
from plumbline.fit.options import plan
from plumbline.models import get_model
from plumbline.trust.check import Check
from plumbline.trust.placement import before_fit
from plumbline.trust.verdicts import after_fit, suspects_check

if TYPE_CHECKING:
    from rich.console import Console

    from plumbline.observations import Observations
    from plumbline.result.calibration import Calibration
    from plumbline.trust.suspect import Suspect


@dataclass(frozen=True)
class Checked:
    """What was found of one lens.

    Attributes:
        checks: All checks.
        suspects: Suspicious picks.
        error: Why it could not be fitted, if it could not.
    """

    checks: tuple[Check, ...]
    suspects: tuple[Suspect, ...] = ()
    error: PlumblineError | None = None


def check_lenses(
    parts: Sequence[Observations],
    model: str,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...],
    narration: Console,
) -> list[Checked]:
    """Check one lens after the other.

    Raises:
        PlumblineError: a coefficient or the model is unknown, or a photo is no rectilinear one.
    """
    chosen = get_model(model)
    found: list[Checked] = []
    for part in parts:
        fitted = plan(chosen, part.lenses[0], free, hold, None).free
        radial = [name for name in fitted if name in chosen.radial]
        before = before_fit(part, len(fitted), len(radial))
        with narration.status("Fitting…"):
            from plumbline.fit.calibrate import calibrate

            try:
                made = calibrate(part, model, free=free, hold=hold)
            except PlumblineError as error:
                other = without_wrong_picks(part, model=model, free=free, hold=hold)
                named = name_the_source(error, part, len(parts))
                found.append(_refused(before, named, other))
                continue
        found.append(Checked((*before, *after_fit(made.trust)), made.suspects))
    return found


def _refused(
    before: tuple[Check, ...], error: PlumblineError, other: Calibration | None
) -> Checked:
    """What is known of a lens that was not fitted; the robust fit may know which picks are wrong.

    Args:
        before: The checks before a fit.
        error: Why it was not fitted.
        other: The robust fit, where it found a lens.
    """
    if other is None:
        return Checked(before, error=error)
    error.hint = "look at the suspicious picks; plumbline fit --robust leaves them out"
    suspicious = suspects_check(replace(other, robust=False).trust)
    return Checked((*before, suspicious), other.suspects, error)


def as_dict(checked: Checked) -> dict[str, Any]:
    """What was found of one lens, as plain lists, dicts, strings and numbers."""
    return {
        "checks": [asdict(check) for check in checked.checks],
        "suspects": [
            {
                name: None if isinstance(value, float) and not isfinite(value) else value
                for name, value in asdict(suspect).items()
            }
            for suspect in checked.suspects
        ],
        "error": None if checked.error is None else checked.error.message,
    }
