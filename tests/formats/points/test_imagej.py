"""ImageJ: Results tables, XY coordinates and selections, all counted from pixel centres."""

from __future__ import annotations

import io
import struct
import zipfile

import pytest

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS
from plumbline.formats.points.imagej_roi import MAX_ENTRIES
from plumbline.observations import Observations

Points = list[tuple[float, float]]
LINE, FREELINE, POLYLINE, POINT, OVAL = 3, 4, 5, 10, 2


def read(content: str | bytes, path: str = "Results.csv") -> Observations:
    raw = content.encode() if isinstance(content, str) else content
    return FORMATS["imagej"].read(Source(path, raw), ReadOptions())


def found(observations: Observations) -> dict[str, list[list[float]]]:
    return {line.label: line.points_px.tolist() for line in observations.lines}


RESULTS = " ,Area,Mean,X,Y,Counter,Count\n1,0,7,10.5,20.5,0,2\n2,0,7,5,7,1,1\n3,0,7,11.25,120,0,2\n"
EXPECTED = [[[10.5, 20.5], [11.25, 120.0]], [[5.0, 7.0]]]


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        (RESULTS, ["Counter 0", "Counter 1"]),
        (RESULTS.replace(",", "\t"), ["Counter 0", "Counter 1"]),
        (RESULTS.replace("Counter", "Slice"), ["Slice 0", "Slice 1"]),
        ("X,Y,Group\n10.5,20.5,1\n5,7,2\n11.25,120,1\n", ["Group 1", "Group 2"]),
        (
            " ,X,Y,Slice,ROI\n1,10.5,20.5,1,1\n2,5,7,2,1\n3,11.25,120,1,1\n",
            ["Slice 1", "Slice 2"],
        ),
        (
            " ,X,Y,Group,Frame\n1,10.5,20.5,1,1\n2,5,7,1,2\n3,11.25,120,1,1\n",
            ["Frame 1", "Frame 2"],
        ),
    ],
)
def test_results_are_grouped_by_what_varies(text: str, labels: list[str]) -> None:
    observations = read(text)
    assert list(found(observations).items()) == list(zip(labels, EXPECTED, strict=True))
    rows = observations.lines[0].rows
    assert rows is not None
    assert rows.tolist() == [2, 4]
    assert FORMATS["imagej"].recognises(Source("Results.csv", text.encode()))


def test_two_columns_may_group_together() -> None:
    text = " ,X,Y,Slice,Group\n1,1,2,1,1\n2,3,4,1,2\n3,5,6,2,1\n"
    assert list(found(read(text))) == ["Group 1, Slice 1", "Group 2, Slice 1", "Group 1, Slice 2"]


def test_labels_group_where_they_repeat() -> None:
    rows = [f"{n},{'roof' if n % 2 else 'wall'},{n},{2 * n}\n" for n in range(1, 7)]
    observations = read(" ,Label,X,Y\n" + "".join(rows))
    assert found(observations) == {
        "roof": [[1, 2], [3, 6], [5, 10]],
        "wall": [[2, 4], [4, 8], [6, 12]],
    }


def test_points_in_no_group_are_left_aside_with_a_note() -> None:
    observations = read(" ,X,Y,Group\n1,1,2,3\n2,3,4,0\n3,5,6,3\n")
    assert found(observations) == {"Group 3": [[1, 2], [5, 6]]}
    assert observations.notes == ("1 point in no group left aside",)


def test_a_single_group() -> None:
    assert found(read(" ,X,Y,Group\n1,1,2,3\n2,3,4,3\n")) == {"Group 3": [[1, 2], [3, 4]]}


