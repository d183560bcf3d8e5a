"""What was picked so far, with its whole history, as one immutable value.

A document is what lies beside the photo as `facade.plumbline.json`. An action is a list of changes
of lines, each with the line before and after: undoing swaps them, and nothing is ever recomputed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite

import msgspec

from plumbline.errors import OptionError
from plumbline.observations.facts import LensFacts

Point = tuple[float, float]

FORMAT = "plumbline picks"
"""Stands in the head of every file of picks, and tells it from other JSON."""

VERSION = 1
"""Raised when an older plumbline would misread the file."""

MOST_LINES = 2000
"""Chosen, because a photo of 100 megapixels with an edge every 10 pixels has fewer."""

MOST_POINTS = 100_000
"""Of one line. Chosen, because no photo has an edge of more pixels."""


class PickedLine(msgspec.Struct, frozen=True, omit_defaults=True, forbid_unknown_fields=True):
    """One picked line.

    Attributes:
        number: Its number, given once.
        photo: Index of its photo.
        clicks: Where the user clicked, in the photo's own pixels.
        points: What is fitted: samples of the traced edge, or the clicks themselves.
        errors: Standard errors of the samples across the edge; empty for free picks.
        snapped: Whether the edge was traced.
        rival: Which of the edges that the clicks could mean was taken, 0 for the likeliest.
        rivals: How many others there are.
        label: Its name where it was read from a file.
    """

    number: int
    photo: int
    clicks: tuple[Point, ...]
    points: tuple[Point, ...]
    errors: tuple[float, ...] = ()
    snapped: bool = False
    rival: int = 0
    rivals: int = 0
    label: str = ""

    @property
    def name(self) -> str:
        """What it is called."""
        return self.label or str(self.number)


class Change(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One line before and after an action; None where there was or is none."""

    before: PickedLine | None
    after: PickedLine | None

    @property
    def reversed(self) -> Change:
        """What undoes it."""
        return Change(self.after, self.before)


class Action(msgspec.Struct, frozen=True, omit_defaults=True, forbid_unknown_fields=True):
    """What the user did.

    Attributes:
        name: In a word or two.
        changes: The lines that it changed.
        rejected: Proposals that it rejected, each by its first and last point.
    """

    name: str
    changes: tuple[Change, ...]
    rejected: tuple[tuple[Point, Point], ...] = ()


class Proposal(msgspec.Struct, frozen=True):
    """A line that was found without a click.

    Attributes:
        number: Its number among the proposals.
        photo: Index of its photo.
        points: Samples along the edge.
        errors: Standard error of each across it.
    """

    number: int
    photo: int
    points: tuple[Point, ...]
    errors: tuple[float, ...] = ()

    @property
    def ends(self) -> tuple[Point, Point]:
        """Its first and last point, by which it is known again."""
        return self.points[0], self.points[-1]


class PhotoRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A photo as it was when it was picked in: file name, size, SHA-256 of its bytes."""

    name: str
    size: tuple[int, int]
    sha256: str = ""


class Settings(msgspec.Struct, frozen=True, omit_defaults=True, forbid_unknown_fields=True):
    """How lines are fitted, and how good the fit is to become.

    Attributes:
        model: Name of the model.
        free: Its free coefficients; None for all of the model's.
        goal_px: The error to reach. Half a pixel by default, because the page draws pixels.
    """

    model: str = "ptlens"
    free: tuple[str, ...] | None = None
    goal_px: float = 0.5


class Document(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """All of it.

    Attributes:
        format: `FORMAT`.
        version: `VERSION`.
        photos: The photos, of one lens.
        lines: The lines by rising number.
        settings: How they are fitted.
        done: Actions that can be undone, the last one last.
        undone: Actions that can be done again, the next one last.
        next_number: The number of the next line.
        facts: What is known of the lens.
        imported: SHA-256 of the files of points that lines were taken from.
    """

    format: str
    version: int
    photos: tuple[PhotoRecord, ...]
    lines: tuple[PickedLine, ...] = ()
    settings: Settings = Settings()
    done: tuple[Action, ...] = ()
    undone: tuple[Action, ...] = ()
    next_number: int = 1
    facts: LensFacts = LensFacts()
    imported: tuple[str, ...] = ()

    @property
    def rejected(self) -> set[tuple[Point, Point]]:
        """Proposals that the user rejected, each by its first and last point."""
        return {ends for action in self.done for ends in action.rejected}

    def line(self, number: int) -> PickedLine:
        """The line of that number.

        Raises:
            OptionError: there is none.
        """
        for each in self.lines:
            if each.number == number:
                return each
        raise OptionError(f"there is no line {number}", hint="it was deleted; undo brings it back")

    def acted(
        self, name: str, changes: Sequence[Change], rejected: Sequence[tuple[Point, Point]] = ()
    ) -> Document:
        """The document after an action; what was undone before cannot be done again."""
        action = Action(name, tuple(changes), tuple(rejected))
        after = self.changed(action.changes)
        highest = max((each.number for each in after.lines), default=0)
        return msgspec.structs.replace(
            after,
            done=(*self.done, action),
            undone=(),
            next_number=max(self.next_number, highest + 1),
        )

    def before_last(self) -> Document:
        """The document with the last action undone; itself where there is none."""
        if not self.done:
            return self
        *rest, last = self.done
        after = self.changed([each.reversed for each in reversed(last.changes)])
        return msgspec.structs.replace(after, done=tuple(rest), undone=(*self.undone, last))

    def after_next(self) -> Document:
        """The document with the action undone last done again; itself where there is none."""
        if not self.undone:
            return self
        *rest, following = self.undone
        after = self.changed(following.changes)
        return msgspec.structs.replace(after, done=(*self.done, following), undone=tuple(rest))

    def amended(self, change: Change) -> Document:
        """The document after one more change that belongs to its last action."""
        *before, last = self.done
        action = Action(last.name, (*last.changes, change), last.rejected)
        return msgspec.structs.replace(self.changed([change]), done=(*before, action))

    def changed(self, changes: Iterable[Change]) -> Document:
        """The document with other lines and the same history."""
        lines = {each.number: each for each in self.lines}
        for change in changes:
            if change.before is not None:
                lines.pop(change.before.number, None)
            if change.after is not None:
                lines[change.after.number] = change.after
        in_order = tuple(lines[number] for number in sorted(lines))
        return msgspec.structs.replace(self, lines=in_order)

    def problem(self) -> str:
        """What is wrong with a document that was read from a file; empty where nothing is."""
        if self.format != FORMAT:
            return "it holds no picks of plumbline"
        if self.version != VERSION:
            return f"it is of version {self.version} and only version {VERSION} can be read"
        if not self.photos:
            return "it names no photo"
        numbers = [line.number for line in self.lines]
        if len(set(numbers)) != len(numbers) or len(numbers) > MOST_LINES:
            return "its lines are numbered twice, or there are too many"
        changes = [change for action in (*self.done, *self.undone) for change in action.changes]
        every = [*self.lines, *(c.before for c in changes), *(c.after for c in changes)]
        for line in every:
            if line is not None and (wrong := self.problem_of(line)):
                return wrong
        return "" if 0 < self.settings.goal_px < float("inf") else "its goal is not a number"

    def problem_of(self, line: PickedLine) -> str:
        """What is wrong with a line; empty where nothing is."""
        if not 0 <= line.photo < len(self.photos):
            return f"line {line.name} is of a photo that it does not name"
        if len(line.points) > MOST_POINTS or len(line.clicks) > MOST_POINTS:
            return f"line {line.name} has too many points"
        width, height = self.photos[line.photo].size
        for x, y in (*line.points, *line.clicks):
            inside = -0.5 <= x <= width - 0.5 and -0.5 <= y <= height - 0.5
            if not (isfinite(x) and isfinite(y) and inside):
                return f"a point of line {line.name} lies outside the photo"
        return ""
