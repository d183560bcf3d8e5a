"""The pictures of the README can be taken, and are small."""

from __future__ import annotations

from pathlib import Path

import cv2

from tests.pick.film import film


def test_six_pictures(tmp_path: Path) -> None:
    taken = film(tmp_path)
    assert len(taken) == 6
    for path in taken:
        assert path.stat().st_size < 60_000
        pixels = cv2.imread(str(path))
        assert pixels is not None
        assert pixels.std() > 20
