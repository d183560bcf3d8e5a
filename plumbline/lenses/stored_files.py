"""Result JSONs, Hugin and PTGui projects and Hugin lens files, read as lenses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.errors import printable
from plumbline.files import RESULT
from plumbline.formats.base import Source
from plumbline.formats.panotools import ptgui, pto
from plumbline.formats.panotools.hugin_ini import read_hugin_ini
from plumbline.formats.panotools.script import ImageRecord, size_of
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.stored import StoredLens, of_calibration, projection_note
from plumbline.models import CENTRE, get_model
from plumbline.observations import MAX_SIDE
from plumbline.observations.facts import LensFacts
from plumbline.photos.cameras import camera_name
from plumbline.result.files import consistent_results

KINDS = "a result JSON, a Hugin or PTGui project, or a Hugin lens .ini"


def stored_lenses(source: Source) -> tuple[StoredLens, ...]:
    """The lenses of a result JSON, a Hugin or PTGui project, or a Hugin lens `.ini`.

    Raises:
        ReadError: the file is damaged, or none of these.
        UnsettledError: a fit in it did not reach a minimum.
    """
    head = source.head.lstrip()
    if head.startswith("{") and f'"{RESULT}"' in head[:1024]:
        results = consistent_results(source.text(), source.path)
        return tuple(of_calibration(each) for each in results)
    if ptgui.recognises(source):
        return _of_images(source, ptgui.read_images(source))
    if pto.recognises(source):
        return _of_images(source, pto.read_images(source))
    if source.suffix == ".ini" or "[lens]" in head.casefold():
        return (_of_ini(source),)
    raise source.error("this file holds no lens that is known here", hint=f"name {KINDS}")


def _of_images(source: Source, images: Sequence[ImageRecord]) -> tuple[StoredLens, ...]:
    return tuple(_of_image(source, image) for image in images)


def _of_image(source: Source, image: ImageRecord) -> StoredLens:
    pto.refuse_moved_centre(source, image)
    size = size_of(source, image)
    values = {name: image.values.get(name, 0.0) for name in ("a", "b", "c", *CENTRE)}
    notes = projection_note(image.projection)
    if any(image.values.get(name, 0.0) for name in ("g", "t")):
        notes = (*notes, "the image is sheared (g, t), which was left aside")
    facts = image.facts(None, None)
    values |= _in_half_sides(source, image, values, min(size) / 2)
    lens = _checked(source, image.row, size, values)
    return StoredLens(lens, facts, (image.name,) if image.name else (), notes)


def _in_half_sides(
    source: Source, image: ImageRecord, values: dict[str, float], radius_px: float
) -> dict[str, float]:
    """a, b, c with radii in half the photo's shorter side.

    Panorama Tools measures them in half the shorter side of what a C crop leaves. With k the
    one over the other, r k takes the place of r, and a common scale λ, which straight lines do
    not see, makes the factor 1 at r = 1 again.
    """
    a, b, c = (values[name] for name in "abc")
    if image.crop is None:
        return {"a": a, "b": b, "c": c}
    left, right, top, bottom = image.crop
    crop_px = min(right - left, bottom - top) / 2
    if crop_px <= 0:
        raise source.error("the crop of the image is empty", image.row, "remove the C crop")
    k = radius_px / crop_px
    curve = [a * k**3, b * k**2, c * k, 1 - a - b - c, -1.0]
    roots = np.roots(curve)
    real = [float(root.real) for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
    if not real:
        raise source.error(
            "the lens values fold inside the photo", image.row, "optimise the project again"
        )
    scale = min(real, key=lambda root: abs(root - 1))
    a, b, c = (value * scale ** (4 - power) for power, value in enumerate(curve[:3]))
    return {"a": a, "b": b, "c": c}


def _of_ini(source: Source) -> StoredLens:
    found = read_hugin_ini(source)
    if found.size is None:
        raise source.error(
            "the lens file has no image_width and image_height, which its values are measured in",
            hint="save the lens again in Hugin",
        )
    camera = camera_name(found.camera_maker, found.camera_model)
    facts = LensFacts(
        camera=printable(camera),
        exif_make=printable(found.camera_maker),
        exif_model=printable(found.camera_model),
        focal_mm=found.focal_mm,
        crop_factor=found.crop_factor,
        hfov_deg=found.hfov_deg,
        projection=found.projection,
    )
    lens = _checked(source, None, found.size, dict(found.values))
    return StoredLens(lens, facts, notes=projection_note(found.projection))


def _checked(
    source: Source, row: int | None, size: tuple[int, int], values: dict[str, float]
) -> Lens:
    if max(size) > MAX_SIDE:
        raise source.error(f"the size {size[0]}x{size[1]} is impossible", row, "correct the size")
    if any(abs(values[name]) > 100 for name in ("a", "b", "c")):
        raise source.error("a lens value is impossibly large", row, "optimise the project again")
    return Lens(get_model("ptlens"), Frame(*size), values)
