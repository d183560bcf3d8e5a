"""Whatever the bytes, a reader ends in observations or a `ReadError`, and recognising never fails.

`PLUMBLINE_FUZZ_CASES` sets the number of mutated files; a few thousand by default.
"""

from __future__ import annotations

import io
import json
import os
import random
import struct
import zipfile
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS, POINT_FORMATS, Format
from plumbline.observations import Observations
from tests.formats.writers import WRITERS, Lines

X, Y = (10.5, 60.0, 172.5), (20.25, 21.5, 22.0)
ROI = struct.pack(
    ">4shBBhhhhH30xhh12x", b"Iout", 228, 5, 0, 20, 10, 24, 180, 3, 0, 128
) + struct.pack(">6h6f64x", 0, 50, 162, 0, 1, 2, *X, *Y)
"""A polyline of three points, big-endian, as `ij/io/RoiEncoder.java` lays it out."""


def zipped(*entries: bytes) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        for number, content in enumerate(entries):
            archive.writestr(f"{number}.roi", content)
    return whole.getvalue()


POLYLINE: dict[str, object] = {
    "shape_attributes": {"name": "polyline", "all_points_x": [1, 2, 3], "all_points_y": [4, 5, 6]},
    "region_attributes": {"line": "roof"},
}
SHAPES: list[object] = [
    {"label": "l1", "points": [[1.5, 2], [3, 4], [5, 6]], "shape_type": "linestrip"},
    {"label": "l2", "points": [[1, 2], [3, 4]], "shape_type": "polygon"},
]
PAIRS = "".join(
    f"c n{{0}} N{{0}} x{x} y{y} X{x2} Y{y2} t{kind}\n"
    for kind in (3, 4)
    for x, y, x2, y2 in ((10, 20.5, 90, 25 + kind), (50, 22, 10, 20.5), (1e1, 30, 70, 3.5e1))
)
LINES: Lines = {
    "roof": [(10.5, 20.25), (60.0, 21.5), (172.5, 22.0)],
    "left wall": [(5.0, 7.0), (5.5, 80.0), (6.0, 95.5), (4.0, 99.0)],
}
OWN = {
    "lenses": [{"maker": "", "focal_mm": 9.2, "stored": {"a": 0.1}, "requested": ["b"]}],
    "lens": {"maker": ""},
    "photos": [{"name": "a.jpg", "number": 0, "size": [200, 100], "pixel_aspect": 1, "lens": 0}],
    "lines": [{"label": "roof", "photo": 0, "points_px": [[1.5, 2], [3, 4], [5, 6]]}],
    "origins": [{"path": "a.csv", "format": "csv", "sha256": "12ab"}],
    "notes": ["a note"],
}
RESULT = {"format": "plumbline calibration", "format_version": 1}
EXTRA: dict[str, list[bytes]] = {
    "json": [json.dumps(RESULT | {"calibrations": [{"observations": OWN}] * 2}).encode()],
    "pto": [
        (
            "# hugin project file\n#hugin_ptoversion 2\np f0 w100 h80 v50\n"
            '#-hugin  cropFactor=1.5\ni w100 h80 f0 v50 a0.01 b-0.02 c0 d0 e0 g0 t0 n"x y.jpg"\n'
            'i w100 h80 f0 v=0 a=0 b=0 c=0 d0 e0 S0,100,0,80 n"y.jpg"\nv a0 b0\nv\n'
            + PAIRS.format(0)
            + PAIRS.format(1)
            + "c n0 N1 x1 y2 X3 Y4 t0\n#hugin_option x\n*\n"
        ).encode(),
        ("i w100 h80\r\n" + PAIRS.format(0).replace("\n", "\r\n")).encode(),
    ],
    "ptgui": [
        (
            "# ptGui project file\n#-fileversion 49\n#-ccdcrop 1.6\n#-dummyimage\n"
            "o w1 h1 v50 a0.03 b-0.1 c0.06 f0 d1 e2 g0 t0\n"
            '#-imgfile 100 80 "x.jpg"\no f0 y0 r0 p0 v=0 a=0 b=0 c=0 d=0 e=0\nv v a b c\n'
            + PAIRS.format(1)
        ).encode(),
    ],
    "csv": [
        b"line,x,y\nroof,10.5,20.5\nroof,11.25,120\n# next\nleft,5,7\n",
        'photo;line;x;y\n"a b";ä_1;1,5;2\n"a b";ä_1;3;4,25\n'.encode(),
        b"1 2\n3 4\n\n5 6\n",
        "line\tx\ty\na\t1\t2\n".encode("utf-16"),
    ],
    "winmorph": [
        b"  Shape1\n  a\n  b\n  0.1 0.2\n  0.2 0.21\n  0.3 0.2\n  Sets = 0\n"
        b"Shape2\n\n\n0,1;0,2\n0,3;0,4\nx\n"
    ],
    "imagej": [
        b" ,Area,X,Y,Group\n1,0,10.5,20.5,1\n2,0,5,7,2\n3,0,11,120,1\n",
        b"10.5000\t20.5000\n11.2500\t120.0000\n",
        ROI,
        zipped(ROI, ROI),
    ],
    "webplotdigitizer": [b"roof,,left wall,\nX,Y,X,Y\n10.5,20.5,5,7\n120,21,5.5,80\n231,22,,\n"],
    "labelme": [
        json.dumps(
            {"shapes": SHAPES, "imagePath": "a.jpg", "imageHeight": 3, "imageWidth": 4}
        ).encode()
    ],
    "via": [
        json.dumps(
            {"_via_img_metadata": {"a9": {"filename": "a", "size": 9, "regions": [POLYLINE]}}}
        ).encode(),
        b"filename,file_size,region_shape_attributes,region_attributes\n"
        b'a.jpg,9,"{""name"":""polyline"",""all_points_x"":[1,2],""all_points_y"":[3,4]}","{}"\n',
    ],
    "cvat": [
        b'<?xml version="1.0" encoding="utf-8"?>\n<annotations><image name="a" width="9" '
        b'height="8"><polyline label="l" points="1,2;3.5,4;5,6"/><box/></image></annotations>\n'
    ],
}
OPTIONS = [
    ReadOptions(),
    ReadOptions((800, 600)),
    ReadOptions((800, 600), (2, 2), "zigzag"),
]
GARBAGE = [
    b"1e999", b"-1e308", b"9" * 5000, b"nan", b"Infinity", b"1_0", "١".encode(), b"\xff\xfe",
    b"\x00", b'"', b"'", b",", b";", b"\t", b"\n", b"\r", b"#", b"<", b"&x;", b"<!DOCTYPE a>",
    b"<![CDATA[", b"[" * 3000, b"{", b"}", b"null", b"true", b"-", b"0x10", b"PK\x03\x04", b"Iout",
    b"\xed\xa0\x80", b"\\ud800", "\u2028".encode(), b"\x7f\xff\xff\xff", b"=", b"/>", b"X,Y",
]  # fmt: skip


