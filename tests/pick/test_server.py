"""The server as a process: who gets in, what is refused, what survives."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Generator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import msgspec
import pytest
from PIL import Image

import plumbline
from tests.pick.served import FACADE, ROOT, Served, bent_lines, photo_file, served

LINES = bent_lines((2256, 1504))


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Generator[Served]:
    photo = tmp_path_factory.mktemp("photo") / "facade.jpg"
    shutil.copy(FACADE, photo)
    with served(photo) as found:
        yield found


def error_of(photo: str | Path, *more: str | Path) -> str:
    """What a call that fails says."""
    with pytest.raises(RuntimeError) as caught, served(photo, *more):
        pass
    said = str(caught.value)
    assert "Traceback" not in said
    return said


def test_the_page_and_its_files(server: Served) -> None:
    status, headers, content = server.ask("")
    assert status == 200
    assert b"<!DOCTYPE html>" in content
    assert "script-src 'self'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    for name in ("main.js", "style.css", "icon.svg"):
        assert server.ask(name)[0] == 200


@pytest.mark.parametrize(
    "path",
    ["../__init__.py", "..%2f..%2f..%2fetc%2fpasswd", "/etc/passwd", "%2e%2e/document.py",
     "__init__.py", "page/../../files.py", "main.js/", "\\..\\x"],
)  # fmt: skip
def test_no_other_file_can_be_reached(path: str, server: Served) -> None:
    status, _, content = server.ask(path)
    assert status in (400, 404)
    assert b"import" not in content
    assert b"root:" not in content


@pytest.mark.parametrize("secret", ["/", "/x/", "/../", "//"])
def test_without_the_secret_nothing_is_told(secret: str, server: Served) -> None:
    status, _, content = server.ask("state", secret=secret)
    assert status == 404
    assert content == b"Not found.\n"


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1:1"},
        {"Host": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},
    ],
)
def test_no_other_page_can_read(headers: dict[str, str], server: Served) -> None:
    assert server.ask("state", **headers)[0] in (400, 403)


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": ""},
        {"Origin": "http://evil.example"},
        {"Content_Type": "text/plain"},
        {"Content_Type": "application/x-www-form-urlencoded"},
        {"Host": "evil.example"},
    ],
)
def test_no_other_page_can_change_anything(headers: dict[str, str], server: Served) -> None:
    before = server.state()["lines"]
    body = {"page": "p", "action": {"do": "draw", "photo": 0, "clicks": [[1, 1]], "snap": False}}
    headers = {name.replace("Content_Type", "Content-Type"): v for name, v in headers.items()}
    assert server.ask("act", body, **headers)[0] == 403
    assert server.ask("act", body, method="PUT")[0] == 403
    assert server.state()["lines"] == before


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"\xff",
        b"[" * 50_000,
        {"page": "p"},
        {"page": "p" * 41, "action": {"do": "undo"}},
        {"page": "p", "action": {"do": "format disk"}},
        {"page": "p", "action": {"do": "draw", "photo": 0, "clicks": [], "snap": False}},
        {"page": "p", "action": {"do": "draw", "photo": 0, "clicks": [[1e300, 1]], "snap": False}},
        {"page": "p", "action": {"do": "draw", "photo": 9, "clicks": [[1, 1]], "snap": False}},
        {"page": "p", "action": {"do": "remove", "line": 10**9}},
        {"page": "p", "action": {"do": "undo", "more": 1}},
    ],
)
def test_nonsense_is_refused_in_a_sentence(body: object, server: Served) -> None:
    status, _, content = server.ask("act", body)
    assert status == 400
    assert msgspec.json.decode(content)["error"]


def test_a_request_that_is_too_large_is_refused(server: Served) -> None:
    status, _, _ = server.ask("act", b" " * 200_000)
    assert status == 413


@pytest.mark.parametrize("path", ["tiles/0/99/0/0", "tiles/0/0/99/0", "tiles/7/0/0/0"])
def test_tiles_that_are_not_there(path: str, server: Served) -> None:
    assert server.ask(path)[0] == 400


def children(pid: int) -> set[str]:
    """The processes that a process began, as Linux lists them."""
    found: set[str] = set()
    for status in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it ended meanwhile
            state, parent = status.read_text().rpartition(")")[2].split()[:2]
            if parent == str(pid) and state != "Z":
                found.add(status.parent.name)
    return found


def gone(processes: set[str]) -> None:
    """Wait until none of these processes runs."""
    for _ in range(300):
        if not any(running(each) for each in processes):
            return
        time.sleep(0.1)
    raise AssertionError("a process outlived its server")


def running(process: str) -> bool:
    with contextlib.suppress(OSError):
        return Path("/proc", process, "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def test_lines_make_a_lens_and_are_saved_at_once(tmp_path: Path) -> None:
    photo = tmp_path / "facade.jpg"
    shutil.copy(FACADE, photo)
    with served(photo) as server:
        drawn = [server.act(do="draw", photo=0, clicks=clicks, snap=False) for clicks in LINES]
        told = drawn[-1]
        # An ideal radius of r (1 + k1 r²) is a barrel: the photo shows corners drawn in.
        assert told["fit"]["corner_px"] < 0
        assert told["fit"]["sigma_px"] == pytest.approx(0.2, rel=0.35)
        assert len(told["fit"]["lines"]) == len(LINES)
        server.act(do="remove", line=2)
        before = server.act(do="undo")["lines"]
        helpers = children(server.process.pid)
        server.process.send_signal(signal.SIGKILL)
        server.process.wait(timeout=30)
    assert helpers or sys.platform != "linux"
    gone(helpers)
    with served(photo) as server:
        state = server.state()
        assert state["lines"] == before
        assert state["redo"] == "delete line 2"
        for _ in LINES:
            state = server.act(do="undo")
        assert state["lines"] == []


def test_actions_in_quick_succession_never_wait_for_each_other(tmp_path: Path) -> None:
    with served(photo_file(tmp_path / "a.png", (2256, 1504))) as server:
        for clicks in LINES:
            server.act(do="draw", photo=0, clicks=clicks, snap=False)
        for _ in range(3):
            for number in range(1, len(LINES) + 1):
                server.act(do="remove", line=number)
            for _ in LINES:
                server.act(do="undo")
        assert len(server.state()["lines"]) == len(LINES)


def test_the_background_says_what_is_suspicious_and_where_to_pick_next(tmp_path: Path) -> None:
    photo = tmp_path / "facade.jpg"
    shutil.copy(FACADE, photo)
    wrong = [list(line) for line in LINES]
    wrong[0][3] = (wrong[0][3][0] + 25, wrong[0][3][1])  # across: the line runs down
    with served(photo) as server:
        for clicks in wrong:
            server.act(do="draw", photo=0, clicks=clicks, snap=False)
        judged = waited(server, len(wrong))
    assert [each["line"] for each in judged["suspects"]] == [1]
    assert judged["suspects"][0]["points"] == [pytest.approx(wrong[0][3], abs=1e-3)]
    assert len(judged["map"]["values"]) == judged["map"]["columns"] * judged["map"]["rows"]


def waited(server: Served, revision: int) -> Any:
    """The judgement of a revision, once it is there."""
    for _ in range(300):
        judgement = server.state()["judgement"]
        if judgement.get("revision") == revision:
            return judgement
        time.sleep(0.1)
    raise AssertionError("no judgement came")


def test_finish_writes_what_fit_writes_and_a_report(tmp_path: Path) -> None:
    photo = tmp_path / "facade.jpg"
    shutil.copy(FACADE, photo)
    with served(photo, "--mount", "Nikon F AF") as server:
        for clicks in LINES:
            server.act(do="draw", photo=0, clicks=clicks, snap=False)
        status, _, content = server.ask("finish", {"page": "test"})
    told = msgspec.json.decode(content)
    assert status == 200, told
    assert [Path(name).name for name in told["files"]] == [
        "facade.fit.pto", "facade.fit.xml", "facade.fit.html",
    ]  # fmt: skip
    assert "Nikon F AF" in (tmp_path / "facade.fit.xml").read_text()
    assert "facade.jpg" in (tmp_path / "facade.fit.html").read_text()
    again = plumbline.read(tmp_path / "facade.fit.pto")
    assert len(again.lines) == len(LINES)


def test_points_of_any_format_are_taken_once(tmp_path: Path) -> None:
    for name in ("facade.jpg", "picks.csv"):
        shutil.copy(FACADE.with_name(name), tmp_path / name)
    for _ in range(2):
        with served(tmp_path / "facade.jpg", tmp_path / "picks.csv") as server:
            state = server.state()
            assert len(state["lines"]) == 14
            assert state["undo"] == "take the lines of picks.csv"


def test_a_second_page_is_told(server: Served) -> None:
    events = HTTPConnection("127.0.0.1", server.place.port or 0, timeout=30)
    events.request("GET", f"{server.place.path}events/one", headers={"Host": server.place.netloc})
    stream = events.getresponse()
    assert stream.readline().startswith(b":")
    server.ask("take", {"page": "one"})
    status, _, content = server.ask("act", {"page": "two", "action": {"do": "undo"}})
    assert status == 400
    assert "another page" in msgspec.json.decode(content)["error"]
    server.ask("take", {"page": "two"})
    heard = b""
    while b'event: holder\ndata: "two"' not in heard:  # the connection's timeout ends it
        heard += stream.readline()
    server.act(page="two", do="undo")
    stream.close()
    events.close()


def test_a_second_program_is_told(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    with served(photo):
        assert "open in another plumbline pick" in error_of(photo)


def test_bad_calls(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    (tmp_path / "none.jpg").write_bytes(b"\xff\xd8\xff nonsense")
    other = photo_file(tmp_path / "b.png", (500, 400))
    (tmp_path / "picks.csv").write_text("line,x,y\n1,1,1\n1,2,2\n1,700,3\n")
    assert "no such photo" in error_of(tmp_path / "missing.jpg")
    assert "not a picture that can be read" in error_of(tmp_path / "none.jpg")
    assert "none of the files is a photo" in error_of(tmp_path / "picks.csv")
    assert "not photos of one lens" in error_of(photo, other)
    assert "lies outside" in error_of(photo, tmp_path / "picks.csv")
    assert "named twice" in error_of(photo, photo)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert f"port {port} cannot be used" in error_of(photo, "--port", str(port))


def test_picks_of_another_size_are_refused(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    with served(photo) as server:
        server.act(do="draw", photo=0, clicks=[[1, 1], [2, 2]], snap=False)
    before = (tmp_path / "a.plumbline.json").read_bytes()
    photo_file(photo, (300, 200))
    assert "made at 600x400" in error_of(photo)
    assert (tmp_path / "a.plumbline.json").read_bytes() == before


def test_without_a_browser_the_address_is_printed(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    hidden = {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"}
    process = subprocess.Popen(
        [sys.executable, "-m", "plumbline", "pick", photo],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        env={name: value for name, value in os.environ.items() if name not in hidden},
    )
    assert process.stdout is not None
    lines = [process.stdout.readline() for _ in range(3)]
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=30)
    assert "http://127.0.0.1:" in lines[0]
    assert "No browser could be opened" in lines[1]


def test_a_photo_that_vanishes_keeps_its_page(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    with served(photo) as server:
        assert server.ask("tiles/0/0/0/0")[0] == 200
        photo.unlink()
        assert server.ask("tiles/0/1/0/0")[0] == 200
        told = server.act(do="draw", photo=0, clicks=[[1, 1], [2, 2]], snap=False)
        assert len(told["lines"]) == 1


def test_a_photo_that_is_cut_short_is_said_to_pages_that_open_later(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.jpg", (1200, 800))
    photo.write_bytes(photo.read_bytes()[:-4000])
    with served(photo) as server:
        assert server.ask("tiles/0/0/0/0")[0] == 400  # answered once it is decoded, or cannot be
        assert "cut short" in told_of(server)


def test_another_photo_under_the_same_name_is_told(tmp_path: Path) -> None:
    photo = photo_file(tmp_path / "a.png")
    picks = tmp_path / "a.plumbline.json"
    with served(photo) as server:
        server.ask("tiles/0/0/0/0")
        for _ in range(100):
            if msgspec.json.decode(picks.read_bytes())["photos"][0]["sha256"]:
                break
            time.sleep(0.1)
        Image.effect_noise((600, 400), 50).save(photo)
        assert "was changed after it was opened" in told_of(server)
    with served(photo) as server:
        assert "changed since the picks were made" in told_of(server)


def told_of(server: Served) -> str:
    """What a page that opens is told of the photos, once something is."""
    for _ in range(100):
        if trouble := server.state()["trouble"]:
            return trouble
        time.sleep(0.1)
    raise AssertionError("nothing is told")
