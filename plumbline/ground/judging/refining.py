"""Are the refined coefficients of the lens determined well enough to be used?

What counts is the displacement that the coefficients make at the photo's corner: its standard
error must be below 15 % of it. For b alone that is the error of b over b. With half a pixel and a
centimetre about 6 good points do for b, and about 20 for a, b and c.
"""

from __future__ import annotations

import numpy as np

from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.ground.adjusting.adjustment import Adjustment
from plumbline.ground.adjusting.network import SIGMA_CENTRE
from plumbline.ground.camera import CENTRE
from plumbline.ground.optics import Optics
from plumbline.wording import joined, number

ACCEPTED = 0.15
"""Largest share of the displacement that its standard error may be."""


def refuse_unrefined(found: Adjustment, *, centre: bool) -> None:
    """Refuse refined coefficients that the observations do not tell.

    Args:
        found: The adjustment.
        centre: Whether the lens's centre was freed too.

    Raises:
        OptionError: the standard error is too large; the sentence says how large.
    """
    layout, network = found.layout, found.network
    if layout.refined:
        camera = found.state.camera
        covariance = found.cofactor[layout.lens, layout.lens] * found.widening**2
        moved, error = _at_corner(camera.optics, layout.refined, covariance)
        if error > ACCEPTED * abs(moved):
            values = [
                f"{name} = {number(camera.optics.lens.coefficients[index], '.4f')} ± {spread:.4f}"
                for name, index, spread in zip(
                    network.refined, layout.refined, np.sqrt(np.diag(covariance)), strict=True
                )
            ]
            raise OptionError(
                f"the points do not determine {joined(list(network.refined))} well enough: "
                f"{', '.join(values)}, {error:.1f} px of {abs(moved):.1f} px at the corner",
                hint="mark more points, spread to the corners of the photo, or calibrate the lens "
                "from straight lines; lane edges along the view run radially and say nothing "
                "about it",
            )
    if centre:
        limit = SIGMA_CENTRE * found.state.camera.optics.lens.frame.radius_px
        error = float(np.sqrt(np.max(np.diag(found.cofactor)[CENTRE]))) * found.widening
        if error > limit:
            raise OptionError(
                f"the points do not determine the lens's centre well enough: ± {error:.0f} px, and "
                f"without them it is known to {limit:.0f} px",
                hint="leave d,e out of --refine",
            )


def _at_corner(optics: Optics, refined: tuple[int, ...], covariance: Array) -> tuple[float, float]:
    """Displacement that the coefficients make at the farthest corner, and its standard error."""
    corner = optics.undistort(optics.lens.frame.corners_px()[:1])
    _, _, by_lens = optics.with_derivatives(corner)
    rows = by_lens[0][:, list(refined)]
    values = np.array(optics.lens.coefficients)[list(refined)]
    moved = float(np.hypot(*(rows @ values)))
    return moved, float(np.sqrt(np.trace(rows @ covariance @ rows.T)))
