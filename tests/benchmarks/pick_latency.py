"""How quickly the page answers: `python -m tests.benchmarks.pick_latency [MEGAPIXELS]`.

Chromium clicks along the edges of the sample façade, enlarged to so many megapixels (24 by
default). Times are those of the page: from the pointer's release to the drawn new lens, and to the
background's judgement; of the server: for single tiles; and of a user: from the address to a page
with its photo. Needs Chromium and the test requirements.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tests.pick.browser import Driven, browsing
from tests.pick.served import FACADE, Served, served
from tests.pick.test_page import edges

_MILLISECONDS = 1e3
_TILES = 40
_JUDGED_MS = 2500
"""Time for the judgement, well above what is wanted, so that one that is late is not lost."""

_WATCH = """() => {
  const stage = document.querySelector("#stage");
  window.released = 0;
  window.seen = { drawn: [], judged: [] };
  stage.addEventListener("pointerup", () => { window.released = performance.now(); }, true);
  const shown = { ...stage.dataset };
  new MutationObserver(() => {
    for (const name of ["drawn", "judged"]) {
      if (stage.dataset[name] === shown[name]) continue; // set again to what it was
      shown[name] = stage.dataset[name];
      window.seen[name].push(performance.now() - window.released);
    }
  }).observe(stage, { attributes: true, attributeFilter: ["data-drawn", "data-judged"] });
}"""
"""The first change after a click counts: later ones are of lines that were traced again."""

_TAKE = """() => {
  const first = Object.fromEntries(Object.entries(window.seen).map(([k, v]) => [k, v[0] ?? null]));
  window.seen = { drawn: [], judged: [] };
  return first;
}"""


@dataclass(frozen=True)
class Times:
    """Times in milliseconds.

    Attributes:
        opened: From the address to a page with its photo.
        clicks: From a line's second click to its new lens on the screen.
        judgements: From that click to what the background says.
        tiles: For single tiles at full size.
    """

    opened: float
    clicks: tuple[float, ...]
    judgements: tuple[float, ...]
    tiles: tuple[float, ...]


def measure(megapixels: float, lines: int = 14) -> Times:
    """Drive one page."""
    with tempfile.TemporaryDirectory() as folder:
        photo = Path(folder) / "facade.jpg"
        scale = _enlarged(photo, megapixels)
        with browsing() as browser, served(photo) as server:
            start = time.perf_counter()
            driven = Driven(browser, server)
            opened = time.perf_counter() - start
            driven.page.wait_for_selector("#stage[data-ready=yes]")
            driven.page.evaluate(_WATCH)
            clicks: list[float] = []
            judgements: list[float] = []
            for ends in edges(1.0)[:lines]:
                for x, y in ends:
                    driven.click((x * scale, y * scale))
                driven.page.wait_for_timeout(_JUDGED_MS)
                driven.press("Escape")
                seen = driven.page.evaluate(_TAKE)
                clicks += [] if seen["drawn"] is None else [seen["drawn"]]
                judgements += [] if seen["judged"] is None else [seen["judged"]]
            tiles = _tile_times(server, photo)
        return Times(opened * _MILLISECONDS, tuple(clicks), tuple(judgements), tuple(tiles))


def _enlarged(photo: Path, megapixels: float) -> float:
    small = cv2.imread(str(FACADE))
    if small is None:
        raise OSError(f"{FACADE} cannot be read")
    height, width = small.shape[:2]
    scale = float(np.sqrt(megapixels * 1e6 / (width * height)))
    if scale == 1:
        shutil.copy(FACADE, photo)
    else:
        size = (round(width * scale), round(height * scale))
        large = cv2.resize(small, size, interpolation=cv2.INTER_CUBIC)
        cv2.imwrite(str(photo), large, [cv2.IMWRITE_JPEG_QUALITY, 90])
    return scale


def _tile_times(server: Served, photo: Path) -> list[float]:
    state = server.state()["photos"][0]
    columns, rows = state["width"] // 512, state["height"] // 512
    rng = np.random.default_rng(1)
    found: list[float] = []
    for _ in range(_TILES):
        column, row = rng.integers(columns), rng.integers(rows)
        start = time.perf_counter()
        assert server.ask(f"tiles/0/0/{column}/{row}")[0] == 200, photo
        found.append((time.perf_counter() - start) * _MILLISECONDS)
    return found


def _row(what: str, values: tuple[float, ...], reach: str) -> str:
    if not values:
        return f"{what:<34} none"
    middle, high = np.percentile(values, [50, 95])
    return f"{what:<34} {middle:>8.0f} {high:>8.0f}   {reach}"


def main(megapixels: float) -> None:
    """Print the table."""
    times = measure(megapixels)
    print(f"{megapixels:g} megapixels, ms {'':<15} median    95 %   reach")
    print(_row("photo opened", (times.opened,), "2,000 at 100 megapixels"))
    print(_row("click to new lens", times.clicks, "100, 150"))
    print(_row("click to judgement", times.judgements, "1,000"))
    print(_row("tile", times.tiles, "50"))


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 24)
