"""The one head of LensFun's lenses, whichever writer asks for it."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import plumbline
from plumbline.errors import OptionError
from plumbline.lenses.stored import of_calibration
from plumbline.lenses.zoom.join import join
from plumbline.observations.facts import LensFacts
from plumbline.result.calibration import Calibration
from plumbline.writing.export import export
from plumbline.writing.results import result_bytes
from plumbline.writing.zoom import zoom_bytes
from tests.lenses.made import calibration

PACKAGE = Path(plumbline.__file__).parent
KNOWN = LensFacts(maker="Sigma", model="18-35", mount="EF", focal_mm=18.0, crop_factor=1.5)


def of_a_fit(made: Calibration) -> bytes:
    return result_bytes([made], Path("x.xml"))


def of_an_export(made: Calibration) -> bytes:
    return export(of_calibration(made), "lensfun").content


def of_lenses_txt(made: Calibration) -> bytes:
    return export(of_calibration(made), "lenses-txt").content


def of_a_zoom(made: Calibration) -> bytes:
    return zoom_bytes(join([("x.json", made)]), Path("x.xml"))[0]


Writer = Callable[[Calibration], bytes]
WRITERS = [of_a_fit, of_an_export, of_lenses_txt, of_a_zoom]
every_writer = pytest.mark.parametrize("written", WRITERS)


def known(**facts: object) -> Calibration:
    made = calibration(size=(3000, 2000), b=-0.02)
    observations = replace(made.observations, lenses=(replace(KNOWN, **facts),))  # pyright: ignore[reportArgumentType]
    return replace(made, observations=observations)


@every_writer
def test_an_aspect_ratio_that_contradicts_the_photo(
    written: Callable[[Calibration], bytes],
) -> None:
    assert b"Sigma" in written(known(aspect_ratio=1.49))
    with pytest.raises(OptionError, match=r"1\.778 contradicts the photo's 1\.5"):
        written(known(aspect_ratio=16 / 9))


@every_writer
def test_a_crop_factor_that_is_not_known(written: Writer) -> None:
    with pytest.raises(OptionError, match="the crop factor is not known") as caught:
        written(known(crop_factor=None))
    assert "--crop-factor" in caught.value.hint


@every_writer
def test_labels_that_are_not_known(written: Writer) -> None:
    text = written(known(maker="", model="", mount="", camera="No camera")).decode()
    for word in ("Unknown", "No camera lens", "Generic"):
        assert word in text


def callers(name: str) -> list[str]:
    """The modules that call a name."""
    return [
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name
    ]


def test_there_is_no_second_head() -> None:
    assert callers("LensfunLens") == ["writing/head.py"]
    generic = [p for p in PACKAGE.rglob("*.py") if '"Generic"' in p.read_text("utf-8")]
    assert [p.name for p in generic] == ["head.py"]
