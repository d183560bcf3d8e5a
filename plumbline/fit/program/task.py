"""What goes into a compiled fit and what comes out of it, as plain arrays."""

from __future__ import annotations

from typing import NamedTuple

from plumbline.fit.program.blocks import AnyArray, Block


class Residuals(NamedTuple):
    """Residuals of a block in pixels, 0 for padding; shape (rows, width) each.

    Attributes:
        image: Distance in the photograph, in its own pixels.
        corrected: Distance in the corrected photograph.
        determinant: Local area of the corrected photo over that of the photograph.
        excess: How far beyond the fold of the model a point lies; 0 for all good points.
        u: Ideal x from the distortion centre, normalised.
        v: Ideal y.
    """

    image: AnyArray
    corrected: AnyArray
    determinant: AnyArray
    excess: AnyArray
    u: AnyArray
    v: AnyArray


class FitTask(NamedTuple):
    """One fit, as arrays.

    Attributes:
        block: The points.
        start: Start and held values, the distortion centre last and normalised, (k + 2,).
        free: Which coefficients are free, (k + 2,).
        staged: Whether free coefficients are found from nothing; else `start` is taken.
        image: Whether the residual is that in the photograph, else in the corrected one.
        unit_px: Square pixels to a normalised radius of 1.
        gauge_radius: Normalised radius at which the model's scale is 1.
        corner: Normalised radius of the photo's corner.
        aspect: Width of one of the photo's pixels over its height.
    """

    block: Block
    start: AnyArray
    free: AnyArray
    staged: AnyArray
    image: AnyArray
    unit_px: AnyArray
    gauge_radius: AnyArray
    corner: AnyArray
    aspect: AnyArray


class Solution(NamedTuple):
    """What a fit found; arrays as in `FitTask` and `Residuals`.

    Attributes:
        coefficients: Fitted and held values, (k + 2,).
        residual: The residual that was minimised, in pixels, to within the last step; 0 for
            padding and for points of weight 0; (rows, width).
        u: Ideal x of all points from the distortion centre, normalised; NaN beyond the fold.
        v: Ideal y.
        corrected_square: Sum of the squared distances in the corrected photograph.
        scale: Mean scale of the corrected photo at the points, √determinant.
        folded: How many points lie beyond the fold of the model.
        normal: JᵀJ of the kind that was minimised, (k + 2, k + 2), in pixels; a one on the
            diagonal for held coefficients.
        last_step_px: By how much the last Gauss–Newton step changes all residuals together, the
            root of the sum of squares; close to 0 at a minimum, whatever the coefficients' units.
        steps: Steps the solver took.
    """

    coefficients: AnyArray
    residual: AnyArray
    u: AnyArray
    v: AnyArray
    corrected_square: AnyArray
    scale: AnyArray
    folded: AnyArray
    normal: AnyArray
    last_step_px: AnyArray
    steps: AnyArray


EMPTY_TASK = FitTask(Block(0, 0, 0), 0, 0, 0, 0, 0, 0, 0, 0)
"""Only its structure counts."""
