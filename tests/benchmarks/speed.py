"""Speed and memory, plumbline and its peers side by side.

    python -m tests.benchmarks.speed                    the table, and speed.json beside it
    python -m tests.benchmarks.speed --only help,fit    some rows

Every figure is for the public call, in a process of its own where that matters; medians of
several runs. Peers that are not installed leave their rows out.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import plumbline

Array = NDArray[np.float64]

SAMPLE = Path(__file__).parents[2] / "sample_projects" / "building"
LIBRARIES = "import jax, optimistix, lxml, rich"
SIZE = (6000, 4000)
ABC = (0.01, -0.05, 0.01)


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        what: What was done.
        ours: Our figure.
        peer: The figure of the peer or floor, or None where there is none.
        unit: Unit of both.
        reach: The ratio, or figure, to be reached.
        reached: Whether it was.
        against: Who the peer is.
    """

    what: str
    ours: float
    peer: float | None
    unit: str
    reach: str
    reached: bool
    against: str


def median(run: Callable[[], float], times: int = 5) -> float:
    """Median of several runs."""
    return statistics.median(run() for _ in range(times))


def seconds(command: list[str], folder: Path | None = None, cache: Path | None = None) -> float:
    """Wall-clock seconds of a command that must succeed."""
    environment = dict(os.environ)
    if cache is not None:
        environment["PLUMBLINE_CACHE_DIR"] = str(cache)
    began = time.perf_counter()
    subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
    return time.perf_counter() - began


