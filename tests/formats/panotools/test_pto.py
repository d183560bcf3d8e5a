"""Hugin projects, read and written."""

from __future__ import annotations

import contextlib
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from plumbline.errors import OptionError, ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS, format_of
from plumbline.formats.panotools.pto_writing import new_project, rewritten
from plumbline.observations import Line, Observations, Photo
from plumbline.observations.facts import LensFacts

SHARED = Path(__file__).parents[4] / "shared" / "data" / "pto"

HEAD = (
    '# hugin project file\n#hugin_ptoversion 2\np f0 w3000 h3000 v179  E10.9 R0 n"TIFF_m"\nm i0\n'
)
IMAGE = (
    "i w1712 h1368 f0 v52.5 Ra0 Rb0 Eev10.9 Er1 r0 p0 y0 TrX0 "
    'a0.03 b-0.1 c0.06 d0 e0 g0 t0 Va1 Vm5 n"x.jpg"\n'
)
LINE = "c n0 N0 x10 y20 X90 Y25 t3\nc n0 N0 x50 y22 X10 Y20 t3\n"
PROJECT = HEAD + "#-hugin  cropFactor=3.72988\n" + IMAGE + "v a0\nv b0\nv\n" + LINE + "*\n"


def read(text: str | bytes, path: str = "some.pto") -> Observations:
    content = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return FORMATS["pto"].read(Source(path, content), ReadOptions())


def lines_of(observations: Observations) -> dict[tuple[int, str], list[tuple[float, float]]]:
    return {
        (line.photo, line.label): [(x, y) for x, y in line.points_px.tolist()]
        for line in observations.lines
    }


def pairs(*points: tuple[float, float], kind: int = 3, image: int = 0) -> str:
    """A chain of pairs through the points."""
    return "".join(
        f"c n{image} N{image} x{x} y{y} X{x2} Y{y2} t{kind}\n"
        for (x, y), (x2, y2) in pairwise(points)
    )


def image(**values: object) -> str:
    tokens = {"w": 100, "h": 80, "f": 0, "v": 50} | values
    return "i " + " ".join(f"{name}{value}" for name, value in tokens.items()) + ' n"y.jpg"\n'


def test_what_a_project_tells() -> None:
    found = read(PROJECT)
    (photo,) = found.photos
    assert (photo.size, photo.name, photo.lens) == ((1712, 1368), "x.jpg", 0)
    (facts,) = found.lenses
    assert facts.stored == {"a": 0.03, "b": -0.1, "c": 0.06, "d": 0, "e": 0, "g": 0, "t": 0}
    assert (facts.hfov_deg, facts.crop_factor, facts.projection) == (52.5, 3.72988, "rectilinear")
    assert facts.requested == ("a", "b")
    assert lines_of(found) == {(0, "t3"): [(10, 20), (50, 22), (90, 25)]}
    assert found.notes == ()


@pytest.mark.parametrize("path", ["x.pto", "X.PTO", "x.txt", "x"])
def test_recognised_by_suffix_or_content(path: str) -> None:
    assert format_of(Source(path, PROJECT.encode())).name == "pto"
    assert (
        format_of(Source(path, ("# PTOptimizer script\n" + image() + LINE).encode())).name == "pto"
    )


@pytest.mark.parametrize("end", ["\r\n", "\n"])
def test_line_ends_and_a_byte_order_mark(end: str) -> None:
    assert lines_of(read(PROJECT.replace("\n", end))) == lines_of(read(PROJECT))
    marked = "\ufeff" + PROJECT.replace("\n", end)
    assert lines_of(read(marked, "x.txt")) == lines_of(read(PROJECT))
    assert format_of(Source("x.txt", marked.encode())).name == "pto"


def test_tabs_part_tokens() -> None:
    found = read(image().replace(" ", "\t") + LINE.replace(" ", "\t") + "v\ta0\tc0\n")
    assert len(found.lines[0].points_px) == 3
    assert found.lenses[0].requested == ("a", "c")


