"""Drawings as files that are known to be plumbline's."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.files import MARK

PICTURES = (".jpg", ".jpeg", ".png")
"""Suffixes that drawings are written with."""

_QUALITY = 88
"""Chosen, because thin lines on a photo show no blocks then."""


def picture_bytes(target: Path, drawing: NDArray[np.uint8]) -> bytes:
    """A drawing (blue, green, red) as JPEG or PNG, as the suffix of its file says."""
    from PIL import Image, PngImagePlugin

    image = Image.fromarray(drawing[..., ::-1])
    out = io.BytesIO()
    how: dict[str, Any] = {"quality": _QUALITY, "comment": MARK.encode()}
    if target.suffix.lower() == ".png":
        text = PngImagePlugin.PngInfo()
        text.add_text("Software", MARK)
        how = {"pnginfo": text}
    image.save(out, format="PNG" if target.suffix.lower() == ".png" else "JPEG", **how)
    return out.getvalue()
