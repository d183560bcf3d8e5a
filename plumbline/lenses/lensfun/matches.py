"""A lens of the library as a match for a photo: its numbers, and how well its name matches."""

from __future__ import annotations

from typing import Any

from plumbline.lenses.choosing import LensMatch
from plumbline.lenses.names import Numbers, likeness, numbers_of

_VARIANTS = (", with ", "converter", "adapter", "extender", ", macro")
"""Words of entries that are a lens with something, or at a close distance."""

_LIKENESS = 1e6
"""Chosen so that likeness counts before LensFun's score, which is below a thousand."""


def numbers(lens: Any) -> Numbers:
    """The numbers of a lens, by its name, else by its entry."""
    told = numbers_of(lens.model)
    return told if told.range_mm else Numbers(range_of(lens), told.apertures)


def range_of(lens: Any) -> tuple[float, float] | None:
    """The range of focal lengths of a lens, by its name, else by its entry."""
    told = numbers_of(lens.model).range_mm
    if told is None and lens.min_focal and lens.max_focal:
        return float(lens.min_focal), float(lens.max_focal)
    return told


def lens_match(lens: Any, name: str | None) -> LensMatch:
    """A lens with the score of its name against the one wanted."""
    focals = [each.focal for each in lens.calib_distortion]
    span = (float(f"{min(focals):.6g}"), float(f"{max(focals):.6g}")) if focals else None
    variant = any(word in lens.model.casefold() for word in _VARIANTS)
    alike = max((likeness(each, lens.model) for each in (name or "").split(" or ")), default=0.0)
    score = round(_LIKENESS * alike) + int(lens.score) if name else 0
    return LensMatch(str(lens.model), span, variant, score)
