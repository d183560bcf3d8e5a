"""The page in a real browser: picked by mouse and keys, looked at, reloaded, killed."""

from __future__ import annotations

import csv
import json
import re
import shutil
import signal
import threading
from collections.abc import Callable, Generator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest

from tests.pick.browser import Driven, browsing
from tests.pick.served import FACADE, Served, served

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Point = tuple[float, float]

DRAWN = {"do": "draw", "photo": 0, "clicks": [[1, 1]], "snap": False}

_SEARCH_MS = 240_000
"""The search for edges gives way to all else on a busy machine."""

WITHIN_PX = 0.3
"""What `find` and `snap` are to reach at worst on clean façades (corner error)."""


@pytest.fixture(scope="module")
def browser() -> Generator[Browser]:
    with browsing() as found:
        yield found


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return Path(shutil.copy(FACADE, tmp_path / "facade.jpg"))


Drive = Callable[..., Driven]


@pytest.fixture
def drive(browser: Browser) -> Generator[Drive]:
    """Opens pages, and closes them after the test."""
    opened: list[Driven] = []

    def opening(server: Served, **how: Any) -> Driven:
        opened.append(Driven(browser, server, **how))
        return opened[-1]

    yield opening
    for each in opened:
        each.context.close()


@pytest.fixture(scope="module")
def shared_photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copy(FACADE, tmp_path_factory.mktemp("photo") / "<b>facade.jpg"))


@pytest.fixture(scope="module")
def shared(shared_photo: Path) -> Generator[Served]:
    with served(shared_photo) as found:
        yield found


@pytest.fixture
def server(shared: Served) -> Generator[Served]:
    """A server without a line; what a test picked is deleted after it."""
    yield shared
    shared.ask("take", {"page": "test"})
    for line in shared.state()["lines"]:
        shared.act(do="remove", line=line["number"])


@pytest.fixture(scope="module")
def picked(tmp_path_factory: pytest.TempPathFactory) -> Generator[Served]:
    """A server with the sample's 14 lines."""
    photo = shutil.copy(FACADE, tmp_path_factory.mktemp("photo") / "facade.jpg")
    with served(photo, FACADE.with_name("picks.csv")) as found:
        yield found


def edges(scatter_px: float, seed: int = 3) -> list[tuple[Point, Point]]:
    """Ends of the edges that the sample's picks lie on, as a hand would click them."""
    rng = np.random.default_rng(seed)
    found: dict[str, list[Point]] = {}
    for row in csv.DictReader(FACADE.with_name("picks.csv").read_text().splitlines()):
        found.setdefault(row["line"], []).append((float(row["x"]), float(row["y"])))
    ends = np.array([(line[0], line[-1]) for line in found.values()])
    ends = np.clip(ends + rng.normal(0, scatter_px, ends.shape), 0, (2255, 1503))
    return [((a[0], a[1]), (b[0], b[1])) for a, b in ends.tolist()]


def off_truth_px(coefficients: dict[str, float]) -> float:
    """How far a ptlens curve is from the photo's true one, after the best common scale."""
    truth = json.loads(FACADE.with_name("expected.json").read_text())["truth"]["coefficients"]
    observed = np.linspace(0, np.hypot(2256, 1504) / 1504, 200)[1:]

    def ideal(c: dict[str, float]) -> np.ndarray[Any, Any]:
        low, high = np.zeros_like(observed), np.full_like(observed, 4.0)
        for _ in range(60):  # bisection
            r = (low + high) / 2
            below = r * (c["a"] * r**3 + c["b"] * r**2 + c["c"] * r + 1 - c["a"] - c["b"] - c["c"])
            low, high = np.where(below < observed, r, low), np.where(below < observed, high, r)
        return low

    one, other = ideal(coefficients), ideal(truth)
    return float(np.max(np.abs(one * (one @ other) / (one @ one) - other))) * 752


def coefficients(server: Served) -> dict[str, float]:
    return {each["name"]: each["value"] for each in server.state()["fit"]["coefficients"]}


def pick_all(driven: Driven, scatter_px: float, notches: int = 0) -> None:
    """Two clicks a line, and the wheel between them."""
    driven.press("p")  # without what is proposed
    wanted = edges(scatter_px)
    while wanted:
        ends, before = wanted.pop(0), driven.lines()
        for end in ends:
            if notches:
                driven.zoom_to(end, notches)
            driven.click(end)
            if notches:
                driven.press("0")
        if driven.lines() == before:  # it said why: try again later
            driven.press("Escape")
            wanted.append(ends)


