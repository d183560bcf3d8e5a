"""`plumbline export`, run as a user runs it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.process import plumbline
from tests.lenses.made import calibration, saved


def test_beside_the_result(tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.02))
    done = plumbline("export", result, "--to", "lensfun", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "r.lensfun.xml").read_bytes().startswith(b"<?xml")


def test_a_refit_prints_its_deviation_and_may_need_force(tmp_path: Path) -> None:
    mild = saved(tmp_path / "m.json", calibration("division", l1=-0.02))
    done = plumbline("export", mild, "--to", "pto", home=tmp_path)
    assert "Refitted to ptlens: at most 0.0" in done.stdout
    strong = saved(tmp_path / "s.json", calibration("division", l1=-0.15))
    done = plumbline("export", strong, "--to", "pto", home=tmp_path)
    assert done.returncode == 1
    assert "--force" in done.stderr
    assert not (tmp_path / "s.pto.pto").exists()
    done = plumbline("export", strong, "--to", "pto", "--force", home=tmp_path)
    assert done.returncode == 0
    assert "Refitted to ptlens: at most" in done.stdout


def test_an_st_map(tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(size=(256, 192), b=-0.02))
    done = plumbline("export", result, "--to", "stmap", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "r.stmap.tif").read_bytes()[:2] in (b"II", b"MM")


def test_an_st_map_tells_of_a_fold(tmp_path: Path) -> None:
    """r (1.4 - 0.4 r^2) is largest at r = sqrt(1.4 / 1.2), of half the shorter side."""
    result = saved(tmp_path / "r.json", calibration(size=(256, 192), b=-0.4))
    done = plumbline("export", result, "--to", "stmap", home=tmp_path)
    fold_px = (1.4 / 1.2) ** 0.5 * 96
    assert f"the lens values fold {fold_px - 0.5:.0f} px from the centre" in done.stdout


@pytest.mark.parametrize(
    ("target", "useless"),
    [
        *(("json", each) for each in ("--mount F", "--focal 9", "--force", "--image 0")),
        *(("stmap", each) for each in ("--maker M", "--crop-factor 2", "--force")),
        *(("imagemagick", each) for each in ("--lens-name L", "--focal-px 900")),
        *(("pto", "--mount F"), ("hugin-ini", "--aspect-ratio 3:2"), ("ptlens", "--maker M")),
    ],
)
def test_options_that_say_nothing_are_refused(tmp_path: Path, target: str, useless: str) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.02))
    done = plumbline("export", result, "--to", target, *useless.split(), home=tmp_path)
    assert done.returncode == 2
    assert f"--to {target} does not use {useless.split(maxsplit=1)[0]}; leave it out" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["r.json"]


@pytest.mark.parametrize(
    "target", ["lensfun", "lenses-txt", "pto", "hugin-ini", "ptlens", "opencv"]
)
def test_options_that_are_taken_show_in_the_file(tmp_path: Path, target: str) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.02))
    files: list[bytes] = []
    for crop in ("4.8", "4.9"):
        out = tmp_path / f"{crop}.txt"
        done = plumbline(
            "export", result, "--to", target, "--crop-factor", crop, "--focal", "9",
            "-o", out, home=tmp_path,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        files.append(out.read_bytes())
    assert files[0] != files[1]


def test_one_of_several(tmp_path: Path) -> None:
    path = tmp_path / "r.json"
    saved(path, *(calibration(b=-0.02, focal_mm=f) for f in (8.0, 9.0)))
    done = plumbline("export", path, "--to", "imagemagick", home=tmp_path)
    assert done.returncode == 1
    assert "--image" in done.stderr
    done = plumbline("export", path, "--to", "imagemagick", "--image", "1", home=tmp_path)
    assert done.returncode == 0


def test_the_original_is_never_written_over(tmp_path: Path) -> None:
    result = saved(tmp_path / "r.json", calibration(b=-0.02))
    before = Path(result).read_bytes()
    done = plumbline("export", result, "--to", "json", "-o", result, "--overwrite", home=tmp_path)
    assert done.returncode == 1
    assert Path(result).read_bytes() == before


def test_a_file_of_another_kind_is_told_what_goes(tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text("menu_lens: Standard")
    done = plumbline("export", tmp_path / "x.txt", "--to", "lensfun", home=tmp_path)
    assert done.returncode == 1
    kinds = "a result JSON, a Hugin or PTGui project, or a Hugin lens .ini"
    assert f"  name {kinds}." in done.stderr
