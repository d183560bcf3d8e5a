"""A photo of a painted plane, rendered by supersampling with the independent camera."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.ground.scenes import Scene
from tests.truth import Array


def photograph(scene: Scene, paint: Callable[[Array], Array], samples: int = 3) -> Array:
    """Grey values of a photo of the plane, float, shape (rows, columns); 200 above the horizon.

    Args:
        scene: The camera; its lens is inverted on a table of radii.
        paint: Grey values of places, shape (n, 2) → (n,).
        samples: How often each pixel is sampled across and down.
    """
    width, height = scene.size
    middle, unit = (np.array(scene.size) - 1) / 2, min(scene.size) / 2
    table = np.linspace(0, 2.5, 100_001)
    matrix = scene.matrix
    back = np.linalg.inv(matrix[:, [0, 1, 3]])
    total = np.zeros(height * width)
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    for i in range(samples):
        for j in range(samples):
            move = np.array([(i + 0.5) / samples - 0.5, (j + 0.5) / samples - 0.5])
            points = np.stack((columns, rows), axis=-1).reshape(-1, 2) + move - middle
            radius = np.hypot(*points.T) / unit
            ideal = np.interp(radius, table * (scene.b * table**2 + 1 - scene.b), table)
            points = points * (ideal / np.maximum(radius, 1e-9))[:, None] + middle
            ground = np.column_stack((points, np.ones(len(points)))) @ back.T
            places = ground[:, :2] / ground[:, 2:]
            ahead = places @ matrix[2, :2] + matrix[2, 3] > 0
            total += np.where(ahead, paint(places), 200.0)
    return (total / samples**2).reshape(height, width)


def checker(places: Array, side: float = 0.5) -> Array:
    """Squares of 60 and 180 grey."""
    odd = (np.floor(places[:, 0] / side) + np.floor(places[:, 1] / side)) % 2
    return 60.0 + 120.0 * odd
