"""What stops a meaningless fit: sentences that say why, and the remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import CollapsedFitError, DegenerateLinesError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.geometry.lines import direction
from plumbline.observations.picks import Line
from plumbline.wording import count

_NOISE_FLOOR_PX = 0.1
"""Chosen, because nobody picks better than a tenth of a pixel."""
_WORST_CORNER = 0.5
"""Share of half the shorter side: chosen, because such a correction is worth nothing."""
_SCALES = 0.6, 4.0
"""Chosen, because the strongest action cameras scale by 0.8 to 2.8."""
_LEAST_BEND_PX = 2.0
"""Chosen, because a change of magnification by one is more than any lens has."""
_CENTRAL = 0.02
"""Share of half the shorter side within which a line counts as central: chosen."""
_BENT = 1 / 30
"""Share of half the shorter side: chosen, 30 px of 1,000, which careless picks do not reach."""
_HINT_MORE = "pick more lines, longer ones and nearer to the edges of the photo, in both directions"


def reach_of_lines(points: Array, sizes: NDArray[np.int64]) -> tuple[Array, Array]:
    """How far lines are from the distortion centre, and how far they reach to either side.

    Args:
        points: Observed points about the distortion centre, line after line, shape (n, 2).
        sizes: Number of points of each line.

    Returns:
        Distance from the centre and half the length of each line, shape (l,).
    """
    starts = np.cumsum(sizes) - sizes
    centres = np.add.reduceat(points, starts) / sizes[:, None]
    x, y = (points - np.repeat(centres, sizes, axis=0)).T
    cosine, sine = direction(*(np.add.reduceat(v, starts) for v in (x * x, x * y, y * y)))
    along = np.abs(x * np.repeat(cosine, sizes) + y * np.repeat(sine, sizes))
    distance = np.abs(centres[:, 1] * cosine - centres[:, 0] * sine)
    return distance, np.maximum.reduceat(along, starts)


def refuse_blind(
    distance: Array, half_length: Array, radius_px: float, *, known_centre: bool
) -> None:
    """Stop where no line can show any distortion, before a fit is tried.

    An ideal line at a distance h from the distortion centre, reaching L to either side of its
    middle, is bent by b h L² where the magnification changes by b r².

    Args:
        distance: Distance of each line from the distortion centre, in units of R.
        half_length: How far it reaches to either side of its middle.
        radius_px: R in pixels.
        known_centre: Whether the distortion centre is held.

    Raises:
        DegenerateLinesError: a change of magnification by one would bend no line by two pixels.
    """
    if np.max(distance * half_length**2) * radius_px >= _LEAST_BEND_PX:
        return
    why = "every line runs through the centre or is too short to show a bend"
    if np.max(distance) < _CENTRAL and known_centre:
        why = (
            "every line runs through the centre of the distortion, where lines stay straight "
            "whatever it is"
        )
    elif np.min(distance) > _CENTRAL:
        why = "every line is too short to show a bend"
    raise DegenerateLinesError(
        f"the lines carry no information about the distortion: {why}", hint=_HINT_MORE
    )


def degrees_of_freedom(n_points: int, n_lines: int, n_free: int) -> int:
    """Points − 2 · lines − free coefficients.

    Raises:
        DegenerateLinesError: there are not more points than unknowns.
    """
    dof = n_points - 2 * n_lines - n_free
    if dof < 1:
        raise DegenerateLinesError(
            f"{count(n_points, 'point')} on {count(n_lines, 'line')} cannot determine "
            f"{count(n_free, 'coefficient')}: "
            f"{2 * n_lines + n_free + 1} points are the least",
            hint="pick more points on each line, or free fewer coefficients with --free",
        )
    return dof


def refuse_undetermined(*, unseen: bool, mixed: bool) -> None:
    """Stop where JᵀJ is singular.

    Args:
        unseen: Some free coefficient moves no residual.
        mixed: Some combination of them does not.

    Raises:
        DegenerateLinesError: either is so.
    """
    if unseen:
        raise DegenerateLinesError(
            "the lines carry no information about some free coefficient",
            hint=_HINT_MORE + "; without distortion the centre cannot be found",
        )
    if mixed:
        raise DegenerateLinesError(
            "the lines cannot tell the free coefficients apart",
            hint=_HINT_MORE + ", or free fewer coefficients with --free",
        )


def refuse_unobservable(
    centre_px: float, corner_px: float, radius_px: float, sigma_px: float
) -> None:
    """Stop where the lines leave the distortion open.

    Args:
        centre_px: Standard error of the distortion centre for σ = 1 px, its larger coordinate.
        corner_px: The largest one of the radial displacement up to the corner.
        radius_px: R in pixels.
        sigma_px: σ̂; at least 0.1 px is assumed, since nobody picks better.

    Raises:
        DegenerateLinesError: the standard error of the radial displacement exceeds half of R
            somewhere up to the corner, or that of the distortion centre R itself.
    """
    noise_px = max(sigma_px, _NOISE_FLOOR_PX)
    if not centre_px * noise_px <= radius_px:
        raise DegenerateLinesError(
            "the lines do not show where the distortion centre is: it is known to no better than "
            f"{noise_px * centre_px:,.0f} px",
            hint="hold the centre (--hold d,e), or " + _HINT_MORE,
        )
    if not corner_px * noise_px <= _WORST_CORNER * radius_px:
        raise DegenerateLinesError(
            "the lines do not show the distortion: with them the radial displacement is known to "
            f"no better than {corner_px * noise_px:,.0f} px somewhere in the photo",
            hint=_HINT_MORE,
        )


def refuse_bent(
    sigma_px: float, radius_px: float, lines: Sequence[Line], residuals_px: Sequence[Array]
) -> None:
    """Stop where the picks do not lie on straight lines whatever the distortion.

    Raises:
        DegenerateLinesError: σ̂ exceeds a thirtieth of R; the sentence names the worst line.
    """
    if sigma_px > _BENT * radius_px:
        spread = [float(np.sqrt(np.mean(values**2))) for values in residuals_px]
        worst = int(np.argmax(spread))
        raise DegenerateLinesError(
            "the picks do not lie on straight lines: even after the fit they stray by "
            f"{sigma_px:,.0f} px, those of line {lines[worst].label} by {spread[worst]:,.0f} px",
            hint="check that every pick is on its line, and that the photo's size (and --grid) is "
            "right",
        )


def refuse_collapsed(lens: Lens, scale: float, folded: int) -> None:
    """Stop where a small residual was bought by shrinking, folding or leaving the photo.

    Args:
        lens: The fitted lens.
        scale: Mean scale of the corrected photo at the picks.
        folded: How many picks lie beyond the model's fold.

    Raises:
        CollapsedFitError: as said.
    """
    hint = (
        "check that every pick is on its line and that the photo's size (and --grid) is right; "
        "else free fewer coefficients, or add lines"
    )
    if folded:
        raise CollapsedFitError(
            f"the fit folds the photo over: {count(folded, 'pick')} beyond the fold", hint=hint
        )
    if not _SCALES[0] <= scale <= _SCALES[1]:
        raise CollapsedFitError(
            f"the fit collapsed: it scales the photo by {scale:.2f} to make its lines straight",
            hint=hint,
        )
    if not lens.frame.contains(np.array(lens.centre_px)):
        x, y = lens.centre_px
        raise CollapsedFitError(
            f"the fit collapsed: it puts the distortion centre at ({x:.0f}, {y:.0f}), outside the "
            f"{lens.frame.width}x{lens.frame.height} photo",
            hint="hold the distortion centre (--hold d,e), or add lines on all sides of it",
        )
