"""Which observation is wrong, where all together contradict each other.

Each point and each tape is left out in turn, and the rest adjusted again. One whose absence ends
the contradiction is a suspect; a tape whose length is another unit's is told so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from plumbline.errors import OptionError, PlumblineError
from plumbline.ground.adjusting.adjustment import Adjustment, adjust
from plumbline.ground.adjusting.network import Network
from plumbline.ground.findings import Doubtful
from plumbline.ground.optics import Optics

_UNITS = {
    "feet": 1 / 0.3048,
    "metres, the others in feet": 0.3048,
    "yards": 1 / 0.9144,
    "centimetres": 100.0,
    "millimetres": 1000.0,
    "inches": 1 / 0.0254,
    "tens of metres": 0.1,
}
"""How many times too long a length is that was read in another unit."""

_SAME_RATIO = 0.03
"""How near a ratio is to a unit's; chosen, a third of the step from yards to metres."""

_MOST_LOOKED_AT = 8
"""Points and tapes that are left out in turn, the least fitting first; chosen."""


def find_suspects(found: Adjustment) -> list[Doubtful]:
    """The observations without which the rest would agree; none where it does already.

    Raises:
        OptionError: two points are exchanged, or one lies beyond the horizon.
    """
    if not found.contradictory:
        return []
    optics = found.start.camera.optics
    _refuse_exchanged(found, optics)
    return [*_tapes(found, optics), *_points(found, optics)]


def _refuse_exchanged(found: Adjustment, optics: Optics) -> None:
    network = found.network
    known = [index for index in _worst(found, "points", "picks") if index in network.known]
    good: list[tuple[int, int]] = []
    for pair in combinations(known, 2):
        places = network.places_m.copy()
        places[list(pair)] = network.places_m[list(pair[::-1])]
        other = _tried(replace(network, places_m=places), optics)
        if other is not None and not other.contradictory:
            good.append(pair)
    if len(good) == 1:
        first, second = (network.names[index] for index in good[0])
        raise OptionError(
            f"{first} and {second} are exchanged: with their places exchanged all agree",
            hint="give each pick the place of its own point",
        )


def _worst(found: Adjustment, *kinds: str) -> list[int]:
    """Owners of the largest residuals of some kinds, worst first."""
    sums: dict[int, float] = {}
    for block in found.blocks:
        if block.kind in kinds:
            for owner, residual in zip(block.owners.tolist(), block.residuals, strict=True):
                sums[owner] = sums.get(owner, 0.0) + float(residual**2)
    return sorted(sums, key=lambda owner: -sums[owner])[:_MOST_LOOKED_AT]


def _tapes(found: Adjustment, optics: Optics) -> Iterator[Doubtful]:
    network = found.network
    for index in _worst(found, "tapes"):
        tape = network.tapes[index]
        kept = tuple(each for at, each in enumerate(network.tapes) if at != index)
        other = _tried(replace(network, tapes=kept), optics)
        if other is None or other.contradictory:
            continue
        ends = other.state.places[[tape.first, tape.second], :2]
        length = float(np.hypot(*(ends[1] - ends[0])))
        names = f"{network.names[tape.first]}-{network.names[tape.second]}"
        off = f"{tape.metres:.3f} m where the others say {length:.3f} m"
        for unit, times in _UNITS.items():
            if abs(tape.metres / length / times - 1) < _SAME_RATIO:
                off += f": it may be in {unit}"
        yield Doubtful(f"tape {names}", off)


def _points(found: Adjustment, optics: Optics) -> Iterator[Doubtful]:
    network = found.network
    if len(network.known) < 5:  # four places have nothing to be compared with
        return
    for index in _worst(found, "points", "picks"):
        if index not in network.known:
            continue
        other = _tried(network.without(index), optics)
        if other is None or other.contradictory:
            continue
        place = other.state.camera.ground(network.picks_px[index : index + 1])[0]
        name = network.names[index]
        if not np.isfinite(place).all():
            raise OptionError(
                f"{name} lies on or beyond the horizon that the others give",
                hint="correct its pick, or leave it out",
            )
        away = float(np.hypot(*(network.places_m[index] - place)))
        yield Doubtful(f"point {name}", f"{away:.2f} m from where the others put it")


def _tried(network: Network, optics: Optics) -> Adjustment | None:
    try:
        other = adjust(network, optics)
    except PlumblineError:
        return None
    return other if other.redundancy >= 0 else None
