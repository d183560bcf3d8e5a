"""Points as Python users have them: NaN, masks, OpenCV's shape, and what is none of these."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.errors import OptionError
from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model

LENS = Lens(
    get_model("ptlens"), Frame(300, 200), {"a": 0.0, "b": -0.05, "c": 0.0, "d": 3.0, "e": 0.0}
)
POINTS = np.array([[10.0, 20.0], [150.0, 90.0], [290.0, 180.0]])


@pytest.mark.parametrize("name", ["undistort", "distort"])
def test_points_that_are_not_there(name: str) -> None:
    mapped = getattr(LENS, name)
    whole = mapped(POINTS)
    half = POINTS.copy()
    half[1, 0] = np.nan
    out = mapped(half)
    assert np.isnan(out[1]).all()
    np.testing.assert_array_equal(out[[0, 2]], whole[[0, 2]])
    assert not np.isnan(half[1, 1])
    masked = np.ma.masked_array(POINTS, [[False, False], [False, True], [False, False]])
    out = mapped(masked)
    assert isinstance(out, np.ma.MaskedArray)
    assert out.mask.tolist() == [[False, False], [True, True], [False, False]]
    np.testing.assert_array_equal(out.data[[0, 2]], whole[[0, 2]])


@pytest.mark.parametrize("name", ["undistort", "distort"])
def test_opencv_s_corners(name: str) -> None:
    mapped = getattr(LENS, name)
    assert mapped(POINTS[:, None].astype(np.float32)).shape == (3, 1, 2)
    np.testing.assert_allclose(mapped(POINTS[:, None])[:, 0], mapped(POINTS), atol=1e-12)
    np.testing.assert_allclose(mapped(POINTS[0]), mapped(POINTS)[0], atol=1e-12)


@pytest.mark.parametrize("wrong", ["text", None, [[1, 2], [3]], 5.0, [[1, 2, 3]], [["a", "b"]]])
def test_what_is_not_points_is_refused_in_words(wrong: Any) -> None:
    for mapped in (LENS.undistort, LENS.distort):
        with pytest.raises(OptionError, match=r"^the points ") as caught:
            mapped(wrong)
        assert "--" not in caught.value.hint


def test_observations_from_masked_and_opencv_s_arrays() -> None:
    line = np.array([[10.0, 10], [50, 12], [90, 11], [140, 10]])
    masked = np.ma.masked_array(line, [[False, False]] * 3 + [[True, False]])
    found = plumbline.Observations.from_arrays([masked, line[:, None] + [0, 80]], size=(300, 200))
    assert [len(each.points_px) for each in found.lines] == [3, 4]
    assert found.notes == ("1 masked point left out",)
    assert repr(found) == "<Observations: 7 points on 2 lines in 1 photo>"