def test_from_a_photo_to_a_profile(drive: Drive, photo: Path) -> None:
    with served(photo) as server:
        driven = drive(server)
        pick_all(driven, 1.0)
        assert driven.clicks <= 30
        assert driven.lines() == 14
        assert off_truth_px(coefficients(server)) < WITHIN_PX
        driven.page.keyboard.press("Control+s")
        driven.page.wait_for_selector("#sheet li code", timeout=180_000)
        written = driven.page.locator("#sheet li code").all_inner_texts()
        assert written == ["facade.fit.pto", "facade.fit.xml", "facade.fit.html"]
        assert all((photo.parent / name).stat().st_size for name in written)
        assert driven.text("#sheet").count("Pincushion distortion: +6.") == 1
        assert (
            "Generic" not in photo.with_suffix(".fit.xml").read_text()
        )  # LensFun knows the camera
        driven.page.get_by_label("Mount").fill("Nikon F AF")
        driven.page.get_by_role("button", name="Write again").click()
        target = photo.with_suffix(".fit.xml")
        while "<mount>Nikon F AF</mount>" not in (profile := target.read_text()):
            driven.page.wait_for_timeout(200)  # the test's own limit of time ends it
        values = {n: float(v) for n, v in re.findall(r' ([abc])="([^"]+)"', profile)}
        assert off_truth_px(values) < WITHIN_PX
        assert driven.complaints == []


def test_zoomed_on_a_dense_screen_it_is_the_same_lens(drive: Drive, server: Served) -> None:
    driven = drive(server, device_scale_factor=2)
    pick_all(driven, 2.0, notches=4)
    assert driven.lines() == 14
    assert off_truth_px(coefficients(server)) < WITHIN_PX
    assert driven.complaints == []


def test_proposals_are_taken_and_rejected(drive: Drive, photo: Path) -> None:
    with served(photo) as server:
        driven = drive(server)
        driven.page.wait_for_selector(
            "#stage[data-proposed]:not([data-proposed='0'])", timeout=_SEARCH_MS
        )
        proposals = server.state()["proposals"]
        assert len(proposals) >= 8
        first, second = (each["points"] for each in proposals[:2])
        driven.page.mouse.move(*driven.place(first[12]))
        assert "takes this edge" in driven.text("#mode")
        driven.click(first[1], "Alt")  # a free pick, though it is near
        driven.press("Escape")
        assert driven.lines() == 0
        driven.click(first[1])
        assert driven.lines() == 1
        driven.click(first[-2])  # who clicks both ends, as everywhere else, gets it once
        assert driven.text("#mode") == "click near one end of an edge"
        assert driven.lines() == 1
        driven.press("Escape")
        driven.click(second[12], "Shift")
        assert len(server.state()["proposals"]) == len(proposals) - 2
        driven.press("Control+z")
        assert len(server.state()["proposals"]) == len(proposals) - 1
        driven.press("Control+Shift+z", "Control+Enter")
        assert driven.lines() == len(proposals) - 1
        assert off_truth_px(coefficients(server)) < WITHIN_PX
        driven.press("Control+z", "Control+z", "Control+z")
        assert driven.lines() == 0
        assert len(server.state()["proposals"]) == len(proposals)


def free_line(driven: Driven, points: list[Point]) -> None:
    for point in points:
        driven.click(point)
    driven.press("Enter")


FREE = [(300.0, 200.0), (900.0, 210.0), (1500.0, 205.0)]


def test_free_picks_undo_redo_reload_and_kill(drive: Drive, photo: Path) -> None:
    with served(photo) as server:
        driven = drive(server)
        driven.press("f")
        free_line(driven, FREE)
        free_line(driven, [(x, y + 400) for x, y in FREE])
        assert driven.lines() == 2
        driven.press("Control+z")
        assert driven.lines() == 1
        driven.page.reload()
        driven.ready()
        assert driven.lines() == 1
        assert driven.page.locator("#banner").is_hidden()  # a reload is no second page
        driven.press("Control+Shift+z")
        assert driven.lines() == 2
        before = server.state()["lines"]
        server.process.send_signal(signal.SIGKILL)
        server.process.wait(timeout=30)
        driven.page.wait_for_selector("#banner:not([hidden])")
        assert "is saved" in driven.text("#banner")
    with served(photo) as server:
        driven = drive(server)
        assert driven.lines() == 2
        assert server.state()["lines"] == before
        driven.press("Control+z", "Control+z")
        assert driven.lines() == 0


