"""VGG Image Annotator: pixel edges there, centres here, so 0.5 less."""

from __future__ import annotations

import json

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.observations import Observations

HEADER = (
    "filename,file_size,file_attributes,region_count,region_id,"
    "region_shape_attributes,region_attributes\n"
)
POLYLINE = '"{""name"":""polyline"",""all_points_x"":[10,120],""all_points_y"":[20,21]}"'
RECT = '"{""name"":""rect"",""x"":1,""y"":2,""width"":3,""height"":4}"'
TABLE = (
    HEADER
    + f'a.jpg,9821,"{{}}",3,0,{POLYLINE},"{{""line"":""roof"",""kind"":""tile""}}"\n'
    + f'a.jpg,9821,"{{}}",3,1,{POLYLINE},"{{""line"":""roof""}}"\n'
    + f'a.jpg,9821,"{{}}",3,2,{RECT},"{{}}"\n'
    + 'none.jpg,5,"{}",0,0,"{}","{}"\n'
    + f'b.jpg,77,"{{}}",1,0,{POLYLINE},"{{}}"\n'
)
POINTS = [[9.5, 19.5], [119.5, 20.5]]
LINES = [(0, "roof", POINTS), (0, "roof (2)", POINTS), (1, "1", POINTS)]
NOTE = "1 shape left aside (1 × rect): only polylines and points are read"


def region(name: str = "polyline", **changes: object) -> dict[str, object]:
    shape: dict[str, object] = {"name": name, "all_points_x": [10, 120], "all_points_y": [20, 21]}
    return {"shape_attributes": shape | changes, "region_attributes": {"line": "roof"}}


def project(*regions: object) -> dict[str, object]:
    image = {"filename": "a.jpg", "size": 9821, "regions": list(regions), "file_attributes": {}}
    return {"_via_settings": {}, "_via_img_metadata": {"a.jpg9821": image}}


def read(content: str | bytes | object, path: str = "via_project.json") -> Observations:
    if isinstance(content, bytes):
        return FORMATS["via"].read(Source(path, content), ReadOptions())
    text = content if isinstance(content, str) else json.dumps(content)
    return FORMATS["via"].read(Source(path, text.encode()), ReadOptions())


def found(observations: Observations) -> list[tuple[int, str, list[list[float]]]]:
    return [(line.photo, line.label, line.points_px.tolist()) for line in observations.lines]


@pytest.mark.parametrize("text", [TABLE, "#" + TABLE, "\ufeff" + TABLE.replace("\n", "\r\n")])
def test_a_table(text: str) -> None:
    observations = read(text)
    assert found(observations) == LINES
    assert [(photo.name, photo.size) for photo in observations.photos] == [
        ("a.jpg", None),
        ("b.jpg", None),
    ]
    assert observations.notes == (NOTE,)
    rows = observations.lines[1].rows
    assert rows is not None
    assert rows.tolist() == [3, 3]
    assert FORMATS["via"].recognises(Source("via.csv", text.encode()))


def test_a_project() -> None:
    content = project(region(), region(), region("rect"))
    observations = read(content)
    assert found(observations) == LINES[:2]
    assert observations.photos[0].name == "a.jpg"
    assert observations.lines[0].rows is None
    assert observations.notes == (NOTE,)
    assert FORMATS["via"].recognises(Source("via.json", json.dumps(content).encode()))


def test_images_alone_and_regions_by_number() -> None:
    image = {"filename": "a.jpg", "size": 9821, "regions": {"0": region(), "1": region()}}
    content = {"a.jpg9821": image}
    assert found(read(content)) == LINES[:2]
    assert FORMATS["via"].recognises(Source("via.json", json.dumps(content).encode()))


def test_the_only_attribute_names_the_line() -> None:
    one, two = region(), region()
    one["region_attributes"] = {"edge": "left"}
    two["region_attributes"] = {"a": "b", "c": "d"}
    assert [line.label for line in read(project(one, two)).lines] == ["left", "1"]


@pytest.mark.parametrize(
    ("content", "message", "line"),
    [
        ("", "empty", None),
        ("filename,x\na,b\n", "region_shape_attributes are missing", 1),
        (HEADER, "no line", None),
        (HEADER + 'a.jpg,1,"{}",1,0,"{""name""}","{}"\n', "JSON is broken", 2),
        (HEADER + 'a.jpg,1,"{}",1,0,"[]","{}"\n', "a list where an object", 2),
        (HEADER + 'a.jpg,1,"{}",1,0,"{""name"":""polyline""}","{}"\n', "'all_points_x'", 2),
        (TABLE.replace("[20,21]", "[20]"), "2 x and 1 y", 2),
        (TABLE.replace("[20,21]", "[20,null]"), "missing where a number", 2),
        (TABLE.replace("[20,21]", "[20,1e999]"), "not a finite number", 2),
        (HEADER + 'a.jpg,1,"{}",1,0,"{', "quotation mark", 2),
        (project(), "no line", None),
        (project(region("rect")), "no line of points but 1 × rect", None),
        (project("text"), "a region is 'text'", None),
        (project(region(all_points_x=[1, "2"])), "'2' where a number", None),
        (project({}), "'shape_attributes' is missing", None),
        ({"_via_img_metadata": 3}, "the list of images", None),
        ({"a": 3}, "an image is", None),
        ({"a": {"regions": 3}}, "'regions' is", None),
        ("{" * 10, "JSON is broken", 1),
    ],
)
def test_errors(content: str | object, message: str, line: int | None) -> None:
    with pytest.raises(ReadError) as caught:
        read(content)
    assert message in caught.value.message
    assert caught.value.line == line


def test_other_files_are_not_claimed() -> None:
    for content in (b"", b"{}", b'{"shapes": []}', b"filename,x,y\n", b"line,x,y\n", b"\xff\x00"):
        assert not FORMATS["via"].recognises(Source("a.csv", content))


def test_attributes_that_were_never_set_cost_only_the_label() -> None:
    shape = '"{""name"":""polyline"",""all_points_x"":[1,2,3],""all_points_y"":[4,5,6]}"'
    text = "filename,file_size,region_shape_attributes,region_attributes\n"
    for attributes in ('{""edge"":""top""}', '{""edge"":undefined}', '{""edge"":', ""):
        text += f'a.jpg,9,{shape},"{attributes}"\n'
    assert [line.label for line in read(text).lines] == ["top", "1", "2", "3"]
    project = (
        '{"_via_img_metadata": {"a9": {"filename": "a", "regions": [{"shape_attributes": '
        '{"name": "polyline", "all_points_x": [1, 2, 3], "all_points_y": [4, 5, 6]}, '
        '"region_attributes": {"edge": undefined}}]}}}'
    )
    assert len(read(project, "via.json").lines) == 1
