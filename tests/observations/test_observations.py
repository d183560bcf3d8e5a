"""Picked points: the checks, the notes and the ways to take them apart."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.errors import DegenerateLinesError, OptionError, ReadError
from plumbline.frame import Frame
from plumbline.observations import Line, Observations, Origin, Photo
from plumbline.observations.facts import LensFacts, best_crop_factor
from plumbline.wording import count, listed

SIZE = (400, 300)
LOWER = [[10.0, 290.0], [200.0, 295.0], [390.0, 289.0]]
EDGE = [[10.0, 12.0], [200.0, 9.0], [390.0, 12.0]]


def test_from_arrays_keeps_points_order_and_names() -> None:
    obs = Observations.from_arrays(
        [EDGE, LOWER[::-1]], SIZE, labels=["eaves", "ridge"], focal_px=500.0, pixel_aspect=1.25
    )
    assert [line.label for line in obs.lines] == ["eaves", "ridge"]
    assert obs.lines[0].points_px.tolist() == EDGE
    assert obs.lines[1].points_px.tolist() == LOWER[::-1]
    assert obs.lines[0].points_px.dtype == np.float64
    assert obs.photos == (Photo(SIZE, pixel_aspect=1.25),)
    assert obs.lenses == (LensFacts(focal_px=500.0),)
    assert (obs.n_points, obs.notes, obs.origins) == (6, (), ())


def test_lines_are_numbered_from_one() -> None:
    obs = Observations.from_arrays(
        iter([EDGE, LOWER, [[5.0, 9.0], [6.0, 90.0], [5.0, 200.0]]]), SIZE
    )
    assert [line.label for line in obs.lines] == ["1", "2", "3"]


def test_labels_may_be_numbers() -> None:
    labels: Any = np.array([7, 8])
    obs = Observations.from_arrays([EDGE, LOWER], SIZE, labels=labels)
    assert [line.label for line in obs.lines] == ["7", "8"]
    with pytest.raises(OptionError, match="line 9 has shape"):
        Observations.from_arrays([EDGE, [1.0, 2.0]], SIZE, labels=[7, 9])


@pytest.mark.parametrize("labels", [[], ["a"], ["a", "b", "c"]])
def test_as_many_labels_as_lines(labels: list[str]) -> None:
    with pytest.raises(
        OptionError, match=rf"^there are {len(labels)} labels? for 2 lines$"
    ) as caught:
        Observations.from_arrays([EDGE, EDGE], SIZE, labels=labels)
    assert caught.value.hint


def test_numbers_of_numpy_become_plain_ones() -> None:
    size: Any = np.array([400, 300])
    numpys: dict[str, Any] = {"focal_px": np.float32(500), "pixel_aspect": np.float32(1.25)}
    obs = Observations.from_arrays([EDGE], size, **numpys)
    photo, facts = obs.photos[0], obs.lenses[0]
    assert photo.size == (400, 300)
    numbers = [*photo.frame.size, photo.pixel_aspect, facts.focal_px]
    assert [type(number) for number in numbers] == [int, int, float, float]


def grid(rows: int, columns: int) -> np.ndarray[Any, Any]:
    """Places of a grid, shape (rows, columns, 2)."""
    y, x = np.meshgrid(20 + 25.0 * np.arange(rows), 10 + 30.0 * np.arange(columns), indexing="ij")
    return np.stack((x, y), axis=-1)


@pytest.mark.parametrize("n", [(3, 3), (4, 7), (9, 3)])
def test_a_grid_is_its_rows_and_columns(n: tuple[int, int]) -> None:
    points = grid(*n)
    obs = Observations.from_grid(points, SIZE, focal_px=500.0, pixel_aspect=1.25)
    rows, columns = [f"row {i + 1}" for i in range(n[0])], [f"column {i + 1}" for i in range(n[1])]
    assert [line.label for line in obs.lines] == [*rows, *columns]
    for line, values in zip(obs.lines, [*points, *points.transpose(1, 0, 2)], strict=True):
        np.testing.assert_array_equal(line.points_px, values)
    assert (obs.photos[0].pixel_aspect, obs.lenses[0].focal_px, obs.notes) == (1.25, 500.0, ())


@pytest.mark.parametrize("how", ["nan", "masked"])
def test_points_that_a_grid_lacks_are_left_out(how: str) -> None:
    points: Any = grid(5, 6)
    points[1, 2, 0] = np.nan
    points[4, :4] = np.nan
    if how == "masked":
        points = np.ma.masked_array(np.nan_to_num(points, nan=7.0), np.isnan(points))
    obs = Observations.from_grid(points, SIZE)
    sizes = {line.label: len(line.points_px) for line in obs.lines}
    assert sizes == {
        "row 1": 6,
        "row 2": 5,
        "row 3": 6,
        "row 4": 6,  # two points of row 5 are no line
        **{f"column {i}": size for i, size in enumerate((4, 4, 3, 4, 5, 5), 1)},
    }
    assert obs.notes[0] == "5 points of the grid missing"


@pytest.mark.parametrize(
    "points", [grid(3, 4).reshape(-1, 2), grid(3, 4)[..., :1], [], 7.0, "abc"], ids=str
)
def test_another_shape_is_no_grid(points: Any) -> None:
    with pytest.raises(OptionError, match="the grid") as caught:
        Observations.from_grid(points, SIZE)
    assert "--" not in caught.value.hint


WRONG: dict[str, Any] = {
    "lines": 3,
    "a line": [EDGE, 3],
    "words": ["abc"],
    "objects": [[object(), object()]],
    "complex": [np.array(EDGE) * 1j],
    "ragged": [[[1.0, 2.0], [3.0]]],
    "three numbers": [[(1.0, 2.0, 3.0)] * 4],
}


@pytest.mark.parametrize("lines", WRONG.values(), ids=WRONG)
def test_lines_of_another_type_are_refused_in_words_of_python(lines: Any) -> None:
    with pytest.raises(OptionError) as caught:
        Observations.from_arrays(lines, SIZE)
    assert "--" not in f"{caught.value} {caught.value.hint}"


@pytest.mark.parametrize(
    "more",
    [
        *({"size": size} for size in (None, 400, ("a", "b"), "400x300", (0, 300), (4e6, 9))),
        {"labels": 3},
        {"focal_px": "x"},
        {"pixel_aspect": "x"},
        {"pixel_aspect": None},
    ],
    ids=str,
)
def test_other_arguments_of_another_type_likewise(more: dict[str, Any]) -> None:
    more = {"size": SIZE} | more
    with pytest.raises(OptionError) as caught:
        Observations.from_arrays([EDGE, LOWER], **more)
    assert "--" not in f"{caught.value} {caught.value.hint}"


@pytest.mark.parametrize("size", [(400, 300, 3), (400,), ()])
def test_a_size_is_two_numbers(size: Any) -> None:
    with pytest.raises(OptionError, match="is not a width and a height") as caught:
        Observations.from_arrays([EDGE], size)
    assert caught.value.hint


def test_arrays_are_copied() -> None:
    mine = np.array(EDGE)
    obs = Observations.from_arrays([mine], SIZE)
    mine[:] = 0
    assert obs.lines[0].points_px.tolist() == EDGE


@pytest.mark.parametrize(
    "values",
    [[1.0, 2.0], [[1, 2, 3]] * 3, 7.0, [], [["x", "y"]] * 3, [[1], [2, 3]]],
)
def test_other_shapes_are_refused(values: Any) -> None:
    with pytest.raises(OptionError, match="line 2"):
        Observations.from_arrays([EDGE, values], SIZE)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf")])
def test_numbers_that_are_none_are_refused(bad: float) -> None:
    with pytest.raises(OptionError, match="line 1 is not a finite number"):
        Observations.from_arrays([[*EDGE, [5.0, bad]]], SIZE)


@pytest.mark.parametrize("point", [(-0.6, 5.0), (399.6, 5.0), (5.0, -0.6), (5.0, 299.6)])
def test_points_outside_the_photo_are_refused(point: tuple[float, float]) -> None:
    with pytest.raises(OptionError, match="outside the 400x300 photo"):
        Observations.from_arrays([[*EDGE, point]], SIZE)
    on_the_edge = np.clip(point, -0.5, (399.5, 299.5)).tolist()
    Observations.from_arrays([[*EDGE, on_the_edge]], SIZE)


def test_points_of_a_file_are_refused_by_file_and_row() -> None:
    line = Line(np.array([*EDGE, [500.0, 5.0]]), label="7", rows=np.array([3, 4, 5, 6]))
    origin = Origin("picks.csv", "csv", b"")
    with pytest.raises(ReadError, match=r"picks\.csv, row 6: .*\(500, 5\) of line 7") as caught:
        Observations((Photo(SIZE),), (line,), origins=(origin,)).checked()
    assert (caught.value.path, caught.value.line) == ("picks.csv", 6)


@pytest.mark.parametrize(
    "size", [(0, 300), (400, -1), (10**7, 300), (float("nan"), 300), (400.5, 300)]
)
def test_impossible_sizes_are_refused(size: Any) -> None:
    with pytest.raises(OptionError, match="impossible"):
        Observations.from_arrays([EDGE], size)


@pytest.mark.parametrize("aspect", [0.0, -1.0, 1e3, float("nan"), float("inf")])
def test_impossible_pixels_are_refused(aspect: float) -> None:
    with pytest.raises(OptionError, match="pixel aspect"):
        Observations.from_arrays([EDGE], SIZE, pixel_aspect=aspect)


def test_an_unknown_size_is_asked_for() -> None:
    with pytest.raises(OptionError, match="size of the photo is not known") as caught:
        Observations((Photo(None),), (Line(np.array(EDGE)),)).checked()
    assert "--size" in caught.value.hint


def test_a_point_picked_twice_counts_once_and_is_told() -> None:
    twice = [EDGE[2], EDGE[0], EDGE[2], EDGE[1], EDGE[0]]
    line = Line(np.array(twice), label="1", rows=np.array([10, 11, 12, 13, 14]))
    obs = Observations((Photo(SIZE),), (line,)).checked()
    assert obs.lines[0].points_px.tolist() == [EDGE[2], EDGE[0], EDGE[1]]
    rows = obs.lines[0].rows
    assert rows is not None
    assert rows.tolist() == [10, 11, 13]
    assert obs.notes == ("2 points picked twice on one line counted once",)


def test_one_point_may_lie_on_two_lines() -> None:
    across = [EDGE[0], [10.0, 100.0], [11.0, 200.0]]
    obs = Observations.from_arrays([EDGE, across], SIZE)
    assert (obs.n_points, obs.notes) == (6, ())


def test_short_lines_are_set_aside_and_told() -> None:
    obs = Observations.from_arrays(
        [EDGE[:2], EDGE, [EDGE[0]] * 4, np.zeros((0, 2))], SIZE, labels=["a", "b", "c", "d"]
    )
    assert [line.label for line in obs.lines] == ["b"]
    assert obs.notes[-1] == (
        "3 lines set aside for having fewer than 3 distinct points: "
        "a (2 points), c (1 point), d (0 points)"
    )


@pytest.mark.parametrize("lines", [[], [EDGE[:2]], [[EDGE[0]] * 5]])
def test_no_line_left_is_refused(lines: list[Any]) -> None:
    with pytest.raises(DegenerateLinesError, match="at least 3 distinct points"):
        Observations.from_arrays(lines, SIZE)


def test_checking_twice_changes_nothing() -> None:
    obs = Observations.from_arrays([EDGE, EDGE[:2]], SIZE)
    again = obs.checked()
    assert again.notes == obs.notes
    assert [line.label for line in again.lines] == ["1"]


def two_lenses() -> Observations:
    """Photos 0 and 2 by lens 1, photo 1 by lens 0; one line in photos 0 and 1, two in 2."""
    photos = (
        Photo((400, 300), "p0", lens=1),
        Photo((640, 480), "p1", lens=0),
        Photo((300, 400), "p2", lens=1),
    )
    lines = tuple(
        Line(np.array(EDGE)[:, ::-1] if photo == 2 else np.array(EDGE), photo, label)
        for photo, label in ((2, "t"), (0, "u"), (1, "v"), (2, "w"))
    )
    return Observations(photos, lines, (LensFacts(model="A"), LensFacts(model="B")), ("n",))


def test_of_lens_keeps_its_photos_and_lines_alone() -> None:
    only = two_lenses().of_lens(1)
    assert [(photo.name, photo.lens) for photo in only.photos] == [("p0", 0), ("p2", 0)]
    assert [(line.label, line.photo) for line in only.lines] == [("t", 1), ("u", 0), ("w", 1)]
    assert [facts.model for facts in only.lenses] == ["B"]
    assert only.notes == ("n",)
    other = two_lenses().of_lens(0)
    assert [(photo.name, photo.lens) for photo in other.photos] == [("p1", 0)]
    assert [(line.label, line.photo) for line in other.lines] == [("v", 0)]


def test_of_photo_keeps_its_lens_and_lines_alone() -> None:
    only = two_lenses().of_photo(2)
    assert [(photo.name, photo.lens) for photo in only.photos] == [("p2", 0)]
    assert [(line.label, line.photo) for line in only.lines] == [("t", 0), ("w", 0)]
    assert [facts.model for facts in only.lenses] == ["B"]


def test_side_by_side_keeps_every_lens_apart() -> None:
    first, second = two_lenses(), Observations.from_arrays([EDGE], SIZE, labels=["x"])
    whole = Observations.side_by_side([first, second, first])
    assert [photo.lens for photo in whole.photos] == [1, 0, 1, 2, 4, 3, 4]
    assert len(whole.lenses) == 5
    assert [(line.label, line.photo) for line in whole.lines] == [
        ("t", 2), ("u", 0), ("v", 1), ("w", 2), ("x", 3), ("t", 6), ("u", 4), ("v", 5), ("w", 6),
    ]  # fmt: skip
    assert whole.notes == ("n",)
    for lens, part in ((1, first.of_lens(1)), (2, second), (3, first.of_lens(0))):
        taken = whole.of_lens(lens)
        assert [line.label for line in taken.lines] == [line.label for line in part.lines]
        assert [photo.name for photo in taken.photos] == [photo.name for photo in part.photos]


def test_squared_stretches_the_rows() -> None:
    corners = [[-0.5, -0.5], [399.5, 10.0], [399.5, 299.5], [100.0, 150.0]]
    obs = Observations.from_arrays([corners], SIZE, pixel_aspect=1.5).squared()
    assert obs.photos[0] == Photo((600, 300))
    # Edges stay edges: the pixel's own corner is half a pixel from its centre.
    assert obs.lines[0].points_px.tolist() == [
        [-0.5, -0.5], [599.5, 10.0], [599.5, 299.5], [150.25, 150.0],
    ]  # fmt: skip
    assert obs.photos[0].frame.contains(obs.lines[0].points_px).all()


def test_squared_leaves_square_pixels_alone() -> None:
    obs = Observations.from_arrays([EDGE], SIZE)
    assert obs.squared() is obs


def test_squared_rounds_to_whole_pixels() -> None:
    obs = Observations.from_arrays(
        [[[0, 0], [500, 1], [1000.5, 2]]], (1001, 300), pixel_aspect=1.05
    )
    squared = obs.squared()
    assert squared.photos[0].size == (1051, 300)  # 1051.05
    assert squared.lines[0].points_px[2, 0] == pytest.approx(1050.5, abs=1e-12)


def test_focal_length_in_pixels() -> None:
    frame, portrait = Frame(4000, 3000), Frame(3000, 4000)
    assert LensFacts().focal_length_px(frame) is None
    assert LensFacts(focal_mm=50.0).focal_length_px(frame) is None
    assert LensFacts(focal_px=1234.5, hfov_deg=90.0).focal_length_px(frame) == 1234.5
    assert LensFacts(hfov_deg=90.0).focal_length_px(frame) == pytest.approx(2000.0, rel=1e-14)
    # A crop factor of 1 is a diagonal of √(36² + 24²) mm, here 5000 px, whichever way up.
    by_crop = LensFacts(focal_mm=np.sqrt(36**2 + 24**2) / 2, crop_factor=1.0)
    assert by_crop.focal_length_px(frame) == pytest.approx(2500.0, rel=1e-14)
    assert by_crop.focal_length_px(portrait) == pytest.approx(2500.0, rel=1e-14)
    twice = LensFacts(focal_mm=10.0, crop_factor=2.0).focal_length_px(frame)
    once = LensFacts(focal_mm=10.0, crop_factor=1.0).focal_length_px(frame)
    assert twice == pytest.approx(2 * (once or 0.0), rel=1e-14)


def test_a_field_of_view_belongs_to_the_width_it_was_given_for() -> None:
    facts = LensFacts(hfov_deg=90.0, hfov_width_px=4000)
    for frame in (Frame(4000, 3000), Frame(3000, 4000)):
        assert facts.focal_length_px(frame) == pytest.approx(2000.0, rel=1e-14)
    assert facts.focal_length_px(Frame(3000, 4000, 1.5)) == pytest.approx(3000.0, rel=1e-14)


def test_the_users_focal_length_counts_before_exifs_and_that_before_the_projects() -> None:
    frame = Frame(4000, 3000)
    diagonal_mm = float(np.hypot(36, 24))
    facts = LensFacts(focal_px=1e3, focal_mm=diagonal_mm / 2, crop_factor=1.0, hfov_deg=90.0)
    found = [
        replace(facts, focal_px=None, focal_mm=None).focal_length_px(frame),
        replace(facts, focal_px=None).focal_length_px(frame),
        facts.focal_length_px(frame),
    ]
    assert found == pytest.approx([2000.0, 2500.0, 1000.0], rel=1e-14)
    # 1000 of 5000 px on the diagonal of the 35-mm frame.
    by_pixels = replace(facts, focal_mm=None).focal_length_mm(frame)
    assert by_pixels == pytest.approx(diagonal_mm / 5, rel=1e-14)


@pytest.mark.parametrize(
    ("told", "best"),
    [
        # 27 and 53 mm are rounded to whole millimetres: 1.8 % and 0.9 % off at most.
        ([(27 / 18, 0.5 / 27), (53 / 35, 0.5 / 53)], 53 / 35),
        ([(1.534, None), (28 / 18, 0.5 / 28)], 1.534),
        ([(28 / 18, 0.5 / 28), (None, None)], 28 / 18),
        ([(1.5, None), (1.6, None)], None),
        ([(1.5, 0.01), (1.6, 0.01)], None),
        ([(None, None)], None),
    ],
)
def test_crop_factors_that_agree_within_their_errors_are_one(
    told: list[tuple[float | None, float | None]], best: float | None
) -> None:
    for order in (told, told[::-1]):
        found = best_crop_factor(
            [LensFacts(crop_factor=crop, crop_factor_error=error) for crop, error in order]
        )
        assert (found.crop_factor if found else None) == best


def test_focal_length_in_millimetres() -> None:
    frame = Frame(3600, 2400)
    assert LensFacts(focal_mm=35.0, hfov_deg=90.0).focal_length_mm(frame) == 35.0
    assert LensFacts(hfov_deg=90.0).focal_length_mm(frame) is None
    # 36 mm across at 90° is 18 mm of focal length; half of it behind a crop factor of 2.
    full = LensFacts(hfov_deg=90.0, crop_factor=1.0).focal_length_mm(frame)
    half = LensFacts(hfov_deg=90.0, crop_factor=2.0).focal_length_mm(frame)
    assert full == pytest.approx(18.0, rel=1e-14)
    assert half == pytest.approx(9.0, rel=1e-14)


def test_counts_and_lists_in_sentences() -> None:
    assert [count(n, "line") for n in (0, 1, 2, 12345)] == [
        "0 lines", "1 line", "2 lines", "12,345 lines",
    ]  # fmt: skip
    assert listed(["a", "b"]) == "a, b"
    assert listed(list("abcdefghij")) == "a, b, c, d, e, f, g, h and 2 more"
