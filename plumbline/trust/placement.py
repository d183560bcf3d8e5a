"""Are the lines well placed? Checks of the picks' geometry, each with its remedy.

The rule for lines is that of LensFun's profile makers: b alone needs one good line; a, b and c
need two, one near the edge of the photo and one about a third of the way out from its centre.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, Frame
from plumbline.geometry.lines import fit_lines, line_numbers
from plumbline.observations import Observations
from plumbline.trust.check import Check
from plumbline.wording import count, joined, listed

_NEAR_EDGE = 0.6
"""Share of the way to the edge: the rule of LensFun's profile makers says near; chosen."""
_THIRD = 0.15, 0.5
"""Shares of the way that count as a third: chosen."""
_LONG = 0.35
"""Parts of the shorter side: chosen; shorter lines bend by a fifth of what full ones do."""
_EXTRAPOLATED = 0.1
"""Share of the photo that may lie beyond the picks: chosen."""
_AT_CORNER = 0.7
"""Share of both half sides from which a pick is near a corner: chosen."""
_LEAST_BEND = 0.02
"""Percent of half the shorter side that a 1 % change must bend a line by: chosen."""
_FEW_DOF = 6
"""Degrees of freedom below which σ̂ is uncertain by more than 30 %: 1/√(2 · 6)."""
_HARDLY_ANY_DOF = 2
"""The same by half and more."""
_GRID = 41
"""Points along a side for the share of the photo: chosen, to a percent or two."""
_CORNERS = "top left", "top right", "bottom right", "bottom left"


class Placed(NamedTuple):
    """Where lines lie in the photo, each of shape (l,).

    Attributes:
        outward: Distance from the image centre, 0 at the centre and 1 at the edge it runs along.
        length: From end to end, in parts of the photo's shorter side.
        bend: Pixels that a change of magnification by 1 % at the short edge bends it by.
        angle: Direction of its normal from the centre, radians, y down.
    """

    outward: Array
    length: Array
    bend: Array
    angle: Array


def before_fit(observations: Observations, n_free: int, n_radial: int) -> tuple[Check, ...]:
    """What can be said of picks without any fit.

    Args:
        observations: Photos and lines of one lens.
        n_free: How many coefficients are to be fitted.
        n_radial: How many of these are radial ones.
    """
    placed = placed_lines(observations)
    return (
        _enough(observations, n_free),
        _radius(observations),
        _corners(observations),
        _central(observations, placed),
        _rule(placed, n_radial),
    )


def placed_lines(observations: Observations) -> Placed:
    """Where the lines lie, from the observed points."""
    frames = [observations.photos[line.photo].frame for line in observations.lines]
    points, sizes = observations.centred_px, observations.sizes
    number = line_numbers(sizes)
    lines = fit_lines(points, sizes, np.ones(len(points)))
    along, _ = lines.place(points, number)
    starts = np.cumsum(sizes) - sizes
    length = np.maximum.reduceat(along, starts) - np.minimum.reduceat(along, starts)
    normal = lines.across
    distance = np.sum(normal * lines.centre, axis=1)
    half = np.array([frame.square_size for frame in frames]) / 2
    outward = np.abs(distance) / np.sum(np.abs(normal) * half, axis=1)
    radius_px = np.array([frame.radius_px for frame in frames])
    bend = 0.01 * np.abs(distance) * (length / 2) ** 2 / radius_px**2
    sign = np.where(distance < 0, -1.0, 1.0)
    angle = np.arctan2(normal[:, 1] * sign, normal[:, 0] * sign)
    return Placed(outward, length / (2 * radius_px), bend, angle)


def extrapolated_share(observations: Observations) -> float:
    """Which part of the photo lies farther out than every pick."""
    return float(np.mean(_radii(observations.photos[0].frame) > _reached_px(observations)))


def _reached_px(observations: Observations) -> float:
    """The largest distance of a pick from the centre of its photo."""
    return float(np.max(np.hypot(*observations.centred_px.T)))


def _radii(frame: Frame) -> NDArray[np.float64]:
    """Distances from the image centre, evenly over the photo."""
    share = (np.arange(_GRID) + 0.5) / _GRID - 0.5
    width, height = frame.square_size
    return np.hypot(*np.meshgrid(share * width, share * height))