def picks(n_lines: int, n_points: int, seed: int = 0, noise_px: float = 0.3) -> list[Array]:
    """Observed points on straight lines through the lens of `ABC`, both directions."""
    rng = np.random.default_rng(seed)
    radius = min(SIZE) / 2
    centre = np.array([(SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2])
    lines: list[Array] = []
    for index in range(n_lines):
        along = np.linspace(-0.93, 0.93, n_points) * (1.5 if index % 2 else 1.0)
        across = rng.uniform(-0.9, 0.9) * (1.0 if index % 2 else 1.45) + 0.02 * along
        ideal = np.stack((along, across) if index % 2 else (across, along), axis=1)
        r = np.hypot(ideal[:, 0], ideal[:, 1])
        a, b, c = ABC
        factor = a * r**3 + b * r**2 + c * r + 1 - a - b - c
        observed = centre + radius * ideal * factor[:, None]
        noisy = observed + rng.normal(0, noise_px, ideal.shape)
        lines.append(np.clip(noisy, 0, np.array(SIZE) - 1))
    return lines


def observations(n_lines: int, n_points: int, seed: int = 0) -> plumbline.Observations:
    """The same, as plumbline takes them."""
    return plumbline.Observations.from_arrays(picks(n_lines, n_points, seed), SIZE)


def timed(call: Callable[[], object]) -> float:
    """Seconds of a call."""
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def help_row(_: Path) -> list[Row]:
    """`plumbline --help` against a bare Python."""
    ours = median(lambda: seconds([sys.executable, "-m", "plumbline", "--help"]), 15)
    floor = median(lambda: seconds([sys.executable, "-c", "pass"]), 15)
    return [Row("plumbline --help", ours, floor, "s", "≤ 5 ×", ours <= 5 * floor, "python -c pass")]


def fit_rows(scratch: Path) -> list[Row]:
    """`plumbline fit building.pto`, first and later, against importing the libraries."""
    folder = scratch / "building"
    shutil.copytree(SAMPLE, folder)
    command = [sys.executable, "-m", "plumbline", "fit", "building.pto"]
    floor = median(lambda: seconds([sys.executable, "-c", LIBRARIES]), 7)
    caches = iter(scratch / f"cache{number}" for number in range(3))
    first = median(lambda: seconds(command, folder, next(caches)), 3)
    warm = median(lambda: seconds(command, folder, scratch / "cache0"), 7)
    return [
        Row(
            "plumbline fit, caches warm",
            warm,
            floor,
            "s",
            "≤ 1.7 ×",
            warm <= 1.7 * floor,
            LIBRARIES,
        ),
        Row(
            "plumbline fit, very first",
            first,
            floor,
            "s",
            "≤ 4.5 ×",
            first <= 4.5 * floor,
            LIBRARIES,
        ),
    ]


def second_fit_row(_: Path) -> list[Row]:
    """A further fit in one process against SciPy on the same residual."""
    from scipy.optimize import least_squares

    made = observations(12, 5)
    lines, frame = [line.points_px for line in made.lines], made.photos[0].frame
    plumbline.calibrate(made)
    ours = median(lambda: timed(lambda: plumbline.calibrate(made)), 51)

    def residual(abc: Array) -> Array:
        values = dict(zip("abc", abc.tolist(), strict=True)) | {"d": 0.0, "e": 0.0}
        return numpy_residual(plumbline.Lens(plumbline.get_model("ptlens"), frame, values), lines)

    def scipy_fit() -> None:
        least_squares(residual, np.zeros(3))

    peer = median(lambda: timed(scipy_fit), 3)
    what = "second fit in one process, 60 points"
    return [Row(what, ours, peer, "s", "≤ 0.5 ×", ours <= 0.5 * peer, "scipy least_squares")]


def numpy_residual(lens: plumbline.Lens, lines: list[Array]) -> Array:
    """The image residual in NumPy, as one would write it for SciPy."""
    ends = np.cumsum([len(points) for points in lines])[:-1]
    ideal = lens.undistort(np.concatenate(lines))
    u, v = lens.frame.normalise(ideal).T
    xx, xy, _, yy = lens.model.jacobian(u, v, lens.vector)
    determinant = xx * yy - xy * xy
    out: list[Array] = []
    for points, rows in zip(np.split(ideal, ends), np.split(np.arange(len(u)), ends), strict=True):
        centred = points - points.mean(axis=0)
        nx, ny = np.linalg.svd(centred, full_matrices=False)[2][1]
        gx = (nx * yy[rows] - ny * xy[rows]) / determinant[rows]
        gy = (ny * xx[rows] - nx * xy[rows]) / determinant[rows]
        out.append(centred @ np.array([nx, ny]) / np.hypot(gx, gy))
    return np.concatenate(out)


def _autooptimiser(project: Path) -> float:
    return seconds(["autooptimiser", "-n", "-o", str(project.with_suffix(".out")), str(project)])


def large_row(scratch: Path) -> list[Row]:
    """10,000 points on 500 lines against Hugin's optimiser."""
    if shutil.which("autooptimiser") is None:
        return []
    made = observations(500, 20)
    project = plumbline.write_points(made, scratch / "large.pto")
    plumbline.calibrate(made)
    ours = median(lambda: timed(lambda: plumbline.calibrate(made)), 9)
    peer = median(lambda: _autooptimiser(project), 3)
    what = "10,000 points on 500 lines, warm"
    return [Row(what, ours, peer, "s", "≤ 0.05 ×", ours <= 0.05 * peer, "autooptimiser")]


_GROWTH = """
import json, resource, sys, time
from tests.benchmarks.speed import observations
import plumbline
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
plumbline.calibrate(observations(int(sys.argv[1]) // 2, 20))
made = observations(int(sys.argv[1]), 20)
before = peak()
plumbline.calibrate(made)
first = peak()
began = time.perf_counter()
plumbline.calibrate(made)
print(json.dumps([made.n_points, time.perf_counter() - began, first - before]))
"""


def growth_rows(_: Path) -> list[Row]:
    """From 10⁴ to 10⁶ points: time and memory."""
    found = [
        json.loads(
            subprocess.run(
                [sys.executable, "-c", _GROWTH, str(lines)],
                check=True,
                capture_output=True,
                text=True,
            ).stdout
        )
        for lines in (500, 5_000, 50_000)
    ]
    n, took, memory = (np.array(column, dtype=float) for column in zip(*found, strict=True))
    exponent = float(np.polyfit(np.log(n), np.log(took), 1)[0])
    per_point = float(memory[-1] / n[-1])
    return [
        Row("exponent, 10⁴ to 10⁶ points", exponent, None, "", "≤ 1.1", exponent <= 1.1, "linear"),
        Row("10⁶ points, warm", took[-1], None, "s", "≤ 5 s", took[-1] <= 5, ""),
        Row("peak memory per point", per_point, None, "bytes", "≤ 400", per_point <= 400, ""),
    ]


def batch_row(scratch: Path) -> list[Row]:
    """`calibrate_many` on 10,000 projects against Hugin's optimiser, two processes at a time."""
    made = [observations(15, 11, seed) for seed in range(10_000)]
    # So many that suspicious ones are among them, whose robust fit has a program of its own.
    plumbline.calibrate_many(made[:640])
    ours = len(made) / timed(lambda: plumbline.calibrate_many(made))
    rows = [Row("10,000 projects of 165 points", ours, None, "fits/s", "≥ 1,500", ours >= 1500, "")]
    if shutil.which("autooptimiser") is None:
        return rows
    projects = [plumbline.write_points(m, scratch / f"{i}.pto") for i, m in enumerate(made[:60])]
    with ThreadPoolExecutor(2) as pool:
        peer = len(projects) / timed(lambda: list(pool.map(_autooptimiser, projects)))
    what = "the same, throughput"
    return [*rows, Row(what, ours, peer, "fits/s", "≥ 30 ×", ours >= 30 * peer, "autooptimiser, 2")]


def reading_row(scratch: Path) -> list[Row]:
    """A project of 10⁶ control points against reading its bytes and splitting its lines."""
    head = f'i w{SIZE[0]} h{SIZE[1]} f0 v50 a0 b0 c0 d0 e0 n"x.jpg"\n'
    rows: list[str] = []
    for number, line in enumerate(picks(2000, 500)):
        pairs = zip(line.round(6).tolist(), line[::-1].round(6).tolist(), strict=True)
        rows += [f"c n0 N0 x{x} y{y} X{u} Y{v} t{3 + number}\n" for (x, y), (u, v) in pairs]
    path = scratch / "million.pto"
    path.write_text("# hugin project file\n" + head + "".join(rows))
    floor = median(lambda: timed(lambda: path.read_bytes().decode().split("\n")), 5)
    ours = median(lambda: timed(lambda: plumbline.read(path)), 3)
    what = "reading a PTO of 10⁶ control points"
    return [Row(what, ours, floor, "s", "≤ 10 ×", ours <= 10 * floor, "read and split lines")]


BENCHMARKS = {
    "help": help_row,
    "fit": fit_rows,
    "second": second_fit_row,
    "large": large_row,
    "growth": growth_rows,
    "batch": batch_row,
    "reading": reading_row,
}


def shown(row: Row) -> str:
    """One line of the table."""
    peer = "" if row.peer is None else f"{row.peer:.4g} {row.unit}"
    ratio = "" if row.peer is None else f"{row.ours / row.peer:.3g} ×"
    mark = "reached" if row.reached else "NOT REACHED"
    ours = f"{row.ours:.4g} {row.unit}"
    return f"{row.what:38} {ours:>16} {peer:>14} {ratio:>9} {row.reach:>9}  {mark:12} {row.against}"


def main() -> None:
    """Run the benchmarks and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default=",".join(BENCHMARKS), help="names, with commas")
    parser.add_argument("--output", type=Path, default=Path("speed.json"))
    chosen = parser.parse_args()
    rows: list[Row] = []
    for name in chosen.only.split(","):
        with tempfile.TemporaryDirectory() as scratch:
            for row in BENCHMARKS[name](Path(scratch)):
                rows.append(row)
                print(shown(row), flush=True)
    usage = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(f"largest process: {usage / 1024:.0f} MiB; load {os.getloadavg()[0]:.1f}")
    figures = [asdict(row) for row in rows]
    chosen.output.write_text(json.dumps(figures, indent=2, default=bool) + "\n")


if __name__ == "__main__":
    main()
