"""Zoom lenses as JSON, written and read, and evaluated for a photo.

    {"format": "plumbline zoom", "format_version": 1, "model": "ptlens", "method": "hermite", …,
     "nodes": [{"focal_mm": 8.2, "values": {"a": 0, …}, "covariance": […], …}, …]}

The centre `d`, `e` is in half shorter sides of the photo. Floats read back exactly.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline._version import __version__
from plumbline.errors import PlumblineError, ReadError, printable
from plumbline.files import ZOOM
from plumbline.formats.base import Source
from plumbline.frame import Array, Frame
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.zoom_lens import Node, ZoomLens, model_of
from plumbline.models import CENTRE
from plumbline.observations import MAX_SIDE
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts

FORMAT_VERSION = 1

_AGAIN = "make it again: plumbline zoom RESULT… -o zoom.json"
_TEXTS = ("maker", "model", "camera", "mount")
_LARGEST = 1e9  # chosen: no value of a lens comes near
_METHODS = ("linear", "hermite", "polynomial")


def zoom_text(lens: ZoomLens) -> str:
    """JSON text of a zoom lens."""
    whole = {
        "format": ZOOM,
        "format_version": FORMAT_VERSION,
        "plumbline": __version__,
        "model": lens.model.label,
        "method": lens.method,
        "degree": lens.degree,
        "free": list(lens.free),
        "size": list(lens.size),
        "pixel_aspect": lens.pixel_aspect,
        "lens": {name: getattr(lens.facts, name) for name in (*_TEXTS, "crop_factor")},
        "nodes": [
            {
                "focal_mm": node.focal_mm,
                "values": dict(zip(lens.names, node.values.tolist(), strict=True)),
                "covariance": node.covariance.tolist(),
                "scatter": node.scatter.tolist(),
                "centre_spread": node.centre_spread,
                "birge": node.birge,
                "sources": list(node.sources),
            }
            for node in lens.nodes
        ],
    }
    text = json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", "backslashreplace").decode()


@dataclass(frozen=True)
class StoredZoom:
    """A zoom lens and the file it was read from."""

    lens: ZoomLens
    path: str

    def profile(self, photo: PhotoFacts, request: LensRequest) -> LensProfile:
        """The lens at the photo's focal length.

        Raises:
            OptionError: it is not known, or more than 10 % out of the calibrated range.
        """
        lens = self.lens
        what = printable(lens.facts.model or lens.facts.camera or "the zoom lens")
        wanted = request.focal_mm or photo.facts.focal_mm
        focal_mm, clamped = clamp_focal(wanted, lens.range_mm, what)
        values = lens.at(focal_mm)
        frame = Frame(*lens.size, lens.pixel_aspect)
        shown = ", ".join(
            f"{name} = {value:.6g}" for name, value in zip(lens.names, values, strict=True) if value
        )
        width, height = frame.square_size
        return LensProfile(
            f"{what} at {focal_mm:.4g} mm ({lens.method} over {len(lens.nodes)} focal lengths), "
            f"{lens.model.label} {shown or 'without distortion'}, from {self.path}",
            lens.model,
            tuple(float(value) for value in values[: -len(CENTRE)]),
            frame.radius_px / float(np.hypot(width, height)),
            size=lens.size,
            aspect=width / height,
            observed_centre=(float(values[-2]), float(values[-1])),
            camera=lens.facts.camera,
            crop_factor=lens.facts.crop_factor,
            pixel_aspect=lens.pixel_aspect,
        ).with_notes(clamped)


def read_zoom(source: Source) -> StoredZoom:
    """Read what `zoom_text` wrote.

    Raises:
        ReadError: the text is not such a JSON.
    """
    try:
        whole = json.loads(source.text(), parse_constant=_not_finite)
        if not isinstance(whole, dict) or whole.get("format") != ZOOM:
            raise source.error("this is not a zoom lens written by plumbline", hint=_AGAIN)
        if whole.get("format_version") != FORMAT_VERSION:
            raise source.error("this was written by another version of plumbline", hint=_AGAIN)
        return StoredZoom(_lens(whole), source.path)
    except ReadError:
        raise
    except RecursionError:
        raise source.error("the JSON is nested too deeply", hint=_AGAIN) from None
    except KeyError as error:
        raise source.error(f"the zoom lens lacks {error}", hint=_AGAIN) from None
    except (PlumblineError, ValueError, TypeError, AttributeError, OverflowError) as error:
        raise source.error(f"the zoom lens is damaged: {error}", hint=_AGAIN) from None


def _not_finite(name: str) -> float:
    raise ValueError(f"{name} is not a finite number")


def _lens(whole: Mapping[str, Any]) -> ZoomLens:
    model = model_of(str(whole["model"]))
    names = (*model.coefficients, *CENTRE)
    nodes = tuple(_node(each, names) for each in whole["nodes"])
    focals = [node.focal_mm for node in nodes]
    if not nodes or focals != sorted(set(focals)) or focals[0] <= 0:
        raise ValueError("the focal lengths do not ascend")
    width, height = (int(side) for side in whole["size"])
    pixel_aspect = float(whole["pixel_aspect"])
    if not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE and 0.01 <= pixel_aspect <= 100):
        raise ValueError("the size of the photos is impossible")
    if whole["method"] not in _METHODS:
        raise ValueError("the method is not known")
    free = tuple(str(name) for name in whole["free"])
    if not set(free) <= set(names):
        raise ValueError("the coefficients do not fit the model")
    maker, lens_model, camera, mount = (printable(str(whole["lens"][name])) for name in _TEXTS)
    crop_factor = whole["lens"]["crop_factor"]
    facts = LensFacts(
        maker=maker,
        model=lens_model,
        camera=camera,
        mount=mount,
        crop_factor=None if crop_factor is None else float(crop_factor),
    )
    if facts.crop_factor is not None and not facts.crop_factor > 0:
        raise ValueError("the crop factor is not above zero")
    degree = int(whole["degree"])
    lens = ZoomLens(
        model, free, nodes, whole["method"], degree, (width, height), pixel_aspect, facts
    )
    lens.at(focals[0])
    return lens


def _node(data: Mapping[str, Any], names: tuple[str, ...]) -> Node:
    values = _array([float(data["values"][name]) for name in names], (len(names),))
    covariance = _array(data["covariance"], (len(names), len(names)))
    if np.any(np.diag(covariance) < 0):
        raise ValueError("a variance is negative")
    return Node(
        float(data["focal_mm"]),
        values,
        covariance,
        _array(data["scatter"], (len(names),)),
        float(data["centre_spread"]),
        float(data["birge"]),
        tuple(printable(str(name)) for name in data["sources"]),
    )


def _array(values: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != shape or not np.all(np.abs(array) < _LARGEST):
        raise ValueError("an array has the wrong shape or holds an absurd number")
    return array