"""Files in other manners than those of the writers."""

SAMPLES = {
    name: [
        *filter(None, (WRITERS[name](LINES, kind) for kind in ("lines", "picks", "groups"))),
        *EXTRA.get(name, ()),
    ]
    for name in POINT_FORMATS
}
"""What is tested, of every row of the table."""


def test_every_format_has_a_sample() -> None:
    assert set(SAMPLES) == set(POINT_FORMATS)


def ends_well(each: Format, content: bytes, options: ReadOptions) -> None:
    """Read the content and check that what comes out is whole."""
    source = Source(f"hostile{each.suffixes[0]}", content)
    assert each.recognises(source) in {True, False}
    try:
        observations = each.read(source, options)
    except ReadError as error:
        refusal = error
    else:
        whole(observations)
        return
    assert refusal.message
    assert refusal.line is None or refusal.line >= 1


def whole(observations: Observations) -> None:
    labels = {(line.photo, line.label) for line in observations.lines}
    assert len(labels) == len(observations.lines) > 0
    for line in observations.lines:
        assert 0 <= line.photo < len(observations.photos)
        assert line.points_px.shape == (len(line.points_px), 2)
        assert line.points_px.dtype == np.float64
        assert np.isfinite(line.points_px).all()
        assert line.rows is None or line.rows.shape == line.points_px.shape[:1]
        assert line.label.isprintable()


