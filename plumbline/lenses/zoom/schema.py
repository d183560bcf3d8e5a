"""The JSON of zoom lenses: one schema for writing and for reading.

Names that are not known are passed over, so that later versions may add some.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from msgspec import Meta, Struct

from plumbline.lenses.zoom.curves import Method
from plumbline.observations import MAX_SIDE
from plumbline.result.schema import Head

FORMAT_VERSION = 1
"""Rises when an older plumbline would misread a file, not when names are added."""

_LARGEST = 1e9
"""Chosen, because a lens with larger coefficients or errors images nothing."""

_MOST_DEGREES = 20
"""As `plumbline zoom --degree` has it."""

Number = Annotated[float, Meta(ge=-_LARGEST, le=_LARGEST)]
Positive = Annotated[float, Meta(gt=0, le=_LARGEST)]
Side = Annotated[int, Meta(ge=1, le=MAX_SIDE)]


class NodeRecord(Struct, frozen=True, kw_only=True):
    """The lens at one focal length."""

    focal_mm: Positive
    values: Mapping[str, Number]
    covariance: tuple[tuple[Number, ...], ...]
    scatter: tuple[Number, ...]
    centre_spread: Number
    birge: Number
    sources: tuple[str, ...]


class LabelsRecord(Struct, frozen=True, kw_only=True):
    """Which lens it is."""

    maker: str = ""
    model: str = ""
    camera: str = ""
    mount: str = ""
    crop_factor: Positive | None = None


class ZoomRecord(Head, frozen=True, kw_only=True):
    """A lens over focal length."""

    model: str
    method: Method
    degree: Annotated[int, Meta(ge=0, le=_MOST_DEGREES)]
    free: tuple[str, ...]
    size: tuple[Side, Side]
    pixel_aspect: Annotated[float, Meta(ge=0.01, le=100)]
    lens: LabelsRecord
    nodes: Annotated[tuple[NodeRecord, ...], Meta(min_length=1)]