def test_the_tokens_of_a_control_point_stand_in_any_order() -> None:
    found = read(image() + "c t3 Y25 X90 y20 x10 N0 n0\nc n0 x50 X10 N0 y22 Y20 t3 q9\n")
    assert lines_of(found) == {(0, "t3"): [(10, 20), (50, 22), (90, 25)]}


def test_unknown_records_and_what_follows_the_end_are_left_alone() -> None:
    extra = 'k i0 t0 p"1 2 3"\no f0 w9\nS x\n? what\n\x0c\nC i0 c9 t3\n'
    assert lines_of(read(PROJECT + extra)) == lines_of(read(PROJECT))


@pytest.mark.parametrize(
    ("records", "wanted"),
    [
        ("v a0 b0 c0\nv\n", ("a", "b", "c")),
        ("v c0\nv a0\nv \n", ("a", "c")),
        ("v a0 v0 y0 d0\n", ("a", "d")),
        ("v v0 r0\n", None),
        ("v\n", None),
        ("", None),
        ("v a1 Ra0 Vb0 Eev0 TrX0\n", None),
        ("v a0 a99999999999999999999 ??? 7\n", ("a",)),
    ],
)
def test_variables_to_optimise(records: str, wanted: tuple[str, ...] | None) -> None:
    assert read(image() + records + LINE).lenses[0].requested == wanted


def test_variables_that_lines_do_not_show_are_named() -> None:
    (note,) = read(image() + "v a0 v0 y0 g0\n" + LINE).notes
    assert "the field of view (v), y, the shear g, which straight lines do not show" in note


def test_the_crop_factor_belongs_to_the_next_image_only() -> None:
    text = "#-hugin  cropFactor=1.5 disabled\n" + image() + "#-hugin\n" + image() + LINE
    text += pairs((1, 1), (2, 2), (3, 3.5), image=1)
    assert [facts.crop_factor for facts in read(text).lenses] == [1.5, None]


@pytest.mark.parametrize("value", ["nan", "x", "inf"])
def test_a_crop_factor_that_is_no_number(value: str) -> None:
    with pytest.raises(ReadError, match=r"some\.pto, row 1: "):
        read(f"#-hugin cropFactor={value}\n" + image() + LINE)


@pytest.mark.parametrize("value", ["0", "-1"])
def test_a_crop_factor_that_hugin_does_not_know(value: str) -> None:
    assert read(f"#-hugin cropFactor={value}\n" + image() + LINE).lenses[0].crop_factor is None


# --- lines from pairs -----------------------------------------------------------------------

COLUMN = [(300.5, float(y)) for y in (10, 200, 350, 600, 1000)]
SLANTED = [(10.0 * i, 5.0 + 7.5 * i) for i in range(6)]


def reversal(points: list[tuple[float, float]], kind: int) -> str:
    both = zip(points, reversed(points), strict=True)
    return "".join(f"c n0 N0 x{x} y{y} X{x2} Y{y2} t{kind}\n" for (x, y), (x2, y2) in both)


@pytest.mark.parametrize("points", [COLUMN, SLANTED])
def test_reversal_chain_and_star_are_the_same_line(points: list[tuple[float, float]]) -> None:
    star = "".join(pairs(points[0], other) for other in points[1:])
    shuffled = pairs(points[3], points[0], points[4], points[1], points[2], *points[5:], points[0])
    every = [reversal(points, 3), pairs(*points), star, shuffled, reversal(points, 3) + star]
    for text in every:
        found = lines_of(read(image(w=1000, h=1001) + text))[0, "t3"]
        assert found in (points, points[::-1])


def test_lines_are_kept_apart_by_image_and_number() -> None:
    text = image() + image() + pairs((1, 1), (2, 2), kind=4) + pairs((5, 5), (6, 6), image=1)
    text += pairs((2, 2), (3, 3), kind=4) + pairs((7, 7), (8, 8)) + pairs((9, 9), (8, 8))
    assert lines_of(read(text)) == {
        (0, "t3"): [(7, 7), (8, 8), (9, 9)],
        (0, "t4"): [(1, 1), (2, 2), (3, 3)],
        (1, "t3"): [(5, 5), (6, 6)],
    }


