"""What the page may ask for, checked by schema before anything looks at it."""

from __future__ import annotations

from typing import Annotated

import msgspec

_MOST_CLICKS = 1000
"""Clicks of one request. Chosen, because nobody clicks so often along one edge."""

_FAR = 1_000_000.0
"""Pixels beyond which no photo reaches (`plumbline.observations.MAX_SIDE`)."""

Coordinate = Annotated[float, msgspec.Meta(ge=-_FAR, le=_FAR)]
Click = tuple[Coordinate, Coordinate]
Clicks = Annotated[tuple[Click, ...], msgspec.Meta(min_length=1, max_length=_MOST_CLICKS)]
Name = Annotated[str, msgspec.Meta(max_length=40)]
Text = Annotated[str, msgspec.Meta(max_length=200)]
Positive = Annotated[float, msgspec.Meta(gt=0, le=100_000)]
Index = Annotated[int, msgspec.Meta(ge=0, le=1_000_000)]


class _Request(msgspec.Struct, frozen=True, tag_field="do", forbid_unknown_fields=True):
    pass


class Draw(_Request, frozen=True, tag="draw"):
    """Pick a new line: trace the edge near the clicks, or take the clicks as they are."""

    photo: Index
    clicks: Clicks
    snap: bool


class Extend(_Request, frozen=True, tag="extend"):
    """Add a click to a line, wherever along it."""

    line: Index
    click: Click


class Move(_Request, frozen=True, tag="move"):
    """Move one click of a line."""

    line: Index
    index: Index
    to: Click


class Remove(_Request, frozen=True, tag="remove"):
    """Delete a line, or one click of it."""

    line: Index
    index: Index | None = None


class Rival(_Request, frozen=True, tag="rival"):
    """Take the next of the edges that the clicks could mean, or the one before."""

    line: Index
    step: Annotated[int, msgspec.Meta(ge=-1, le=1)]


class Snap(_Request, frozen=True, tag="snap"):
    """Trace the edge near a line of free picks, or go back to the clicks."""

    line: Index
    on: bool


class Accept(_Request, frozen=True, tag="accept"):
    """Take proposals as lines."""

    proposals: Annotated[tuple[Index, ...], msgspec.Meta(min_length=1, max_length=_MOST_CLICKS)]


class Reject(_Request, frozen=True, tag="reject"):
    """Show a proposal no more."""

    proposal: Index


class Undo(_Request, frozen=True, tag="undo"):
    """Undo the last action."""


class Redo(_Request, frozen=True, tag="redo"):
    """Do again what was undone last."""


class Set(_Request, frozen=True, tag="set"):
    """Choose the model, its free coefficients (None for all) and the goal."""

    model: Name
    free: Annotated[tuple[Name, ...], msgspec.Meta(max_length=20)] | None
    goal_px: Annotated[float, msgspec.Meta(gt=0, le=1000)]


class Describe(_Request, frozen=True, tag="describe"):
    """Say what LensFun is to call the lens; empty and None where it is not known."""

    maker: Text
    model: Text
    mount: Text
    focal_mm: Positive | None
    crop_factor: Positive | None


_Lines = Draw | Extend | Move | Remove | Rival | Snap | Accept | Reject | Undo | Redo
Request = _Lines | Set | Describe


class Act(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A request and the page that it comes from."""

    page: Name
    action: Request


class Page(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Which page asks."""

    page: Name
