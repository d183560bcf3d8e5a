"""A pick that is probably wrong, and what it looks like."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["stray", "other line", "exchanged", "duplicate", "bent line", "no line"]
KINDS: tuple[Kind, ...] = (
    "stray",
    "other line",
    "exchanged",
    "duplicate",
    "bent line",
    "no line",
)


@dataclass(frozen=True)
class Suspect:
    """One suspicious pick, or a line that bends by itself.

    Attributes:
        line: Index of its line.
        picks: Which of the line's picks, counted from 0.
        kind: "stray", a pick on no line; "other line", it lies on another one; "exchanged", two
            picks have changed lines; "duplicate", two picks of one place; "bent line", an edge
            that was not straight; "no line", the picks that agree on a line that is left
            out as a whole, since so few may agree by chance.
        residual_px: Its distance from its line under the robust fit; the bend of a bent line.
        studentised: The same in units of its own standard deviation.
        left_out: Whether a robust fit leaves it out.
        sentence: All this in words.
    """

    line: int
    picks: tuple[int, ...]
    kind: Kind
    residual_px: float
    studentised: float
    left_out: bool
    sentence: str
