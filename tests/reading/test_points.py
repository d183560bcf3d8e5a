"""Reading: format, size, photo, checks and joining."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

import plumbline
from plumbline.errors import DegenerateLinesError, OptionError, PlumblineError, ReadError
from plumbline.reading.points import join, read

CSV = "line,x,y\nleft,10,10\nleft,12,40\nleft,13,70\nroof,20,5\nroof,50,6\nroof,80,4\n"
PTO_LINE = "c n0 N0 x10 y20 X90 Y25 t3\nc n0 N0 x50 y22 X10 Y20 t3\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def put(name: str, text: str = CSV) -> str:
    Path(name).write_bytes(text.encode())
    return name


def jpeg(name: str, size: tuple[int, int] = (100, 80), **tags: object) -> str:
    numbers = {"orientation": 0x0112, "make": 0x010F, "model": 0x0110}
    exif = Image.Exif()
    for tag, value in tags.items():
        if tag in numbers:
            exif[numbers[tag]] = value
        else:
            exif.get_ifd(0x8769)[{"focal": 0x920A, "equivalent": 0xA405}[tag]] = value
    Image.new("L", size).save(name, exif=exif)
    return name


def pto(*photos: str, lines: str = PTO_LINE) -> str:
    return "".join(f"i {photo}\n" for photo in photos) + lines


def test_the_size_from_a_flag(folder: Path) -> None:
    found = read(put("a.csv"), size=(100, 80))
    assert [photo.size for photo in found.photos] == [(100, 80)]
    assert [(line.label, len(line.points_px)) for line in found.lines] == [("left", 3), ("roof", 3)]
    (origin,) = found.origins
    assert (origin.path, origin.format, origin.content) == ("a.csv", "csv", CSV.encode())


def test_size_and_lens_from_the_photo(folder: Path) -> None:
    photo = jpeg("p.jpg", make="NIKON", model="E995", focal=8.0, equivalent=38)
    found = read(put("a.csv"), photo=photo)
    assert (found.photos[0].size, found.photos[0].name) == ((100, 80), "p.jpg")
    (facts,) = found.lenses
    assert (facts.focal_mm, facts.crop_factor, facts.camera) == (8, 4.75, "NIKON E995")


def test_a_sideways_photo_is_taken_upright(folder: Path) -> None:
    found = read(put("a.csv"), photo=jpeg("p.jpg", (80, 100), orientation=6))
    assert found.photos[0].size == (100, 80)
    (note,) = found.notes
    assert "p.jpg is stored sideways" in note
    assert "the upright 100x80 picture" in note


def test_a_project_may_have_been_made_before_the_photo_was_turned(folder: Path) -> None:
    put("a.pto", pto('w80 h100 f0 v50 n"p.jpg"', lines=PTO_LINE.replace("9", "7")))
    jpeg("p.jpg", (80, 100), orientation=6, focal=8.0)
    for found in (read("a.pto", photo="p.jpg"), read("a.pto")):
        assert found.photos[0].size == (80, 100)
        assert found.lenses[0].focal_mm == 8
        assert not any("sideways" in note for note in found.notes)


def test_a_photo_of_swapped_sides_that_is_not_turned_is_not_used(folder: Path) -> None:
    jpeg("p.jpg", (80, 100), focal=8.0)
    found = read(put("a.pto", pto('w100 h80 f0 v50 n"p.jpg"')))
    assert found.photos[0].size == (100, 80)
    assert found.lenses[0].focal_mm is None
    (note,) = found.notes
    assert note == (
        "p.jpg beside the file is 80x100 and not the file's 100x80: its EXIF was not used"
    )


def test_the_photo_beside_a_project_tells_of_its_lens(folder: Path) -> None:
    jpeg("p.jpg", make="NIKON", focal=8.0, equivalent=38)
    put("a.pto", pto('w100 h80 f0 v50 n"C:\\holiday\\p.jpg"'))
    assert read("a.pto").lenses[0].focal_mm == 8
    assert read(folder / "a.pto").lenses[0].focal_mm == 8


def test_a_resized_photo_beside_a_project_is_not_used(folder: Path) -> None:
    jpeg("p.jpg", (200, 160), focal=8.0)
    found = read(put("a.pto", pto('w100 h80 f0 v50 n"p.jpg"')))
    assert found.lenses[0].focal_mm is None
    assert any("p.jpg beside the file is 200x160" in note for note in found.notes)


def test_a_damaged_photo_beside_a_project_is_told_and_not_needed(folder: Path) -> None:
    put("p.jpg", "no picture")
    found = read(put("a.pto", pto('w100 h80 f0 v50 n"p.jpg"')))
    assert found.photos[0].size == (100, 80)
    assert any("was not used" in note for note in found.notes)


@pytest.mark.parametrize("name", ["..", ".", "", "/", "x" * 300, "\x01"])
def test_names_of_photos_that_are_no_files(folder: Path, name: str) -> None:
    assert read(put("a.pto", pto(f'w100 h80 f0 v50 n"{name}"'))).lines


def test_a_photo_for_a_project_of_several_lenses_is_not_dropped_silently(folder: Path) -> None:
    two = PTO_LINE + PTO_LINE.replace("n0 N0", "n1 N1")
    put("a.pto", pto("w100 h80 f0 v50", "w100 h80 f0 v30", lines=two))
    found = read("a.pto", photo=jpeg("p.jpg", focal=8.0))
    assert [facts.focal_mm for facts in found.lenses] == [None, None]
    assert any("p.jpg was not used" in note for note in found.notes)


def test_a_photo_is_for_the_image_that_is_selected(folder: Path) -> None:
    two = PTO_LINE + PTO_LINE.replace("n0 N0", "n1 N1")
    put("a.pto", pto("w640 h480 f0 v50", "w100 h80 f0 v30", "w9 h9 v3", lines=two))
    found = read("a.pto", photo=jpeg("p.jpg", focal=8.0), image=1)
    assert [(photo.number, photo.size, photo.name) for photo in found.photos] == [
        (1, (100, 80), "p.jpg")
    ]
    assert [(facts.focal_mm, facts.hfov_deg) for facts in found.lenses] == [(8, 30)]
    assert found.notes == ()
    for image, sentence in {
        2: "photo number 2 has no straight lines",
        3: "there is no photo number 3; there are 3",
        -1: "there is no photo number -1",
    }.items():
        with pytest.raises(OptionError, match=rf"^a\.pto: {sentence}") as caught:
            read("a.pto", image=image)
        assert caught.value.hint


def test_exif_counts_before_the_project(folder: Path) -> None:
    head = "#-hugin cropFactor=%s\n"
    photo = 'w100 h80 f0 v50 n"p.jpg"'
    jpeg("p.jpg", focal=8.0, equivalent=38)  # 4.75, good to 1.3 %

    def crop(project: str) -> tuple[float | None, float | None, int]:
        found = read(put("a.pto", head % project + pto(photo)))
        (facts,) = found.lenses
        return facts.crop_factor, facts.crop_factor_error, len(found.notes)

    assert crop("4.843") == (4.75, 0.5 / 38, 1)  # contradicts: told
    assert crop("4.8") == (4.8, None, 0)  # agrees and is better known
    assert crop("4.75") == (4.75, 0.5 / 38, 0)  # as Hugin copies it
    note = read(put("a.pto", head % "4.843" + pto(photo))).notes[0]
    assert note.startswith("the crop factor is 4.75 by EXIF but 4.843 by the project")


def test_linked_photos_of_several_focal_lengths_are_told(folder: Path) -> None:
    jpeg("p.jpg", focal=8.0)
    jpeg("q.jpg", focal=12.0)
    linked = 'w100 h80 f0 v=0 a=0 b=0 c=0 n"q.jpg"'
    both = PTO_LINE + PTO_LINE.replace("n0 N0", "n1 N1")
    put("a.pto", pto('w100 h80 f0 v50 a0 b0 c0 n"p.jpg"', linked, lines=both))
    note, copies = read("a.pto").notes
    assert copies.startswith("line t3 of q.jpg repeats line t3 of p.jpg")
    assert "several focal lengths (p.jpg at 8 mm, q.jpg at 12 mm)" in note
    jpeg("q.jpg", focal=8.0)
    assert read("a.pto").notes == (copies,)


def test_the_field_of_view_is_that_of_the_photo_it_stands_with(folder: Path) -> None:
    linked = "w80 h100 f0 v=0 a=0 b=0 c=0"
    both = PTO_LINE + PTO_LINE.replace("n0 N0", "n1 N1").replace("90", "70")
    put("a.pto", pto("w100 h80 f0 v90 a0 b0 c0", linked, lines=both))
    portrait = read("a.pto", image=1)
    focal_px = portrait.lenses[0].focal_length_px(portrait.photos[0].frame)
    assert focal_px == pytest.approx(50, rel=1e-14)  # half of 100 px at 45 degrees


@pytest.mark.parametrize(
    ("size", "photo_size", "sentence"),
    [
        ((100, 81), None, "the file says 100x80, --size 100x81"),
        ((80, 100), None, "the file says 100x80, --size 80x100"),
        (None, (101, 80), "the file says 100x80, the photo 101x80"),
        (None, (80, 100), "the file says 100x80, the photo 80x100"),
    ],
)
def test_contradictory_sizes(
    folder: Path, size: tuple[int, int] | None, photo_size: tuple[int, int] | None, sentence: str
) -> None:
    put("a.pto", pto("w100 h80 f0 v50"))
    photo = None if photo_size is None else jpeg("p.jpg", photo_size)
    with pytest.raises(ReadError) as caught:
        read("a.pto", size=size, photo=photo)
    assert caught.value.message == f"a.pto: contradictory sizes: {sentence}"
    assert caught.value.hint


def test_size_and_photo_contradict(folder: Path) -> None:
    with pytest.raises(ReadError, match=r"^a\.csv: contradictory sizes: --size says 100x80"):
        read(put("a.csv"), size=(100, 80), photo=jpeg("p.jpg", (200, 160)))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "a.csv: the file is empty"),
        ("\n \r\n", "a.csv: the file is empty"),
        ("a\0b", "a.csv: the file is binary"),
        ("what, ever\nthis, is\n", "a.csv: the format of this file is not recognised"),
        (CSV + "left,100,10\n", "a.csv, row 8: the point (100, 10) of line left lies outside the"),
        (CSV + "left,10,-3\n", "a.csv, row 8: the point (10, -3) of line left lies outside"),
        (CSV + "left,nan,10\n", "a.csv, row 8: "),
        (CSV + "left,1,inf\n", "a.csv, row 8: "),
        (CSV + "left,ten,10\n", "a.csv, row 8: 'ten' stands where a coordinate belongs"),
        ("line,x,y\na,1,1\na,2,2\nb,3,3\n", "a.csv: no line with at least 3 distinct points"),
        ("line,x,y\na,1,1\na,2,2\na,1,1\na,2,2\n", "a.csv: no line with at least 3 distinct"),
    ],
)
def test_bad_input_names_file_and_line_and_a_remedy(folder: Path, text: str, sentence: str) -> None:
    with pytest.raises(PlumblineError) as caught:
        read(put("a.csv", text), size=(100, 80))
    assert caught.value.message.startswith(sentence)
    assert caught.value.hint


@pytest.mark.parametrize("size", [(0, 80), (-1, 5), (100, 0), (2_000_000, 80)])
def test_impossible_sizes(folder: Path, size: tuple[int, int]) -> None:
    with pytest.raises(OptionError, match=r"^a\.csv: the size \S+ is impossible") as caught:
        read(put("a.csv"), size=size)
    assert caught.value.hint


def test_an_unknown_size(folder: Path) -> None:
    with pytest.raises(ReadError, match=r"^a\.csv: the size of the photo is not known") as caught:
        read(put("a.csv"))
    assert "--photo" in caught.value.hint


@pytest.mark.parametrize("aspect", [0.0, -1.0, 1e-3, 1e3, float("nan")])
def test_impossible_pixels(folder: Path, aspect: float) -> None:
    with pytest.raises(OptionError, match="pixel aspect") as caught:
        read(put("a.csv"), size=(100, 80), pixel_aspect=aspect)
    assert caught.value.hint


def test_formats_by_name(folder: Path) -> None:
    assert read(put("a.dat"), size=(100, 80), format="csv").n_points == 6
    with pytest.raises(OptionError, match="there is no format 'pdf'") as caught:
        read("a.dat", format="pdf")
    assert "csv" in caught.value.hint
    with pytest.raises(ReadError, match=r"^a\.dat: there is no image in this project"):
        read("a.dat", format="pto")


def test_short_lines_and_duplicates_are_set_aside_with_a_note(folder: Path) -> None:
    found = read(put("a.csv", CSV + "left,10,10\nshort,1,1\nshort,2,2\n"), size=(100, 80))
    assert [line.label for line in found.lines] == ["left", "roof"]
    assert found.n_points == 6
    assert found.notes == (
        "1 point picked twice on one line counted once",
        "1 line set aside for having fewer than 3 distinct points: short (2 points)",
    )


# --- joining --------------------------------------------------------------------------------


def test_several_files_are_photos_of_one_lens(folder: Path) -> None:
    for i in range(3):
        put(f"{i}.csv", CSV.replace("left,1", f"left,{i}").replace("roof,5", f"roof,{i}"))
    parts = [read(f"{i}.csv", size=(100, 80)) for i in range(3)]
    whole = join(parts)
    assert len(whole.lenses) == 1
    assert [photo.lens for photo in whole.photos] == [0, 0, 0]
    assert [line.photo for line in whole.lines] == [0, 0, 1, 1, 2, 2]
    assert [origin.path for origin in whole.origins] == ["0.csv", "1.csv", "2.csv"]
    assert join(parts[:1]) is parts[0]


def test_facts_are_gathered_from_all_files(folder: Path) -> None:
    first = read(put("a.csv"), photo=jpeg("a.jpg", make="NIKON"))
    second = read(put("b.csv"), photo=jpeg("b.jpg", focal=8.0, equivalent=38))
    facts = join([first, second]).lenses[0]
    assert (facts.maker, facts.focal_mm, facts.crop_factor) == ("NIKON", 8, 4.75)


def test_files_of_different_focal_lengths_are_not_joined(folder: Path) -> None:
    first = read(put("a.csv"), photo=jpeg("a.jpg", focal=8.0))
    second = read(put("b.csv"), photo=jpeg("b.jpg", focal=9.0))
    with pytest.raises(OptionError, match=r"^b\.csv: the focal length is 9 mm") as caught:
        join([first, second])
    assert caught.value.hint


def test_files_of_different_lenses_are_not_joined(folder: Path) -> None:
    plain = "w100 h80 f0 v50 a0 b0 c0"
    read_first = read(put("a.pto", pto(plain + " d3")))
    for other, sentence in {
        "w100 h80 f3 v50 a0 b0 c0 d3": "the photo is marked as full-frame fisheye, those before",
        plain: "the lens has d = 0, in the files before it 3",
        plain + " d3 e-1": "the lens has e = −1, in the files before it 0",
        plain + " d3 g2": "the lens has g = 2",
        plain + " d3 t2": "the lens has t = 2",
        "w100 h80 f0 v20 a0 b0 c0 d3": "the focal length is 284 px by the field of view or EXIF, "
        "in the files before it 107 px",
    }.items():
        second = read(put("b.pto", pto(other)))
        with pytest.raises(OptionError) as caught:
            join([read_first, second])
        assert caught.value.message.startswith(f"b.pto: {sentence}")
        assert caught.value.hint
    fisheye = read(put("c.pto", pto("w100 h80 f3 v50")))
    with pytest.raises(OptionError, match=r"^a\.csv: the photo is marked as rectilinear"):
        join([fisheye, read(put("a.csv"), size=(100, 80))])


def test_what_files_of_one_lens_tell_is_united(folder: Path) -> None:
    bare = read(put("a.csv"), size=(100, 80))
    first = read(put("a.pto", pto("w100 h80 f0 a0.5 b0 c0 d3") + "v c0\n"))
    second = read(put("b.pto", pto("w100 h80 f0 v50 a0 b0 c0 d3 e0") + "v a0 d0\n"))
    for order in ([bare, first, second], [first, second, bare]):
        facts = join(order).lenses[0]
        assert facts.stored == {"a": 0.5, "b": 0, "c": 0, "d": 3}
        assert facts.requested == ("a", "c", "d")
        assert (facts.hfov_deg, facts.hfov_width_px) == (50, 100)
    line = [[10, 10], [12, 40], [13, 70]]
    arrays = plumbline.Observations.from_arrays([line], (100, 80), focal_px=107.0)
    assert join([bare, arrays]).lenses[0].focal_px == 107
    assert join([second, arrays]).lenses[0].focal_px == 107  # 50 degrees are 107.2 px
    far = plumbline.Observations.from_arrays([line], (100, 80), focal_px=120.0)
    with pytest.raises(OptionError, match="the focal length is 120 px"):
        join([second, far])


def test_a_file_of_several_lenses_is_not_joined(folder: Path) -> None:
    two = PTO_LINE + PTO_LINE.replace("n0 N0", "n1 N1")
    several = read(put("a.pto", pto("w100 h80 f0 v50", "w100 h80 f0 v30", lines=two)))
    with pytest.raises(OptionError, match=r"^a\.pto: the file holds 2 lenses") as caught:
        join([several, read(put("b.csv"), size=(100, 80))])
    assert caught.value.hint


def test_too_few_points_in_the_api(folder: Path) -> None:
    with pytest.raises(DegenerateLinesError):
        plumbline.read(put("a.csv", "line,x,y\na,1,1\n"), size=(100, 80))
