"""The page of a rectification: complete, safe, the same each time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from lxml import html

from plumbline.ground.stored import StoredRectification
from plumbline.report.page.ground import ground_page
from tests.cli.process import plumbline
from tests.ground.files import matches, photo, rectified, rows, tapes


def test_the_page_says_what_there_is_to_say(tmp_path: Path) -> None:
    lines = [(*row[:4], "<b>A&B</b>" if row[4] == "A" else row[4]) for row in rows()]
    found = rectified(tmp_path, matches(tmp_path, lines), tapes=tapes(tmp_path, ["BC"]))
    pixels = np.full((384, 512, 3), 120, np.uint8)
    stored = StoredRectification(found, "road.jpg", "0" * 64, "plumbline rectify …")
    page = ground_page(stored, pixels)
    assert page == ground_page(stored, pixels)
    root = html.fromstring(page)
    text = " ".join(root.itertext())
    for told in ("implies a focal length", "unevenness there", "± 0.02 m", "SHA-256", "B-C"):
        assert told in text
    assert "<b>A&B</b>" in text, "a name is text"
    assert not root.xpath("//b[text()='A&B']")
    assert len(root.xpath("//figure")) == 3
    assert "times as large" in text
    assert b"http://" not in page.replace(b"http://www.w3.org", b"")


def test_measurements_stand_on_the_page(tmp_path: Path) -> None:
    how = ("--points", matches(tmp_path), "--ptlens", "b=-0.02", "--no-picture")
    plumbline("rectify", photo(tmp_path), *how, home=tmp_path)
    asked = ("--from", tmp_path / "road_rectified.json", "--place", "A", "--distance", "A,B")
    page = tmp_path / "measured.html"
    done = plumbline("measure", *asked, "-o", page, "--json", home=tmp_path)
    assert done.returncode == 0, done.stderr
    place, distance = json.loads(done.stdout)["measurements"]
    (first, second) = html.fromstring(page.read_bytes()).xpath("//section/table | //section/div")[
        :2
    ]
    assert f"{place['values'][0]:.3f}".replace("-", "−") in " ".join(first.itertext())
    told = " ".join(second.itertext())
    low, high = distance["intervals_95"][0]
    assert "distance A-B" in told
    assert f"{distance['values'][0]:.3f} m" in told
    assert f"{(high - low) / 2:.3f}" in told


def test_report_takes_a_rectification(tmp_path: Path) -> None:
    how = ("--points", matches(tmp_path), "--ptlens", "b=-0.02", "--no-picture")
    plumbline("rectify", photo(tmp_path), *how, home=tmp_path)
    saved = tmp_path / "road_rectified.json"
    done = plumbline("report", saved, home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert b"is not at hand" not in (tmp_path / "road_rectified.html").read_bytes()
    photo(tmp_path, exif=False)
    done = plumbline("report", saved, "--photo", tmp_path / "road.jpg", home=tmp_path)
    assert done.returncode == 1
    assert "another photo" in done.stderr
