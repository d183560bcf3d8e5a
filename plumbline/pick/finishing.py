"""Finish: what `plumbline fit` writes, and the report; and the comparison of models."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import msgspec

from plumbline.errors import WriteError, printable
from plumbline.fit.calibrate import calibrate
from plumbline.fit.choice.compare import ROWS, compare
from plumbline.observations import Observations, Origin
from plumbline.pick.document import FORMAT, Document
from plumbline.pick.observing import observations_of
from plumbline.pick.session import Session
from plumbline.pick.words import on_page
from plumbline.report.writing import comparisons_of, report_contents
from plumbline.result.comparison import Comparison, as_dict
from plumbline.result.sentence import finding_sentence
from plumbline.writing.beside import command_line, write_results

_LENSFUN_FOLDER = r"%LOCALAPPDATA%\lensfun" if os.name == "nt" else "~/.local/share/lensfun"
"""Where LensFun looks for a user's own profiles."""


def finished(session: Session) -> dict[str, Any]:
    """Fit all samples, write a Hugin project, a LensFun profile and a report beside the photo.

    Raises:
        PlumblineError: there is no fit, or a file cannot be written; the sentence says which.
    """
    document = session.document
    observations = _whole(session, document)
    settings = document.settings
    session.hub.publish("progress", "Fitting…")
    calibration = calibrate(observations, settings.model, free=settings.free)
    calibration = replace(calibration, command=command_line())
    photo = session.photos[0].path
    tables, notes = comparisons_of([calibration], lambda part: _compare(session, part))
    session.hub.publish("progress", "Drawing the report…")
    report = photo.with_suffix(".fit.html")
    try:
        drawn, unseen = report_contents(
            [calibration],
            str(report),
            (),
            comparisons=tables,
            photo=str(photo) if len(session.photos) == 1 else None,
            source=str(session.keeper.path),
        )
        written, more = write_results([calibration], (), str(photo), drawn, overwrite=False)
    except WriteError as error:
        error.hint = "move that file away, and finish again"
        raise
    return {
        "finding": finding_sentence(calibration),
        "files": [printable(path.name) for path in written],
        "lensfun": _LENSFUN_FOLDER,
        "notes": [on_page(note) for note in (*notes, *more, *unseen, *calibration.notes)],
    }


def compared(session: Session) -> dict[str, Any]:
    """All models side by side, for the page.

    Raises:
        PlumblineError: no model can be fitted.
    """
    return as_dict(_compare(session, _whole(session, session.document)))


def _whole(session: Session, document: Document) -> Observations:
    path = session.keeper.path
    origin = Origin(str(path), FORMAT, msgspec.json.encode(document))
    return observations_of(document, origin=origin)


def _compare(session: Session, observations: Observations) -> Comparison:
    done = 0

    def advance() -> None:
        nonlocal done
        done += 1
        session.hub.publish("progress", f"Comparing models: {done} of {len(ROWS)}")

    return compare(observations, advance)
