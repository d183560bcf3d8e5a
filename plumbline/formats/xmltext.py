"""XML that may be hostile: parsed in one way, within bounds, by every reader of it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Protocol, cast

from plumbline.errors import printable
from plumbline.formats.base import Source

MAX_LENGTH = 64 * 2**20
"""Characters, chosen as ten times what a file of 200,000 picked lines has."""

MAX_NODES = 4_000_000
"""Elements and attributes, chosen as what lxml holds in about 1 GB."""

_AGAIN = "export the file again"


class Element(Protocol):
    """What is used of an element of lxml, which has no types of its own."""

    tag: object
    text: str | None
    sourceline: int | None

    def get(self, name: str, default: str = ..., /) -> str:
        """The value of an attribute."""
        ...

    def find(self, path: str, /) -> Element | None:
        """The first child of a name."""
        ...

    def findall(self, path: str, /) -> list[Element]:
        """All children of a name."""
        ...

    def iter(self, *tags: str) -> Iterator[Element]:
        """All elements of a name, at any depth."""
        ...

    def __iter__(self) -> Iterator[Element]: ...


def parsed(source: Source, remedy: str = _AGAIN) -> Element:
    """The first element of a file in XML.

    Entities, the network and document types elsewhere are off; comments and processing
    instructions are left out.

    Args:
        source: The file.
        remedy: What the user can do about a damaged one.

    Raises:
        ReadError: the XML is broken, declares entities, or is too large.
    """
    from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

    text = source.text()
    if "<!ENTITY" in text:
        raise source.error("the XML declares entities, which are not read", hint=remedy)
    nodes = text.count("<") + text.count("=")
    if len(text) > MAX_LENGTH or nodes > MAX_NODES:
        raise source.error(
            f"the XML is too large: {len(text):,} characters, {nodes:,} nodes",
            hint="give the picks of one photo or a few at a time",
        )
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        huge_tree=False,
        load_dtd=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return cast(Element, etree.parse(io.BytesIO(text.encode()), parser).getroot())
    except (etree.XMLSyntaxError, UnicodeEncodeError) as error:
        row = getattr(error, "lineno", None) or None
        reason = printable(getattr(error, "msg", None) or "a character is not text")
        raise source.error(f"the XML is broken: {reason}", row, remedy) from None


def row_of(element: Element) -> int | None:
    """The row of the file where an element stands."""
    return element.sourceline or None
