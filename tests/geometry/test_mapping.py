"""One mapping for lenses and photos, on either side, that knows where a model folds."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline.errors import FoldedError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.lenses.mapping import PhotoLens
from plumbline.models import get_model
from plumbline.models.base import Direction

FRAME = Frame(3001, 2001)
WAYS: tuple[Direction, ...] = ("ideal to observed", "observed to ideal")

# r f(r) with one coefficient, and the radius at which its derivative vanishes, by hand:
# ptlens (1 - b + b r²) r with b = -0.4: 1.4 = 1.2 r²; poly3 the same; radial (1 + k1 r²) r.
FOLDS = {
    "ptlens": ({"b": -0.4}, (1.4 / 1.2) ** 0.5),
    "poly3": ({"k1": -0.4}, (1.4 / 1.2) ** 0.5),
    "brown": ({"k1": -0.25}, (1 / 0.75) ** 0.5),
}


def values(name: str, given: dict[str, float]) -> dict[str, float]:
    return dict.fromkeys((*get_model(name).coefficients, "d", "e"), 0.0) | given


@pytest.mark.parametrize("name", FOLDS)
@pytest.mark.parametrize("beyond", [1.02, 3.0, 300.0])
@pytest.mark.parametrize("way", WAYS)
def test_beyond_the_fold_nothing_is_mapped(name: str, beyond: float, way: Direction) -> None:
    given, fold = FOLDS[name]
    model, every = get_model(name), values(name, given)
    vector = tuple(every[each] for each in model.coefficients)
    factor = float(model.factor(np.float64(fold), vector))
    last = fold if way == model.direction else fold * factor
    points = np.array([[0.98 * last, 0.0], [0.0, beyond * last], [np.nan, 0.0]])
    mapping = model.distort if way == "ideal to observed" else model.undistort
    mapped = mapping(points, np.array(vector), 1.0)
    assert np.isfinite(mapped[0]).all()
    assert np.isnan(mapped[1:]).any(axis=-1).all()
    lens = Lens(model, FRAME, every)
    photo = PhotoLens(FRAME, model, vector, FRAME.radius_px)
    pixels = FRAME.to_pixels(points)
    for each in (lens, photo):
        mapping = each.distort if way == "ideal to observed" else each.undistort
        with pytest.raises(FoldedError, match="1 of the"):
            mapping(pixels)
        np.testing.assert_allclose(mapping(pixels[:1]), FRAME.to_pixels(mapped[:1]), atol=1e-9)


def test_no_second_function_maps_points() -> None:
    """A model is run, or inverted, in one module of the library beside the fit's programs."""
    allowed = {
        "models": {"apply", "invert"},  # the equation itself, and its mapping both ways
        "fit/program": {"apply"},  # compiled, with the excess beyond the fold as a penalty
        "geometry/derivatives.py": {"apply"},  # by coefficients, at points mapped already
        "ground/optics.py": {"apply"},  # by coefficients, at points mapped already
        "writing/refit.py": {"apply"},  # the unknown model of a least-squares problem
        "lenses/zoom/needs.py": {"apply"},  # one polynomial against another, no picture
    }
    package = Path(plumbline.__file__).parent
    for path in sorted(package.rglob("*.py")):
        place = path.relative_to(package).as_posix()
        granted = {
            word for part, words in allowed.items() if place.startswith(part) for word in words
        }
        calls = [
            node.func
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
            if isinstance(node, ast.Call)
        ]
        names = {
            each.attr if isinstance(each, ast.Attribute) else getattr(each, "id", "")
            for each in calls
        }
        assert (names & {"apply", "invert"}) <= granted, place
