"""Points as an annotation file of labelme, which keeps the size of the photo beside them."""

from __future__ import annotations

import json

from plumbline.errors import OptionError
from plumbline.files import POINTS
from plumbline.observations import Observations

_VERSION = "5.5.0"
"""The version of labelme whose files have this form."""

_HALF = 0.5
"""labelme counts from the corner of the first pixel, plumbline from its centre."""


def write_labelme(observations: Observations) -> str:
    """The points of one photo as labelme has them, one shape of type linestrip a line.

    Raises:
        OptionError: the points are of several photos.
    """
    with_lines = sorted({line.photo for line in observations.lines})
    if len(with_lines) != 1:
        raise OptionError(
            f"{observations.named}the lines are in {len(with_lines)} photos, and a .json holds "
            "those of one",
            hint="select one with --image N, or write a .pto",
        )
    photo = observations.photos[with_lines[0]]
    shapes = [
        {
            "label": line.label,
            "points": (line.points_px + _HALF).tolist(),
            "group_id": None,
            "shape_type": "linestrip",
            "flags": {},
        }
        for line in observations.lines
    ]
    content = {
        "version": _VERSION,
        "software": POINTS,
        "flags": {},
        "shapes": shapes,
        "imagePath": photo.name,
        "imageData": None,
        "imageHeight": photo.frame.height,
        "imageWidth": photo.frame.width,
    }
    return json.dumps(content, ensure_ascii=False, indent=1) + "\n"
