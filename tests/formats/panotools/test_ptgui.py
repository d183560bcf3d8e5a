"""Projects of PTGui and PTAssembler."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from plumbline.errors import ReadError
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS, format_of
from plumbline.observations import Observations

DUMMY = "#-dummyimage\no w1 h1 y0 r0 p0 v52.5 a0.03 b-0.1 c0.06 f0 d1 e2 g0 t0\n"
FIRST = (
    '#-imgfile 1712 1368 "first one.jpg"\n#-metadata 3 *\no f0 y0 r0 p0 v=0 a=0 b=0 c=0 d=0 e=0\n'
)
SECOND = '#-imgfile 800 600 "b5 d9.jpg"\no f0 y0 r0 p0 v40 a0.5 b=0 c=0 d0 e0 g0 t0\n'


def line(image: int, kind: int = 3) -> str:
    pairs = [(10, 20, 90, 25), (50, 22, 10, 20)]
    return "".join(f"c n{image} N{image} x{x} y{y} X{x2} Y{y2} t{kind}\n" for x, y, x2, y2 in pairs)


def project(*records: str, version: int = 41) -> str:
    head = f"# ptGui project file\n#-fileversion {version}\n#-ccdcrop 1.613\np w100 h50 f2 v360\n"
    return head + "".join(records)


def read(text: str, path: str = "some.pts") -> Observations:
    return FORMATS["ptgui"].read(Source(path, text.encode()), ReadOptions())


def test_the_dummy_holds_the_lens_and_is_no_photo() -> None:
    found = read(project(DUMMY, FIRST, "v v a b c\n", line(1)))
    (photo,) = found.photos
    assert (photo.size, photo.name, photo.lens) == ((1712, 1368), "first one.jpg", 0)
    (facts,) = found.lenses
    assert {n: facts.stored[n] for n in "abcde"} == {
        "a": 0.03,
        "b": -0.1,
        "c": 0.06,
        "d": 1,
        "e": 2,
    }
    assert (facts.hfov_deg, facts.crop_factor, facts.projection) == (52.5, 1.613, "rectilinear")
    assert facts.requested == ("a", "b", "c")
    assert [(made.photo, made.label) for made in found.lines] == [(0, "t3")]
    assert found.lines[0].points_px.tolist() == [[10, 20], [50, 22], [90, 25]]


@pytest.mark.parametrize(
    ("version", "dummy", "shift"),
    [(41, True, 1), (8, True, 1), (7, True, 0), (0, True, 0), (41, False, 0), (7, False, 0)],
)
def test_whether_control_points_count_the_dummy(version: int, dummy: bool, shift: int) -> None:
    first = FIRST if dummy else FIRST.replace("=0", "0.5")
    second = SECOND if dummy else SECOND.replace("=0", "0.5")
    records = (DUMMY * dummy, first, second, line(shift), line(1 + shift, 4))
    found = read(project(*records, version=version))
    assert [(made.photo, made.label) for made in found.lines] == [(0, "t3"), (1, "t4")]


def test_a_point_on_the_dummy_itself_is_refused_with_its_line() -> None:
    with pytest.raises(ReadError, match=r"some\.pts, row 10: the control point refers to an im"):
        read(project(DUMMY, FIRST, line(0)))


def test_without_a_version_line_the_dummy_is_not_counted() -> None:
    text = project(DUMMY, FIRST, line(0)).replace("#-fileversion 41\n", "")
    assert [made.photo for made in read(text).lines] == [0]


def test_linked_values_share_the_dummys_lens_and_others_do_not() -> None:
    third = FIRST.replace("first one", "third")
    found = read(project(DUMMY, FIRST, SECOND, third, "v a b c b2\n", line(1)))
    assert [photo.lens for photo in found.photos] == [0, 1, 0]
    assert [photo.name for photo in found.photos] == ["first one.jpg", "b5 d9.jpg", "third.jpg"]
    assert [facts.stored["a"] for facts in found.lenses] == [0.03, 0.5]


def test_variables_with_a_number_belong_to_that_image_counting_the_dummy() -> None:
    alone = '#-imgfile 800 600 "x"\no f0 v40 a0 b0 c0 d0 e0\n'
    found = read(project(DUMMY, FIRST, alone, "v a b2 c2 y2\n", line(1)))
    assert [facts.requested for facts in found.lenses] == [("a",), ("b", "c")]


def test_line_ends_of_windows() -> None:
    found = read(project(DUMMY, FIRST, line(1)).replace("\n", "\r\n"))
    assert found.photos[0].size == (1712, 1368)
    assert len(found.lines[0].points_px) == 3


def test_recognised() -> None:
    text = project(DUMMY, FIRST, line(1))
    for path in ("a.pts", "a.PTS", "a.txt", "a"):
        assert format_of(Source(path, text.encode())).name == "ptgui"
    bare = text.replace("# ptGui project file\n", "")
    assert format_of(Source("a.pts", bare.encode())).name == "ptgui"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ('{"contenttype":"com.ptgui.project_pro"}', r"^a\.pts: 'project' is missing"),
        (' \r\n{\n"fileversion"', r"^a\.pts, row 3: the JSON is broken"),
    ],
)
def test_newer_projects_that_are_damaged_are_refused(text: str, match: str) -> None:
    assert format_of(Source("a.pts", text.encode())).name == "ptgui"
    with pytest.raises(ReadError, match=match) as caught:
        read(text, "a.pts")
    assert caught.value.hint


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (project(DUMMY), "there is no image in this project"),
        (project(), "there is no image in this project"),
        (project(DUMMY, FIRST), "there is no straight line in this project"),
        (project(DUMMY, "o f0 a0\n", line(1)), "row 7: the image record has no '#-imgfile"),
        (project(DUMMY, FIRST.replace("1712", "0"), line(1)), "row 9: the image has no size"),
        (
            project(DUMMY, FIRST.replace("a=0", "a=1"), line(1)),
            "row 9: 'a=1' does not refer to an",
        ),
        (project(DUMMY, FIRST.replace("a=0", "aX"), line(1)), "row 9: 'X' stands where the value"),
        (project(DUMMY, FIRST, line(2)), "row 10: the control point refers to an image"),
        (project().replace("1.613", "big"), "row 3: 'big' stands where the crop factor belongs"),
        (
            project(DUMMY, FIRST.replace("e=0", "C-825,3993,-33,4785"), line(1)),
            "row 9: the image has a crop (C)",
        ),
        ("# ptGui project file\0", "binary"),
        ("", "the file is empty"),
    ],
)
def test_every_refusal_names_file_and_line_and_a_remedy(text: str, sentence: str) -> None:
    with pytest.raises(ReadError, match=r"^some\.pts[,:] ") as caught:
        read(text)
    assert sentence in caught.value.message
    assert caught.value.hint


def test_fisheye_lens_types_are_named() -> None:
    found = read(project(DUMMY, FIRST.replace("f0", "f3"), line(1)))
    assert found.lenses[0].projection == "full-frame fisheye"


@given(
    st.lists(st.sampled_from([DUMMY, FIRST, SECOND, line(0), line(1), "v a b1\n", "o\n"])),
    st.lists(st.tuples(st.integers(0, 400), st.characters()), max_size=6),
)
def test_only_read_errors_come_out(records: list[str], changes: list[tuple[int, str]]) -> None:
    text = list(project(*records))
    for place, sign in changes:
        text[place % len(text)] = sign
    caught: ReadError | None = None
    try:
        FORMATS["ptgui"].read(
            Source("x.pts", "".join(text).encode("utf-8", "replace")), ReadOptions()
        )
    except ReadError as error:
        caught = error
    assert caught is None or (str(caught).startswith("x.pts") and caught.hint)