def test_xy_coordinates() -> None:
    assert found(read("10.5000\t20.5000\n11.2500\t120.0000\n", "XY.txt")) == {
        "1": [[10.5, 20.5], [11.25, 120.0]]
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        (" ,X,Y\n", "no points"),
        (" ,X,Y\n1,1,2\n2,3,4\n", "which points lie on one line"),
        (" ,X,Y,Group\n1,1,2,0\n2,3,4,0\n", "which points lie on one line"),
        (" ,Label,X,Y\n1,a,1,2\n2,b,3,4\n", "which points lie on one line"),
        (" ,X,Y,Group\n1,1,x,1\n2,3,4,2\n", "'x'"),
        (" ,X,Y,Group\n1,1,NaN,1\n2,3,4,2\n", "not a finite number"),
        (" ,Group,X,Y\n1,1,5\n2,2,3,4\n", "no X or Y"),
        (" ,Area,Mean\n1,2,3\n", "has no columns X and Y"),
        (" ,X,Y,Group\n" + "1,1,2,3\n" * 3_000_000, "not a Results table"),
    ],
)
def test_errors_of_tables(text: str, message: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(text)
    assert message in caught.value.message


def roi(
    kind: int,
    points: Points,
    *,
    name: str = "",
    group: int = 0,
    counters: list[int] | None = None,
    subpixel: bool = True,
) -> bytes:
    """A selection as `ij/io/RoiEncoder.java` lays it out, big-endian."""
    count = 0 if kind in {LINE, OVAL} else len(points)
    left = min(int(x) for x, _ in points)
    top = min(int(y) for _, y in points)
    ends = [c for point in (points[0], points[-1]) for c in point] if kind == LINE else [0.0] * 4
    body = b""
    if count:
        body += b"".join(struct.pack(">h", int(x) - left) for x, _ in points)
        body += b"".join(struct.pack(">h", int(y) - top) for _, y in points)
        if subpixel:
            body += b"".join(struct.pack(">f", x) for x, _ in points)
            body += b"".join(struct.pack(">f", y) for _, y in points)
    header2 = 64 + len(body)
    name_at, counters_at = header2 + 64, header2 + 64 + 2 * len(name)
    header = struct.pack(
        ">4shBBhhhhH4fhiiihhBBhii",
        b"Iout", 228, kind, 0, top, left, top + 10, left + 10, count, *ends,
        0, 0, 0, 0, 0, 128 if subpixel else 0, 0, 0, 0, 0, header2,
    )  # fmt: skip
    second = struct.pack(
        ">iiiiiiihBBifiii12x",
        0, 0, 0, 0, name_at if name else 0, len(name), 0, 0, group, 0, 0, 0.0, 0, 0,
        counters_at if counters else 0,
    )  # fmt: skip
    tail = b"".join(struct.pack(">i", counter) for counter in counters or [])
    return header + body + second + name.encode("utf-16-be") + tail


def zipped(entries: dict[str, bytes]) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return whole.getvalue()


EDGE: Points = [(10.5, 20.25), (60.0, 21.5), (120.75, 22.0)]


@pytest.mark.parametrize("kind", [POLYLINE, FREELINE, POINT])
def test_a_selection_is_a_line(kind: int) -> None:
    content = roi(kind, EDGE, name="roof")
    assert found(read(content, "x.roi")) == {"roof": [[10.5, 20.25], [60.0, 21.5], [120.75, 22.0]]}
    assert FORMATS["imagej"].recognises(Source("x.roi", content))


def test_a_selection_in_whole_pixels_counts_their_centres() -> None:
    content = roi(POLYLINE, [(10, 20), (60, 21), (120, 22)], subpixel=False)
    assert found(read(content, "folder/edge.roi")) == {"edge": [[10, 20], [60, 21], [120, 22]]}


def test_a_straight_selection_has_two_points() -> None:
    assert found(read(roi(LINE, EDGE), "a.roi")) == {"a": [[10.5, 20.25], [120.75, 22.0]]}


def test_counters_part_a_multi_point_selection() -> None:
    content = roi(POINT, EDGE, name="p", counters=[0, 3, 0])
    assert found(read(content, "p.roi")) == {
        "p counter 0": [[10.5, 20.25], [120.75, 22.0]],
        "p counter 3": [[60.0, 21.5]],
    }


def test_a_set() -> None:
    content = zipped(
        {
            "0001.roi": roi(POLYLINE, EDGE, name="roof"),
            "0002.roi": roi(POLYLINE, EDGE, name="roof"),
            "0003.roi": roi(OVAL, EDGE),
            "a.roi": roi(POINT, [(1, 2)], group=4),
            "b.roi": roi(POINT, [(5, 6)], group=4),
            "__MACOSX/._a.roi": b"junk",
            "readme.txt": b"hello",
        }
    )
    observations = read(content, "RoiSet.zip")
    assert list(found(observations)) == ["roof", "roof (2)", "Group 4"]
    assert found(observations)["Group 4"] == [[1, 2], [5, 6]]
    assert "1 × oval" in observations.notes[0]
    assert FORMATS["imagej"].recognises(Source("RoiSet.zip", content))


BOMB = zipped({"a.roi": b"\0" * (65 * 2**20)})
CROWD = b"PK\x03\x04" + b"PK\x01\x02" * (MAX_ENTRIES + 1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"Iout", "not an ImageJ selection"),
        (roi(POLYLINE, EDGE)[:70], "cut off or broken"),
        (roi(OVAL, EDGE), "no line of points but 1 × oval"),
        (roi(POLYLINE, EDGE)[:64] + b"\xff" * 99, "not a finite number"),
        (zipped({"a.txt": b""}), "holds no selections"),
        (zipped({"a.roi": b"junk"}), "'a' is not an ImageJ selection"),
        (zipped({"a.roi": roi(POLYLINE, EDGE)})[:-30], "zipped set of selections is broken"),
        (BOMB, "more than 64 MiB"),
        (CROWD, "10,001 entries"),
        (b"PK", "broken"),
    ],
    ids=range(10),
)
def test_errors_of_selections(content: bytes, message: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(content, "RoiSet.zip")
    assert message in caught.value.message


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"line,x,y\n1,2,3\n",
        b"x,y\n1,2\n",
        b",line,X,Y\n1,a,2,3\n",
        b"roof,,left,\nX,Y,X,Y\n1,2,3,4\n",
        b"PK\x03\x04 annotations.xml",
        b"\xff\xfe\x00",
    ],
)
def test_other_files_are_not_claimed(content: bytes) -> None:
    assert not FORMATS["imagej"].recognises(Source("a.csv", content))


def test_the_centre_of_mass_stands_in_for_the_centroid() -> None:
    text = " ,Area,XM,YM,Group\n1,0,10.5,20.5,1\n2,0,5,7,2\n3,0,11,120,1\n"
    assert FORMATS["imagej"].recognises(Source("Results.csv", text.encode()))
    found = read(text)
    assert found.lines[0].points_px.tolist() == [[10.5, 20.5], [11, 120]]


def test_a_table_without_coordinates_says_what_to_tick() -> None:
    text = " ,Area,Mean,Min,Max\n1,0,10.5,20.5,1\n"
    assert FORMATS["imagej"].recognises(Source("Results.csv", text.encode()))
    with pytest.raises(ReadError) as caught:
        read(text)
    assert "tick Centroid" in caught.value.hint
