"""The sample projects against the truth they were rendered from, without any of plumbline."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

from . import make_samples, photo, picks
from .make_samples import CSV, EXPOSURES, GRID, TARGET, ZOOM, Exposure
from .optics import Array, View
from .scene import Edge

ALL = [(folder, each) for folder, found in EXPOSURES.items() for each in found]
NAMES = [f"{folder}/{each.name}" for folder, each in ALL]
every_photo = pytest.mark.parametrize(("folder", "exposure"), ALL, ids=NAMES)
FOUR_SIGMA_PX = 4 * picks.NOISE_PX


def pto_lines(path: Path) -> dict[tuple[int, int], Array]:
    """Read the union of both ends of every pair, by image and line."""
    found: dict[tuple[int, int], set[tuple[float, float]]] = {}
    pattern = r"^c n(\d+) N(\d+) x(\S+) y(\S+) X(\S+) Y(\S+) t(\d+)$"
    for row in re.findall(pattern, path.read_text(encoding="utf-8"), re.MULTILINE):
        image, other, x, y, x2, y2, kind = row
        assert image == other
        assert (x, y) != (x2, y2)
        line = found.setdefault((int(image), int(kind)), set())
        line |= {(float(x), float(y)), (float(x2), float(y2))}
    return {key: np.array(sorted(line)) for key, line in found.items()}


def committed(folder: str, exposure: Exposure) -> tuple[list[Array], float]:
    """Return the lines in the committed file of a photograph, and its rounding in pixels."""
    if folder == "facade_csv":
        table = np.loadtxt(TARGET / folder / "picks.csv", delimiter=",", skiprows=1)
        return [table[table[:, 0] == number, 1:] for number in np.unique(table[:, 0])], 0.05
    if folder == "grid_winmorph":
        text = (TARGET / folder / "grid.mrf").read_text(encoding="utf-8")
        rows = re.findall(r"^\s+(0\.\d{6}) (0\.\d{6})$", text, re.MULTILINE)
        size = np.array([exposure.view.width, exposure.view.height])
        points = (np.array(rows, float) * size - 0.5).reshape(7, 9, 2)
        return [*points, *points.swapaxes(0, 1)], 0.5e-6 * float(size.max())
    lines = pto_lines(next((TARGET / folder).glob("*.pto")))
    number = EXPOSURES[folder].index(exposure)
    return [line for (image, _), line in lines.items() if image == number], 0.5e-6


def curves(exposure: Exposure) -> Iterator[tuple[Edge, Array]]:
    """Follow every edge of the façade through the lens, hidden stretches included."""
    view, facade = exposure.view, exposure.facade
    reach = max(facade.width, facade.height)
    along = np.arange(0.0, reach, 0.05)
    for edge in facade.edges():
        seen = view.project(edge.points(along))
        seen = seen[picks.inside(view, seen, margin=-60.0)]
        if len(seen) > 2:
            yield edge, seen


def distance(points: Array, curve: Array) -> Array:
    """Return the distance of each point from a finely sampled curve."""
    gaps = points[:, None] - curve[None]
    nearest = np.clip((gaps**2).sum(-1).argmin(1), 1, len(curve) - 2)
    chord = curve[nearest + 1] - curve[nearest - 1]
    offset = points - curve[nearest]
    cross = offset[:, 0] * chord[:, 1] - offset[:, 1] * chord[:, 0]
    return np.abs(cross) / np.linalg.norm(chord, axis=1)


def frame_points(view: View) -> Array:
    x, y = np.linspace(0, view.width - 1, 61), np.linspace(0, view.height - 1, 41)
    return np.stack(np.meshgrid(x, y), axis=-1)


@every_photo
def test_inverse_and_forward_agree(folder: str, exposure: Exposure) -> None:
    observed = frame_points(exposure.view)
    back = exposure.view.distort(exposure.view.undistort(observed))
    assert np.abs(back - observed).max() < 1e-5


@every_photo
def test_inverse_agrees_with_bisection(folder: str, exposure: Exposure) -> None:
    view = exposure.view
    q = frame_points(view).reshape(-1, 2) - view.centre
    observed = np.linalg.norm(q, axis=1) / view.radius
    low, high = np.zeros_like(observed), observed * 1.6
    for _ in range(60):
        middle = (low + high) / 2
        short = middle * view.lens.stretch(middle) < observed
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    ideal = np.linalg.norm(view.undistort(q + view.centre) - view.centre, axis=1) / view.radius
    assert np.abs(ideal - low).max() * view.radius < 1e-3


@every_photo
def test_ideal_edges_are_straight_and_observed_ones_are_bent(
    folder: str, exposure: Exposure
) -> None:
    view = exposure.view
    bends = []
    for _, curve in curves(exposure):
        sags = []
        for points in (view.undistort(curve), curve):
            centred = points - points.mean(0)
            sags.append(np.abs(centred @ np.linalg.svd(centred, full_matrices=False)[2][1]).max())
        assert sags[0] < 1e-3
        bends.append(sags[1])
    assert max(bends) > 5.0


@every_photo
def test_rays_meet_the_wall_where_it_was_projected_from(folder: str, exposure: Exposure) -> None:
    view, pose = exposure.view, exposure.view.pose
    wall = np.array([[pose.x, pose.eye], [pose.x + 2.5, pose.eye - 3], [pose.x - 4, pose.eye + 1]])
    rays = view.rays(view.project(wall))
    rays *= pose.distance / rays[:, 2:]
    met = np.stack([pose.x + rays[:, 0], pose.eye - rays[:, 1]], axis=1)
    assert np.abs(met - wall).max() < 1e-6


@every_photo
def test_committed_picks_lie_on_true_edges(folder: str, exposure: Exposure) -> None:
    lines, rounding = committed(folder, exposure)
    known = list(curves(exposure))
    offsets: list[Array] = []
    for line in lines:
        nearest = min((distance(line, curve) for _, curve in known), key=np.max)
        assert nearest.max() < FOUR_SIGMA_PX + rounding * 2**0.5
        offsets.append(nearest)
        assert (line >= 0).all()
        assert (line <= [exposure.view.width - 1, exposure.view.height - 1]).all()
        assert 6 <= len(line) <= 12
    spread = float(np.sqrt(np.mean(np.concatenate(offsets) ** 2)))
    assert spread == pytest.approx(picks.NOISE_PX, rel=0.25)


@every_photo
def test_committed_lines_reach_the_frame_and_a_third_of_the_way(
    folder: str, exposure: Exposure
) -> None:
    lines, _ = committed(folder, exposure)
    half = np.array([exposure.view.width, exposure.view.height]) / 2
    across: tuple[list[float], list[float]] = ([], [])
    for line in lines:
        axis = 0 if np.ptp(line[:, 0]) < np.ptp(line[:, 1]) else 1
        across[axis].append(float((line[:, axis].mean() - exposure.view.centre[axis]) / half[axis]))
    for places in across:
        assert min(places) < -0.6
        assert max(places) > 0.6
        assert any(0.2 < abs(place) < 0.5 for place in places)


@every_photo
def test_committed_photograph_shows_the_edges_where_they_should_be(
    folder: str, exposure: Exposure
) -> None:
    view = exposure.view
    grey = np.asarray(Image.open(TARGET / folder / exposure.name).convert("L"), np.float32)
    assert grey.shape == (view.height, view.width)
    steps = np.arange(-4, 4.01, 0.25)
    found: list[float] = []
    sharp = [each for each in exposure.facade.edges() if re.match("window|pier left", each.name)]
    for edge in sharp[::3]:
        _, seen = picks.trace(view, edge)
        if len(seen) < 60:
            continue
        at = seen[5:-5:25]
        tangent = seen[6:-4:25][: len(at)] - at
        normal = tangent[:, ::-1] * [1, -1] / np.linalg.norm(tangent, axis=1, keepdims=True)
        where = at[:, None] + steps[None, :, None] * normal[:, None]
        x, y = where[..., 0].astype(np.float32), where[..., 1].astype(np.float32)
        profile = cv2.remap(grey, x, y, cv2.INTER_LINEAR)
        slope = np.abs(np.gradient(profile, axis=1)) ** 2
        slope = np.where(np.abs(steps) < 2.5, slope, 0)
        found += list((slope * steps).sum(1) / slope.sum(1))
    assert len(found) > 200
    assert abs(float(np.median(found))) < 0.1
    assert float(np.median(np.abs(found))) < 0.35


@every_photo
def test_exif(folder: str, exposure: Exposure) -> None:
    path = TARGET / folder / exposure.name
    lens, view = exposure.view.lens, exposure.view
    assert path.stat().st_size < 700_000
    with Image.open(path) as picture:
        exif = picture.getexif()
    detail = exif.get_ifd(0x8769)
    assert (exif[0x010F], exif[0x0110]) == (lens.make, lens.camera)
    assert exif[0x0131] == photo.SOFTWARE
    assert detail[0xA434] == lens.lens
    assert float(detail[0x920A]) == pytest.approx(lens.focal)
    assert detail[0xA405] == round(lens.focal * lens.crop)
    assert (detail[0xA002], detail[0xA003]) == (view.width, view.height)
    assert detail[0x9003] == exposure.taken


def test_text_files_are_what_the_generator_writes() -> None:
    for name, text in make_samples.texts().items():
        assert (TARGET / name).read_text(encoding="utf-8") == text, name


@pytest.mark.parametrize("folder", EXPOSURES)
def test_expected_counts_and_truth(folder: str) -> None:
    content: dict[str, Any] = json.loads((TARGET / folder / "expected.json").read_text())
    entries = content.get("lenses", [content])
    assert len(entries) == len(EXPOSURES[folder])
    readme = (TARGET / folder / "README.md").read_text(encoding="utf-8")
    for entry, exposure in zip(entries, EXPOSURES[folder], strict=True):
        lines, _ = committed(folder, exposure)
        assert entry["n_lines"] == len(lines)
        assert entry["n_points"] == sum(len(line) for line in lines)
        assert entry["truth"]["coefficients"] == exposure.view.lens.coefficients
        for value in exposure.view.lens.coefficients.values():
            assert f"{value:g}".replace("-", "−") in readme
    assert f"plumbline {' '.join(content['command'])}" in readme
    stem = Path(content["command"][1]).stem
    assert content["outputs"] == [f"{stem}.fit.pto", f"{stem}.fit.xml"]


def test_every_line_is_picked_from_a_different_edge() -> None:
    for exposure in (CSV, *ZOOM):
        names = [line.edge.name for line in exposure.lines()]
        assert len(set(names)) == len(names) == 14
    assert GRID.grid().shape == (7, 9, 2)


def test_folder_stays_small() -> None:
    assert sum(path.stat().st_size for path in TARGET.rglob("*") if path.is_file()) < 5_000_000


def test_renderer_imports_nothing_of_plumbline() -> None:
    for source in Path(__file__).parent.glob("*.py"):
        text = source.read_text(encoding="utf-8")
        assert not re.search(r"^\s*(import|from) plumbline", text, re.MULTILINE), source.name
