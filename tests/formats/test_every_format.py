"""Every format of the table × lines, picked points and groups: the same lines come back."""

from __future__ import annotations

import io
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import plumbline
from plumbline.formats.archives import opened
from plumbline.formats.base import ReadOptions, Source
from plumbline.formats.known import FORMATS, POINT_FORMATS, format_of, written
from tests.formats.writers import SIZE, WRITERS, Kind, Lines

WHOLE = {"cell-counter"}
"""Formats that store whole pixels."""
SINGLE = {"imagej"}
"""Formats that store single precision."""
EXPORTED = {"lensfun", "lenses-txt", "pto", "hugin-ini", "ptlens", "imagemagick", "opencv"}


def test_every_row_has_a_writer_here_and_what_is_written_is_derived() -> None:
    from plumbline.writing.results import POINT_SUFFIXES, RESULT_SUFFIXES
    from plumbline.writing.targets import TARGETS

    assert set(WRITERS) == set(POINT_FORMATS)
    assert set(written("lens")) == set(TARGETS) == EXPORTED
    assert set(RESULT_SUFFIXES) == {".json", ".pto", ".xml"}
    assert set(POINT_SUFFIXES) == {".json", ".pto", ".csv"}
    assert all(row.reads == bool(row.module) for row in FORMATS.values())


@st.composite
def drawn(draw: st.DrawFn) -> Lines:
    """Two to five lines that cross the photo, each of three to eight points of three decimals."""
    lines: dict[str, list[tuple[float, float]]] = {}
    for number in range(draw(st.integers(2, 5))):
        n = draw(st.integers(3, 8))
        level = draw(st.integers(40, 540)) + number * 0.5
        bend = draw(st.integers(-30, 30))
        along = np.linspace(30, 560, n)
        across = level + bend * ((along - 300) / 300) ** 2
        x, y = (along, across) if draw(st.booleans()) else (across, along)
        lines[f"line {'abcde'[number]}"] = list(
            zip(x.round(3).tolist(), y.round(3).tolist(), strict=True)
        )
    return lines


@pytest.mark.parametrize("kind", ["lines", "picks", "groups"])
@pytest.mark.parametrize("name", POINT_FORMATS)
@settings(max_examples=15, deadline=None)
@given(lines=drawn())
def test_what_is_drawn_is_read(name: str, kind: Kind, lines: Lines) -> None:
    if name in WHOLE:
        lines = {k: [(round(x), round(y)) for x, y in points] for k, points in lines.items()}
    content = WRITERS[name](lines, kind)
    if content is None:
        return
    source = Source(f"points{FORMATS[name].suffixes[0]}", content)
    assert format_of(source).name == name
    found = FORMATS[name].read(source, ReadOptions(SIZE))
    assert len(found.photos) == 1
    assert found.photos[0].size in (None, SIZE)
    exact = 1e-4 if name in SINGLE else 1e-9
    places = [np.sort(line.points_px, axis=0) for line in found.lines]
    for points, place in zip(lines.values(), places, strict=True):
        assert np.allclose(place, np.sort(np.array(points), axis=0), rtol=0, atol=exact)
    named = {line.label for line in found.lines} == set(lines)
    assert named or kind == "groups" or name in {"pto", "ptgui", "napari", "winmorph", "csv"}


@pytest.mark.parametrize("kind", ["lines", "picks", "groups"])
@pytest.mark.parametrize("name", POINT_FORMATS)
def test_every_format_is_there_in_some_kind(name: str, kind: Kind) -> None:
    lines = {"a": [(10.0, 20.0), (50.0, 22.0), (90.0, 21.0)]}
    assert any(WRITERS[name](lines, each) for each in ("lines", "picks", "groups"))
    assert kind


LINES: Lines = {
    "roof": [(10.0, 40.0), (200.0, 28.0), (400.0, 24.0), (790.0, 41.0)],
    "kerb": [(10.0, 560.0), (200.0, 572.0), (400.0, 576.0), (790.0, 559.0)],
}


def picture(size: tuple[int, int] = SIZE) -> bytes:
    from PIL import Image

    out = io.BytesIO()
    Image.new("L", size).save(out, "PNG")
    return out.getvalue()


def zipped(members: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


def tarred(members: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as archive:
        for name, content in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return out.getvalue()


@pytest.mark.parametrize("name", [n for n in POINT_FORMATS if n not in {"imagej", "xlsx"}])
@pytest.mark.parametrize("pack", [zipped, tarred])
def test_every_format_in_an_archive(name: str, pack: object, tmp_path: Path) -> None:
    every = (WRITERS[name](LINES, kind) for kind in ("lines", "picks", "groups"))
    content = next(filter(None, every))
    packed = (zipped if pack is zipped else tarred)(
        {
            f"x/points{FORMATS[name].suffixes[0]}": content,
            "x/images/wall.jpg": picture(),
            "__MACOSX/x/._points.csv": b"line,x,y\na,1,2\n",
            "x/readme.md": b"Hello, World\n",
        }
    )
    path = tmp_path / "download.zip"
    path.write_bytes(packed)
    found = plumbline.read(path, size=SIZE if name in {"winmorph", "svg"} else None)
    assert [len(line.points_px) for line in found.lines] == [4, 4]
    assert found.photos[0].size == SIZE
    (origin,) = found.origins
    assert origin.content == packed


def test_archives_that_hold_none_or_several() -> None:
    points = WRITERS["labelme"](LINES, "lines")
    assert points is not None
    for content, message in (
        (zipped({"a.md": b"# Hello"}), "holds no file of points (a.md)"),
        (zipped({"images/": b""}), "holds no file of points"),
        (zipped({"a.png": picture()}), "holds no file of points"),
        (zipped({"a.json": points, "b.json": points}), "holds 2 files of points (a.json, b.json)"),
        (zipped({"a.json": points})[:-30], "broken"),
    ):
        with pytest.raises(plumbline.ReadError) as caught:
            opened(Source("x.zip", content))
        assert message in caught.value.message
        assert caught.value.hint


@pytest.mark.parametrize(
    ("content", "message", "hint"),
    [
        (b"\xff\xd8\xff\xe0\0\x10JFIF", "this is a photo (JPEG), not a file of points", "--photo"),
        (b"\x89PNG\r\n\x1a\n", "a picture (PNG)", "--photo"),
        (b"II*\0\x08\0\0\0", "a picture (TIFF)", "To ROI Manager"),
        (b"MM\0*\0\0\0\x08", "a picture (TIFF)", "--photo"),
        (b"RIFF\x10\0\0\0WEBPVP8 ", "a picture (WebP)", "--photo"),
        (b"\0\0\0\x18ftypheic", "HEIC", "--photo"),
        (b"%PDF-1.7", "a PDF", "line,x,y"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an old Excel workbook", "CSV"),
        (b"\x1f\x8b\x08", "gzip", "unpack"),
    ],
)
@pytest.mark.parametrize("given_format", [None, "csv"])
def test_what_holds_no_points_says_what_it_is(
    content: bytes, message: str, hint: str, given_format: str | None, tmp_path: Path
) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(content)
    with pytest.raises(plumbline.ReadError) as caught:
        plumbline.read(path, size=SIZE, format=given_format)
    assert message in caught.value.message
    assert hint in caught.value.hint
