"""Six pictures of a lens being picked, for the README: `python -m tests.pick.film [folder]`."""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

from tests.pick.browser import Driven, browsing
from tests.pick.served import FACADE, ROOT, served
from tests.pick.test_page import edges

TARGET = ROOT / "sample_projects"
_WIDTH, _QUALITY = 800, 60
"""Small enough for a README (below 60 kB), large enough to read."""


class Camera:
    """Takes the pictures."""

    def __init__(self, driven: Driven, folder: Path) -> None:
        self.driven = driven
        self.folder = folder
        self.taken: list[Path] = []

    def shoot(self) -> None:
        """Save what the page shows."""
        self.driven.page.wait_for_timeout(400)
        self.driven.settled()
        data = np.frombuffer(self.driven.page.screenshot(), dtype=np.uint8)
        full = cv2.imdecode(data, cv2.IMREAD_COLOR)
        assert full is not None
        height = round(full.shape[0] * _WIDTH / full.shape[1])
        small = cv2.resize(full, (_WIDTH, height), interpolation=cv2.INTER_AREA)
        path = self.folder / f"pick_{len(self.taken) + 1}.jpg"
        how = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
        cv2.imwrite(str(path), small, how)
        self.taken.append(path)


def film(folder: Path) -> list[Path]:
    """Pick the sample façade, and take a picture at every step."""
    with tempfile.TemporaryDirectory() as scratch:
        photo = Path(shutil.copy(FACADE, Path(scratch) / "facade.jpg"))
        with browsing() as browser, served(photo, "--mount", "Nikon F AF") as server:
            camera = Camera(Driven(browser, server), folder)
            _pick(camera)
            _judge(camera)
            _finish(camera)
            assert camera.driven.complaints == []
    return camera.taken


def _pick(camera: Camera) -> None:
    """The second click of the first line; then, half of the lines."""
    driven, wanted = camera.driven, edges(0.3)
    driven.press("p")
    first, second = wanted[1]
    driven.click(first)
    driven.page.mouse.move(*driven.place(second), steps=3)
    camera.shoot()
    for ends in wanted[1:8]:
        for end in ends:
            driven.click(end)
        driven.press("Escape")
    driven.press("n")
    driven.page.mouse.move(640, 20)
    driven.page.wait_for_timeout(3000)
    camera.shoot()


def _judge(camera: Camera) -> None:
    """Where it is uncertain, and a pick that is wrong."""
    driven = camera.driven
    driven.press("Escape", "x", "u")
    driven.page.locator("#goal").fill("0.03")
    driven.page.locator("#goal").press("Enter")
    driven.page.wait_for_timeout(2000)
    camera.shoot()
    driven.page.locator("#stage").focus()
    driven.press("u", "s", "n", "s")  # the first line's clicks, and one more that is wrong
    driven.click((1130.0, 280.0), "Shift")
    driven.page.mouse.move(640, 20)
    driven.page.wait_for_selector("#suspects li", timeout=60_000)
    driven.press("Escape")
    camera.shoot()
    driven.press("Control+z", "Control+z")


def _finish(camera: Camera) -> None:
    """The corrected photo with a guide, and the files."""
    driven = camera.driven
    driven.press("c", "g")
    camera.shoot()
    driven.press("g", "c")
    driven.page.keyboard.press("Control+s")
    driven.page.wait_for_selector("#sheet code", timeout=180_000)
    camera.shoot()


if __name__ == "__main__":
    for taken in film(Path(sys.argv[1]) if len(sys.argv) > 1 else TARGET):
        print(taken, taken.stat().st_size)
