"""The fit while one picks: at once after a click, and its judgement in the background."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plumbline.errors import DegenerateLinesError, PlumblineError
from plumbline.fit.calibrate import calibrate
from plumbline.fit.outcome import finish
from plumbline.fit.problem import prepare
from plumbline.fit.program.solve import solve
from plumbline.models import get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.pick.document import Document, Settings
from plumbline.pick.observing import LIVE_SAMPLES, observations_of
from plumbline.result.calibration import Calibration

_ROWS = (16, 32, 64)
"""Numbers of lines whose programs are made ready: a block has at least 16 rows, and few people
pick more than 64 lines."""

_JUDGED_SAMPLES = 2 * LIVE_SAMPLES
"""Samples of a traced line that are judged: a robust search over dense wrong lines took 2 s."""


@dataclass(frozen=True)
class Fitted:
    """What a fit came to: a calibration, or why there is none and what to do."""

    made: Calibration | None
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


def judged(document: Document) -> Fitted:
    """Fit with the search for suspicious picks."""
    settings = document.settings
    try:
        observations = observations_of(document, most=_JUDGED_SAMPLES)
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


class Judge:
    """Works on the newest document in a thread of its own; older ones are passed over.

    Args:
        work: Called with the revision and the document.
    """

    def __init__(self, work: Callable[[int, Document], None]) -> None:
        self._work = work
        self._next: tuple[int, Document] | None = None
        self._changed = threading.Condition()
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name="judge", daemon=True)
        self._thread.start()

    def ask(self, revision: int, document: Document) -> None:
        """Judge this document next."""
        with self._changed:
            self._next = revision, document
            self._changed.notify()

    def stop(self) -> None:
        """End after the work in hand."""
        with self._changed:
            self._stopped = True
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopped or self._next is not None)
                if self._stopped:
                    return
                task, self._next = self._next, None
            if task is not None:
                self._work(*task)
