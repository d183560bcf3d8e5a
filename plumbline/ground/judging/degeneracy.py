"""What the observations do not determine, and which further one would tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbline.errors import DegenerateLinesError
from plumbline.frame import Array
from plumbline.ground.adjusting.adjustment import Adjustment
from plumbline.ground.adjusting.network import Network
from plumbline.ground.camera import FOCAL, HEIGHT
from plumbline.wording import joined

_HARDLY = 0.5
"""Relative standard error of height or focal length from which the plane counts as not determined:
chosen, because no linear error bar means anything there."""

_LEAST_POINTS = 4
"""A homography has eight unknowns, two a point."""


@dataclass(frozen=True)
class _Missing:
    """One thing that could be observed.

    Attributes:
        what: Its name.
        row: Its derivative by the unknowns.
    """

    what: str
    row: Array


def refuse_too_few(network: Network) -> None:
    """Refuse what cannot determine a plane, whatever the camera.

    Raises:
        DegenerateLinesError: as said.
    """
    count = network.n_points
    square = network.sigma_square_rad is not None
    if square and count < 2:
        raise DegenerateLinesError("one point gives no scale", hint="pick two points at least")
    helped = square or len(network.lines) >= 2 or len(network.horizon_px) > 0
    if count < _LEAST_POINTS and not helped:
        raise DegenerateLinesError(
            f"{count} point{'s do' if count != 1 else ' does'} not determine the plane",
            hint="pick at least 4 points with places or tapes; for a plane photographed square-on, "
            "2 points and --square-on; or add parallel lines",
        )
    if network.right_angles and network.focal is None and not _rigid(network):
        raise DegenerateLinesError(
            "a figure known by right angles and fewer tapes than fix its shape needs the focal "
            "length, and none is known",
            hint="give --focal-px, or measure a second side",
        )


def _rigid(network: Network) -> bool:
    """Whether coordinates and tapes are enough in number to fix the figure's shape and size."""
    known = set(network.known.tolist())
    taped = {end for tape in network.tapes for end in (tape.first, tape.second)}
    cornered = {e for a in network.right_angles for e in (a.first, a.corner, a.last)}
    return len(network.tapes) + max(2 * len(known) - 3, 0) >= 2 * len(known | taped | cornered) - 3


def refuse_undetermined(found: Adjustment) -> None:
    """Refuse an adjustment with a direction that nothing, or hardly anything, determines.

    Raises:
        DegenerateLinesError: as said; the sentence names what is missing.
    """
    loose = found.undetermined
    if len(loose):
        raise DegenerateLinesError(
            f"the observations leave {_freedom(found, loose)} undetermined",
            hint=_remedy(found, loose),
        )
    spread = np.sqrt(np.diag(found.cofactor))
    for index, what in ((HEIGHT, "camera's height"), (FOCAL, "focal length")):
        if spread[index] > _HARDLY:
            weak = found.cofactor[index] / spread[index]
            raise DegenerateLinesError(
                f"the observations hardly determine the {what}: ± {100 * spread[index]:.0f} %",
                hint=_remedy(found, weak[None]),
            )


def _freedom(found: Adjustment, loose: Array) -> str:
    """What moves along the loose directions, in words."""
    layout, network = found.layout, found.network
    moving = [
        network.names[index]
        for index in range(layout.points)
        if np.max(np.abs(loose[:, layout.places[index]])) > 1e-3 * np.max(np.abs(loose))
    ]
    camera = np.max(np.abs(loose[:, : layout.starts[1]])) > 1e-3 * np.max(np.abs(loose))
    if moving and len(moving) <= 3:
        return f"the place of {joined(moving)}"
    if camera:
        return "the camera over the plane"
    return "the places of most points" if moving else "one of the lines"


def _remedy(found: Adjustment, loose: Array) -> str:
    """The observations that would tell most about the loose directions."""
    names = found.network.names
    told = [
        (float(np.linalg.norm(loose @ each.row) / np.linalg.norm(each.row)), each.what)
        for each in _missing(found)
    ]
    best = [what for size, what in sorted(told, reverse=True)[:2] if size > 0]
    if not best:
        return f"add tapes, or the places of points such as {names[0]}"
    return "add " + joined(best, "or")


def _missing(found: Adjustment) -> list[_Missing]:
    """Tapes, places and the focal length that were not observed."""
    layout, network = found.layout, found.network
    missing: list[_Missing] = []
    taped = {frozenset((t.first, t.second)) for t in network.tapes}
    known = set(network.known.tolist())
    for first in range(layout.points):
        for second in range(first):
            if frozenset((first, second)) in taped or {first, second} <= known:
                continue
            row = np.zeros(layout.size)
            apart = found.state.places[first, :2] - found.state.places[second, :2]
            row[layout.places[first]], row[layout.places[second]] = apart, -apart
            length = float(np.hypot(*apart))
            if length > 0:
                what = f"a tape from {network.names[second]} to {network.names[first]}"
                missing.append(_Missing(what, row / length))
    if network.focal is None:
        row = np.zeros(layout.size)
        row[FOCAL] = 1.0
        missing.append(_Missing("the focal length with --focal-px", row))
    return missing
