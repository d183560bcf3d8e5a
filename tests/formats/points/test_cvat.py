"""CVAT for images 1.1: pixel edges there, centres here, so 0.5 less."""

from __future__ import annotations

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

SAMPLE = """<?xml version="1.0" encoding="utf-8"?>
<annotations>
  <version>1.1</version>
  <meta><task><id>1</id><name>façade</name></task></meta>
  <image id="0" name="wall.jpg" width="2048" height="1536">
    <polyline label="l1" source="manual" occluded="0" points="527.11,207.00;593.38,182.53">
      <attribute name="kind">roof</attribute>
    </polyline>
    <polyline label="l1" points="1,2;3,4;5.5,6"/>
    <box label="l1" xtl="1" ytl="2" xbr="3" ybr="4"/>
    <tag label="day"/>
  </image>
  <image id="1" name="wall.jpg" width="4000" height="3000">
    <polyline label="l1" points="0.00,0.00;4000.00,3000.00"/>
    <!-- <polyline label="x" points="1,1"/> -->
  </image>
  <image id="2" name="empty.jpg" width="10" height="10"/>
</annotations>
"""


def read(text: str | bytes) -> Observations:
    content = text.encode() if isinstance(text, str) else text
    return FORMATS["cvat"].read(Source("annotations.xml", content), ReadOptions())


def of_image(inside: str, attributes: str = 'name="a" width="9" height="9"') -> str:
    return f"<annotations><image {attributes}>{inside}</image></annotations>"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_polylines_become_lines(encoding: str) -> None:
    content = SAMPLE.encode(encoding)
    observations = read(content)
    found = [
        (line.photo, line.label, line.points_px.round(9).tolist()) for line in observations.lines
    ]
    assert found == [
        (0, "l1", [[526.61, 206.5], [592.88, 182.03]]),
        (0, "l1 (2)", [[0.5, 1.5], [2.5, 3.5], [5.0, 5.5]]),
        (1, "l1", [[-0.5, -0.5], [3999.5, 2999.5]]),
    ]
    assert [(photo.name, photo.size) for photo in observations.photos] == [
        ("wall.jpg", (2048, 1536)),
        ("wall.jpg", (4000, 3000)),
    ]
    assert observations.notes == (
        "1 shape left aside (1 × box): only polylines and points are read",
    )
    rows = observations.lines[1].rows
    assert rows is not None
    assert rows.tolist() == [9, 9, 9]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("<annotations>", "XML is broken"),
        ("<annotations/>", "no line"),
        ("<html/>", "not CVAT's"),
        ("<annotations><track id='0'/></annotations>", "exported for video"),
        (of_image('<box label="b"/>'), "no line of points but 1 × box"),
        (of_image('<polyline points="1,2;3"/>'), "''"),
        (of_image('<polyline points="1,2;x,4"/>'), "'x'"),
        (of_image('<polyline points="1,2;3,4,5"/>'), "'4,5'"),
        (of_image('<polyline points="1,nan"/>'), "not a finite number"),
        (of_image('<polyline points="1,2"/>', 'name="a" width="x" height="9"'), "the width"),
        (of_image('<polyline points="1,2"/>', 'name="a" width="0" height="9"'), "impossible"),
        (of_image('<polyline points="&bomb;"/>'), "XML is broken"),
        (of_image('<polyline points="1,2" points="1,2"/>'), "XML is broken"),
        ("<annotations>" + "<a>" * 300, "XML is broken"),
        ("<annotations>" + "<a/>" * 5_000_000, "too large"),
    ],
)
def test_errors(text: str, message: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(text)
    assert message in caught.value.message


def test_entities_are_refused_unread() -> None:
    bomb = '<!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><annotations>&b;</annotations>'
    with pytest.raises(ReadError, match="declares entities"):
        read(bomb)
    secret = '<!DOCTYPE annotations [<!ENTITY a SYSTEM "file:///etc/hostname">]><annotations/>'
    with pytest.raises(ReadError, match="declares entities"):
        read(secret.encode("utf-16"))


def test_an_unknown_size_stays_unknown() -> None:
    assert read(of_image('<polyline points="1,2"/>', 'name="a"')).photos[0].size is None


def test_recognition() -> None:
    assert FORMATS["cvat"].recognises(Source("a.xml", SAMPLE.encode()))
    for content in (b"", b"<lensdatabase/>", b"annotations", b"\xff\xfe\x00", b"line,x,y\n"):
        assert not FORMATS["cvat"].recognises(Source("a.xml", content))
