"""`plumbline report` of a rectification."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.errors import OptionError
from plumbline.files import (
    RECTIFICATION,
    read_bytes,
    refuse_to_clobber,
    refuse_unknown_suffix,
    write_atomically,
)
from plumbline.ground.stored import StoredRectification, read_rectification

_MOST_SIDE_PX = 1600
"""Longer side of the photo in the page; chosen, what a page shows."""


def is_rectification(path: str) -> bool:
    """Whether a file is a rectification."""
    return RECTIFICATION.encode() in read_bytes(path)[:1024]


def draw_ground(result: str, output: str | None, photo: str | None, *, overwrite: bool) -> Path:
    """Write the page of a rectification.

    Raises:
        PlumblineError: the file is damaged, or the photo is another.
    """
    from plumbline.report.page.ground import ground_page

    target = Path(output) if output else Path(result).with_suffix(".html")
    refuse_unknown_suffix(target, (".html",), "reports")
    refuse_to_clobber(target, [result], overwrite=overwrite)
    stored = read_rectification(result)
    page = ground_page(stored, pixels_of(stored, Path(result), photo))
    write_atomically({target: page})
    return target


def pixels_of(stored: StoredRectification, result: Path, photo: str | None = None) -> Any:
    """The photo, upright and not larger than a page shows; None where it is not at hand."""
    from PIL import Image, ImageOps

    path = Path(photo) if photo else result.with_name(stored.photo)
    if photo is None and not path.is_file():
        return None
    if sha256(read_bytes(path)).hexdigest() != stored.photo_sha256:
        if photo is None:
            return None
        raise OptionError(
            f"{path} is another photo than the one that was rectified",
            hint="give the photo itself, unchanged",
        )
    with Image.open(path) as image:
        shown = ImageOps.exif_transpose(image).convert("RGB")
        shown.thumbnail((_MOST_SIDE_PX, _MOST_SIDE_PX))
        return np.asarray(shown)
