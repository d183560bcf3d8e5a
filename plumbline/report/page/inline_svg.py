"""A figure inside a page, whose colours the page may change."""

from __future__ import annotations

import re
from typing import Any

from plumbline.errors import printable
from plumbline.report.figures import encoding, style
from plumbline.report.page.markup import Element

_SVG = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_LEFT_OUT = ("metadata", "style")
_REFERENCE = re.compile(r"url\(#")
_VARIABLES = {
    style.INK: "var(--ink)",
    style.MUTED: "var(--muted)",
    style.RULE: "var(--rule)",
    style.PAPER: "var(--paper)",
    style.BLUE: "var(--blue)",
}


def inline(figure: Any, prefix: str, description: str) -> Element:
    """A figure as an element of a page.

    Args:
        figure: The figure.
        prefix: Sets its ids apart from those of other figures of the page.
        description: What it shows, for those who do not see it.
    """
    root = encoding.svg_tree(figure)
    for name in _LEFT_OUT:
        for element in list(root.iter(f"{_SVG}{name}")):
            parent = element.getparent()
            if parent is not None:
                parent.remove(element)
    for element in root.iter():
        for name, value in list(element.attrib.items()):
            element.set(name, _adapted(name, value, prefix))
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    root.set("role", "img")
    root.set("aria-label", printable(description))
    return root


def _adapted(name: str, value: str, prefix: str) -> str:
    if name == "id":
        return f"{prefix}{value}"
    if name == _LINK:
        return f"#{prefix}{value[1:]}" if value.startswith("#") else value
    value = _REFERENCE.sub(f"url(#{prefix}", value)
    if name != "style":
        return value
    for colour, variable in _VARIABLES.items():
        value = value.replace(colour, variable)
    return value
