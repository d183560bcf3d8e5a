"""Hugin projects, written: an existing one with new lens values, or a new one from points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbline._version import __version__
from plumbline.files import MARK
from plumbline.formats.base import Source
from plumbline.formats.panotools.control_points import FIRST_LINE_TYPE, pairs
from plumbline.formats.panotools.script import (
    STAND_IN,
    UNKNOWN_HFOV_DEG,
    ImageRecord,
    decimal,
    encoded,
    fitted,
    kind_of,
    lens_type,
    parse_image,
    records,
    with_values,
)
from plumbline.observations import Observations, Photo

_RADIAL = ("a", "b", "c")
_COEFFICIENTS = (*_RADIAL, "d", "e")


def rewritten(content: bytes, path: str, values: dict[int, dict[str, float]]) -> bytes:
    """A project with lens values set on its `i` lines, every other byte as it was.

    An image that gets no new values keeps its old ones: where it takes them from an image that
    does get new ones, its links are replaced by the values themselves.

    Args:
        content: The project.
        path: Its name, for messages.
        values: For each image number its a, b, c, d, e.
    """
    source = Source(path, content)
    before: list[ImageRecord] = []
    after: list[ImageRecord] = []
    texts = records(source)
    for index, text in enumerate(texts):
        if kind_of(text) != "i":
            continue
        image = parse_image(source, index + 1, text, before)
        linked = parse_image(source, index + 1, text, after)
        fit = values.get(len(before))
        wanted = fit if fit is not None else _lost(image, linked)
        keep = {name for name in image.links if linked.values.get(name) == wanted.get(name)}
        texts[index] = with_values(text, wanted, keep, decimal if fit is None else fitted)
        before.append(image)
        after.append(replace(linked, values={**linked.values, **wanted}))
    return encoded(texts)


def _lost(image: ImageRecord, linked: ImageRecord) -> dict[str, float]:
    """Linked lens values that are no longer what they were."""
    names = [name for name in _COEFFICIENTS if name in image.links]
    return {n: image.values[n] for n in names if image.values.get(n) != linked.values.get(n)}


def new_project(observations: Observations, values: Mapping[int, Mapping[str, float]]) -> bytes:
    """A Hugin project from picked points, at square pixels.

    The points of a line are paired with their reversed order, a middle one with its neighbour,
    never with itself.

    Args:
        observations: The photos and lines.
        values: For each lens number its a, b, c, d, e; lenses without keep what the file that
            they come from stores, or are written as zeros.
    """
    squared = observations.squared()
    width, height = squared.photos[0].frame.size
    hfov = _hfov(observations, 0) or UNKNOWN_HFOV_DEG
    out = ["# hugin project file", "#hugin_ptoversion 2", f"# {MARK} {__version__}"]
    out += [f'p f0 w{width} h{height} v{decimal(hfov)} n"TIFF_m c:LZW r:CROP"', "m i0"]
    out += ["", "# image lines"]
    first_of_lens: dict[int, int] = {}
    for number, photo in enumerate(squared.photos):
        its = values.get(photo.lens, _stored(observations, number))
        out += _image_lines(observations, photo, number, first_of_lens, its)
        first_of_lens.setdefault(photo.lens, number)
    out += ["", "# specify variables that should be optimized"]
    for lens, number in first_of_lens.items():
        requested = observations.lenses[lens].requested or _RADIAL
        out += [f"v {name}{number}" for name in requested]
    out += ["v", "", "# control points"]
    numbers: Counter[int] = Counter()
    for line in squared.lines:
        kind = FIRST_LINE_TYPE + numbers[line.photo]
        numbers[line.photo] += 1
        out += pairs(line, kind)
    out += ["", "#hugin_optimizeReferenceImage 0", ""]
    return encoded(out)


def _stored(observations: Observations, number: int) -> dict[str, float]:
    """The lens values of a photo's file, the centre at square pixels."""
    photo = observations.photos[number]
    stored = dict(observations.lenses[photo.lens].stored)
    if "d" in stored:
        stored["d"] *= round(photo.frame.square_size[0]) / photo.frame.width
    return stored


def _hfov(observations: Observations, number: int) -> float | None:
    """Field of view of a photo in degrees, in the way of Hugin, as far as it is known."""
    photo = observations.photos[number]
    facts = observations.lenses[photo.lens]
    measured = facts.focal_px or (facts.focal_mm and facts.crop_factor)
    of_its_width = facts.hfov_width_px in (None, photo.frame.width)
    if of_its_width and not (measured and facts.projection == "rectilinear"):
        return facts.hfov_deg
    focal_px = facts.focal_length_px(photo.frame)
    if focal_px is None:
        return None
    return float(np.degrees(2 * np.arctan(photo.frame.square_size[0] / 2 / focal_px)))


def _image_lines(
    observations: Observations,
    squared: Photo,
    number: int,
    first_of_lens: Mapping[int, int],
    values: Mapping[str, float],
) -> list[str]:
    facts = observations.lenses[squared.lens]
    linked = first_of_lens.get(squared.lens)
    width, height = squared.frame.size
    kept = (c for c in squared.name if (c.isprintable() or "\udc80" <= c <= "\udcff") and c != '"')
    name = "".join(kept) or f"photo{number}.jpg"
    comment = (
        f"#-hugin  cropFactor={decimal(facts.crop_factor)}" if facts.crop_factor else "#-hugin "
    )
    hfov = _hfov(observations, number)
    of_one_width = (
        linked is not None
        and observations.photos[linked].frame.width == observations.photos[number].frame.width
    )
    lens = f"v={linked} " if of_one_width else f"v{decimal(hfov or UNKNOWN_HFOV_DEG)} "
    if linked is None:
        lens += " ".join(f"{n}{fitted(values.get(n, 0.0))}" for n in _COEFFICIENTS)
    else:
        lens += " ".join(f"{n}={linked}" for n in _COEFFICIENTS)
    shear = " ".join(f"{n}{decimal(values.get(n, 0.0))}" for n in ("g", "t"))
    rest = "Ra0 Rb0 Rc0 Rd0 Re0 Eev0 Er1 Eb1 r0 p0 y0 TrX0 TrY0 TrZ0 Tpy0 Tpp0 j0"
    size = f"w{width} h{height} f{lens_type(facts.projection)}"
    image = f'i {size} {rest} {lens} {shear} Va1 Vb0 Vc0 Vd0 Vx0 Vy0 Vm5 n"{name}"'
    return [comment, image] if hfov or of_one_width else [STAND_IN, comment, image]
