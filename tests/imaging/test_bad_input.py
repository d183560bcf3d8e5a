"""Pictures that are damaged, absurd or in the way: one sentence, nothing written."""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

import plumbline
from plumbline.errors import PlumblineError, ReadError, WriteError
from plumbline.lenses.request import LensRequest
from tests.imaging.painted import texture

SIZE = (320, 240)
BARREL = LensRequest(ptlens={"a": 0.0, "b": -0.05, "c": 0.0})


def _save(path: Path, **how: Any) -> bytes:
    Image.fromarray(texture(SIZE)).save(path, **how)
    return path.read_bytes()


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_files_cut_short_anywhere_are_refused(tmp_path: Path, suffix: str) -> None:
    how = {"compression": "tiff_lzw"} if suffix == ".tif" else {}
    whole = _save(tmp_path / f"a{suffix}", **how)
    for length in (*range(0, len(whole), max(len(whole) // 25, 1)), len(whole) - 30):
        cut = tmp_path / f"cut{suffix}"
        cut.write_bytes(whole[:length])
        with pytest.raises(ReadError) as caught:
            plumbline.correct(cut, BARREL)
        assert caught.value.hint
        assert "\n" not in caught.value.message
        assert cut.read_bytes() == whole[:length]
        assert sorted(p.name for p in tmp_path.iterdir()) == [f"a{suffix}", f"cut{suffix}"]


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_noise_in_a_file_never_ends_in_a_traceback(tmp_path: Path, suffix: str) -> None:
    whole = bytearray(_save(tmp_path / f"a{suffix}"))
    rng = np.random.default_rng(1)
    for _ in range(40):
        noisy = bytearray(whole)
        for place in rng.integers(0, min(len(whole), 3000), 12):
            noisy[place] = rng.integers(256)
        (tmp_path / f"b{suffix}").write_bytes(noisy)
        with contextlib.suppress(PlumblineError):
            plumbline.correct(tmp_path / f"b{suffix}", BARREL)


def test_a_decompression_bomb_is_refused_before_it_goes_off(tmp_path: Path) -> None:
    def chunk(name: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        )

    header = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    data = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + data)
    with pytest.raises(ReadError, match="more pixels than any camera"):
        plumbline.correct(tmp_path / "a.png", BARREL)


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_one_pixel_is_a_picture(tmp_path: Path, suffix: str) -> None:
    Image.new("RGB", (1, 1), (90, 90, 90)).save(tmp_path / f"a{suffix}")
    with Image.open(plumbline.correct(tmp_path / f"a{suffix}", BARREL).output) as made:
        assert made.size == (1, 1)
        assert abs(np.asarray(made.convert("L"))[0, 0] - 90) <= 1


def test_what_is_no_picture_or_not_there(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_text("not a picture")
    for name in ("a.jpg", "missing.jpg", "."):
        with pytest.raises(PlumblineError):
            plumbline.correct(tmp_path / name, BARREL, tmp_path / "b.jpg")
    assert not (tmp_path / "b.jpg").exists()


def test_the_original_is_never_overwritten(tmp_path: Path) -> None:
    whole = _save(tmp_path / "a.jpg")
    os.link(tmp_path / "a.jpg", tmp_path / "same.jpg")
    (tmp_path / "link.jpg").symlink_to("a.jpg")
    for target in ("a.jpg", "same.jpg", "link.jpg"):
        with pytest.raises(WriteError, match="original"):
            plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / target, overwrite=True)
    assert (tmp_path / "a.jpg").read_bytes() == whole


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_only_plumbline_s_own_results_are_replaced(tmp_path: Path, suffix: str) -> None:
    _save(tmp_path / f"a{suffix}")
    other = _save(tmp_path / f"a_corrected{suffix}")
    with pytest.raises(WriteError, match="not written by plumbline"):
        plumbline.correct(tmp_path / f"a{suffix}", BARREL)
    assert (tmp_path / f"a_corrected{suffix}").read_bytes() == other
    plumbline.correct(tmp_path / f"a{suffix}", BARREL, overwrite=True)
    plumbline.correct(tmp_path / f"a{suffix}", BARREL)


def test_targets_that_cannot_be_written(tmp_path: Path) -> None:
    _save(tmp_path / "a.jpg")
    (tmp_path / "folder.jpg").mkdir()
    for target in ("missing/b.jpg", "folder.jpg", "a.jpg/b.jpg", "b" * 300 + ".jpg"):
        with pytest.raises(WriteError) as caught:
            plumbline.correct(tmp_path / "a.jpg", BARREL, tmp_path / target)
        assert caught.value.hint


def test_a_folder_without_permission(tmp_path: Path) -> None:
    _save(tmp_path / "a.jpg")
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o555)
    if os.access(closed, os.W_OK):
        pytest.skip("this user may write everywhere, so that no folder is closed")
    with pytest.raises(WriteError, match="cannot be written"):
        plumbline.correct(tmp_path / "a.jpg", BARREL, closed / "b.jpg")


@pytest.mark.parametrize("shape", [SIZE[::-1], (*SIZE[::-1], 3)])
def test_pictures_of_floats_are_named(tmp_path: Path, shape: tuple[int, ...]) -> None:
    cv2.imwrite(str(tmp_path / "a.tif"), np.full(shape, 0.5, dtype=np.float32))
    with pytest.raises(ReadError, match="32-bit float pictures are not supported"):
        plumbline.correct(tmp_path / "a.tif", BARREL)
