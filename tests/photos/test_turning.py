"""Turning pixels upright, against Pillow."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

import plumbline
from plumbline.photos.turning import turned_upright

PIXELS = np.random.default_rng(4).integers(0, 255, (5, 7, 3), dtype=np.uint8)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_it_turns_as_pillow_does(orientation: int) -> None:
    image = Image.fromarray(PIXELS)
    image.getexif()[274] = orientation
    upright = np.asarray(ImageOps.exif_transpose(image))
    assert np.array_equal(turned_upright(PIXELS, orientation), upright)
    grey = turned_upright(PIXELS[..., 0], orientation)
    assert np.array_equal(grey, turned_upright(PIXELS, orientation)[..., 0])


def test_nothing_else_turns_pixels() -> None:
    """Who flips a picture asks this module."""
    package = Path(plumbline.__file__).parent
    flipping = {
        path.name
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.FunctionDef)
        and any(argument.arg == "orientation" for argument in node.args.args)
        and "swapaxes" in ast.unparse(node)
    }
    assert flipping == {"turning.py"}
