"""labelme: pixel edges there, centres here, so 0.5 less."""

from __future__ import annotations

import json

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

Json = dict[str, object]


def shape(kind: str = "linestrip", label: object = "l1", points: object = None) -> Json:
    return {
        "label": label,
        "points": [[10.5, 20.5], [120, 21]] if points is None else points,
        "group_id": None,
        "shape_type": kind,
        "flags": {},
    }


def document(*shapes: object, **changes: object) -> bytes:
    whole: Json = {
        "version": "5.4.1",
        "flags": {},
        "shapes": list(shapes),
        "imagePath": "wall.jpg",
        "imageData": None,
        "imageHeight": 1536,
        "imageWidth": 2048,
    }
    return json.dumps(whole | changes, indent=2).encode()


def read(content: bytes) -> Observations:
    return FORMATS["labelme"].read(Source("wall.json", content), ReadOptions())


def test_shapes_become_lines() -> None:
    content = document(shape(), shape(), shape("line", "l2", [[0, 0], [2048, 1536]]))
    observations = read(content)
    assert [(line.label, line.points_px.tolist()) for line in observations.lines] == [
        ("l1", [[10.0, 20.0], [119.5, 20.5]]),
        ("l1 (2)", [[10.0, 20.0], [119.5, 20.5]]),
        ("l2", [[-0.5, -0.5], [2047.5, 1535.5]]),
    ]
    assert [(photo.name, photo.size) for photo in observations.photos] == [
        ("wall.jpg", (2048, 1536))
    ]
    assert observations.lines[0].rows is None
    assert observations.notes == ()
    assert FORMATS["labelme"].recognises(Source("wall.json", content))


def test_other_shapes_are_left_aside_with_a_note() -> None:
    content = document(shape(), shape("polygon"), shape("rectangle"), shape("polygon"))
    observations = read(content)
    assert len(observations.lines) == 1
    assert observations.notes == (
        "3 shapes left aside (2 × polygon, 1 × rectangle): "
        "only linestrip, line, points and point are read",
    )


def test_an_unknown_size_stays_unknown() -> None:
    assert read(document(shape(), imageWidth=None)).photos[0].size is None


def test_the_embedded_photo_does_not_count() -> None:
    content = document(shape(), imageData="QUJD" * 2**20)
    assert len(read(content).lines) == 1


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"{", "JSON is broken"),
        (b"[]", "the file is a list"),
        (b"{}", "'shapes' is missing"),
        (b'{"shapes": 3}', "'shapes' is not a finite number where a list"),
        (b'{"shapes": []}', "no line of points"),
        (document(shape("circle")), "no line of points but 1 × circle"),
        (document("text"), "shape 1 is 'text'"),
        (document(shape(points="text")), "'points' of shape 1"),
        (document(shape(points=[[1, 2], [3]])), "point 2 of shape 1 has 1 coordinates"),
        (document(shape(points=[[1, "2"]])), "'2' where a number belongs"),
        (document(shape(points=[[1, True]])), "true or false where a number belongs"),
        (document(shape(points=[[1, None]])), "missing where a number belongs"),
        (document(shape(points=[[1, float("nan")]])), "not a finite number where"),
        (document(shape(points=[[1, float("inf")]])), "not a finite number where"),
        (document(shape(points=[[1, 10**400]])), "not a finite number where"),
        (document(shape(), imageWidth="2048"), "'imageWidth' is '2048'"),
        (document(shape(), imageWidth=-1), "-1x1536 pixels is impossible"),
        (document(shape(), imageWidth=1e300), "impossible"),
        (document(shape(), imageHeight=0.5), "impossible"),
        (b'{"shapes": ' + b"[" * 100_000, "nests too deep"),
        (b'{"shapes": ' + b"1" * 10_000 + b"}", "absurdly long number"),
        (b'{"shapes": [' + b"[]," * 3_000_000 + b"[]]}", "more than is read"),
    ],
)
def test_errors(content: bytes, message: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(content)
    assert message in caught.value.message


def test_broken_json_names_the_line() -> None:
    with pytest.raises(ReadError) as caught:
        read(b'{\n"shapes": [\n}')
    assert caught.value.line == 3


@pytest.mark.parametrize("label", ["", None, 7, [], "a\nb\x1b[31m", "\ud800"])
def test_labels_are_made_printable(label: object) -> None:
    made = read(document(shape(label=label))).lines[0].label
    assert made
    assert made.isprintable()


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b'{"_via_img_metadata": {"shapes": 1}}', b"line,x,y\n1,2,3\n", b"\xff\x00"],
)
def test_other_files_are_not_claimed(content: bytes) -> None:
    assert not FORMATS["labelme"].recognises(Source("a.json", content))
