"""Do the points lie in the photo as on the plane? Looked at before anything is adjusted.

Seen from above its plane and before its camera, any three points run the same way round in the
photo as on the plane. Where some do not, points are exchanged or lie beyond the horizon; where
none does, the plane's axes are mirrored.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from plumbline.errors import DegenerateLinesError, OptionError
from plumbline.frame import Array, Indices
from plumbline.ground.adjusting.network import Network
from plumbline.ground.optics import Optics
from plumbline.wording import joined, listed

_SURE = 6.0
"""Standard errors by which three points must miss one line before their turn counts; chosen."""

_MOST_LOOKED_AT = 40
"""Points whose triples are looked at, 9,880 of them; chosen."""


def refuse_beyond_fold(network: Network, optics: Optics) -> Array:
    """Ideal points of the picks; refuse those that the lens cannot show.

    Raises:
        OptionError: as said.
    """
    ideal = optics.undistort(network.picks_px)
    lost = np.flatnonzero(~np.isfinite(ideal).all(axis=1))
    if len(lost):
        names = listed([network.names[index] for index in lost])
        raise OptionError(
            f"the lens values fold before they reach {names}",
            hint="the lens does not belong to this photo, or the picks lie outside of it",
        )
    return ideal


def refuse_one_line(network: Network, ideal: Array) -> None:
    """Refuse points that all, or all but one, lie on one line of the photo.

    Raises:
        DegenerateLinesError: as said.
    """
    if network.lines or network.sigma_square_rad is not None or len(network.horizon_px):
        return
    for left_out in range(network.n_points):
        others = [index for index in range(network.n_points) if index != left_out]
        away = ideal[others] - ideal[others].mean(axis=0)
        aside = np.linalg.svd(away)[2][1] @ away.T
        if np.max(np.abs(aside)) <= _SURE * network.sigma_pick_px / 2:
            names = joined([network.names[index] for index in others[:8]])
            raise DegenerateLinesError(
                f"{names} lie on one line, which leaves the plane undetermined",
                hint="take four points that make a wide quadrilateral, no three of them on a line",
            )


def refuse_disorder(network: Network, ideal: Array) -> None:
    """Refuse points in another order on the plane than in the photo.

    Raises:
        OptionError: the axes are mirrored, two points are exchanged, or some lie beyond the
            horizon; the sentence names them.
    """
    known = network.known[:_MOST_LOOKED_AT]
    if len(known) < 3:
        return
    triples = np.array(list(combinations(range(len(known)), 3)))
    photo = _turns(ideal[known], triples, network.sigma_pick_px)
    sigma = float(np.max(network.sigma_places_m[known]))
    places = network.places_m[known]
    ground = -_turns(places, triples, sigma)  # y runs down in the photo and up on the plane
    wrong = photo * ground < 0
    if not wrong.any():
        return
    if not (photo * ground > 0).any():
        raise OptionError(
            "the points run the other way round on the ground than in the photo",
            hint="X grows to the right and Y away from the camera as seen from above: exchange "
            "the columns X and Y, or turn the sign of one of them",
        )
    names = [network.names[index] for index in known]
    pairs = _exchanged(places, photo, triples, sigma)
    if pairs:
        told = joined([f"{names[first]} with {names[second]}" for first, second in pairs], "or")
        raise OptionError(
            f"the points are in crossed order: they fit once {told} is exchanged",
            hint="give each pick the place of its own point",
        )
    worst = np.argmax(np.bincount(triples[wrong].ravel(), minlength=len(known)))
    raise OptionError(
        f"{names[worst]} lies in the photo where no place on the ground beside the others is seen: "
        "it is on or beyond the horizon, or its place is wrong",
        hint="correct the point, or leave it out",
    )


def _turns(points: Array, triples: Indices, sigma: float) -> Array:
    """1 or −1 by the way round of each triple; 0 where it is not sure."""
    a, b, c = (points[triples[:, i]] for i in range(3))
    p, q = b - a, c - a
    area = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    longest = np.max([np.hypot(*side.T) for side in (p, q, b - c)], axis=0)
    return np.sign(area) * (np.abs(area) > _SURE * sigma * longest)


def _exchanged(
    places: Array, photo: Array, triples: Indices, sigma: float
) -> list[tuple[int, int]]:
    """The pairs whose exchange leaves nothing in disorder, if they are few."""
    found: list[tuple[int, int]] = []
    for pair in combinations(range(len(places)), 2):
        swapped = places.copy()
        swapped[list(pair)] = places[list(pair[::-1])]
        if not (photo * -_turns(swapped, triples, sigma) < 0).any():
            found.append(pair)
    return found if len(found) <= 2 else []
