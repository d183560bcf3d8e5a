"""Check the picks of a project: `plumbline check` minus its parsing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from plumbline.cli.tools.narration import name_the_source

if TYPE_CHECKING:
    from rich.console import Console

    from plumbline.observations import Observations
    from plumbline.result.checked import Checked


def check_lenses(parts: Sequence[Observations], narration: Console, **how: Any) -> list[Checked]:
    """Check one lens after the other; `how` as for `plumbline.check`.

    Raises:
        PlumblineError: as `plumbline.check`.
    """
    found: list[Checked] = []
    for part in parts:
        with narration.status("Fitting…"):
            from plumbline.fit.check import check

            checked = check(part, **how)
        if checked.error is not None:
            named = name_the_source(checked.error, part, len(parts))
            checked = replace(checked, error=named)
        found.append(checked)
    return found