def flip(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :]


def delete(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + content[at + rng.randint(1, 8) :]


def duplicate(rng: random.Random, content: bytes) -> bytes:
    start = rng.randrange(len(content))
    end = start + rng.randint(1, 40)
    return content[:end] + content[start:end] * rng.randint(1, 3) + content[end:]


def truncate(rng: random.Random, content: bytes) -> bytes:
    return content[: rng.randrange(len(content))]


def insert(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + rng.choice(GARBAGE) + content[at + rng.choice([0, 0, 1, 4]) :]


def scramble(rng: random.Random, content: bytes) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + rng.randbytes(rng.randint(1, 6)) + content[at:]


MUTATIONS: list[Callable[[random.Random, bytes], bytes]] = [
    flip, delete, duplicate, truncate, insert, insert, scramble,
]  # fmt: skip
CASES = int(os.environ.get("PLUMBLINE_FUZZ_CASES", "4200"))


@pytest.mark.timeout(max(300, CASES // 20))
@pytest.mark.parametrize("name", SAMPLES)
def test_mutated_files(name: str) -> None:
    rng = random.Random(f"plumbline {name}")
    for _ in range(CASES // len(SAMPLES)):
        content = rng.choice(SAMPLES[name])
        for _ in range(rng.choice([1, 1, 2, 5])):
            content = rng.choice(MUTATIONS)(rng, content) if content else content
        options = rng.choice(OPTIONS)
        try:
            ends_well(FORMATS[name], content, options)
        except Exception as error:
            error.add_note(f"{name}: {content!r} with {options}")
            raise


@pytest.mark.parametrize("name", POINT_FORMATS)
@given(content=st.one_of(st.binary(max_size=300), st.text(max_size=300).map(str.encode)))
@example(content=b"")
@example(content=b"\xff\xfe")
@example(content=b"PK\x03\x04.roi")
@example(content=b"Iout" + b"\xff" * 200)
@example(content=b"\n" * 300)
def test_arbitrary_bytes(name: str, content: bytes) -> None:
    ends_well(FORMATS[name], content, OPTIONS[1])


@pytest.mark.parametrize("name", POINT_FORMATS)
def test_every_sample_is_read_and_every_foreign_one_ends_well(name: str) -> None:
    for content in SAMPLES[name]:
        whole(FORMATS[name].read(Source("sample", content), OPTIONS[1]))
    for others in SAMPLES.values():
        for content in others:
            ends_well(FORMATS[name], content, OPTIONS[1])


@pytest.mark.parametrize("name", SAMPLES)
def test_only_one_format_claims_a_sample(name: str) -> None:
    for content in SAMPLES[name]:
        claims = [each.name for each in FORMATS.values() if each.recognises(Source("x", content))]
        # Two columns of numbers are the same in either; the plain table takes them.
        expected = ["csv"] if content[:4] == b"10.5" else [name]
        assert claims == expected


SIZE = 2**17
LARGE = {
    "zeros": b"\0",
    "line ends": b"\n",
    "one long line": b"a",
    "numbers on one line": b"12,",
    "short rows": b"1,2\n",
    "short words": b"1 2 3 4\n",
    "quotes": b'"\n",',
    "lists": b"[],",
    "elements": b"<a/>",
    "noise": bytes(range(1, 256)),
}
OPENINGS = [b"", b'{"shapes": [', b"<annotations>", b"Shape1\n", b"a,,\nX,Y\n", b" ,X,Y,Group\n"]


@pytest.mark.timeout(120)
@pytest.mark.parametrize("kind", LARGE)
def test_large_files_are_refused_or_read(kind: str) -> None:
    unit = LARGE[kind]
    for opening in OPENINGS:
        content = opening + unit * (SIZE // len(unit))
        for name in POINT_FORMATS:
            ends_well(FORMATS[name], content, OPTIONS[1])