def _enough(observations: Observations, n_free: int) -> Check:
    n_points, n_lines = observations.n_points, len(observations.lines)
    dof = n_points - 2 * n_lines - n_free
    picks = f"{count(n_points, 'point')} on {count(n_lines, 'line')}"
    wanted = count(n_free, "coefficient")
    if dof < 1:
        left = n_points - 2 * n_lines
        return Check(
            "points",
            False,
            f"{picks} are too few for {wanted}: 2 of each line only place it, which leaves {left}",
            f"pick at least {_FEW_DOF - dof} more along the lines, or free fewer coefficients",
        )
    finding = f"{picks} leave {count(dof, 'degree')} of freedom for {wanted}"
    if dof >= _FEW_DOF:
        return Check("points", True, finding)
    more = count(_FEW_DOF - dof, "more point")
    remedy = f"{worth_of_error_bars(dof)}; pick at least {more} along the lines"
    return Check("points", False, finding, remedy)


def worth_of_error_bars(dof: int) -> str:
    """What to think of error bars from few degrees of freedom; empty where there are enough."""
    if dof >= _FEW_DOF:
        return ""
    worth = "nearly worthless" if dof <= _HARDLY_ANY_DOF else "uncertain themselves"
    return f"error bars from {count(dof, 'degree')} of freedom are {worth}"


def _radius(observations: Observations) -> Check:
    frame = observations.photos[0].frame
    corner = frame.corner_radius * frame.radius_px
    beyond = extrapolated_share(observations)
    finding = (
        f"the picks reach {100 * _reached_px(observations) / corner:.0f} % of the way to the "
        f"corner; {100 * beyond:.0f} % of the photo lies farther out, where the correction is "
        "extrapolated"
    )
    if beyond <= _EXTRAPOLATED:
        return Check("radius", True, finding)
    return Check("radius", False, finding, "pick lines that end nearer to the corners")


def _corners(observations: Observations) -> Check:
    half = np.array([photo.frame.square_size for photo in observations.photos]) / 2
    photo = np.repeat([line.photo for line in observations.lines], observations.sizes)
    points = observations.centred_px / half[photo]
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    towards = [np.min(points * sign, axis=1) for sign in signs]
    bare = [name for name, t in zip(_CORNERS, towards, strict=True) if np.max(t) < _AT_CORNER]
    if not bare:
        return Check("corners", True, "there are picks near all four corners")
    finding = f"there are no picks near the {joined(bare)} corner{'s' if len(bare) > 1 else ''}"
    if len(bare) <= 2:
        return Check("corners", True, finding, doubtful=True)
    return Check("corners", False, finding, "pick lines that run into the corners")


def _central(observations: Observations, placed: Placed) -> Check:
    blind = placed.bend < _LEAST_BEND * observations.photos[0].frame.radius_px / 100
    names = [line.label for line, b in zip(observations.lines, blind.tolist(), strict=True) if b]
    if not names:
        return Check("central lines", True, "every line lies where a lens bends it")
    runs, are = ("runs", "is") if len(names) == 1 else ("run", "are")
    finding = (
        f"{count(len(names), 'line')} ({listed(names)}) {runs} too close to the centre, or {are} "
        "too short, to show any distortion"
    )
    if 2 * len(names) <= len(blind):
        return Check("central lines", True, finding, doubtful=True)
    remedy = "pick long lines near the edges of the photo instead"
    return Check("central lines", False, finding, remedy)


def _rule(placed: Placed, n_radial: int) -> Check:
    long = placed.length >= _LONG
    edge = long & (placed.outward >= _NEAR_EDGE)
    third = long & (placed.outward >= _THIRD[0]) & (placed.outward <= _THIRD[1])
    needed = "one of each" if n_radial >= 2 else "one near the edge"
    finding = (
        f"{count(int(edge.sum()), 'long line')} near the edge, {int(third.sum())} about a third of "
        f"the way out; at least {needed} is needed"
    )
    if not edge.any():
        remedy = f"pick one more line near the {_emptiest(placed)} edge"
        return Check("profile makers' rule", False, finding, remedy)
    if n_radial >= 2 and not third.any():
        remedy = "pick one more long line a third of the way from the centre to an edge"
        return Check("profile makers' rule", False, finding, remedy)
    return Check("profile makers' rule", True, finding)


def _emptiest(placed: Placed) -> str:
    """The edge whose nearest line lies farthest inside."""
    sides = {"right": 0.0, "bottom": np.pi / 2, "left": np.pi, "top": -np.pi / 2}
    nearest = {
        side: float(
            np.max(
                np.where(np.cos(placed.angle - towards) > np.cos(np.pi / 4), placed.outward, 0.0),
                initial=0.0,
            )
        )
        for side, towards in sides.items()
    }
    return min(nearest, key=lambda side: nearest[side])