@given(
    points=st.sets(st.integers(0, 99), min_size=3, max_size=12),
    seed=st.randoms(use_true_random=False),
)
def test_any_pairing_gives_each_point_once_along_the_line(points: set[int], seed: object) -> None:
    rng = np.random.default_rng(abs(hash(str(seed))) % 2**32)
    wanted = [(float(x), 40 + x / 4) for x in sorted(points)]
    order = [wanted[i] for i in rng.permutation(len(wanted))]
    more = [wanted[i] for i in rng.integers(len(wanted), size=6)]
    found = lines_of(read(image() + pairs(*order, *more)))[0, "t3"]
    assert found in (wanted, wanted[::-1])


def test_rows_tell_where_a_point_stands() -> None:
    (line,) = read(image() + pairs((10, 1), (20, 2), (30, 3.5))).lines
    assert line.rows is not None
    rows = dict(zip(line.points_px[:, 0].tolist(), line.rows.tolist(), strict=True))
    assert (rows[10], rows[30]) == (2, 3)
    assert rows[20] in (2, 3)  # it stands in both


def test_the_same_point_on_both_ends_counts_once_and_is_told() -> None:
    text = image() + "".join(pairs((x, 9), (x, 9)) for x in (10, 20, 30))
    found = read(text)
    assert lines_of(found) == {(0, "t3"): [(10, 9), (20, 9), (30, 9)]}
    assert any("one point on both ends" in note for note in found.notes)


def test_other_kinds_of_points_are_counted_and_left_aside() -> None:
    text = image() + image() + LINE + "c n0 N1 x1 y1 X2 Y2 t0\nc n0 N1 x1 y1 X2 Y2\n"
    text += "c n0 N0 x1 y1 X2 Y2 t1\nc n0 N0 x1 y1 X2 Y2 t2\nc n0 N1 x1 y1 X2 Y2 t4\n"
    found = read(text)
    assert lines_of(found) == {(0, "t3"): [(10, 20), (50, 22), (90, 25)]}
    assert found.notes == (
        "4 control points of other kinds (normal, horizontal, vertical) left aside",
        "1 line point between different images left aside",
    )


# --- lenses ---------------------------------------------------------------------------------


def test_linked_photos_share_a_lens_and_others_have_their_own() -> None:
    linked = dict.fromkeys("vabcde", "=0")
    text = image(a=0.1, b=0, c=0) + image(a=0.2, b=0, c=0) + image(**linked) + LINE
    found = read(text)
    assert [photo.lens for photo in found.photos] == [0, 1, 0]
    assert [facts.stored["a"] for facts in found.lenses] == [0.1, 0.2]


@pytest.mark.parametrize("own", [{"d": 5}, {"e": -2}, {"g": 1}, {"t": 0.5}])
def test_a_linked_photo_with_its_own_centre_or_shear_is_a_lens_of_its_own(
    own: dict[str, float],
) -> None:
    found = read(image(a=0, b=0, c=0) + image(a="=0", b="=0", c="=0", **own) + LINE)
    assert [photo.lens for photo in found.photos] == [0, 1]
    (name,) = own
    assert f"has its own {name}" in found.notes[0]


def test_links_that_are_not_complete_do_not_share_a_lens() -> None:
    found = read(image(a=0, b=0, c=0) + image(a="=0", b="=0", c=0) + LINE)
    assert [photo.lens for photo in found.photos] == [0, 1]


def test_crops() -> None:
    assert read(image(C="-10,110,-5,85") + LINE).photos[0].size == (100, 80)
    assert read(image(S="10,90,5,60") + LINE).photos[0].size == (100, 80)
    with pytest.raises(ReadError, match=r"some\.pto, row 1: the image has a crop \(C\)"):
        read(image(C="10,110,0,80") + LINE)


