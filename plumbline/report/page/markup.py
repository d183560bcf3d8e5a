"""HTML elements whose text cannot be anything but text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

from lxml import etree, html  # pyright: ignore[reportAttributeAccessIssue]

from plumbline.errors import printable

Element: TypeAlias = Any
"""An element of lxml, which brings no types."""

Node: TypeAlias = Element | str
"""What an element may hold."""

Rows: TypeAlias = Sequence[Sequence[Node]]


def tag(name: str, /, *children: Node | None, **attributes: str) -> Element:
    """An element; a child may be left out by None, and `class_` stands for `class`.

    Strings are text from wherever it comes: lxml escapes them, and what no page could show is
    replaced.
    """
    element = etree.Element(name, {n.rstrip("_"): printable(v) for n, v in attributes.items()})
    for child in children:
        if child is None:
            continue
        if not isinstance(child, str):
            element.append(child)
        elif len(element):
            element[-1].tail = (element[-1].tail or "") + printable(child)
        else:
            element.text = (element.text or "") + printable(child)
    return element


def table(head: Sequence[Node], rows: Rows, *, text: Iterable[int] = (0,)) -> Element:
    """A table.

    Args:
        head: Titles of the columns.
        rows: The cells.
        text: Which columns hold text; the others hold numbers and are set flush right.
    """
    words = set(text)

    def cells(kind: str, row: Sequence[Node]) -> Element:
        element = (
            tag(kind, cell, **({} if column in words else {"class_": "number"}))
            for column, cell in enumerate(row)
        )
        return tag("tr", *element)

    body = tag("tbody", *(cells("td", row) for row in rows))
    return tag("div", tag("table", tag("thead", cells("th", head)), body), class_="wide")


def document(head: Element, body: Element, *, language: str = "en") -> bytes:
    """A whole page."""
    root = tag("html", head, body, lang=language)
    page: Any = html.tostring(root, doctype="<!DOCTYPE html>", encoding="utf-8")
    return bytes(page) + b"\n"
