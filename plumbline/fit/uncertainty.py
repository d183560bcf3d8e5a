"""Covariance of the fitted coefficients, and the checks that stop a meaningless fit.

The line parameters are eliminated (variable projection; Golub and Pereyra 1973), so that the
covariance is σ̂² (JᵀJ)⁻¹ with J the derivative of the residuals by the coefficients alone and
σ̂² = Σ residual² / (points − 2 · lines − free coefficients).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import CollapsedFitError, DegenerateLinesError
from plumbline.frame import Array
from plumbline.lens import Lens
from plumbline.linearised import Linearised
from plumbline.models import CENTRE, Model
from plumbline.straightness import direction
from plumbline.wording import count

_NOISE_FLOOR_PX = 0.1
_WORST_CORNER = 0.5
_SCALES = 0.6, 4.0
_LEAST_BEND_PX = 2.0
_CENTRAL = 0.02
_BENT = 1 / 30
_RADII = 12
_HINT_MORE = "pick more lines, longer ones and nearer to the edges of the photo, in both directions"


def refuse_blind(
    points: Array, sizes: NDArray[np.int64], radius_px: float, *, known_centre: bool
) -> None:
    """Stop where no line can show any distortion, before a fit is tried.

    An ideal line at a distance h from the distortion centre, reaching L to either side of its
    middle, is bent by b h L² where the magnification changes by b r².

    Args:
        points: Observed points about the distortion centre, in units of R, line after line.
        sizes: Number of points of each line.
        radius_px: R in pixels.
        known_centre: Whether the distortion centre is held.

    Raises:
        DegenerateLinesError: a change of magnification by one would bend no line by two pixels.
    """
    starts = np.cumsum(sizes) - sizes
    centres = np.add.reduceat(points, starts) / sizes[:, None]
    x, y = (points - np.repeat(centres, sizes, axis=0)).T
    cosine, sine = direction(*(np.add.reduceat(v, starts) for v in (x * x, x * y, y * y)))
    along = np.abs(x * np.repeat(cosine, sizes) + y * np.repeat(sine, sizes))
    half_length = np.maximum.reduceat(along, starts)
    distance = np.abs(centres[:, 1] * cosine - centres[:, 0] * sine)
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


def unit_covariance(normal: Array) -> Array:
    """(JᵀJ)⁻¹ of the free coefficients: their covariance for picks with σ = 1 px.

    Args:
        normal: JᵀJ, shape (k, k).

    Raises:
        DegenerateLinesError: JᵀJ is singular: the lines do not see some coefficient.
    """
    scale = np.sqrt(np.diag(normal))
    if not np.all(np.isfinite(normal)) or np.any(scale <= 1e-9 * max(1.0, scale.max())):
        raise DegenerateLinesError(
            "the lines carry no information about some free coefficient",
            hint=_HINT_MORE + "; without any distortion there is no centre to be found",
        )
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if values[0] <= 1e-13:
        raise DegenerateLinesError(
            "the lines cannot tell the free coefficients apart",
            hint=_HINT_MORE + ", or free fewer coefficients with --free",
        )
    inverse = (vectors / values) @ vectors.T
    return inverse / np.outer(scale, scale)


def sandwich(linear: Linearised, dof: int) -> tuple[Array, float]:
    """Covariance and σ̂ where residuals are measured in the corrected photo.

    A pick's error σ in the photograph is s σ there, s the local stretch, so that the covariance is
    σ̂² N⁻¹ (Σ s² J Jᵀ) N⁻¹ with N = JᵀJ (P. Huber 1967, H. White 1980), and σ̂ is taken from the
    residuals in the photograph.

    Returns:
        Covariance, shape (k, k), and σ̂ in pixels of the photograph.
    """
    jacobian, stretch = linear.jacobian[linear.kept], linear.stretch[linear.kept]
    sigma_px = float(np.sqrt(np.sum(linear.image_px[linear.kept] ** 2) / dof))
    unit = unit_covariance(linear.normal)
    meat = (jacobian * stretch[:, None] ** 2).T @ jacobian
    return sigma_px**2 * unit @ meat @ unit, sigma_px


def corner_error(
    model: Model, c: Array, cov: Array, radial: NDArray[np.int64], corner: float
) -> float:
    """Largest standard error of the radial displacement up to the corner, normalised.

    The best common scale is taken out, since straight lines do not see it.

    Args:
        model: The model.
        c: Its coefficients.
        cov: Covariance of those that are free and radial.
        radial: Their places in `c`.
        corner: Normalised radius of the photo's corner.
    """
    radii = corner * np.arange(1, _RADII + 1) / _RADII
    step = 1e-6
    base = radii * model.factor(radii, c)
    columns: list[Array] = []
    for index in radial:
        moved = c.copy()
        moved[index] += step
        columns.append((radii * model.factor(radii, moved) - base) / step)
    design = np.stack(columns, axis=1)
    design -= np.outer(radii, radii @ design) / (radii @ radii)
    variance = np.einsum("ri,ij,rj->r", design, cov, design)
    return float(np.sqrt(np.max(variance)))


def refuse_unobservable(lens: Lens, free: tuple[str, ...], unit: Array, sigma_px: float) -> None:
    """Stop where the lines leave the distortion open.

    Args:
        lens: The fitted lens.
        free: Names of the free coefficients.
        unit: Their covariance for σ = 1 px, `d` and `e` in pixels.
        sigma_px: σ̂; at least 0.1 px is assumed, since nobody picks better.

    Raises:
        DegenerateLinesError: the standard error of the radial displacement exceeds half of R
            somewhere up to the corner, or that of the distortion centre R itself.
    """
    model, unit_px, radius_px = lens.model, lens.unit_px, lens.frame.radius_px
    noise = max(sigma_px, _NOISE_FLOOR_PX)
    centre = max([0.0, *(np.sqrt(unit[free.index(n), free.index(n)]) for n in CENTRE if n in free)])
    if centre * noise > radius_px:
        raise DegenerateLinesError(
            "the lines do not show where the distortion centre is: it is known to no better than "
            f"{noise * centre:,.0f} px",
            hint="hold the centre (--hold d,e), or " + _HINT_MORE,
        )
    names = [n for n in free if n in model.coefficients and n not in model.tangential]
    if not names:
        return
    chosen = [free.index(name) for name in names]
    places = np.array([model.coefficients.index(name) for name in names], dtype=np.int64)
    part, far = unit[np.ix_(chosen, chosen)], lens.frame.corner_radius * radius_px / unit_px
    error_px = corner_error(model, lens.vector, part, places, far) * unit_px * noise
    if error_px > _WORST_CORNER * radius_px:
        raise DegenerateLinesError(
            "the lines do not show the distortion: with them the radial displacement is known to "
            f"no better than {error_px:,.0f} px somewhere in the photo",
            hint=_HINT_MORE,
        )


def refuse_bent(
    sigma_px: float, radius_px: float, labels: Sequence[str], residuals_px: Sequence[Array]
) -> None:
    """Stop where the picks lie on no straight lines whatever the distortion.

    Raises:
        DegenerateLinesError: σ̂ exceeds a thirtieth of R; the sentence names the worst line.
    """
    if sigma_px > _BENT * radius_px:
        spread = [float(np.sqrt(np.mean(values**2))) for values in residuals_px]
        worst = int(np.argmax(spread))
        raise DegenerateLinesError(
            f"the picks lie on no straight lines: even after the fit they stray by {sigma_px:,.0f} "
            f"px, those of line {labels[worst]} by {spread[worst]:,.0f} px",
            hint="check that every pick is on its line, and that the photo's size (and --grid) is "
            "right; --robust leaves single wrong picks out",
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
        "--robust leaves single wrong picks out; else free fewer coefficients, or add lines"
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