def test_dragging_deleting_extending_and_nudging(drive: Drive, server: Served) -> None:
    driven = drive(server)
    driven.press("f")
    free_line(driven, FREE)
    start, goal = driven.place(FREE[1]), driven.place((950.0, 208.0))
    driven.page.mouse.move(*start)
    driven.page.mouse.down()
    driven.page.mouse.move(*goal, steps=4)
    driven.page.mouse.up()
    driven.settled()
    moved = server.state()["lines"][0]["clicks"][1]
    assert moved == pytest.approx((950, 208), abs=3)
    driven.press("Shift+ArrowRight")
    nudged = server.state()["lines"][0]["clicks"][1]
    assert nudged == pytest.approx((moved[0] + 0.1, moved[1]))
    driven.click((1900.0, 204.0))  # beyond its end, where it goes on
    assert len(server.state()["lines"][0]["clicks"]) == 4
    driven.click(FREE[0])
    driven.press("Delete")
    assert len(server.state()["lines"][0]["clicks"]) == 3
    driven.press("Escape", "n", "Delete")
    assert driven.lines() == 0


def test_rivals_and_reasons(drive: Drive, server: Served) -> None:
    driven = drive(server)
    driven.press("p")  # without what is proposed
    for end in edges(0.5)[2]:
        driven.click(end)
    line = server.state()["lines"][0]
    if line.get("rivals"):
        driven.press("Tab")
        assert server.state()["lines"][0]["rival"] == 1
        driven.press("Shift+Tab")
    assert server.state()["lines"][0].get("rival", 0) == 0
    driven.press("s")
    assert not server.state()["lines"][0].get("snapped", False)
    driven.click((900.0, 40.0))  # the sky: there is no edge
    driven.click((1100.0, 20.0))
    assert driven.page.locator("#reason").is_visible()
    assert "edge" in driven.text("#reason")
    assert driven.lines() == 1


def test_a_second_page_is_told(drive: Drive, server: Served) -> None:
    first, second = drive(server), drive(server)
    second.page.wait_for_selector("#banner:not([hidden])")
    assert "another page" in second.text("#banner")
    second.page.get_by_role("button", name="Pick here").click()
    first.page.wait_for_selector("#banner:not([hidden])")
    assert second.page.locator("#banner").is_hidden()
    second.press("f")
    free_line(second, FREE)
    assert second.lines() == 1
    second.context.close()
    first.page.wait_for_selector("#banner", state="hidden")


def test_a_foreign_page_reads_nothing(browser: Browser, server: Served) -> None:

    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!DOCTYPE html><title>foreign</title>")

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
            pass

    foreign = HTTPServer(("127.0.0.1", 0), Foreign)
    threading.Thread(target=foreign.serve_forever, daemon=True).start()
    page = browser.new_page()
    page.goto(f"http://127.0.0.1:{foreign.server_port}/")
    read = page.evaluate("u => fetch(u).then(() => 'read', () => 'refused')", server.address)
    assert read == "refused"
    shown = page.evaluate(
        """u => new Promise(told => { const image = new Image();
        image.onload = () => told("shown"); image.onerror = () => told("refused");
        image.src = u + "tiles/0/0/0/0"; })""",
        server.address,
    )
    assert shown == "refused"
    page.evaluate(
        """([u, body]) => fetch(u + "act", { method: "POST", mode: "no-cors", body })
        .catch(() => 0)""",
        [server.address, json.dumps({"page": "x", "action": DRAWN})],
    )
    assert server.state()["lines"] == []
    foreign.shutdown()
    foreign.server_close()
    page.close()


def test_what_is_not_saved_is_said_and_kept(
    drive: Drive, server: Served, shared_photo: Path
) -> None:
    picks = shared_photo.with_suffix(".plumbline.json")
    driven = drive(server)
    picks.write_text("another program's")
    driven.press("f")
    free_line(driven, FREE)
    driven.page.wait_for_selector("#banner:not([hidden])")
    assert "not saved" in driven.text("#banner").lower()
    assert driven.lines() == 1
    assert picks.read_text() == "another program's"
    picks.unlink()
    driven.page.wait_for_selector("#banner", state="hidden")
    assert json.loads(picks.read_text())["lines"]


