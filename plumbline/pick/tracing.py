"""Trace edges of loaded photos: `plumbline.edges` for the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbline.edges.light import linear_light
from plumbline.edges.snap import SAMPLES
from plumbline.edges.trace import Traced as Found, condensed, trace
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.pick.document import Point
from plumbline.pick.editing import Traced
from plumbline.pick.photos import LoadedPhoto, Pixels

_UNBENT = 2
"""Clicks that tell nothing of an edge's bend."""

_BENDS = (-0.03, 0.02, -0.06, 0.04, -0.1, 0.08)
"""l1 of the division model that are tried for a first line: kit zooms at their ends, compacts,
action cameras, and as much the other way."""


_SURE = 0.8
"""Support of an edge from which no other bend is tried: clean edges have 0.9 and more, by-chance
ones up to 0.2 (`plumbline.edges.trace.LEAST_SUPPORT`)."""


class Tracer:
    """Traces the edges that clicks mean.

    Args:
        photos: The photos.
    """

    def __init__(self, photos: Sequence[LoadedPhoto]) -> None:
        self._photos = photos

    def __call__(
        self, photo: int, clicks: Sequence[Point], lens: Lens | None, rival: int
    ) -> Traced:
        """Trace one edge; `rival` is 0 for the likeliest.

        Raises:
            ReadError: the photo cannot be decoded.
        """
        loaded = self._photos[photo]
        if lens is not None and lens.frame != Frame(*loaded.size):
            lens = None  # the photo stands otherwise than the lens: the clicks alone tell the bend
        image: Any = _Light(loaded.source())
        picks = np.array(clicks, dtype=np.float64)
        found = trace(image, picks, lens, rival=rival)
        if not found.found and lens is None and len(clicks) == _UNBENT:
            found = self._guessed(image, picks, rival) or found
        if found.rivals and not found.found:
            found = trace(image, picks, lens, rival=rival, choosing=True)
        if found.refusal:
            return Traced(refusal=found.refusal, rivals=len(found.rivals))
        samples = condensed(found, SAMPLES)
        return Traced(
            _plain(samples.points_px),
            tuple(np.round(samples.errors_px, 4).tolist()),
            len(found.rivals),
            doubt=found.doubt,
        )

    def _guessed(self, image: Any, picks: Array, rival: int) -> Found | None:
        """What two clicks mean under lenses that bend this and that way, before one is known."""
        rows, columns = image.shape
        model, frame = get_model("division"), Frame(columns, rows)
        best: Found | None = None
        for bend in _BENDS:
            lens = Lens(model, frame, {"l1": bend, "l2": 0.0, "d": 0.0, "e": 0.0})
            found = trace(image, picks, lens, rival=rival)
            if found.found and (best is None or found.support > best.support):
                best = found
            if best is not None and best.support > _SURE:
                break
        return best


class _Light:
    """Linear light of a photo where it is looked at: all of 100 megapixels would take 400 MB."""

    def __init__(self, pixels: Pixels, *, turned: bool = False) -> None:
        self._pixels = pixels
        self._turned = turned
        rows, columns = pixels.shape[:2]
        self.shape = (columns, rows) if turned else (rows, columns)

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def T(self) -> _Light:  # noqa: N802 - as arrays have it
        return _Light(self._pixels, turned=not self._turned)

    def __getitem__(self, where: tuple[Any, Any]) -> Any:
        rows, columns = where[::-1] if self._turned else where
        # Taking from one long row costs two thirds of what two indices cost.
        flat = self._pixels.reshape(-1, *self._pixels.shape[2:])
        return linear_light(np.take(flat, rows * self._pixels.shape[1] + columns, axis=0))


def _plain(points_px: Array) -> tuple[Point, ...]:
    return tuple((x, y) for x, y in np.round(points_px, 4).tolist())
