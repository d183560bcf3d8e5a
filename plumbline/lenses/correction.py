"""What corrects one photograph: a pair of maps between ideal and observed pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from plumbline.frame import Array


@dataclass(frozen=True)
class Correction:
    """A lens, as it was found, for one photograph.

    Both maps take and give pixels of the photograph as displayed, upright, (0, 0) being the
    centre of its top-left pixel; shape (..., 2). They are bound methods of frozen dataclasses,
    so that a correction can be sent to another process.

    Attributes:
        distort: Ideal points to observed ones.
        undistort: Observed points to ideal ones; raises FoldedError where there is none.
        size: Width and height of the photograph in pixels.
        description: What was found and used, in one sentence.
        notes: What the user should be warned of, in plain sentences.
    """

    distort: Callable[[Array], Array]
    undistort: Callable[[Array], Array]
    size: tuple[int, int]
    description: str
    notes: tuple[str, ...] = ()
