"""The benchmark of lens names, on one maker."""

from __future__ import annotations

from tests.benchmarks.lens_names import CAMERAS, found
from tests.peers.tools import program


def test_nine_of_ten_lenses_are_found_by_exiftool_s_name() -> None:
    results = list(found(program("exiftool"), {"Pentax": CAMERAS["Pentax"]}))
    assert len(results) > 20
    assert sum(each.right for each in results) >= 0.9 * len(results)
