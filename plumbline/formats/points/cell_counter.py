"""Markers of Fiji's Cell Counter (XML): the markers of one type are one line.

    <CellCounter_Marker_File>
      <Image_Properties><Image_Filename>wall.tif</Image_Filename></Image_Properties>
      <Marker_Data>
        <Marker_Type><Type>1</Type><Name>roof</Name>
          <Marker><MarkerX>10</MarkerX><MarkerY>40</MarkerY><MarkerZ>1</MarkerZ></Marker>
        </Marker_Type>
      </Marker_Data>
    </CellCounter_Marker_File>

Kept: names or numbers of the types, coordinates, the photo's name. Dropped: the slice, unless
there are several, which are photos then. The counter stores the number of the pixel that was
clicked in, whose centre plumbline has at that number: nothing is added. Source:
`sc/fiji/cellCounter/WriteXML.java` and `CellCntrImageCanvas.java`.
"""

from __future__ import annotations

import re

from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.points.lines import LineGatherer
from plumbline.formats.xmltext import Element, parsed, row_of
from plumbline.observations import Observations

_FIRST = re.compile(r"<CellCounter_Marker_File[\s>]")


def read(source: Source, _options: ReadOptions) -> Observations:
    """One line for each type of marker.

    Raises:
        ReadError: the XML is broken or not the Cell Counter's.
    """
    root = parsed(source)
    if root.tag != "CellCounter_Marker_File":
        raise source.error(
            "the XML is not the Cell Counter's: its first element is not <CellCounter_Marker_File>",
            hint="save the markers in the Cell Counter again",
        )
    name = next((_text(each) for each in root.iter("Image_Filename")), "")
    slices = {_text(each) for each in root.iter("MarkerZ")}
    gatherer = LineGatherer(source)
    for kind in root.iter("Marker_Type"):
        label = _text(kind.find("Name")) or f"type {_text(kind.find('Type'))}"
        for marker in kind.findall("Marker"):
            z = _text(marker.find("MarkerZ")) if len(slices) > 1 else ""
            gatherer.pick(
                (_number(source, marker, "MarkerX"), _number(source, marker, "MarkerY")),
                label,
                group=(_text(kind.find("Type")), label),
                photo=z,
                photo_name=name,
                row=row_of(marker),
            )
    return gatherer.observations("markers")


def recognises(source: Source) -> bool:
    """Whether the XML starts with <CellCounter_Marker_File>."""
    return source.head.lstrip().startswith("<") and _FIRST.search(source.head) is not None


def _text(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()


def _number(source: Source, marker: Element, tag: str) -> float:
    return source.number(_text(marker.find(tag)), row_of(marker))
