"""Time and memory of correcting a 12-megapixel JPEG, beside ImageMagick and nona.

    python -m tests.benchmarks.correct_speed [--runs N] [--photos N]

Each program runs as a process of its own, start included, in turn, several times over; the
best wall-clock and processor times are printed. Memory is the largest resident size; that of
the imports alone is measured in a process that only imports.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
SIZE = (4000, 3000)
A, B, C = 0.032, -0.0978, 0.0417
PTLENS = ("--ptlens", f"a={A},b={B},c={C}", "-q")
PLUMBLINE = (sys.executable, "-m", "plumbline", "correct", "photo.jpg", *PTLENS)
IMPORTS = (
    "import plumbline.cli.correct, plumbline.cli.tools.correct, plumbline.lenses.lookup, "
    "plumbline.lenses.sources, plumbline.lenses.profile"
)
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
ENVIRONMENT.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed program is compiled already
PAINT = f"""
import cv2, numpy as np
rng = np.random.default_rng(0)
photo = cv2.imread({str(ROOT / "sample_projects" / "building" / "facade.jpg")!r})
photo = cv2.resize(photo, {SIZE}, interpolation=cv2.INTER_CUBIC).astype(np.float32)
photo += rng.standard_normal(photo.shape, dtype=np.float32) * 3
cv2.imwrite("photo.jpg", np.clip(photo, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 92])
"""
PROJECT = f"""p f0 w{SIZE[0]} h{SIZE[1]} v50 E0 R0 n"JPEG q95"
m i0
i w{SIZE[0]} h{SIZE[1]} f0 v50 r0 p0 y0 a{A} b{B} c{C} d0 e0 g0 t0 Eev0 Vm5 n"photo.jpg"
"""


@dataclass(frozen=True)
class Run:
    """One run of a program.

    Attributes:
        wall_s: Seconds from start to end.
        cpu_s: Seconds of processor time, user and system.
        peak_mb: Largest resident size, 10⁶ bytes.
    """

    wall_s: float
    cpu_s: float
    peak_mb: float


def run(command: Sequence[str], folder: Path, cores: set[int] | None = None) -> Run:
    """Run a program that must succeed, perhaps on some of the processor's cores alone."""
    started = time.perf_counter()
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=ENVIRONMENT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    if cores is not None:
        os.sched_setaffinity(process.pid, cores)
    _, status, usage = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{command[0]} failed with status {process.returncode}")
    return Run(wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6)


def best(runs: Sequence[Run]) -> Run:
    """The best of each figure; of memory the worst."""
    return Run(
        min(each.wall_s for each in runs),
        min(each.cpu_s for each in runs),
        max(each.peak_mb for each in runs),
    )


def compare(folder: Path, runs: int) -> None:
    """Print plumbline beside its peers."""
    commands: dict[str, tuple[str, ...]] = {
        "imports alone": (sys.executable, "-c", IMPORTS),
        **{
            f"plumbline {kind}": (*PLUMBLINE, "--interpolation", kind, "-o", f"{kind}.jpg")
            for kind in ("nearest", "linear", "cubic", "lanczos")
        },
    }
    if convert := shutil.which("convert-im6.q16") or shutil.which("magick"):
        barrel = ("-virtual-pixel", "black", "-distort", "Barrel", f"{A} {B} {C}")
        commands["ImageMagick Barrel"] = (convert, "photo.jpg", *barrel, "im.jpg")
    if nona := shutil.which("nona"):
        commands["nona"] = (nona, "-o", "nona.jpg", "photo.pto")
    found = {name: list[Run]() for name in commands}
    for _ in range(runs):
        for name, command in commands.items():
            found[name].append(run(command, folder))
    table = {name: best(each) for name, each in found.items()}
    peers = [name for name in ("ImageMagick Barrel", "nona") if name in table]
    megapixels = SIZE[0] * SIZE[1] / 1e6
    print(f"{megapixels:g}-megapixel JPEG, best of {runs}; load {os.getloadavg()[0]:.1f}")
    heads = "".join(f" {'of ' + name:>21}" for name in peers)
    print(f"{'':22} {'wall s':>7} {'cpu s':>7} {'MB':>6} {'bytes/px':>9}{heads}")
    for name, each in table.items():
        above = (each.peak_mb - table["imports alone"].peak_mb) / megapixels
        own = f"{above:9.1f}" if name.startswith("plumbline") else " " * 9
        shares = "".join(f" {each.wall_s / table[peer].wall_s:21.3f}" for peer in peers)
        print(f"{name:22} {each.wall_s:7.2f} {each.cpu_s:7.2f} {each.peak_mb:6.0f} {own}{shares}")


def scale(folder: Path, photos: int, runs: int) -> None:
    """Print how a folder of photographs scales from one core to all."""
    many = folder / "many"
    many.mkdir()
    for number in range(photos):
        (many / f"{number}.jpg").hardlink_to(folder / "photo.jpg")
    everywhere = os.sched_getaffinity(0)
    places = {"one core": {min(everywhere)}, f"{len(everywhere)} cores": everywhere}
    found = {name: list[Run]() for name in places}
    for _ in range(runs):
        for name, cores in places.items():
            shutil.rmtree(folder / "out", ignore_errors=True)
            command = (sys.executable, "-m", "plumbline", "correct", "many", *PTLENS, "-o", "out")
            found[name].append(run(command, folder, cores))
    one_s, all_s = (best(each).wall_s for each in found.values())
    for name, wall_s in zip(places, (one_s, all_s), strict=True):
        print(f"{photos} photos, {name}: {wall_s:.2f} s wall, {photos / wall_s:.2f}/s")
    print(f"{one_s / all_s:.2f} times as many on {len(everywhere)} cores as on one")


def main() -> None:
    """Parse, paint, run, print."""
    parser = argparse.ArgumentParser(description="Time and memory of correcting a photograph.")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--photos", type=int, default=36)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run([sys.executable, "-c", PAINT], cwd=folder, check=True)
        (folder / "photo.pto").write_text(PROJECT)
        compare(folder, options.runs)
        scale(folder, options.photos, options.runs)


if __name__ == "__main__":
    main()
