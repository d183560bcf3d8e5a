"""OpenCV's camera matrix and distortion coefficients, written as its YAML.

    import cv2
    store = cv2.FileStorage("lens.yml", cv2.FILE_STORAGE_READ)
    matrix = store.getNode("camera_matrix").mat()
    k = store.getNode("distortion_coefficients").mat()      # k1, k2, p1, p2, k3
    corrected = cv2.undistort(photo, matrix, k)

The principal point is the distortion centre, on both sides. Source: OpenCV, `calib3d`.
"""

from __future__ import annotations

from collections.abc import Sequence

from plumbline.errors import OptionError
from plumbline.formats.script import decimal
from plumbline.lens import Lens

_ORDER = ("k1", "k2", "p1", "p2", "k3")


def opencv_yaml(lens: Lens, mark: str) -> bytes:
    """A file for `cv2.FileStorage`.

    Args:
        lens: A lens of the model `opencv`, at square pixels.
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
        *_matrix("distortion_coefficients", 1, [lens.coefficients[name] for name in _ORDER]),
    ]
    return ("\n".join(rows) + "\n").encode()


def _matrix(name: str, rows: int, values: Sequence[float]) -> list[str]:
    shown = ", ".join(decimal(value) for value in values)
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {len(values) // rows}",
        "   dt: d",
        f"   data: [ {shown} ]",
    ]
