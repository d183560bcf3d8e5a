"""Debian's Chromium on the page, driven by Playwright."""

from __future__ import annotations

import shutil
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from tests.pick.served import Served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
_PATIENCE_MS = 60_000
_FRAMES_MS = 50
"""In which the page sends what a key or a click asks for."""


@contextmanager
def browsing() -> Generator[Browser]:
    """A browser; the test is skipped where there is none."""
    if CHROMIUM is None:
        pytest.skip("chromium is not installed, so the page is not driven")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


class Driven:
    """One open page, and what it complained of."""

    def __init__(self, browser: Browser, server: Served, **how: Any) -> None:
        options: dict[str, Any] = {"viewport": {"width": 1280, "height": 720}} | how
        self.context = browser.new_context(**options)
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(_PATIENCE_MS)
        self.complaints: list[str] = []
        self.clicks = 0
        self.page.on("console", lambda told: self.complaints.append(told.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(server.address)
        self.ready()

    def ready(self) -> None:
        """Wait until the page can be used."""
        self.page.wait_for_selector("html[data-ready=yes]")
        self.settled()

    def settled(self) -> None:
        """Wait until every tile is drawn and every request answered."""
        self.page.wait_for_timeout(_FRAMES_MS)
        # Not by a function: the page's policy forbids to evaluate one.
        self.page.wait_for_selector("#stage[data-settled=true]:not(.waiting)")

    def data(self, name: str) -> str:
        """What the stage says of itself."""
        return self.page.locator("#stage").get_attribute(f"data-{name}") or ""

    def place(self, point: Sequence[float]) -> tuple[float, float]:
        """Where a point of the photo is on the screen."""
        box = self.page.locator("#stage").bounding_box()
        assert box is not None
        x, y, scale = (float(each) for each in self.data("view").split())
        return (
            box["x"] + box["width"] / 2 + (point[0] - x) * scale,
            box["y"] + box["height"] / 2 + (point[1] - y) * scale,
        )

    def click(self, point: Sequence[float], *keys: str) -> None:
        """Click at a point of the photo, and wait for what comes of it.

        Args:
            point: In the photo's pixels.
            keys: Keys that are held meanwhile.
        """
        for key in keys:
            self.page.keyboard.down(key)
        self.page.mouse.click(*self.place(point))
        for key in keys:
            self.page.keyboard.up(key)
        self.clicks += 1
        self.settled()

    def zoom_to(self, point: Sequence[float], notches: int) -> None:
        """Turn the wheel over a point of the photo."""
        self.page.mouse.move(*self.place(point))
        for _ in range(notches):
            self.page.mouse.wheel(0, -120)
        self.page.wait_for_timeout(100)
        self.settled()

    def press(self, *keys: str) -> None:
        """Press keys, each when what the one before asked for is done."""
        for key in keys:
            self.page.keyboard.press(key)
            self.settled()

    def heap_bytes(self) -> float:
        """What the page's objects take, once those that nobody uses are collected."""
        session = self.context.new_cdp_session(self.page)
        session.send("Performance.enable")
        session.send("HeapProfiler.collectGarbage")
        metrics = session.send("Performance.getMetrics")["metrics"]
        session.detach()
        return next(each["value"] for each in metrics if each["name"] == "JSHeapUsedSize")

    def text(self, selector: str) -> str:
        """What an element says."""
        return self.page.locator(selector).inner_text()

    def lines(self) -> int:
        """How many lines the panel lists."""
        return self.page.locator("#lines tr").count()
