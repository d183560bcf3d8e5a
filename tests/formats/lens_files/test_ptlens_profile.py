"""PTLens profiles and their index."""

from __future__ import annotations

from pathlib import Path

import pytest

from plumbline.errors import ReadError
from plumbline.files import read_bytes
from plumbline.formats.base import Source
from plumbline.formats.lens_files.ptlens_profile import (
    PTLensCamera,
    PTLensLens,
    ptlens_profile,
    read_ptlens,
    recognises,
)

CANON = """# a comment
begin camera
menu_make: Canon  # and another
menu_model: EOS 10D
exif_make: Canon
exif_model: Canon EOS 10D
group: canon slr
group: m42
multiplier: 1.6
end

begin lens
menu_lens: EF 17-40mm f/4
group: canon slr
multiplier: 1.0
cal_abc: 40 0 0.001 0
cal_abc: 17 0.0067 -0.0201 0.0
cal_vig: 17 4 0 0 0
cal_tca: 17 1 1
end
"""


def test_an_index_gathers_its_files(tmp_path: Path) -> None:
    (tmp_path / "canon.txt").write_text(CANON)
    index = tmp_path / "profile.txt"
    index.write_bytes(b"version: 4.2\r\nfile: canon.txt\r\n")
    source = Source(str(index), read_bytes(index))
    assert recognises(source)
    found = read_ptlens(source)
    (camera,) = found.cameras
    assert camera == PTLensCamera(
        "Canon", "EOS 10D", "Canon", "Canon EOS 10D", frozenset({"canon slr", "m42"}), 1.6
    )
    (lens,) = found.lenses
    assert lens.calibrations == ((17.0, (0.0067, -0.0201, 0.0)), (40.0, (0.0, 0.001, 0.0)))


def test_what_is_written_is_read_again() -> None:
    camera = PTLensCamera("Maker", "Body", "MAKER", "BODY", frozenset({"g"}), 1.5)
    lens = PTLensLens("Zoom", frozenset({"g"}), 1.5, ((18.0, (0.01, -0.02, 0.003)),))
    found = read_ptlens(Source("p.txt", ptlens_profile(camera, lens, "made by plumbline")))
    assert found.cameras == (camera,)
    assert found.lenses == (lens,)


@pytest.mark.parametrize(
    ("text", "line", "sentence"),
    [
        ("begin lens\nmultiplier: x\nend\n", 2, "'x' stands where the value of multiplier"),
        ("begin lens\nmultiplier: 0\nend\n", 2, "not above zero"),
        ("begin lens\nmenu_lens: a\nend\n", 1, "has no multiplier"),
        (
            "begin lens\nmultiplier: 1\ncal_abc: 1 2\nend\n",
            3,
            "not hold a focal length, a, b and c",
        ),
        ("begin lens\nmultiplier: 1\ncal_abc: 1 nan 0 0\nend\n", 3, "not a finite number"),
        ("begin lens\nbegin camera\n", 2, "before the last one ended"),
        ("begin lens\nmultiplier: 1\n", None, "cut off"),
        ("begin lens\nwhat\nend\n", 2, "not 'key: value'"),
        ("begin camera\nmultiplier: 1\nend\n", None, "no lens in this profile"),
        ("version: 4.2\nfile: ../secret.txt\n", 2, "not a plain file name"),
        ("version: 4.2\nfile: missing.txt\n", None, "no such file"),
    ],
)
def test_damage_is_told_with_its_line(text: str, line: int | None, sentence: str) -> None:
    with pytest.raises(ReadError) as error:
        read_ptlens(Source("profile.txt", text.encode()))
    assert sentence in error.value.message
    assert error.value.line == line
    assert error.value.hint
