"""Zoom lenses as JSON, written and read, and evaluated for a photo.

    {"format": "plumbline zoom", "format_version": 1, "model": "ptlens", "method": "hermite", …,
     "nodes": [{"focal_mm": 8.2, "values": {"a": 0, …}, "covariance": […], …}, …]}

The centre `d`, `e` is in half shorter sides of the photo. Floats read back exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbline._version import __version__
from plumbline.errors import PlumblineError, ReadError, printable
from plumbline.files import ZOOM
from plumbline.formats.base import Source
from plumbline.frame import Frame
from plumbline.lenses.focal import clamp_focal
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.zoom.schema import FORMAT_VERSION, LabelsRecord, NodeRecord, ZoomRecord
from plumbline.lenses.zoom.zoom_lens import Node, ZoomLens, model_of
from plumbline.models import CENTRE
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts
from plumbline.result.records import DamageError, converted, parsed, record_text
from plumbline.result.schema import Head
from plumbline.wording import number

_AGAIN = "join it again: plumbline zoom RESULT… -o zoom.json"


def zoom_text(lens: ZoomLens) -> str:
    """JSON text of a zoom lens."""
    facts = lens.facts
    return record_text(
        ZoomRecord(
            format=ZOOM,
            format_version=FORMAT_VERSION,
            plumbline=__version__,
            model=lens.model.label,
            method=lens.method,
            degree=lens.degree,
            free=lens.free,
            size=lens.size,
            pixel_aspect=lens.pixel_aspect,
            lens=LabelsRecord(
                maker=facts.maker,
                model=facts.model,
                camera=facts.camera,
                mount=facts.mount,
                crop_factor=facts.crop_factor,
            ),
            nodes=tuple(_record(node, lens.names) for node in lens.nodes),
        )
    )


def _record(node: Node, names: tuple[str, ...]) -> NodeRecord:
    return NodeRecord(
        focal_mm=node.focal_mm,
        values=dict(zip(names, node.values.tolist(), strict=True)),
        covariance=tuple(tuple(row) for row in node.covariance.tolist()),
        scatter=tuple(node.scatter.tolist()),
        centre_spread=node.centre_spread,
        birge=node.birge,
        sources=node.sources,
    )


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
            f"{name} = {number(value, '.6g')}"
            for name, value in zip(lens.names, values, strict=True)
            if value
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
        ReadError: the text is not such JSON.
    """
    whole = parsed(source.text(), source.path, _AGAIN)
    if not isinstance(whole, dict) or whole.get("format") != ZOOM:
        raise source.error("this is not a zoom lens written by plumbline", hint=_AGAIN)
    try:
        if converted(whole, Head).format_version > FORMAT_VERSION:
            raise source.error(
                f"this zoom lens was written by plumbline {whole['plumbline']}, which is newer",
                hint="update plumbline",
            )
        return StoredZoom(_lens(converted(whole, ZoomRecord)), source.path)
    except ReadError:
        raise
    except (PlumblineError, DamageError) as error:
        raise source.error(f"the zoom lens is damaged: {error}", hint=_AGAIN) from None


def _lens(record: ZoomRecord) -> ZoomLens:
    model = model_of(record.model)
    names = (*model.coefficients, *CENTRE)
    nodes = tuple(
        _node(node, names, f"nodes[{number}]") for number, node in enumerate(record.nodes)
    )
    focals = [node.focal_mm for node in nodes]
    if focals != sorted(set(focals)):
        raise DamageError("the focal lengths of the nodes do not ascend")
    if not set(record.free) <= set(names):
        raise DamageError("the coefficients do not fit the model")
    labels = record.lens
    facts = LensFacts(
        maker=printable(labels.maker),
        model=printable(labels.model),
        camera=printable(labels.camera),
        mount=printable(labels.mount),
        crop_factor=labels.crop_factor,
    )
    lens = ZoomLens(
        model,
        record.free,
        nodes,
        record.method,
        record.degree,
        record.size,
        record.pixel_aspect,
        facts,
    )
    lens.at(focals[0])
    return lens


def _node(record: NodeRecord, names: tuple[str, ...], place: str) -> Node:
    if set(record.values) != set(names):
        raise DamageError(f"{place}.values does not hold {', '.join(names)}")
    sizes = [len(record.scatter), len(record.covariance), *map(len, record.covariance)]
    if set(sizes) != {len(names)}:
        raise DamageError(f"{place} does not have a value for each coefficient")
    covariance = np.array(record.covariance, dtype=np.float64)
    if np.any(np.diag(covariance) < 0):
        raise DamageError(f"{place}: a variance is negative")
    return Node(
        record.focal_mm,
        np.array([record.values[name] for name in names]),
        covariance,
        np.array(record.scatter, dtype=np.float64),
        record.centre_spread,
        record.birge,
        tuple(printable(name) for name in record.sources),
    )
