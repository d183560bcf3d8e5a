"""What the background says of a fit: suspects, checks, where it is unsure, what to pick next."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbline.pick.document import Document
from plumbline.pick.live import Fitted
from plumbline.pick.observing import fitted_lines
from plumbline.pick.words import on_page
from plumbline.result.calibration import Calibration
from plumbline.trust.next_line import worthwhile_line
from plumbline.wording import px

_COLUMNS, _ROWS = 24, 16
"""Cells of the map of uncertainty: what it shows is as smooth as a polynomial of r."""


def judgement(fitted: Fitted, document: Document) -> dict[str, Any]:
    """What the background says of a document, for the page.

    Args:
        fitted: Its fit with the search for suspicious picks.
        document: The document.
    """
    calibration = fitted.calibration
    if calibration is None:
        return {"failure": on_page(fitted.failure), "hint": on_page(fitted.hint)}
    goal_px = document.settings.goal_px
    return {
        "failure": "",
        "hint": "",
        "suspects": _suspects(calibration, document),
        "checks": [
            *_doubt(calibration),
            *_mixed(document),
            *(
                {"good": check.passed and not check.doubtful, "text": on_page(check.sentence)}
                for check in calibration.checks
            ),
        ],
        "quote": _quote(calibration),
        "map": _map(calibration),
        "next": _next(calibration),
        "goal": _goal(calibration, goal_px),
    }


def _doubt(calibration: Calibration) -> list[dict[str, Any]]:
    return [{"good": False, "text": on_page(calibration.doubt)}] if calibration.doubt else []


def _mixed(document: Document) -> list[dict[str, Any]]:
    """That the fit trusts picks of the hand as much as samples of edges, where there are both."""
    if len({line.snapped for line in fitted_lines(document)}) < 2:
        return []
    text = (
        "free picks count as much as the samples of traced edges, which are far more precise: pick "
        "freely only where no edge is found"
    )
    return [{"good": False, "text": text}]


def _suspects(calibration: Calibration, document: Document) -> list[dict[str, Any]]:
    numbers = [line.number for line in fitted_lines(document)]
    return [
        {
            "line": numbers[suspect.line],
            "points": calibration.observations.lines[suspect.line]
            .points_px[list(suspect.picks)]
            .round(3)
            .tolist(),
            "whole": suspect.kind in ("bent line", "no line"),
            "text": on_page(suspect.sentence),
        }
        for suspect in calibration.suspects
    ]


def _quote(calibration: Calibration) -> str:
    """The error to quote: it costs more than the fit, so that no click waits for it."""
    sure = calibration.quoted_displacement
    if sure is None:
        return "the model folds inside the photo"
    return f"± {px(sure.worst_px)} {sure.worst_place}"


def _map(calibration: Calibration) -> dict[str, Any] | None:
    """The error to quote over the first photo, row by row; None where the model folds."""
    frame = calibration.lens.frame
    x, y = np.linspace(0, frame.width - 1, _COLUMNS), np.linspace(0, frame.height - 1, _ROWS)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    errors = calibration.trust.quoted_errors_px(points)
    if errors is None:
        return None
    return {
        "columns": _COLUMNS,
        "rows": _ROWS,
        "size": list(frame.size),
        "values": np.round(errors, 4).tolist(),
    }


def _next(calibration: Calibration) -> dict[str, Any] | None:
    """The line that would help most, as a ghost; None where none would help by much."""
    sure, more = calibration.quoted_displacement, worthwhile_line(calibration.trust)
    if sure is None or more is None:
        return None
    best, to_px = more
    return {
        "photo": 0,
        "points": best.points_px.round(1).tolist(),
        "text": f"one more line {best.place} would lower the error from {px(sure.worst_px)} to "
        f"about {px(to_px)}",
        "label": f"{px(sure.worst_px)} → {px(to_px)}",
    }


def _goal(calibration: Calibration, goal_px: float) -> dict[str, Any] | None:
    """How near the error is to the goal: 1 when it is reached."""
    sure = calibration.quoted_displacement
    if sure is None:
        return None
    share = min(1.0, goal_px / sure.worst_px) if sure.worst_px > 0 else 1.0
    reached = sure.worst_px <= goal_px
    text = f"{px(sure.worst_px)} now, {px(goal_px)} wanted" + (": reached" if reached else "")
    return {"share": round(share, 3), "reached": reached, "text": text}
