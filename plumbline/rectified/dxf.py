"""A rectified photo for CAD: frame, points, measured lines and error ellipses, as DXF, metres.

Layers: FRAME, POINTS, ELLIPSES (95 %) and MEASURED. Written by ezdxf as DXF R2010; ellipses are
ELLIPSE entities, areas closed LWPOLYLINEs, names TEXT.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.errors import printable
from plumbline.files import MARK
from plumbline.frame import Array
from plumbline.ground.ellipses import ellipse
from plumbline.ground.measure import Measurement
from plumbline.ground.rectification import Rectification

_METRES = 6
_LEAST_AXIS_M = 1e-6
"""CAD programs reject an ellipse without extent; that of a datum's point has none."""

_LEAST_RATIO = 1e-6
"""DXF bears no flatter ellipse."""

_TEXT_SHARE = 0.015
"""Height of letters over the drawing's size; chosen."""

_LAYERS = {"FRAME": 8, "POINTS": 3, "ELLIPSES": 1, "MEASURED": 5}
"""Layers with AutoCAD's colour numbers."""


def dxf_bytes(
    found: Rectification,
    picks: Mapping[str, tuple[float, float]] | None = None,
    measured: Sequence[Measurement] = (),
    frame_m: Array | None = None,
) -> bytes:
    """The DXF file of a rectification.

    Args:
        found: The rectified photo.
        picks: Further picks by name, pixels.
        measured: What was measured; distances and areas are drawn.
        frame_m: Corners of the rectified picture, shape (4, 2).
    """
    import ezdxf

    drawing: Any = ezdxf.new("R2010", units=_METRES)  # pyright: ignore[reportPrivateImportUsage]
    drawing.header["$PROJECTNAME"] = f"{MARK} {__version__}"
    for layer, colour in _LAYERS.items():
        drawing.layers.add(layer, color=colour)
    space = drawing.modelspace()
    further = dict(picks or {})
    names = [*found.names, *further]
    places, joint = found.joint(names, further)
    size = float(np.max(np.ptp(places, axis=0))) or 1.0
    if frame_m is not None:
        space.add_lwpolyline(frame_m.tolist(), close=True, dxfattribs={"layer": "FRAME"})
    for index, (name, place) in enumerate(zip(names, places, strict=True)):
        block = joint[2 * index : 2 * index + 2, 2 * index : 2 * index + 2]
        _add_point(space, printable(name), place, block, _TEXT_SHARE * size)
    at = {name: place.tolist() for name, place in zip(names, places, strict=True)}
    for each in measured:
        _add_measured(space, each, at, _TEXT_SHARE * size)
    text = io.StringIO()
    drawing.write(text)
    return text.getvalue().encode("utf-8")


def _add_point(space: Any, name: str, place: Array, covariance: Array, height: float) -> None:
    x, y = place.tolist()
    space.add_point((x, y), dxfattribs={"layer": "POINTS"})
    label = space.add_text(name, height=height, dxfattribs={"layer": "POINTS"})
    label.set_placement((x + height / 2, y + height / 2))
    long, short, angle = ellipse(covariance)
    if long < _LEAST_AXIS_M:
        return
    turn = math.radians(angle)
    space.add_ellipse(
        (x, y),
        (long * math.cos(turn), long * math.sin(turn)),
        max(short / long, _LEAST_RATIO),
        dxfattribs={"layer": "ELLIPSES"},
    )


def _add_measured(
    space: Any, each: Measurement, at: Mapping[str, list[float]], height: float
) -> None:
    if each.kind not in ("distance", "area"):
        return
    corners = [at[name] for name in each.names]
    space.add_lwpolyline(corners, close=each.kind == "area", dxfattribs={"layer": "MEASURED"})
    low, high = each.intervals[0]
    told = f"{each.values[0]:.3f} ± {(high - low) / 2:.3f} {each.unit}"
    label = space.add_text(told, height=height, dxfattribs={"layer": "MEASURED"})
    label.set_placement(tuple(np.mean(corners, axis=0).tolist()))
