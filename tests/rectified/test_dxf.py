"""The drawing passes ezdxf's own audit, and holds places, frame, lines and ellipses."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from plumbline.ground.ellipses import ellipse
from plumbline.rectified.dxf import dxf_bytes
from tests.ground.files import NAMES, SCENE, rectified

ezdxf = pytest.importorskip("ezdxf")


def test_the_drawing(tmp_path: Path) -> None:
    found = rectified(tmp_path)
    picks = {"S": tuple(SCENE.photo(np.array([[0.5, 12.0]]))[0].tolist())}
    measured = [
        found.measure("distance", ["A", "S"], picks),
        found.measure("area", ["A", "B", "C", "D"]),
    ]
    frame = np.array([[-6.0, 30.0], [6.0, 30.0], [6.0, 2.0], [-6.0, 2.0]])
    text = dxf_bytes(found, picks, measured, frame).decode()
    drawing = ezdxf.read(io.StringIO(text))
    audit = drawing.audit()
    assert not audit.errors
    assert not audit.fixes
    space = drawing.modelspace()
    points = [tuple(point.dxf.location)[:2] for point in space.query("POINT")]
    wanted = np.vstack((found.places_m, found.to_ground([picks["S"]])))
    assert np.allclose(points, wanted, atol=1e-9)
    ellipses = list(space.query('ELLIPSE[layer=="ELLIPSES"]'))
    assert len(ellipses) == len(points)
    long, short, _ = ellipse(found.covariances([picks["S"]])[0])
    assert float(ellipses[-1].dxf.major_axis.magnitude) == pytest.approx(long)
    assert ellipses[-1].dxf.ratio == pytest.approx(short / long)
    texts = {each.dxf.text for each in space.query("TEXT")}
    assert set(NAMES[:7]) <= texts
    (outline,) = space.query('LWPOLYLINE[layer=="FRAME"]')
    assert outline.closed
    assert np.allclose([point[:2] for point in outline.get_points()], frame)
    assert len(space.query('LWPOLYLINE[layer=="MEASURED"]')) == 2
    assert drawing.units == 6, "metres"
