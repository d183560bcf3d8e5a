"""An independent truth for rectification: a pinhole camera over a road, written from scratch.

It imports nothing of plumbline. The lens is `tests.truth`'s, which inverts by bisection; the
camera is a homogeneous projection matrix, K [R | t].
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tests.truth import Array, TrueLens

COOLPIX = (2048, 1536)
COOLPIX_FOCAL_PX = 8.2 / 7.18 * 2048
"""Nikon Coolpix 995 at 8.2 mm; its sensor is 7.18 mm wide."""


@dataclass(frozen=True)
class Scene:
    """A camera over the plane z = 0.

    Attributes:
        height: Of the camera, metres; it stands over (0, 0).
        pitch: Degrees downwards.
        heading: Degrees clockwise from y.
        roll: Degrees clockwise.
        focal: Pixels, of the ideal picture.
        b: Of the a, b, c model; the others are 0.
        shift: The lens's centre from the image's, pixels.
        size: Of the photo.
    """

    height: float = 1.6
    pitch: float = 9.0
    heading: float = 0.0
    roll: float = 0.5
    focal: float = COOLPIX_FOCAL_PX
    b: float = -0.02
    shift: tuple[float, float] = (0.0, 0.0)
    size: tuple[int, int] = field(default=COOLPIX)

    @property
    def lens(self) -> TrueLens:
        """The distortion."""
        return TrueLens("ptlens", {"b": self.b}, self.size)

    @property
    def matrix(self) -> Array:
        """K [R | t] from (x, y, z, 1) to homogeneous ideal pixels."""
        p, h, r = np.radians([self.pitch, self.heading, self.roll])
        about_z = np.array([[np.cos(h), -np.sin(h), 0], [np.sin(h), np.cos(h), 0], [0, 0, 1]])
        # x right, y ahead, z up → right, down, forward of a level camera that looks along y
        level = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
        tilt = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
        spin = np.array([[np.cos(r), np.sin(r), 0], [-np.sin(r), np.cos(r), 0], [0, 0, 1]])
        rotation = spin @ tilt @ level @ about_z
        middle = (np.array(self.size) - 1) / 2
        k = np.array([[self.focal, 0, middle[0]], [0, self.focal, middle[1]], [0, 0, 1]])
        return k @ np.column_stack((rotation, -rotation @ np.array([0, 0, self.height])))

    def photo(self, ground: Array, lift: Array | float = 0.0) -> Array:
        """Observed pixels of places (n, 2) that lie `lift` above the plane."""
        z = np.broadcast_to(lift, len(ground))
        seen = np.column_stack((ground, z, np.ones(len(ground)))) @ self.matrix.T
        assert np.all(seen[:, 2] > 0), "behind the camera"
        return self.lens.distort(seen[:, :2] / seen[:, 2:]) + np.array(self.shift)

    def shows(self, ground: Array) -> bool:
        """Whether all places lie inside the photo."""
        return bool(np.all(self.lens.inside(self.photo(ground))))

    def with_(self, **changes: object) -> Scene:
        """The scene with other values."""
        return replace(self, **changes)  # pyright: ignore[reportArgumentType]
