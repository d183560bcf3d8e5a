"""OpenCV's camera matrix and distortion coefficients, written as its YAML.

    import cv2
    store = cv2.FileStorage("lens.yml", cv2.FILE_STORAGE_READ)
    matrix = store.getNode("camera_matrix").mat()
    k = store.getNode("distortion_coefficients").mat()      # k1, k2, p1, p2, k3
    new = store.getNode("new_camera_matrix").mat()
    maps = cv2.initUndistortRectifyMap(matrix, k, None, new, photo.shape[1::-1], cv2.CV_32FC1)
    corrected = cv2.remap(photo, *maps, cv2.INTER_CUBIC)

The principal point is the distortion centre. `new_camera_matrix` makes plumbline's own picture,
at its scale and about the image's centre; for tangential terms of another model it holds a
perspective too, which `cv2.undistort` does not take. Source: OpenCV, `calib3d`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.errors import OptionError
from plumbline.formats.panotools.script import decimal
from plumbline.frame import Array
from plumbline.geometry.lens import Lens

_ORDER = ("k1", "k2", "p1", "p2", "k3")


def opencv_yaml(lens: Lens, homography: Array | None, mark: str) -> bytes:
    """A file for `cv2.FileStorage`.

    Args:
        lens: A lens of the model `opencv`, at square pixels.
        homography: From plumbline's ideal points to those of the lens, both in half shorter sides
            from the image centre, shape (3, 3); None if they are the same.
        mark: A comment for the head.

    Raises:
        OptionError: the lens has no focal length in pixels.
    """
    if lens.focal_px is None:
        raise OptionError("the focal length in pixels is not known", hint="give --focal-px")
    x, y = lens.centre_px
    matrix = (lens.focal_px, 0.0, x, 0.0, lens.focal_px, y, 0.0, 0.0, 1.0)
    rows = [
        "%YAML:1.0",
        "---",
        f"# {mark}",
        f"image_width: {lens.frame.width}",
        f"image_height: {lens.frame.height}",
        *_matrix("camera_matrix", 3, matrix),
        *_matrix("new_camera_matrix", 3, _new_matrix(lens, homography).ravel().tolist()),
        *_matrix("distortion_coefficients", 1, [lens.coefficients[name] for name in _ORDER]),
    ]
    return ("\n".join(rows) + "\n").encode()


def _new_matrix(lens: Lens, homography: Array | None) -> Array:
    """From rays, as OpenCV has them, to pixels of plumbline's corrected picture."""
    radius_px, (x, y) = lens.frame.radius_px, lens.frame.centre_px
    pixels = np.array([[radius_px, 0, x], [0, radius_px, y], [0, 0, 1]])
    rays = np.diag([lens.unit_px / radius_px, lens.unit_px / radius_px, 1.0])
    matrix = pixels @ np.linalg.inv(np.eye(3) if homography is None else homography) @ rays
    return matrix / matrix[2, 2]


def _matrix(name: str, rows: int, values: Sequence[float]) -> list[str]:
    shown = ", ".join(decimal(value) for value in values)
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {len(values) // rows}",
        "   dt: d",
        f"   data: [ {shown} ]",
    ]
