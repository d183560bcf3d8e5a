"""What a request of the page does to a document, as pure functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import msgspec
import numpy as np

from plumbline.errors import OptionError
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, get_model
from plumbline.pick import requests
from plumbline.pick.document import (
    MOST_LINES,
    Change,
    Document,
    PickedLine,
    Point,
    Proposal,
    Settings,
)
from plumbline.wording import count

_Clicks = requests.Extend | requests.Move | requests.Remove
_Picks = requests.Draw | requests.Rival | requests.Snap | _Clicks

_FEWEST = 2
"""Clicks that a traced line keeps at least: an edge runs between two."""


@dataclass(frozen=True)
class Traced:
    """The edge that clicks mean; or why there is none.

    Attributes:
        points: Samples along it.
        errors: Standard error of each across it.
        rivals: How many other edges the clicks could mean.
        refusal: Why there is none; else empty.
        doubt: Why another of them may be meant; empty where none is as good.
    """

    points: tuple[Point, ...] = ()
    errors: tuple[float, ...] = ()
    rivals: int = 0
    refusal: str = ""
    doubt: str = ""


class Tracer(Protocol):
    """Traces the edge of a photo that clicks mean."""

    def __call__(
        self, photo: int, clicks: Sequence[Point], lens: Lens | None, rival: int
    ) -> Traced:
        """Trace one edge; `rival` is 0 for the likeliest."""
        ...


@dataclass(frozen=True)
class Edited:
    """What came of a request.

    Attributes:
        document: The document after it.
        line: The number of the line to look at; None for none.
        refusal: Why nothing was done, to be shown at the pointer; else empty.
        doubt: Why something else may be meant, to be shown there too; else empty.
    """

    document: Document
    line: int | None = None
    refusal: str = ""
    doubt: str = ""


@dataclass(frozen=True)
class Editor:
    """Edits documents.

    Attributes:
        tracer: Traces edges; None where there is none, and all picks are free.
        proposals: Lines that were found without a click.
    """

    tracer: Tracer | None
    proposals: tuple[Proposal, ...] = ()

    def proposed(self, document: Document) -> list[Proposal]:
        """The proposals that the user neither took nor rejected."""
        known = {(line.points[0], line.points[-1]) for line in document.lines if line.points}
        known |= document.rejected
        return [each for each in self.proposals if each.ends not in known]

    def edited(self, document: Document, request: requests.Request, lens: Lens | None) -> Edited:
        """The document after a request.

        Args:
            document: The document.
            request: The request.
            lens: The lens as far as it is known, which tells how an edge bends.

        Raises:
            OptionError: it names what is not there, or a point outside the photo.
        """
        match request:
            case requests.Undo():
                return Edited(document.before_last())
            case requests.Redo():
                return Edited(document.after_next())
            case requests.Set():
                return Edited(_set(document, request))
            case requests.Describe():
                return Edited(_described(document, request))
            case requests.Accept() | requests.Reject():
                return self._answered(document, request)
            case _:
                return self._picked(document, request, lens)

    def _picked(self, document: Document, request: _Picks, lens: Lens | None) -> Edited:
        match request:
            case requests.Draw():
                return self._drawn(document, request, lens)
            case requests.Remove(index=None):
                return _deleted(document, document.line(request.line))
            case requests.Rival() | requests.Snap():
                return self._retraced(document, request, lens)
            case _:
                return self._reclicked(document, request, lens)

    def _asked(self, document: Document, numbers: Sequence[int]) -> list[Proposal]:
        """Proposals by number, those that are still open.

        Raises:
            OptionError: there is none of them.
        """
        found = [each for each in self.proposed(document) if each.number in set(numbers)]
        if not found:
            raise OptionError("this proposal was taken or rejected before")
        return found

    def _answered(self, document: Document, request: requests.Accept | requests.Reject) -> Edited:
        """Proposals taken as lines, or one rejected."""
        if isinstance(request, requests.Reject):
            (each,) = self._asked(document, (request.proposal,))
            return Edited(document.acted("reject a proposed line", (), (each.ends,)))
        changes: list[Change] = []
        taken = self._asked(document, request.proposals)[: MOST_LINES - len(document.lines)]
        for number, each in enumerate(taken, document.next_number):
            line = PickedLine(number, each.photo, each.ends, each.points, each.errors, snapped=True)
            changes.append(Change(None, line))
        name = f"take {count(len(changes), 'proposed line')}"
        return Edited(document.acted(name, changes), document.next_number)

    def _drawn(self, document: Document, request: requests.Draw, lens: Lens | None) -> Edited:
        if len(document.lines) >= MOST_LINES:
            raise OptionError(f"there are {MOST_LINES:,} lines, and more are not kept")
        number = document.next_number
        line = PickedLine(number, request.photo, request.clicks, request.clicks)
        line = msgspec.structs.replace(line, snapped=request.snap and self.tracer is not None)
        return self._placed(document, "draw a line", None, line, lens)

    def _retraced(
        self, document: Document, request: requests.Rival | requests.Snap, lens: Lens | None
    ) -> Edited:
        """The same clicks, by another edge or as free picks."""
        line = document.line(request.line)
        if isinstance(request, requests.Rival):
            rival = (line.rival + request.step) % (line.rivals + 1)
            after = msgspec.structs.replace(line, rival=rival)
            return self._placed(document, "take another edge", line, after, lens)
        after = msgspec.structs.replace(line, snapped=request.on, rival=0, rivals=0)
        name = "trace the edge" if request.on else "keep the clicks"
        return self._placed(document, name, line, after, lens)

    def _reclicked(self, document: Document, request: _Clicks, lens: Lens | None) -> Edited:
        """The same line with one click more, moved or less."""
        line = document.line(request.line)
        clicks = list(line.clicks)
        if isinstance(request, requests.Extend):
            clicks.insert(_place_along(clicks, request.click), request.click)
            name = f"add a click to line {line.name}"
        else:
            if request.index is None or request.index >= len(clicks):
                raise OptionError(f"line {line.name} has no such click")
            if isinstance(request, requests.Move):
                clicks[request.index] = request.to
                name = f"move a click of line {line.name}"
            else:
                del clicks[request.index]
                name = f"delete a click of line {line.name}"
        fewest = _FEWEST if line.snapped else 1
        if len(clicks) < fewest:
            return _deleted(document, line)
        after = msgspec.structs.replace(line, clicks=tuple(clicks), rival=0)
        return self._placed(document, name, line, after, lens)

    def _placed(
        self,
        document: Document,
        name: str,
        before: PickedLine | None,
        line: PickedLine,
        lens: Lens | None,
    ) -> Edited:
        """The document with a line at its clicks, its edge traced; or why there is none."""
        free = msgspec.structs.replace(
            line, points=line.clicks, errors=(), rivals=0, rival=0, snapped=False
        )
        if wrong := document.problem_of(free):
            raise OptionError(wrong)
        after, doubt = free, ""
        if line.snapped and self.tracer is not None:
            traced = self.tracer(line.photo, line.clicks, lens, line.rival)
            if traced.refusal:
                seen = before.number if before is not None else None
                return Edited(document, seen, traced.refusal)
            after = msgspec.structs.replace(
                line, points=traced.points, errors=traced.errors, rivals=traced.rivals
            )
            doubt = traced.doubt
        done = document.acted(name, [Change(before, after)])
        return Edited(done, line.number, doubt=doubt)


def _deleted(document: Document, line: PickedLine) -> Edited:
    return Edited(document.acted(f"delete line {line.name}", [Change(line, None)]))


def _place_along(clicks: Sequence[Point], new: Point) -> int:
    """Where a click belongs among the others, by its place along the line through them."""
    if len(clicks) < _FEWEST:
        return len(clicks)
    points = np.array([*clicks, new])
    ends = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along = points @ ends
    if along[0] > along[-2]:
        along = -along
    return int(np.searchsorted(np.sort(along[:-1]), along[-1]))


def _described(document: Document, request: requests.Describe) -> Document:
    """The document with the user's facts of the lens."""
    said = msgspec.structs.asdict(request)
    if request.crop_factor != document.facts.crop_factor:
        said["crop_factor_error"] = None
    return msgspec.structs.replace(document, facts=replace(document.facts, **said))


def _set(document: Document, request: requests.Set) -> Document:
    """The document with other settings.

    Raises:
        OptionError: the model or a coefficient is unknown.
    """
    model = get_model(request.model)
    known = (*model.coefficients, *CENTRE)
    for name in request.free or ():
        if name not in known:
            raise OptionError(f"{request.model} has no coefficient {name!r}")
    if request.free is not None and not request.free:
        raise OptionError("nothing is free, so there is nothing to fit")
    settings = Settings(request.model, request.free, request.goal_px)
    return msgspec.structs.replace(document, settings=settings)
