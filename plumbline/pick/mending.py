"""Trace a line again that was traced before the lens was known, and along another edge than meant.

The first lines of a photo are traced under guesses of how the lens bends them. Once other lines
tell the lens, one of these that fits to none of them is traced again.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from plumbline.pick.document import Change, Document, PickedLine
from plumbline.pick.editing import Tracer
from plumbline.pick.live import Fitted, fit_now
from plumbline.pick.observing import fitted_lines
from plumbline.result.calibration import Calibration

_LEAST_LINES = 4
"""Lines besides the odd one: three tell a lens of three coefficients, one more checks it."""

_STRAIGHTER = 3.0
"""Times that the others must be straighter without the odd line for it to be the odd one. On the
sample façade a line along another edge made σ̂ 1.3 px and 0.04 px without it; leaving out a good
line changed it by less than a fifth."""

_MATTERS_PX = 0.1
"""σ̂ below which nothing is mended: traced edges of real photographs scatter by .05 to .15 px."""

_TRIED = 4
"""Lines that are tried as the odd one, those that bend most: an odd line bends the lens, and with
it others, so that it is not always the worst."""


def mended(document: Document, fitted: Fitted, tracer: Tracer | None) -> Change | None:
    """The odd line traced again under the lens of the others.

    Args:
        document: The document.
        fitted: Its fit.
        tracer: Traces edges; None where there is none.

    Returns:
        None where no traced line is odd, or it fits no better when it is traced again.
    """
    calibration, lines = fitted.calibration, fitted_lines(document)
    if calibration is None or tracer is None or len(lines) <= _LEAST_LINES:
        return None
    if calibration.sigma_px < _MATTERS_PX:
        return None
    odd, rest = _odd(document, lines, calibration)
    if odd is None or rest is None or calibration.sigma_px < _STRAIGHTER * rest.sigma_px:
        return None
    traced = tracer(odd.photo, odd.clicks, rest.lens, 0)
    if traced.refusal:
        return None
    again = msgspec.structs.replace(
        odd, points=traced.points, errors=traced.errors, rivals=traced.rivals, rival=0
    )
    change = Change(odd, again)
    better = fit_now(document.changed([change])).calibration
    return change if better is not None and _fits(better, calibration) else None


def _odd(
    document: Document, lines: Sequence[PickedLine], calibration: Calibration
) -> tuple[PickedLine | None, Calibration | None]:
    """The traced line without which the others are straightest, and their fit."""
    bent = np.argsort([-_rms(residuals) for residuals in calibration.residuals_px])[:_TRIED]
    tried = [lines[index] for index in bent.tolist() if lines[index].snapped]
    fits = [(line, fit_now(_without(document, line)).calibration) for line in tried]
    known = [(line, rest) for line, rest in fits if rest is not None]
    if not known:
        return None, None
    sigmas = [rest.sigma_px for _, rest in known]
    return known[int(np.argmin(sigmas))]


def _fits(better: Calibration, before: Calibration) -> bool:
    return _STRAIGHTER * better.sigma_px < before.sigma_px


def _without(document: Document, line: PickedLine) -> Document:
    return document.changed([Change(line, None)])


def _rms(residuals: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    return float(np.sqrt(np.mean(residuals**2)))
