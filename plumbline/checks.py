"""Are the lines well placed? Checks of the picks' geometry, each with its remedy.

The rule for lines is that of LensFun's profile makers: b alone needs one good line; a, b and c
need two, one near the edge of the photo and one about a third of the way out from its centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.frame import Array, Frame
from plumbline.observations import Observations
from plumbline.straightness import fit_lines, line_numbers
from plumbline.wording import count, listed

_NEAR_EDGE = 0.6
_THIRD = 0.15, 0.5
_LONG = 0.35
_EXTRAPOLATED = 0.1
_AT_CORNER = 0.7
_LEAST_BEND = 0.02
_FEW_DOF = 6
_GRID = 41
_CORNERS = "top left", "top right", "bottom right", "bottom left"


@dataclass(frozen=True)
class Check:
    """One question and its answer.

    Attributes:
        name: What was looked at, in a word or two.
        passed: Whether all is well.
        finding: What was found.
        remedy: What to do about it; empty where all is well.
    """

    name: str
    passed: bool
    finding: str
    remedy: str = ""

    @property
    def sentence(self) -> str:
        """Finding and remedy."""
        return f"{self.finding}: {self.remedy}" if self.remedy else self.finding


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
    points = _points(observations)
    sizes = observations.sizes
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
    frame = observations.photos[0].frame
    reached = float(np.max(np.hypot(*_points(observations).T)))
    return float(np.mean(_radii(frame) > reached))


def _points(observations: Observations) -> Array:
    """All picks in square pixels from the centres of their photos."""
    frames = [observations.photos[line.photo].frame for line in observations.lines]
    each = zip(frames, observations.lines, strict=True)
    return np.concatenate([frame.normalise(line.points_px, 1.0) for frame, line in each])


def _radii(frame: Frame) -> NDArray[np.float64]:
    """Distances from the image centre, evenly over the photo."""
    share = (np.arange(_GRID) + 0.5) / _GRID - 0.5
    width, height = frame.square_size
    return np.hypot(*np.meshgrid(share * width, share * height))


def _enough(observations: Observations, n_free: int) -> Check:
    n_lines = len(observations.lines)
    dof = observations.n_points - 2 * n_lines - n_free
    finding = (
        f"{count(observations.n_points, 'point')} on {count(n_lines, 'line')} leave "
        f"{count(max(dof, 0), 'degree')} of freedom for {count(n_free, 'coefficient')}"
    )
    if dof >= _FEW_DOF:
        return Check("points", True, finding)
    remedy = "pick more points along each line; the error bars themselves are uncertain"
    return Check("points", False, finding, remedy)


def _radius(observations: Observations) -> Check:
    frame = observations.photos[0].frame
    reached = float(np.max(np.hypot(*_points(observations).T)))
    corner = frame.corner_radius * frame.radius_px
    beyond = extrapolated_share(observations)
    finding = (
        f"the picks reach {100 * reached / corner:.0f} % of the way to the corner; "
        f"{100 * beyond:.0f} % of the photo lies farther out, where the correction is extrapolated"
    )
    if beyond <= _EXTRAPOLATED:
        return Check("radius", True, finding)
    return Check("radius", False, finding, "pick lines that end nearer to the corners")


def _corners(observations: Observations) -> Check:
    frame = observations.photos[0].frame
    points = _points(observations) / frame.radius_px
    half = np.array(frame.square_size) / 2 / frame.radius_px
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    towards = [np.min(points * sign / half, axis=1) for sign in signs]
    bare = [name for name, t in zip(_CORNERS, towards, strict=True) if np.max(t) < _AT_CORNER]
    if len(bare) <= 2:
        named = f"no picks near {_joined(bare)}" if bare else "there are picks near all four"
        return Check("corners", True, f"of the corners, {named}")
    finding = f"there are no picks near the corners {_joined(bare)}"
    return Check("corners", False, finding, "pick lines that run into the corners")


def _central(observations: Observations, placed: Placed) -> Check:
    radius_px = observations.photos[0].frame.radius_px
    blind = placed.bend * radius_px < _LEAST_BEND * radius_px / 100
    names = [line.label for line, b in zip(observations.lines, blind.tolist(), strict=True) if b]
    if not names:
        return Check("central lines", True, "every line lies where a lens bends it")
    verb = "runs" if len(names) == 1 else "run"
    finding = (
        f"{count(len(names), 'line')} ({listed(names)}) {verb} too close to the centre, or "
        f"{'is' if len(names) == 1 else 'are'} too short, to show any distortion"
    )
    if 2 * len(names) <= len(blind):
        return Check("central lines", True, finding)
    remedy = "pick long lines near the edges of the photo instead"
    return Check("central lines", False, finding, remedy)


def _rule(placed: Placed, n_radial: int) -> Check:
    long = placed.length >= _LONG
    edge = long & (placed.outward >= _NEAR_EDGE)
    third = long & (placed.outward >= _THIRD[0]) & (placed.outward <= _THIRD[1])
    finding = (
        f"{count(int(edge.sum()), 'long line')} near the edge, {int(third.sum())} about a third of "
        "the way out"
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


def _joined(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
