"""The fit while one picks: at once after a click, and with a search for suspicious picks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plumbline.edges.rough_lens import one_coefficient, polynomial
from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.calibrate import calibrate
from plumbline.fit.outcome import finish
from plumbline.fit.problem import prepare
from plumbline.fit.program.solve import solve
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.pick.document import Document, Settings
from plumbline.pick.observing import LIVE_SAMPLES, fitted_lines, observations_of
from plumbline.result.calibration import Calibration

_ROWS = (16, 32, 64)
"""Numbers of lines whose programs are made ready: a block has at least 16 rows, and few people
pick more than 64 lines."""

_FEW = 3
"""Lines from which more than one coefficient is taken for a prediction: two can be made straight
by lenses that differ wildly elsewhere."""

_TRUSTED = 6
"""Lines from which the fit predicts better than the rough lens, whose coefficients are held near
0 (chosen, because three free coefficients of a fit to fewer lines are hardly determined)."""


@dataclass(frozen=True)
class Fitted:
    """What a fit came to: a calibration, or why there is none and what to do."""

    calibration: Calibration | None
    failure: str = ""
    hint: str = ""


def fit_now(document: Document) -> Fitted:
    """Fit thin samples of all lines, without looking for suspicious picks."""
    try:
        observations = observations_of(document, most=LIVE_SAMPLES)
        return Fitted(_fitted(observations, document.settings))
    except DegenerateLinesError as error:
        return Fitted(None, *_in_words(document, error))
    except PlumblineError as error:
        return Fitted(None, error.message, error.hint)


def guide(document: Document, fitted: Fitted, found: Lens | None = None) -> Lens | None:
    """The lens that predicts where edges run: the fit's, or a rough one.

    Args:
        document: The document.
        fitted: Its fit.
        found: The lens that edges tell which were found without a click, if there are any.
    """
    if fitted.calibration is not None and len(fitted.calibration.observations.lines) >= _TRUSTED:
        return fitted.calibration.lens
    if found is not None:
        return found
    first = document.photos[0].size
    lines = [
        np.array(line.points)
        for line in fitted_lines(document)
        if document.photos[line.photo].size == first
    ]
    if not lines:
        return None
    rough = one_coefficient(lines, Frame(*first))
    return (polynomial(lines, rough) if len(lines) >= _FEW else rough).lens


def judged(document: Document) -> Fitted:
    """Fit with the search for suspicious picks."""
    settings = document.settings
    try:
        observations = observations_of(document, most=LIVE_SAMPLES)
        return Fitted(calibrate(observations, settings.model, free=settings.free))
    except PlumblineError as error:
        return Fitted(None, error.message, error.hint)


def warm_up(settings: Settings, size: tuple[int, int]) -> None:
    """Make the compiled programs ready for all numbers of lines that are likely.

    The first fit of a shape costs seconds where its program is not in the cache.
    """
    width, height = size
    along = np.linspace(0.05, 0.95, LIVE_SAMPLES) * (width - 1)
    for before, _ in pairwise((0, *_ROWS)):
        count = before + 1 if before else 3
        bent = [
            np.stack((along, share * (height - 1) + 1e-3 * height * (along / width - 0.5) ** 2), 1)
            for share in np.linspace(0.05, 0.95, count)
        ]
        lines = tuple(Line(points, 0, str(index)) for index, points in enumerate(bent))
        try:
            _fitted(Observations((Photo(size),), lines), settings)
        except PlumblineError:
            continue  # made-up lines need not make a lens: the program is ready all the same


def _fitted(observations: Observations, settings: Settings) -> Calibration:
    problem = prepare(observations, get_model(settings.model), settings.free, (), None, "image")
    return finish(problem, solve(problem.model, problem.task))


def _in_words(document: Document, error: DegenerateLinesError) -> tuple[str, str]:
    """Why too few picks make no lens, as one says it who has just begun."""
    if not document.lines:
        return "no line is picked yet", "click near one end of a straight edge, then the other"
    return error.message, error.hint