def test_a_photo_that_vanishes_is_told(drive: Drive, server: Served, shared_photo: Path) -> None:
    driven = drive(server)
    shared_photo.rename(shared_photo.with_suffix(".moved"))
    driven.page.wait_for_selector("#banner:not([hidden])")
    assert "moved or deleted" in driven.text("#banner")
    driven.press("f")
    free_line(driven, FREE)
    assert driven.lines() == 1
    shared_photo.with_suffix(".moved").rename(shared_photo)
    driven.page.wait_for_selector("#banner", state="hidden")


def test_keys_alone_suffice(drive: Drive, server: Served) -> None:
    driven = drive(server)
    assert driven.text("#title") == "<b>facade.jpg"
    driven.press("f", "Space", "ArrowRight", "Space", "ArrowRight", "Space", "Enter")
    assert driven.lines() == 1
    driven.press("+", "+", "-", "1", "0", "r", "]", "[", "l", "x", "u", "w", "p", "g", "g")
    driven.press("?")
    keys = driven.page.locator("#sheet kbd").all_inner_texts()
    assert {"Tab", "Space", "Esc", "?", "U", "C", "G", "M"} <= set(keys)
    driven.press("Escape")
    assert driven.page.locator("#sheet").is_hidden()
    assert driven.complaints == []


def test_controls_have_names_and_the_result_is_spoken(drive: Drive, picked: Served) -> None:
    driven = drive(picked)
    unnamed = driven.page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, [role=application]")]
        .filter(each => !(each.textContent.trim() || each.ariaLabel || each.labels?.length))
        .map(each => each.outerHTML)"""
    )
    assert unnamed == []
    driven.page.wait_for_selector("#spoken:not(:empty)", state="attached")
    assert (driven.page.locator("#spoken").text_content() or "").startswith("14 lines. ")
    driven.press("n")
    assert driven.page.locator("#lines button[aria-pressed=true]").count() == 1


def test_views_show_what_they_say(drive: Drive, picked: Served) -> None:
    """Photo, map, corrected photo and dark page, by their pixels."""
    driven = drive(picked, color_scheme="dark")
    driven.page.wait_for_selector("#stage[data-judged]:not([data-judged=''])")
    driven.press("l", "w", "x")
    plain = shot(driven)
    assert np.median(plain[60:, 1000:]) < 60  # the panel is dark
    driven.press("u")
    mapped = shot(driven)
    assert np.mean(np.abs(mapped - plain)[80:660, 60:900]) > 15
    driven.press("u", "c")
    corrected = shot(driven)
    assert np.mean(np.abs(corrected - plain)[80:660, 60:900]) > 5
    driven.press("c")
    assert np.mean(np.abs(shot(driven) - plain)[80:660, 60:900]) < 0.5


def shot(driven: Driven) -> np.ndarray[Any, Any]:
    """The page's pixels."""
    driven.page.mouse.move(1270, 10)
    driven.page.wait_for_timeout(300)
    driven.settled()
    data = np.frombuffer(driven.page.screenshot(), dtype=np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), dtype=np.int64)


def test_on_a_tablet(drive: Drive, server: Served) -> None:
    driven = drive(server, viewport={"width": 820, "height": 1180}, has_touch=True)
    driven.page.locator("#stage").focus()
    driven.press("f")
    for point in FREE:
        driven.page.touchscreen.tap(*driven.place(point))
        driven.settled()
    driven.press("Enter")
    assert driven.lines() == 1
    wide = driven.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 820


def test_a_hundred_megapixels(drive: Drive, photo: Path) -> None:
    small = cv2.imread(str(photo))
    assert small is not None
    large = cv2.resize(small, (12_288, 8_192), interpolation=cv2.INTER_LINEAR)
    cv2.imwrite(str(photo), large, [cv2.IMWRITE_JPEG_QUALITY, 80])
    scale = 12_288 / 2256
    with served(photo) as server:
        driven = drive(server)
        for x, y in edges(0.5)[3]:
            driven.zoom_to((x * scale, y * scale), 8)
            driven.click((x * scale, y * scale))
            driven.press("0")
        assert driven.lines() == 1


def test_memory_does_not_grow(drive: Drive, picked: Served) -> None:
    driven = drive(picked)
    driven.click((10.2, 43.4))
    sizes: list[float] = []
    for _ in range(3):
        for key in ("Shift+ArrowRight", "Shift+ArrowLeft") * 6:
            driven.press(key)
        sizes.append(driven.heap_bytes())
    assert sizes[2] < sizes[0] + 2e6
