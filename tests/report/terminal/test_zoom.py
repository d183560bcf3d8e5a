"""A zoom lens on the terminal."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
from rich.console import Console

from plumbline.lenses.zoom.join import join
from plumbline.lenses.zoom.zoom_lens import ZoomLens
from plumbline.report.terminal.zoom import print_zoom
from tests.lenses.made import calibration

FOCALS = (100.0, 180.0, 260.0, 400.0)


def lens(method: str = "polynomial") -> ZoomLens:
    """b and d run along parabolas of the focal length."""
    errors = {"a": 0.001, "b": 0.001, "c": 0.001, "d": 2.0, "e": 2.0}
    made = [
        (f"{f:g}.json", calibration(b=-0.02 + 2e-9 * f**3, d=0.05 * f, focal_mm=f, errors=errors))
        for f in FOCALS
    ]
    return join(made, method, 3)  # type: ignore[arg-type]


def shown(width: int, method: str = "polynomial") -> str:
    out = io.StringIO()
    print_zoom(Console(file=out, width=width), lens(method))
    return out.getvalue()


def test_a_printed_polynomial_gives_the_values_back() -> None:
    text = shown(100).replace("−", "-")
    told = {
        name: [float(number) for number in re.findall(r"([+-][\d.]+(?:e-?\d+)?)(?= |$)", terms)]
        for name, terms in re.findall(r"• (\w)\(f\) = ([^,\n]*)", text)
    }
    for focal in FOCALS:
        assert np.polyval(told["b"], focal) == pytest.approx(-0.02 + 2e-9 * focal**3, abs=1e-7)
        assert np.polyval(told["d"], focal) == pytest.approx(0.05 * focal, abs=1e-4)
    assert re.search(r"d\(f\) = .*, in pixels$", shown(100), re.MULTILINE)


@pytest.mark.parametrize("width", [80, 160])
def test_a_value_is_never_torn(width: int) -> None:
    text = shown(width, "hermite")
    rows = [line for line in text.splitlines() if line.lstrip().startswith("180 mm")]
    assert len(rows) == 1
    assert "−0.008336" in rows[0]
    assert "9.00 px" in rows[0]
    assert not re.search(r"±\s*$", text, re.MULTILINE)
    assert ("± 0.001000" in rows[0]) is (width == 160)
    assert text.count("± 0.001000") == 3 * len(FOCALS)
