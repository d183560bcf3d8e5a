"""Whether the camera corrected the photo itself, in maker notes built by hand."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plumbline.lenses.lookup import find_correction
from plumbline.lenses.request import LensRequest
from plumbline.photos.exif import read_photo
from plumbline.photos.maker_notes import corrected_in_camera
from tests.lenses.photos import real
from tests.peers.tools import program, run


def nikon(setting: int, order: str = "<") -> bytes:
    """Maker notes with DistortInfo alone: version 0100 and the setting."""
    mark = b"II*\0" if order == "<" else b"MM\0*"
    head = mark + struct.pack(f"{order}I", 8)
    entry = struct.pack(f"{order}HHII", 0x2B, 7, 16, 26)
    info = b"0100" + bytes([setting]) + bytes(11)
    return b"Nikon\0\x02\x10\0\0" + head + struct.pack(f"{order}H", 1) + entry + bytes(4) + info


def sony(setting: int, order: str = "<") -> bytes:
    entry = struct.pack(f"{order}HHII", 0x2013, 4, 1, setting)
    return b"SONY DSC \0\0\0" + struct.pack(f"{order}H", 1) + entry + bytes(4)


@pytest.mark.parametrize("order", "<>")
def test_on_and_off(order: str) -> None:
    assert "Nikon" in corrected_in_camera(nikon(1, order))
    assert corrected_in_camera(nikon(0, order)) == ""
    assert "Sony" in corrected_in_camera(sony(2, order))
    assert corrected_in_camera(sony(0, order)) == ""


def test_exiftool_reads_the_same_and_the_photo_is_warned_of(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "NIKON", "E995"
    inner = exif.get_ifd(0x8769)
    inner[0x927C], inner[0x920A] = nikon(1), 8.2
    path = tmp_path / "a.jpg"
    Image.new("L", (400, 300)).save(path, exif=exif)
    assert "On" in run([program("exiftool"), "-AutoDistortionControl", str(path)])
    notes = find_correction(read_photo(path), LensRequest()).notes
    assert any("the camera corrected the distortion itself" in note for note in notes)


@pytest.mark.parametrize("name", ["nikon_e995_8.2mm.jpg", "nikon_e5700_8.9mm_portrait.jpg"])
def test_old_cameras_tell_nothing(name: str) -> None:
    assert read_photo(real(name)).in_camera == ""


def test_any_bytes_are_survived() -> None:
    random = np.random.default_rng(1)
    for whole in (nikon(1), sony(2)):
        for end in range(len(whole)):
            corrected_in_camera(whole[:end])
        for _ in range(300):
            broken = bytearray(whole)
            for place in random.integers(0, len(whole), 6):
                broken[place] = random.integers(0, 256)
            corrected_in_camera(bytes(broken))
