"""One lens in the words of another model, as well as that model can.

A target model with coefficients θ is fitted to the lens over a grid of the whole photo: with p
an observed point, q(p) its ideal point by the lens, and G a common scale and translation (for
lenses with tangential terms a homography), which straight lines cannot see,

    minimise Σ |distort_θ(G q(p)) − p|²   over θ and G

by Levenberg–Marquardt. The deviation is the largest of these distances, in the photo's pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, Model

_GRID = 41
"""Nodes a side; chosen, distortion is smooth between them."""
_MOST_STEPS = 100
"""Chosen: such fits take fewer than ten."""
_STEP = 1e-6
"""For central differences of coefficients near 1: the cube root of rounding, about."""


@dataclass(frozen=True)
class Refit:
    """A lens in another model.

    Attributes:
        lens: The fitted lens.
        deviation_px: How far it moves a point of the photo from where the original does.
        homography: G, from the original's ideal points to those of `lens`, both in half
            shorter sides from the image centre; shape (3, 3).
    """

    lens: Lens
    deviation_px: float
    homography: Array


def refit(lens: Lens, model: Model, *, centre: bool, focal_px: float | None = None) -> Refit:
    """Fit a model whose polynomial runs from ideal to observed to a lens.

    Args:
        lens: The lens, at square pixels.
        model: The model wanted.
        centre: Whether the target can hold a distortion centre.
        focal_px: Focal length in pixels, for models that measure in it.

    Raises:
        FoldedError: the lens folds inside the photo.
    """
    frame = lens.frame
    columns, rows = (np.linspace(0, side - 1, _GRID) for side in frame.size)
    observed_px = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    ideal, observed = (frame.normalise(p) for p in (lens.undistort(observed_px), observed_px))
    unit = (focal_px if model.unit == "focal length" and focal_px else frame.radius_px) / (
        frame.radius_px
    )
    bent = any(lens.coefficients[name] for name in lens.model.tangential)
    names = [n for n in model.coefficients if bent or n not in model.tangential]
    n, n_centre = len(names), 2 if centre else 0

    def off(theta: Array) -> Array:
        values = dict.fromkeys(model.coefficients, 0.0) | dict(zip(names, theta, strict=False))
        c = np.array([values[name] for name in model.coefficients])
        shift = theta[n : n + n_centre] if centre else np.zeros(2)
        q = _moved(ideal, theta[n + n_centre :]) / unit
        mapped = np.stack(model.apply(q[:, 0], q[:, 1], c), axis=-1) * unit + shift
        return (mapped - observed).ravel()

    start = np.zeros(n + n_centre + (8 if bent else 3))
    if centre:
        start[n : n + 2] = [lens.coefficients[name] / frame.radius_px for name in CENTRE]
    theta = _least_squares(off, start)
    shift = theta[n : n + 2] * frame.radius_px if centre else np.zeros(2)
    values = dict.fromkeys(model.coefficients, 0.0) | dict(
        zip((*names, *CENTRE), (float(v) for v in (*theta[:n], *shift)), strict=True)
    )
    distance = np.hypot(*off(theta).reshape(-1, 2).T) * frame.radius_px
    return Refit(
        Lens(model, frame, values, focal_px),
        float(np.max(distance)),
        _matrix(theta[n + n_centre :]),
    )


def _moved(points: Array, g: Array) -> Array:
    """Points after a scale and translation (3 parameters) or a homography (8)."""
    moved = np.column_stack((points, np.ones(len(points)))) @ _matrix(g).T
    return moved[:, :2] / moved[:, 2:]


def _matrix(g: Array) -> Array:
    if len(g) == 3:
        return np.array([[1 + g[0], 0, g[1]], [0, 1 + g[0], g[2]], [0, 0, 1]])
    return np.append(g, 0.0).reshape(3, 3) + np.eye(3)


def _least_squares(off: Callable[[Array], Array], theta: Array) -> Array:
    """Levenberg–Marquardt with central differences and scaled columns."""
    damping, now = 1e-3, off(theta)
    for _ in range(_MOST_STEPS):
        steps = np.eye(len(theta)) * _STEP
        jacobian = np.stack([(off(theta + h) - off(theta - h)) / (2 * _STEP) for h in steps], 1)
        scale = np.linalg.norm(jacobian, axis=0)
        scale[scale == 0] = 1.0
        stacked = np.vstack((jacobian / scale, damping * np.eye(len(theta))))
        wanted = np.concatenate((-now, np.zeros(len(theta))))
        move = np.linalg.lstsq(stacked, wanted, rcond=None)[0] / scale
        after = off(theta + move)
        if not after @ after < now @ now:
            damping *= 10
            if damping > 1e6:
                break
            continue
        gain = 1 - float(after @ after) / float(now @ now)
        theta, now, damping = theta + move, after, max(damping / 10, 1e-12)
        if gain < 1e-12:
            break
    return theta
