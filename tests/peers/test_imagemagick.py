"""ImageMagick's Barrel puts points where plumbline puts them, by itself and in our script."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from plumbline.formats.lens_files.imagemagick import barrel as script_of
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from tests.peers.tools import program, run

SIZE = (901, 600)
COEFFICIENTS = {"a": 0.032059, "b": -0.097803, "c": 0.041666, "d": 0.0, "e": 0.0}
SIGMA_PX = 2.5


def _dots(centres: Array) -> Array:
    """A picture of Gaussian dots, grey values 0 to 1."""
    width, height = SIZE
    y, x = np.mgrid[0:height, 0:width].astype(float)
    picture = np.zeros((height, width))
    for cx, cy in centres:
        picture += np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * SIGMA_PX**2))
    return picture


def _centroid(picture: Array, near: Array) -> Array:
    x0, y0 = np.round(near).astype(int)
    reach = 12
    y, x = np.mgrid[y0 - reach : y0 + reach + 1, x0 - reach : x0 + reach + 1]
    patch = picture[y0 - reach : y0 + reach + 1, x0 - reach : x0 + reach + 1]
    return np.array([(patch * x).sum(), (patch * y).sum()]) / patch.sum()


def _write_pgm(path: Path, picture: Array) -> None:
    width, height = SIZE
    values = np.round(picture * 60000).astype(">u2")
    path.write_bytes(f"P5 {width} {height} 65535\n".encode() + values.tobytes())


def _read_pgm(path: Path) -> Array:
    content = path.read_bytes()
    header, size, depth = content.split(b"\n", 3)[:3]
    assert (header, depth) == (b"P5", b"65535")
    width, height = (int(side) for side in size.split())
    return np.frombuffer(content[-2 * width * height :], ">u2").reshape(height, width) / 60000


def test_barrel_moves_dots_to_their_ideal_places(tmp_path: Path) -> None:
    convert = program("convert-im6.q16", "magick")
    lens = Lens(get_model("ptlens"), Frame(*SIZE), COEFFICIENTS)
    gx, gy = np.meshgrid(np.linspace(60, SIZE[0] - 61, 9), np.linspace(60, SIZE[1] - 61, 6))
    ideal = np.stack((gx.ravel(), gy.ravel()), axis=1)
    observed = lens.distort(ideal)
    assert np.max(np.hypot(*(observed - ideal).T)) > 8
    _write_pgm(tmp_path / "observed.pgm", _dots(observed))
    barrel = " ".join(str(COEFFICIENTS[name]) for name in "abc")
    how = ["-filter", "point", "-interpolate", "catrom", "-virtual-pixel", "black"]
    target = ["-depth", "16", str(tmp_path / "corrected.pgm")]
    run([convert, str(tmp_path / "observed.pgm"), *how, "-distort", "Barrel", barrel, *target])
    corrected = _read_pgm(tmp_path / "corrected.pgm")
    found = np.array([_centroid(corrected, point) for point in ideal])
    assert np.max(np.hypot(*(found - ideal).T)) < 0.05


def test_the_script_fits_smaller_photos_and_refuses_others(tmp_path: Path) -> None:
    """A centre in shares of the sides: a lens for twice the size, run on this one."""
    program("convert-im6.q16", "magick")
    centre = {"d": 40.0, "e": -24.0}
    whole = Frame(2 * SIZE[0], 2 * SIZE[1])
    abc = COEFFICIENTS["a"], COEFFICIENTS["b"], COEFFICIENTS["c"]
    (tmp_path / "fix.sh").write_bytes(script_of(abc, whole, (40.0, -24.0), "a lens"))
    halved = {name: value / 2 for name, value in centre.items()}
    lens = Lens(get_model("ptlens"), Frame(*SIZE), COEFFICIENTS | halved)
    gx, gy = np.meshgrid(np.linspace(80, SIZE[0] - 81, 5), np.linspace(80, SIZE[1] - 81, 4))
    ideal = np.stack((gx.ravel(), gy.ravel()), axis=1)
    _write_pgm(tmp_path / "observed.pgm", _dots(lens.distort(ideal)))
    run(["sh", str(tmp_path / "fix.sh"), str(tmp_path / "observed.pgm"), str(tmp_path / "b.pgm")])
    corrected = _read_pgm(tmp_path / "b.pgm")
    # The script's centre lies on both sides: the picture moves by it.
    moved = ideal + np.array([halved["d"], halved["e"]])
    found = np.array([_centroid(corrected, each) for each in moved])
    assert np.max(np.hypot(*(found - moved).T)) < 0.1
    _, rows = SIZE
    (tmp_path / "tall.pgm").write_bytes(b"P5 %d 900 255\n" % rows + bytes(rows * 900))
    done = subprocess.run(
        ["sh", str(tmp_path / "fix.sh"), str(tmp_path / "tall.pgm"), str(tmp_path / "c.pgm")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "not a whole photo that lies as 1802x1200 does" in done.stderr
    assert not (tmp_path / "c.pgm").exists()
