"""What the lens does to a rectified road: errors outside of the quadrilateral, uncorrected or not.

    python -m tests.benchmarks.figure_eight

The literature lays a rectified photograph over an aerial picture: four points fit, and outside of
them the road bends unless the lens is corrected. Here a scene with the Coolpix 995's distortion
(b = −0.02) is rectified by four exact points, once as if there were no distortion and once with the
lens, and once more with b off by its standard error of 0.001. The error is that of the places at 25
to 30 m. What theory predicts for the uncorrected one is a homography through the four distorted
points, computed from the independent camera alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plumbline.ground.adjusting.adjustment import adjust
from plumbline.ground.adjusting.network import Network
from plumbline.ground.outcome import rectification_of
from tests.benchmarks.road_scenes import EYE, HIGH, optics
from tests.ground.scenes import Scene
from tests.truth import Array

CORNERS = {
    "1.6 m": (EYE, np.array([[-1.3, 3.6], [1.3, 3.6], [1.5, 6.0], [-1.5, 6.0]])),
    "5 m": (HIGH, np.array([[-2.5, 6.8], [2.5, 6.8], [2.4, 9.0], [-2.4, 9.0]])),
}
FAR = np.array([[x, y] for y in (25.0, 27.5, 30.0) for x in (-3.0, 0.0, 3.0)])


@dataclass(frozen=True)
class Row:
    """Root mean squared errors of the far places, metres."""

    height: str
    uncorrected: float
    predicted: float
    nearly: float
    corrected: float


def measured(scene: Scene, corners: Array, b: float) -> float:
    """Error of the far places where the lens is taken to have this b."""
    network = Network(
        tuple("ABCD"), scene.photo(corners), corners, np.full(4, 0.001), flatness_m=1e-4
    )
    lens = optics(scene.with_(b=b))
    found = rectification_of(adjust(network, lens))
    return _rms(found.to_ground(scene.photo(FAR)) - FAR)


def predicted(scene: Scene, corners: Array) -> float:
    """The same without any lens, by the homography through the four points as observed."""
    seen, far = scene.photo(corners), scene.photo(FAR)
    matrix = cv2.getPerspectiveTransform(seen.astype(np.float32), corners.astype(np.float32))
    places = np.column_stack((far, np.ones(len(far)))) @ np.asarray(matrix).T
    return _rms(places[:, :2] / places[:, 2:] - FAR)


def _rms(away: Array) -> float:
    return float(np.sqrt(np.nanmean(np.sum(away**2, axis=1))))


def rows() -> list[Row]:
    """Both heights."""
    return [
        Row(
            height,
            measured(scene, corners, 0.0),
            predicted(scene, corners),
            measured(scene, corners, scene.b + 0.001),
            measured(scene, corners, scene.b),
        )
        for height, (scene, corners) in CORNERS.items()
    ]


def main() -> None:
    """Print the table."""
    print("height  uncorrected  by theory  b off by .001  corrected   (m at 25 to 30 m)")
    for row in rows():
        print(
            f"{row.height:7} {row.uncorrected:11.3f} {row.predicted:10.3f} {row.nearly:14.3f} "
            f"{row.corrected:10.4f}"
        )


if __name__ == "__main__":
    main()