# --- refusals -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (HEAD + LINE, "there is no image in this project"),
        (image() + "c n0 N0 x1 y1 X2 Y2 t0\n", "no straight line in this project among its 1 "),
        (image(), "there is no straight line in this project"),
        (image(w=0) + LINE, "row 1: the image has no size"),
        ("i f0\n" + LINE, "row 1: the image has no size"),
        (image() + "c n0 N0 x1 y1 X2 t3\n", "row 2: the control point lacks Y"),
        (image() + "c n0 N0 x1 y1 X2 Yfoo t3\n", "row 2: 'foo' stands where a coordinate belongs"),
        (image() + "c n0 N0 x1 y1 X2 Y1-2 t3\n", "row 2: '1-2' stands where a coordinate"),
        (image() + "c n0 N0 x1 y1 X2 Ynan t3\n", "row 2: 'nan' is not a finite number"),
        (image() + "c n0 N0 x1 y1 X2 Y2 t-3\n", "row 2: 't-3' is not a whole number"),
        (image() + "c n-1 N0 x1 y1 X2 Y2 t3\n", "row 2: 'n-1' is not a whole number"),
        (image() + "c n0 N1 x1 y1 X2 Y2 t3\n", "row 2: the control point refers to an image"),
        (image() + image(a="=1") + LINE, "row 2: 'a=1' does not refer to an earlier image"),
        (image(a="=1") + image() + LINE, "row 1: 'a=1' does not refer to an earlier image"),
        (image(b="huge") + LINE, "row 1: 'huge' stands where the value of b belongs"),
    ],
)
def test_every_refusal_names_file_and_line_and_a_remedy(text: str, sentence: str) -> None:
    with pytest.raises(ReadError, match=r"^some\.pto[,:] ") as caught:
        read(text)
    assert sentence in caught.value.message
    assert caught.value.hint


NO_LINE = "there is no straight line in this project"
SHARED_FILES = {
    "dmgerman_84bw.pto": f"{NO_LINE} among its 10 control points",
    "domegen_project.pto": f"{NO_LINE} among its 18 control points",
    "gear360sm-r210.pto": f"{NO_LINE} among its 12 control points",
    "itoncek_template.pto": NO_LINE,
    "libpano13_simple.pto": f"{NO_LINE} among its 7 control points",
    "panotoolsscript_cemetery.pto": f"{NO_LINE} among its 41 control points",
    "panotoolsscript_cemetery_optimise.txt": f"{NO_LINE} among its 41 control points",
    "ptgui_v41_from_script.pts": NO_LINE,
    "sinky_fix_pitch.pto": "'{{panoheight}}' stands where the value of h belongs",
    "stefal_calibration.pto": f"{NO_LINE} among its 554 control points",
}


@pytest.mark.parametrize("name", SHARED_FILES)
def test_projects_of_other_people(name: str) -> None:
    path = SHARED / name
    if not path.is_file():
        pytest.skip("the projects of other people are not beside this checkout")
    source = Source(str(path), path.read_bytes())
    with pytest.raises(ReadError) as caught:
        format_of(source).read(source, ReadOptions())
    line = "row 7: " if name.startswith("sinky") else ""
    where = f"{path}, {line}" if line else f"{path}: "
    assert caught.value.message == where + SHARED_FILES[name]
    assert caught.value.hint
    if path.suffix == ".pto" and "sinky" not in name:
        assert rewritten(source.content, name, {}) == source.content


# --- written --------------------------------------------------------------------------------


@st.composite
def projects(draw: st.DrawFn) -> bytes:
    """A project with bytes changed, lines dropped and doubled, in either kind of line end."""
    text = (HEAD + IMAGE + image(a="=0", b="=0") + "v a0 b0\n" + LINE + "k i0 t0\n*\n").encode()
    text += b'i w9 h9 n"caf\xe9 \xff.jpg"\n'
    lines = text.replace(b"\n", draw(st.sampled_from([b"\n", b"\r\n"]))).splitlines(keepends=True)
    picked = draw(st.lists(st.sampled_from(lines), min_size=1, max_size=20))
    content = bytearray(b"".join(picked))
    for place in draw(st.lists(st.integers(0, len(content) - 1), max_size=8)):
        content[place] = draw(st.integers(1, 255))
    return bytes(content)


