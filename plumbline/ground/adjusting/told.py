"""Equations of what is told of camera and lens: focal length, centre, squareness, coefficients."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from plumbline.ground.adjusting.block import Block, ones
from plumbline.ground.adjusting.network import Network
from plumbline.ground.adjusting.state import Layout, State
from plumbline.ground.camera import CENTRE, FOCAL, TURN

_HELD_PX = 1e-6
"""Standard error of a centre that is held: chosen, far below any effect."""


def camera(network: Network, layout: Layout, start: State, state: State) -> Iterator[Block]:
    """Focal length, centre of the lens, and how square the camera was held."""
    if network.focal is not None:
        scale = 1.0
        if layout.refined:  # what EXIF tells belongs to the observed picture
            scale = start.camera.optics.paraxial_scale / state.camera.optics.paraxial_scale
        away = np.log(network.focal.px * scale / state.camera.focal_px) / network.focal.sigma
        rows = ones(np.array([FOCAL]), np.array([-1 / network.focal.sigma]), layout.size)
        yield Block("focal length", np.array([away]), rows, np.zeros(1, dtype=np.int64))
    if np.isfinite(network.sigma_centre_px):
        sigma = max(network.sigma_centre_px, _HELD_PX)
        shift = np.array(start.camera.optics.shift_px) - state.camera.optics.shift_px
        columns = np.arange(layout.size)[CENTRE]
        rows = ones(columns, np.full(2, -1 / sigma), layout.size)
        yield Block("centre", shift / sigma, rows, np.zeros(2, dtype=np.int64))
    if network.sigma_square_rad is not None:
        upright = state.camera.rotation @ np.array([0.0, 0.0, 1.0])
        rows = np.zeros((2, layout.size))
        rows[:, TURN] = -np.array([[0, upright[2], -upright[1]], [-upright[2], 0, upright[0]]])
        rows /= network.sigma_square_rad
        residuals = -upright[:2] / network.sigma_square_rad
        yield Block("square", residuals, rows, np.zeros(2, dtype=np.int64))


def lens(network: Network, layout: Layout, start: State, state: State) -> Iterator[Block]:
    """What the lens's source says of refined coefficients, where it says anything."""
    if network.lens_covariance is None or not layout.refined:
        return
    chosen = list(layout.refined)
    covariance = network.lens_covariance[np.ix_(chosen, chosen)]
    told = np.isfinite(np.diag(covariance)) & (np.diag(covariance) > 0)
    if not told.any():
        return
    columns = np.arange(layout.size)[layout.lens][told]
    root = np.linalg.inv(np.linalg.cholesky(covariance[np.ix_(told, told)]))
    values = (np.array(each.camera.optics.lens.coefficients) for each in (start, state))
    away = np.subtract(*values)[chosen][told]
    rows = np.zeros((len(columns), layout.size))
    rows[:, columns] = -root
    yield Block(
        "lens", np.asarray(root @ away, np.float64), rows, np.zeros(len(columns), dtype=np.int64)
    )
