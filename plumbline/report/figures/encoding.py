"""Figures as PNG and SVG."""

from __future__ import annotations

import base64
import io
from typing import Any

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from plumbline._version import __version__
from plumbline.files import MARK

_SVG = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_DPI = 150
"""Chosen: a photo of a page's width stays sharp on a screen."""
_JPEG_QUALITY = 82
"""Chosen: artefacts cannot be seen at the shown size."""


def png_bytes(figure: Any) -> bytes:
    """The figure as PNG."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=_DPI, metadata={"Software": f"{MARK} {__version__}"})
    return out.getvalue()


def svg_tree(figure: Any) -> Any:
    """The figure as SVG, its photographs as JPEG, which is a tenth as large as PNG."""
    pictures = {
        f"picture{index}": picture
        for index, picture in enumerate(p for axes in figure.axes for p in axes.images)
    }
    pixels = {place: picture.get_array() for place, picture in pictures.items()}
    for place, picture in pictures.items():
        picture.set_gid(place)
        picture.set_data(pixels[place][:1, :1])  # no PNG is made of the whole
    out = io.BytesIO()
    creator = f"{MARK} {__version__}"
    figure.savefig(out, format="svg", dpi=_DPI, metadata={"Creator": creator, "Date": None})
    root = etree.fromstring(out.getvalue(), etree.XMLParser(huge_tree=True))
    for image in root.iter(f"{_SVG}image"):
        place = image.get("id", "")
        if place in pixels:
            pictures[place].set_data(pixels[place])
            image.set(_LINK, _jpeg_uri(pixels[place]))
            image.set("preserveAspectRatio", "none")
            image.set("style", "")
        else:
            image.set(_LINK, _fewer_colours(image.get(_LINK, "")))
    return root


def svg_bytes(figure: Any) -> bytes:
    """The figure as an SVG file."""
    return etree.tostring(svg_tree(figure), xml_declaration=True, encoding="utf-8") + b"\n"


def _fewer_colours(uri: str) -> str:
    """A drawing in a PNG with 64 colours, which it hardly needs, and a fifth of the bytes."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))) as image:
        image.quantize(64, method=Image.Quantize.FASTOCTREE).save(out, "PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(out.getvalue()).decode()}"


def _jpeg_uri(pixels: Any) -> str:
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(pixels).save(out, format="JPEG", quality=_JPEG_QUALITY, optimize=True)
    return f"data:image/jpeg;base64,{base64.b64encode(out.getvalue()).decode()}"