@given(projects())
def test_a_project_without_new_values_is_the_same_bytes(content: bytes) -> None:
    with contextlib.suppress(ReadError):  # that makes no sense as a project
        assert rewritten(content, "x.pto", {}) == content


@given(projects())
def test_only_read_errors_come_out_of_the_reader(content: bytes) -> None:
    caught: ReadError | None = None
    try:
        FORMATS["pto"].read(Source("x.pto", content), ReadOptions())
    except ReadError as error:
        caught = error
    assert caught is None or (str(caught).startswith("x.pto") and caught.hint)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_only_lens_values_change(end: str) -> None:
    text = (PROJECT + "\x80k what ever\n").replace("\n", end).encode("latin-1")
    done = rewritten(text, "x.pto", {0: {"a": 0.25, "b": -0.5, "c": 0.0, "d": 0.0, "e": 3.0}})
    before, after = text.split(b"\n"), done.split(b"\n")
    changed = [i for i, (old, new) in enumerate(zip(before, after, strict=True)) if old != new]
    assert [before[i][:2] for i in changed] == [b"i "]
    expected = (
        before[changed[0]]
        .replace(b" a0.03 ", b" a0.250000000000000000 ")
        .replace(b" b-0.1 ", b" b-0.500000000000000000 ")
        .replace(b" c0.06 ", b" c0 ")
        .replace(b" e0 ", b" e3.000000000000000000 ")
    )
    assert after[changed[0]] == expected


def test_linked_values_stay_links_where_they_mean_the_same() -> None:
    text = image(a=1, b=2, c=3) + image(a="=0", b="=0", c="=0", d=0, e=0) + LINE
    values = {"a": 0.5, "b": 0.25, "c": 0.125, "d": 0.0, "e": 0.0}
    both = rewritten(text.encode(), "x.pto", {0: values, 1: values}).decode()
    assert "a=0 b=0 c=0" in both
    assert " a0.500000000000000000 b0.250000000000000000" in both
    second = rewritten(text.encode(), "x.pto", {1: values}).decode()
    assert "=0" not in second
    assert second.splitlines()[0] == text.splitlines()[0]


def test_images_parted_by_tabs_are_counted_when_written() -> None:
    text = image(a=1).replace(" ", "\t", 1) + image(a=2) + LINE
    done = rewritten(text.encode(), "x.pto", {1: {"a": 0.5}}).decode().splitlines()
    assert done[0] == text.splitlines()[0]
    assert " a0.500000000000000000 " in done[1]


def test_what_is_written_reads_back() -> None:
    values = {"a": 0.032059123456789, "b": -1 / 3, "c": 1e-9, "d": -12.375, "e": 0.1}
    done = rewritten(PROJECT.encode(), "x.pto", {0: values})
    stored = read(done).lenses[0].stored
    assert all(abs(stored[name] - value) <= 5e-19 for name, value in values.items())


coordinates = st.floats(-0.5, 99.5)
picks = st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=9, unique=True)


@given(st.lists(picks, min_size=1, max_size=4), st.integers(0, 1))
def test_new_projects_hold_the_same_points(
    lines: list[list[tuple[float, float]]], second: int
) -> None:
    made = Observations(
        photos=(Photo((100, 100), "a.jpg"), Photo((100, 100), "b c.jpg", second)),
        lines=tuple(Line(np.array(each), i % 2, str(i)) for i, each in enumerate(lines)),
        lenses=(LensFacts(hfov_deg=50.25, crop_factor=1.6), LensFacts(focal_px=100))[: second + 1],
    )
    content = new_project(made, {})
    found = read(content)
    assert [(p.size, p.name, p.lens) for p in found.photos] == [
        ((100, 100), "a.jpg", 0),
        ((100, 100), "b c.jpg", second),
    ]
    wanted = [(i % 2, sorted(map(list, each))) for i, each in enumerate(lines)]
    assert sorted((line.photo, sorted(line.points_px.tolist())) for line in found.lines) == sorted(
        wanted
    )
    for match in re.finditer(r"c n\d N\d x(\S+) y(\S+) X(\S+) Y(\S+)", content.decode()):
        assert (match[1], match[2]) != (match[3], match[4])


