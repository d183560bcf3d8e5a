"""Rectifications as JSON: written, and read back with everything checked.

Floats are written so that they read back exactly. The first key says what the file is.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from plumbline._version import __version__
from plumbline.errors import PlumblineError, ReadError
from plumbline.files import RECTIFICATION, read_bytes
from plumbline.frame import Array, Frame
from plumbline.ground.camera import N_STEPS, Camera
from plumbline.ground.findings import Findings
from plumbline.ground.optics import Optics
from plumbline.ground.rectification import Rectification
from plumbline.lenses.mapping import TURNS, PhotoLens, Turn
from plumbline.models import get_model
from plumbline.result.records import DamageError, converted, parsed
from plumbline.result.schema import Head

FORMAT_VERSION = 1
"""Raised when an older plumbline would misread the file."""
_AGAIN = "rectify the photo again"
_MOST_SIDE = 100_000
"""Pixels; chosen, more than the largest stitched photos have."""
_MOST_POINTS = 1_000
"""Chosen: every point is marked by hand."""
"""Larger ones are refused as damage; no photo and no match file is."""


@dataclass(frozen=True)
class _Lens:
    model: str
    coefficients: dict[str, float]
    unit_px: float
    observed_centre: tuple[float, float]
    ideal_centre: tuple[float, float]
    turn: tuple[tuple[int, int], tuple[int, int]]
    shift_px: tuple[float, float]


@dataclass(frozen=True)
class _Camera:
    place_m: tuple[float, float, float]
    rotation: tuple[tuple[float, float, float], ...]
    focal_px: float
    heading_deg: float
    pitch_deg: float
    roll_deg: float


@dataclass(frozen=True)
class _Point:
    name: str
    pick_px: tuple[float, float]
    place_m: tuple[float, float]


@dataclass(frozen=True)
class _Whole:
    format: str
    format_version: int
    plumbline: str
    photo: str
    photo_sha256: str
    size: tuple[int, int]
    pixel_aspect: float
    lens: _Lens
    camera: _Camera
    points: list[_Point]
    sigma_pick_px: float
    flatness_m: float
    widening: float
    covariance: list[list[float]]
    shares: dict[str, list[list[float]]]
    findings: Findings
    command: str = ""


@dataclass(frozen=True)
class StoredRectification:
    """A rectification with the photo that it belongs to.

    Attributes:
        rectification: The camera over the plane.
        photo: Name of the photo.
        photo_sha256: SHA-256 of its bytes.
        command: The command that made it.
    """

    rectification: Rectification
    photo: str
    photo_sha256: str
    command: str = ""


def rectification_json(stored: StoredRectification) -> bytes:
    """The JSON of a rectification with its findings."""
    found = stored.rectification
    camera, lens = found.camera, found.camera.optics.lens
    whole = _Whole(
        RECTIFICATION,
        FORMAT_VERSION,
        __version__,
        stored.photo,
        stored.photo_sha256,
        lens.frame.size,
        lens.frame.pixel_aspect,
        _Lens(
            lens.model.label,
            dict(zip(lens.model.coefficients, lens.coefficients, strict=True)),
            lens.unit_px,
            lens.observed_centre,
            lens.ideal_centre,
            lens.turn,
            camera.optics.shift_px,
        ),
        _Camera(
            _three(camera.place),
            tuple(map(_three, camera.rotation)),
            camera.focal_px,
            camera.heading_deg,
            camera.pitch_deg,
            camera.roll_deg,
        ),
        [
            _Point(name, _two(pick), _two(place))
            for name, pick, place in zip(found.names, found.picks_px, found.places_m, strict=True)
        ],
        found.sigma_pick_px,
        found.flatness_m,
        found.widening,
        found.covariance.tolist(),
        {kind: share.tolist() for kind, share in found.shares.items()},
        found.findings,
        stored.command,
    )
    text = msgspec.json.encode(_plain(asdict(whole)))
    return msgspec.json.format(text, indent=1) + b"\n"


def read_rectification(path: str | Path) -> StoredRectification:
    """Read a rectification that plumbline wrote.

    Raises:
        ReadError: the file is missing, another file, or damaged.
    """
    data = read_bytes(path)
    if RECTIFICATION.encode() not in data[:1024]:
        raise ReadError(
            "this is not a rectification",
            path=path,
            hint="write one with plumbline rectify PHOTO --points MATCH --save FILE.json",
        )
    values = parsed(data.decode("utf-8", "replace"), str(path), _AGAIN)
    try:
        version = converted(values, Head).format_version
        whole = converted(values, _Whole) if version <= FORMAT_VERSION else None
        found = _rectification(whole) if whole else None
    except (DamageError, PlumblineError, ValueError) as error:
        raise ReadError(f"the rectification is damaged: {error}", path=path, hint=_AGAIN) from None
    if whole is None or found is None:
        raise ReadError(
            "this rectification was written by a newer plumbline",
            path=path,
            hint="update plumbline",
        )
    return StoredRectification(found, whole.photo, whole.photo_sha256, whole.command)


def _rectification(whole: _Whole) -> Rectification:
    """What the file says, once it hangs together; raises ValueError where it does not."""
    model = get_model(whole.lens.model)
    if set(whole.lens.coefficients) != set(model.coefficients):
        raise ValueError("the lens has other coefficients than its model")
    if not (min(whole.size) > 0 and max(whole.size) <= _MOST_SIDE and whole.pixel_aspect > 0):
        raise ValueError("the size of the photo is impossible")
    if not whole.points or len(whole.points) > _MOST_POINTS:
        raise ValueError("it has no points, or too many")
    if whole.lens.turn not in TURNS.values():
        raise ValueError("the lens is turned otherwise than by quarters")
    turn: Turn = whole.lens.turn
    lens = PhotoLens(
        Frame(*whole.size, whole.pixel_aspect),
        model,
        tuple(whole.lens.coefficients[name] for name in model.coefficients),
        whole.lens.unit_px,
        whole.lens.observed_centre,
        whole.lens.ideal_centre,
        turn,
    )
    rotation = np.array(whole.camera.rotation)
    if rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9):
        raise ValueError("the camera's rotation is not one")
    place = np.array(whole.camera.place_m)
    sizes = (whole.lens.unit_px, whole.camera.focal_px, place[2], whole.sigma_pick_px)
    if not all(value > 0 and math.isfinite(value) for value in (*sizes, whole.flatness_m)):
        raise ValueError("a length that must be above 0 is not")
    seen = N_STEPS + len(model.coefficients)
    covariance = _square(whole.covariance, seen + 2 * len(whole.points))
    shares = {kind: _square(rows, seen) for kind, rows in whole.shares.items()}
    summed = np.sum(list(shares.values()), axis=0)
    if not np.allclose(summed, covariance[:seen, :seen], rtol=1e-6, atol=1e-12):
        raise ValueError("the shares of the covariance do not sum up to it")
    return Rectification(
        Camera(place, rotation, whole.camera.focal_px, Optics(lens, whole.lens.shift_px)),
        tuple(point.name for point in whole.points),
        np.array([point.pick_px for point in whole.points]),
        np.array([point.place_m for point in whole.points]),
        covariance,
        shares,
        whole.sigma_pick_px,
        whole.flatness_m,
        whole.widening,
        whole.findings,
    )


def _square(rows: list[list[float]], size: int) -> Array:
    """A covariance of that size; raises ValueError where it is none."""
    if len(rows) != size or any(len(row) != size for row in rows):
        raise ValueError(f"a covariance does not have {size} rows and columns")
    matrix = np.array(rows)
    if not np.isfinite(matrix).all() or np.max(np.abs(matrix - matrix.T)) > 1e-9 * np.max(
        np.abs(matrix)
    ):
        raise ValueError("a covariance is not symmetric")
    return (matrix + matrix.T) / 2


def _plain(value: Any) -> Any:
    """NumPy's numbers as Python's, all the way down."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return value.item() if isinstance(value, np.generic) else value


def _two(values: Array) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def _three(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
