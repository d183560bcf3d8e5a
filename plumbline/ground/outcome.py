"""From an adjustment to a rectification: its covariance, and what adds to it."""

from __future__ import annotations

import numpy as np

from plumbline.frame import Array
from plumbline.ground.adjusting.adjustment import Adjustment
from plumbline.ground.camera import N_STEPS
from plumbline.ground.rectification import Rectification

KINDS = {
    "picks": "picks",
    "points": "points",
    "flatness": "flatness",
    "tapes": "tapes",
    "angles": "tapes",
    "lines": "lines",
    "straight": "lines",
    "horizon": "lines",
    "focal length": "focal length",
    "square": "camera",
    "centre": "lens",
    "lens": "lens",
    "datum": "points",
}
"""Which entry of the budget each kind of observation counts in."""


def rectification_of(found: Adjustment) -> Rectification:
    """What an adjustment says of the photo."""
    into = _placing(found)
    gain = into @ found.cofactor
    scale = found.widening**2
    whole = scale * into @ found.cofactor @ into.T
    seen = N_STEPS + len(found.state.camera.optics.names)
    shares: dict[str, Array] = {}
    for block in found.blocks:
        rows = gain @ block.derivative.T
        share = (scale * rows @ rows.T)[:seen, :seen]
        name = KINDS[block.kind]
        shares[name] = shares[name] + share if name in shares else share
    told = _of_the_lens(found, into)
    if told is not None:
        whole = whole + told
        share = told[:seen, :seen]
        shares["lens"] = shares["lens"] + share if "lens" in shares else share
    network = found.network
    return Rectification(
        found.state.camera,
        network.names,
        network.picks_px,
        found.state.places[:, :2],
        whole,
        shares,
        network.sigma_pick_px,
        network.flatness_m,
        found.widening,
    )


def _placing(found: Adjustment) -> Array:
    """The matrix from the unknowns to camera, all coefficients, and X, Y of the points."""
    layout, optics = found.layout, found.state.camera.optics
    count = len(optics.names)
    matrix = np.zeros((N_STEPS + count + 2 * layout.points, layout.size))
    matrix[:N_STEPS, :N_STEPS] = np.eye(N_STEPS)
    for at, index in enumerate(layout.refined):
        matrix[N_STEPS + index, layout.lens.start + at] = 1.0
    for at, column in enumerate(layout.places.ravel().tolist()):
        matrix[N_STEPS + count + at, column] = 1.0
    return matrix


def _of_the_lens(found: Adjustment, into: Array) -> Array | None:
    """Covariance from what the lens's source says of coefficients that were not adjusted."""
    told = found.network.lens_covariance
    if told is None:
        return None
    names = found.state.camera.optics.names
    held = [index for index in range(len(names)) if index not in found.layout.refined]
    if not held or not np.any(told[np.ix_(held, held)]):
        return None
    gain = into @ found.lens_gain[:, held]
    for at, index in enumerate(held):
        gain[N_STEPS + index, at] += 1.0
    return gain @ told[np.ix_(held, held)] @ gain.T