def test_new_projects_pair_points_with_their_reversed_order() -> None:
    line = Line(np.array([[1.5, 2], [3, 4], [5, 6], [7, 8], [9, 10]]))
    text = new_project(Observations((Photo((20, 20)),), (line,)), {}).decode()
    assert re.findall(r"^c .*", text, re.MULTILINE) == [
        "c n0 N0 x1.5 y2 X9 Y10 t3",
        "c n0 N0 x3 y4 X7 Y8 t3",
        "c n0 N0 x5 y6 X3 Y4 t3",
        "c n0 N0 x7 y8 X3 Y4 t3",
        "c n0 N0 x9 y10 X1.5 Y2 t3",
    ]


def test_new_projects_are_ready_for_hugin() -> None:
    line = Line(np.array([[1.0, 2], [3, 4], [5, 6.5]]))
    name = 'the "big"\none.jpg'
    made = Observations(
        (Photo((200, 100), name),),
        (line,),
        (LensFacts(crop_factor=1.5, focal_mm=24),),
    )
    text = new_project(made, {0: {"a": 0.5, "b": -0.25, "c": 0.0, "d": 1.0, "e": 0.0}}).decode()
    # 24 mm on a sensor with half the width of: 43.2666 mm / 1.5 * 2 / sqrt(5) across.
    across = np.hypot(36, 24) / 1.5 * 2 / np.sqrt(5)
    hfov = np.degrees(2 * np.arctan(across / 2 / 24))
    (record,) = re.findall(r"^i .*", text, re.MULTILINE)
    (angle,) = re.findall(r" v(\S+) ", record)
    assert float(angle) == pytest.approx(hfov, abs=1e-9)
    assert 'n"the bigone.jpg"' in record
    assert " a0.500000000000000000 b-0.250000000000000000 c0 d1.000000000000000000 e0 " in record
    assert "#-hugin  cropFactor=1.5\n" in text
    assert text.startswith("# hugin project file\n#hugin_ptoversion 2\n")
    assert "\nv a0\nv b0\nv c0\nv\n" in text


def test_converting_a_project_keeps_what_it_says_of_the_lenses() -> None:
    first = image(v=50.25, a=0.5, b=-0.25, c=0.125, d=3.5, e=-2, g=0, t=0)
    text = first + image(v="=0", a="=0", b="=0", c="=0", d="=0", e="=0", g=0, t=0)
    text += image(f=3, v=120, a=0, b=0.03125, c=0, d=0, e=0, g=1.5, t=-0.5) + "v b0 d0\nv a2\n"
    text += LINE + pairs((1, 1), (2, 2), (3, 3.5), image=1) + pairs((1, 1), (2, 3), (5, 5), image=2)
    before = read(text)
    after = read(new_project(before, {}))
    assert [photo.lens for photo in after.photos] == [0, 0, 1]
    assert [facts.stored for facts in after.lenses] == [
        {"a": 0.5, "b": -0.25, "c": 0.125, "d": 3.5, "e": -2, "g": 0, "t": 0},
        {"a": 0, "b": 0.03125, "c": 0, "d": 0, "e": 0, "g": 1.5, "t": -0.5},
    ]
    assert [facts.requested for facts in after.lenses] == [("b", "d"), ("a",)]
    assert [facts.projection for facts in after.lenses] == ["rectilinear", "full-frame fisheye"]
    assert [facts.hfov_deg for facts in after.lenses] == [50.25, 120]


def test_converting_keeps_lens_types_that_have_no_name() -> None:
    content = new_project(read(image(f=17) + LINE), {})
    assert read(content).lenses[0].projection == "lens type f17"
    odd = Observations(read(image() + LINE).photos, (), (LensFacts(projection="odd"),))
    with pytest.raises(OptionError, match="there is no lens type 'odd'"):
        new_project(odd, {})


