"""The page in a browser: light, dark and as PDF, without a complaint on the console."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plumbline.report.page.document import Assignment, Part, page_bytes
from plumbline.report.photos import find_photos
from tests.report.made import building, hostile

_QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--enable-logging=stderr",
    "--v=0",
)
_DARK, _LIGHT = 0, 1


def chromium(folder: Path, page: Path, *options: str) -> str:
    """Run the browser on a page; what the page wrote to its console."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("chromium is not installed, so the page is not rendered")
    done = subprocess.run(
        [program, *_QUIET, f"--user-data-dir={folder / 'profile'}", *options, page.as_uri()],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return "\n".join(line for line in done.stderr.splitlines() if "CONSOLE" in line)


@pytest.fixture
def page(tmp_path: Path) -> Path:
    made = [building(), hostile()]
    parts = [Part(m, f) for m, f in zip(made, find_photos(made, None), strict=True)]
    path = tmp_path / "building.html"
    path.write_bytes(page_bytes(parts, Assignment()))
    return path


@pytest.mark.parametrize(("scheme", "dark"), [(_LIGHT, False), (_DARK, True)])
def test_on_the_screen(scheme: int, dark: bool, page: Path, tmp_path: Path) -> None:
    shot = tmp_path / "shot.png"
    said = chromium(
        tmp_path,
        page,
        f"--blink-settings=preferredColorScheme={scheme}",
        "--window-size=1000,3000",
        f"--screenshot={shot}",
    )
    assert not said
    with Image.open(shot) as image:
        pixels = np.asarray(image.convert("L")).astype(int)
    ground = np.median(pixels[:, :20])
    assert (ground < 50) if dark else (ground > 240)
    # Text and drawings stand out from the ground down the whole page.
    contrast = np.abs(pixels[:, 40:960] - ground).max(axis=1).reshape(30, 100).max(axis=1)
    assert np.all(contrast > 100)


def test_the_console_would_be_heard(tmp_path: Path) -> None:
    page = tmp_path / "loud.html"
    page.write_text("<!DOCTYPE html><script>console.error('loud')</script>")
    assert "loud" in chromium(tmp_path, page, f"--screenshot={tmp_path / 'shot.png'}")


def test_on_paper(page: Path, tmp_path: Path) -> None:
    pdf = tmp_path / "building.pdf"
    said = chromium(
        tmp_path,
        page,
        "--blink-settings=preferredColorScheme=0",
        "--no-pdf-header-footer",
        f"--print-to-pdf={pdf}",
    )
    assert not said
    assert pdf.read_bytes().startswith(b"%PDF")
    program = shutil.which("pdftoppm")
    if program is None:
        pytest.skip("pdftoppm is not installed, so the pages are not looked at")
    subprocess.run([program, "-r", "40", "-png", pdf, tmp_path / "sheet"], check=True, timeout=60)
    sheets = sorted(tmp_path.glob("sheet*.png"))
    # Eleven figures, one a sheet at most, and five sheets of tables, picks and provenance.
    assert 4 <= len(sheets) <= 18
    for sheet in sheets:
        with Image.open(sheet) as image:
            width, height = image.size
            pixels = np.asarray(image.convert("L")).astype(int)
        assert height / width == pytest.approx(297 / 210, abs=0.02)
        # On paper the ground is white whatever the screen's, and the margins are empty.
        assert pixels.max() == 255
        assert np.median(pixels) > 240
        assert pixels[:, :15].min() > 240
        assert pixels[:, -15:].min() > 240
