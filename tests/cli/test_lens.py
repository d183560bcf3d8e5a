"""`plumbline lens`, run as a user runs it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.process import plumbline
from tests.lenses.made import calibration, saved
from tests.lenses.photos import photo


@pytest.fixture
def coolpix(tmp_path: Path) -> Path:
    return photo(tmp_path / "a.jpg", (2048, 1536), make="NIKON", model="E995", focal=8.2)


def test_what_would_be_used_and_the_candidates(coolpix: Path, tmp_path: Path) -> None:
    done = plumbline("lens", coolpix, home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "2048x1536, NIKON E995, 8.2 mm" in done.stdout
    assert "Used: Nikon E995 & compatibles (Standard) on Nikon E995 at 8.2 mm" in done.stdout
    assert "Matching lenses:" in done.stdout
    assert "with WC-E63 (8.2–16.9 mm)" in done.stdout
    assert "Lensfun" not in done.stderr


def test_add_and_find(coolpix: Path, tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.123))
    done = plumbline("lens", "add", result, home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Wrote" in done.stdout
    assert "b = −0.123" in plumbline("lens", coolpix, home=tmp_path).stdout
    again = plumbline("lens", "add", result, home=tmp_path)
    assert again.returncode == 1
    assert "--overwrite" in again.stderr
    assert plumbline("lens", "add", result, "--overwrite", home=tmp_path).returncode == 0


def test_add_wants_a_result(tmp_path: Path) -> None:
    done = plumbline("lens", "add", home=tmp_path)
    assert done.returncode == 2
    assert "name a result to add" in done.stderr


def test_options_that_say_nothing_are_refused(coolpix: Path, tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.123))
    done = plumbline("lens", "add", result, "--focal", "9", home=tmp_path)
    assert done.returncode == 2
    assert "lens add does not use --focal; leave it out" in done.stderr
    assert not (tmp_path / "data").exists()
    done = plumbline("lens", coolpix, "--overwrite", home=tmp_path)
    assert done.returncode == 2
    assert "lens PHOTO does not use --overwrite" in done.stderr


def test_questions_are_sentences(tmp_path: Path) -> None:
    done = plumbline("lens", photo(tmp_path / "b.jpg"), home=tmp_path)
    assert done.returncode == 1
    assert "Error: the photo has no EXIF that names its camera." in done.stderr
    assert "--camera" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_photo_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "x.jpg").write_bytes(b"\xff\xd8")
    done = plumbline("lens", tmp_path / "x.jpg", home=tmp_path)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr


def test_coefficients_need_names(coolpix: Path, tmp_path: Path) -> None:
    done = plumbline("lens", coolpix, "--ptlens", "0,1,2", home=tmp_path)
    assert done.returncode == 2
    done = plumbline("lens", coolpix, "--ptlens", "file", home=tmp_path)
    assert done.returncode == 2


def test_neither_jax_nor_matplotlib_is_loaded(coolpix: Path) -> None:
    program = (
        "import sys\n"
        "from plumbline.photos.exif import read_photo\n"
        "from plumbline.lenses.lookup import find_correction\n"
        "from plumbline.lenses.request import LensRequest\n"
        f"find_correction(read_photo({str(coolpix)!r}), LensRequest())\n"
        "print({'jax', 'matplotlib', 'scipy'} & {n.split('.')[0] for n in sys.modules})"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"


def test_what_is_kept_is_listed_and_removed(tmp_path: Path) -> None:
    assert "You have no calibrations" in plumbline("lens", "list", home=tmp_path).stdout
    result = saved(tmp_path / "r.json", calibration(b=-0.123))
    plumbline("lens", "add", result, home=tmp_path)
    listed = plumbline("lens", "list", home=tmp_path).stdout
    assert "NIKON E995, no lens named, 8.2 mm" in listed
    name = listed.splitlines()[0]
    wrong = plumbline("lens", "remove", "another", home=tmp_path)
    assert wrong.returncode == 1
    assert f"there are: {name}" in wrong.stderr
    assert (
        "Removed" in plumbline("lens", "remove", name.removesuffix(".json"), home=tmp_path).stdout
    )
    assert "You have no calibrations" in plumbline("lens", "list", home=tmp_path).stdout
    assert plumbline("lens", "list", "more", home=tmp_path).returncode == 2
    assert plumbline("lens", "remove", home=tmp_path).returncode == 2


def test_a_photo_that_fails_stops_nothing(coolpix: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.jpg").write_text("hello")
    unknown = photo(tmp_path / "u.jpg", make="NIKON", model="E996", focal=8.2)
    done = plumbline("lens", tmp_path / "bad.jpg", unknown, coolpix, home=tmp_path)
    assert done.returncode == 1
    assert "bad.jpg: this is not a picture that can be read" in done.stderr
    assert f"{unknown}: the camera NIKON E996 is not in" in done.stderr
    assert done.stdout.count("Used: ") == 1


def test_a_folder_stands_for_its_photos_and_others_are_counted(tmp_path: Path) -> None:
    folder = tmp_path / "photos"
    folder.mkdir()
    for name in ("a.jpg", "b.jpg"):
        photo(folder / name, (2048, 1536), make="NIKON", model="E995", focal=8.2)
    for name in ("a.nef", "b.nef", "notes.txt", ".hidden"):
        (folder / name).write_text("x")
    done = plumbline("lens", folder, home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("Used: ") == 2
    assert "Passed over 3 other files: 2 .nef, 1 .txt." in done.stdout


def test_an_own_calibration_is_told_where_the_photo_names_no_lens(
    coolpix: Path, tmp_path: Path
) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.123))
    plumbline("lens", "add", result, home=tmp_path)
    told = "the photo does not name its lens: your own calibration of this camera was taken"
    assert told in plumbline("lens", coolpix, home=tmp_path).stdout
    named = photo(
        tmp_path / "n.jpg", (2048, 1536), make="NIKON", model="E995", focal=8.2, lens="8.2-31mm"
    )
    assert told not in plumbline("lens", named, home=tmp_path).stdout
