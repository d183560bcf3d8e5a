"""Hugin projects, written: an existing one with new lens values, or a new one from points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from plumbline._version import __version__
from plumbline.files import MARK
from plumbline.formats.base import Source
from plumbline.formats.control_points import FIRST_LINE_TYPE, pairs
from plumbline.formats.script import (
    ImageRecord,
    decimal,
    encoded,
    fitted,
    kind_of,
    parse_image,
    records,
    with_values,
)
from plumbline.observations import Observations

UNKNOWN_HFOV_DEG = 50.0
"""Stands in for an unknown field of view: a PTO must have one, and lines do not depend on it."""

_RADIAL = ("a", "b", "c")
_COEFFICIENTS = (*_RADIAL, "d", "e")


def rewritten(content: bytes, path: str, values: dict[int, dict[str, float]]) -> bytes:
    """A project with lens values set on its `i` lines, every other byte as it was.

    Args:
        content: The project.
        path: Its name, for messages.
        values: For each image number its a, b, c, d, e.
    """
    source = Source(path, content)
    images: list[ImageRecord] = []
    texts = records(source)
    for index, text in enumerate(texts):
        if kind_of(text) != "i":
            continue
        image = parse_image(source, index + 1, text, images)
        wanted = values.get(len(images))
        if wanted is not None:
            keep = {name for name, root in image.links.items() if values.get(root) == wanted}
            texts[index] = with_values(text, wanted, keep)
        images.append(image)
    return encoded(texts)


def new_project(observations: Observations, values: Mapping[int, Mapping[str, float]]) -> bytes:
    """A Hugin project from picked points, at square pixels.

    The points of a line are paired with their reversed order, a middle one with its neighbour,
    never with itself.

    Args:
        observations: The photos and lines.
        values: For each lens number its a, b, c, d, e; lenses without are written as zeros.
    """
    squared = observations.squared()
    width, height = squared.photos[0].frame.size
    out = ["# hugin project file", "#hugin_ptoversion 2", f"# {MARK} {__version__}"]
    out += [f'p f0 w{width} h{height} v{decimal(_hfov(squared, 0))} n"TIFF_m c:LZW r:CROP"', "m i0"]
    out += ["", "# image lines"]
    first_of_lens: dict[int, int] = {}
    for number, photo in enumerate(squared.photos):
        out += _image_lines(squared, number, first_of_lens, values.get(photo.lens, {}))
        first_of_lens.setdefault(photo.lens, number)
    out += ["", "# specify variables that should be optimized"]
    out += [f"v {name}{number}" for number in first_of_lens.values() for name in _RADIAL]
    out += ["v", "", "# control points"]
    numbers: Counter[int] = Counter()
    for line in squared.lines:
        kind = FIRST_LINE_TYPE + numbers[line.photo]
        numbers[line.photo] += 1
        out += pairs(line, kind)
    out += ["", "#hugin_optimizeReferenceImage 0", ""]
    return encoded(out)


def _hfov(observations: Observations, number: int) -> float:
    """Field of view of a photo in degrees, in the way of Hugin; a stand-in where unknown."""
    photo = observations.photos[number]
    facts = observations.lenses[photo.lens]
    if facts.hfov_deg:
        return facts.hfov_deg
    focal = facts.focal_length_px(photo.frame)
    if focal is None:
        return UNKNOWN_HFOV_DEG
    return float(np.degrees(2 * np.arctan(photo.frame.square_size[0] / 2 / focal)))


def _image_lines(
    observations: Observations,
    number: int,
    first_of_lens: Mapping[int, int],
    values: Mapping[str, float],
) -> list[str]:
    photo = observations.photos[number]
    facts = observations.lenses[photo.lens]
    linked = first_of_lens.get(photo.lens)
    width, height = photo.frame.size
    kept = (c for c in photo.name if (c.isprintable() or "\udc80" <= c <= "\udcff") and c != '"')
    name = "".join(kept) or f"photo{number}.jpg"
    comment = (
        f"#-hugin  cropFactor={decimal(facts.crop_factor)}" if facts.crop_factor else "#-hugin "
    )
    if linked is None:
        lens = f"v{decimal(_hfov(observations, number))} " + " ".join(
            f"{n}{fitted(values.get(n, 0.0))}" for n in _COEFFICIENTS
        )
    else:
        lens = " ".join(f"{n}={linked}" for n in ("v", *_COEFFICIENTS))
    rest = "Ra0 Rb0 Rc0 Rd0 Re0 Eev0 Er1 Eb1 r0 p0 y0 TrX0 TrY0 TrZ0 Tpy0 Tpp0 j0"
    vignetting = "g0 t0 Va1 Vb0 Vc0 Vd0 Vx0 Vy0 Vm5"
    return [comment, f'i w{width} h{height} f0 {rest} {lens} {vignetting} n"{name}"']