def test_a_stored_centre_moves_with_the_pixels_of_video() -> None:
    made = read(image(w=100, d=4, e=2) + LINE)
    video = replace(made, photos=(replace(made.photos[0], pixel_aspect=1.5),))
    stored = read(new_project(video, {})).lenses[0].stored
    assert (stored["d"], stored["e"]) == (6, 2)


def test_photos_of_other_widths_have_their_own_field_of_view() -> None:
    lines = tuple(Line(np.array([[1.0, 2], [3, 4], [5, 6.5]]), i) for i in range(3))
    photos = (Photo((400, 300), "a"), Photo((300, 400), "b"), Photo((400, 300), "c"))
    made = Observations(photos, lines, (LensFacts(hfov_deg=90.0, hfov_width_px=400),))
    records = re.findall(r"^i .*", new_project(made, {}).decode(), re.MULTILINE)
    angles = [re.findall(r" v(\S+)", record)[0] for record in records]
    # 90 degrees over 400 px is a focal length of 200 px, seen by half of 300 px.
    assert (angles[0], angles[2]) == ("90", "=0")
    assert float(angles[1]) == pytest.approx(2 * np.degrees(np.arctan(150 / 200)), abs=1e-12)
    portrait = new_project(made.of_photo(1), {}).decode()
    assert re.findall(r"^i .* v(\S+)", portrait, re.MULTILINE) == [angles[1]]


def test_a_measured_focal_length_counts_before_the_projects_field_of_view() -> None:
    line = Line(np.array([[1.0, 2], [3, 4], [5, 6.5]]))
    facts = LensFacts(hfov_deg=50.0, focal_px=200.0)
    text = new_project(Observations((Photo((400, 300)),), (line,), (facts,)), {}).decode()
    (angle,) = re.findall(r"^i .* v(\S+)", text, re.MULTILINE)
    assert float(angle) == pytest.approx(90.0, abs=1e-12)


def test_a_field_of_view_that_is_not_known_stays_so() -> None:
    line = Line(np.array([[1.0, 2], [3, 4], [5, 6.5]]))
    photos = (Photo((40, 30)), Photo((40, 30)), Photo((30, 40)))
    content = new_project(Observations(photos, (line,), (LensFacts(),)), {})
    assert b" v50 " in content
    assert read(content).lenses[0].hfov_deg is None
    edited = content.replace(b" v50 ", b" v51 ")
    assert read(edited).lenses[0].hfov_deg == 51
    assert read(image() + LINE).lenses[0].hfov_deg == 50


def effective(text: str) -> list[dict[str, float]]:
    """The lens values of every image, links followed one by one."""
    found: list[dict[str, float]] = []
    for record in re.findall(r"^i .*", text, re.MULTILINE):
        own: dict[str, str] = dict(re.findall(r" ([abcde])(\S+)", record))
        found.append(
            {n: found[int(v[1:])].get(n, 0) if v[0] == "=" else float(v) for n, v in own.items()}
        )
    return found


@pytest.mark.parametrize("fitted", [{0}, {1}, {2}, {3}, {0, 2}, {1, 3}, {0, 1, 2, 3}])
def test_images_that_are_not_fitted_keep_their_values(fitted: set[int]) -> None:
    text = image(a=0.1, b=1e-7, c=3, d=4, e=5) + image(a="=0", b="=0", c="=0", d="=0", e=6)
    text += image(a="=1", b="=1", c=0.25, d="=1", e="=1") + image(a="=2", b=7, c="=2") + LINE
    values = {"a": 0.5, "b": 0.25, "c": 0.125, "d": 0.0, "e": 1.5}
    done = rewritten(text.encode(), "x.pto", dict.fromkeys(fitted, values)).decode()
    before, after = effective(text), effective(done)
    for number in range(4):
        assert after[number] == (values if number in fitted else before[number])
    changed = [
        old for old, new in zip(text.splitlines(), done.splitlines(), strict=True) if old != new
    ]
    assert all(record.startswith("i ") for record in changed)
