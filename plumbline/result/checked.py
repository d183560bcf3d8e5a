"""What a check of the picks found: the result of `plumbline.check`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from plumbline.errors import PlumblineError
from plumbline.result.calibration import Calibration
from plumbline.trust.check import Check
from plumbline.trust.suspect import Suspect


@dataclass(frozen=True, eq=False)
class Checked:
    """What was found of the picks of one lens.

    Attributes:
        checks: Every question with its answer, those before a fit first.
        suspects: Suspicious picks.
        calibration: The fit; None where it was refused.
        error: Why it was refused; None where it was not.
    """

    checks: tuple[Check, ...]
    suspects: tuple[Suspect, ...] = ()
    calibration: Calibration | None = None
    error: PlumblineError | None = None

    @property
    def passed(self) -> bool:
        """Whether the picks can be fitted and nothing is wrong."""
        return self.error is None and all(check.passed for check in self.checks)


def as_dict(checked: Checked) -> dict[str, Any]:
    """What was found, as plain lists, dicts, strings and numbers."""
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
