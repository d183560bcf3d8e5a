"""Time and memory of large projects: 100,000 lines, and 300,000 picks on ten lines.

    python -m tests.benchmarks.size

Each project is worked on in a process of its own: read from CSV, fitted twice (the first time of
its shape compiles), summed up, written and read as JSON, and shown as a report. Printed are
seconds, and the highest memory so far in bytes a pick above what a fit of 60 picks leaves.
"""

from __future__ import annotations

import io
import multiprocessing
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np
from rich.console import Console

import plumbline
from plumbline.frame import Array
from plumbline.report.terminal.summary import print_summary

T = TypeVar("T")

SIZE = 6000, 4000
PROJECTS = {"100,000 lines": (100_000, 6), "300,000 picks on 10 lines": (10, 30_000)}
"""Number of lines, and of picks on each."""

B = -0.03
NOISE_PX = 0.3


def lines(n_lines: int, picks: int, seed: int = 0) -> list[Array]:
    """Chords of the photo, as a lens with that b shows them: q (b |q|² + 1 − b)."""
    rng = np.random.default_rng(seed)
    size = np.array(SIZE)
    middle, radius = (size - 1) / 2, size.min() / 2
    ends = rng.uniform(0.05, 0.95, (n_lines, 2))
    upright = rng.random(n_lines) < 0.5
    share = np.linspace(0.05, 0.95, picks)
    along = np.broadcast_to(share, (n_lines, picks))
    across = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * share
    places = np.stack((along, across), axis=2)
    places[upright] = places[upright][..., ::-1]
    q = (places * size - middle) / radius
    seen = middle + radius * q * (B * np.sum(q**2, axis=2, keepdims=True) + 1 - B)
    return list(seen + rng.normal(0, NOISE_PX, seen.shape))


def as_csv(made: list[Array]) -> str:
    """The picks as a table."""
    rows = (f"{n},{x:.2f},{y:.2f}" for n, points in enumerate(made) for x, y in points.tolist())
    return "\n".join(("line,x,y", *rows)) + "\n"


def megabytes() -> float:
    """The highest memory of this process so far."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def measured(name: str) -> list[tuple[str, float, float]]:
    """What was done, seconds, and bytes a pick above the libraries."""
    n_lines, picks = PROJECTS[name]
    small = plumbline.Observations.from_arrays(lines(10, 6), SIZE)
    with TemporaryDirectory() as folder:
        table, result, page = (Path(folder) / each for each in ("p.csv", "r.json", "r.html"))
        plumbline.write_report(plumbline.calibrate(small, free=("b",)), page)
        text = as_csv(lines(n_lines, picks))
        table.write_text(text)
        del text
        before = megabytes()
        rows: list[tuple[str, float, float]] = []

        def timed(what: str, make: Callable[[], T]) -> T:
            start = time.perf_counter()
            made = make()
            spent = time.perf_counter() - start
            rows.append((what, spent, (megabytes() - before) * 1e6 / (n_lines * picks)))
            return made

        observed = timed("read", lambda: plumbline.read(table, size=SIZE))
        timed("fit, first", lambda: plumbline.calibrate(observed))
        made = timed("fit", lambda: plumbline.calibrate(observed))
        console = Console(file=io.StringIO())
        timed("summary", lambda: print_summary(console, [made], []))
        timed("report", lambda: plumbline.write_report(made, page, overwrite=True))
        timed("JSON", lambda: plumbline.write(made, result))
        timed("JSON read", lambda: plumbline.read_calibration(result))
        if n_lines < 1000:
            timed("compare", lambda: plumbline.compare(observed))
    return rows


def main() -> None:
    """Print the table."""
    spawn = multiprocessing.get_context("spawn")
    for name in PROJECTS:
        with ProcessPoolExecutor(1, mp_context=spawn) as pool:
            rows = pool.submit(measured, name).result()
        print(f"{name}\n  {'':12}{'s':>8}{'bytes a pick':>14}")
        for what, spent, size in rows:
            print(f"  {what:12}{spent:8.1f}{size:14.0f}")


if __name__ == "__main__":
    main()
