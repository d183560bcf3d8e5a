"""Find the long straight edges of a photograph without picks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.edges.gathering import Gathered, gathered, voted_lens
from plumbline.edges.growing import grown
from plumbline.edges.judging import Verdict, judged
from plumbline.edges.light import Light, linear_light
from plumbline.edges.photograph import Photograph, PhotoSource, load
from plumbline.edges.rough_lens import one_coefficient, polynomial
from plumbline.edges.segments import segments
from plumbline.edges.snap import SAMPLES
from plumbline.edges.trace import Traced, condensed, trace
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.observations import Line, Observations, Photo
from plumbline.wording import count, px

MOST = 40
"""Lines that are traced: a lens of more was no better on rendered façades, and each costs 50 ms."""

_SEEDS = 200
"""Pieces that lines are begun with: five times the lines that are traced."""

_PICKS = 8
"""Ends of pieces that stand for picks of a line."""

_SAG_PX = 2.0
"""How far an edge may bend from a lens that pieces voted for or that edges were fitted with."""

_TWIN_PX = 1.5
"""Distance of two edges over their common length below which they are one."""

_BENT = 4.0
"""Times the median rms of lines from which a line is none of the straight world."""

_BENT_PX = 0.15
"""Root mean square residual below which no line is rejected: what straight edges of rendered
photographs with noise and JPEG reach."""

_COMMON = 0.3
"""Share of an edge beside another one from which both can be twins: chosen."""
_LEAST = 3
"""Points of a curve: two have no bend."""


@dataclass(frozen=True, eq=False)
class Found:
    """The long edges of a photograph.

    Attributes:
        observations: One line an edge, with samples for picks; empty of lines where none is found.
        lines: What was traced, every sample of it; in the order of the lines.
        lens: The rough lens that made them collinear.
        verdict: Whether they are vouched for, and to what error.
        pixels: The photo as it was looked at, upright.
        notes: What the photo tells of itself.
    """

    observations: Observations
    lines: tuple[Traced, ...]
    lens: Lens
    verdict: Verdict
    pixels: NDArray[Any]
    notes: tuple[str, ...] = ()


def find_edges(photo: PhotoSource, *, samples: int = SAMPLES) -> Found:
    """Find the long straight edges of a photograph, to a small part of a pixel.

    Straight pieces vote for a one-coefficient lens; pieces that it makes collinear are gathered
    over the whole width (the idea of Alemán-Flores, Alvarez, Gomez and Santana-Cedrés,
    "Automatic lens distortion correction using one-parameter division models", 2014), traced,
    followed to their ends, and traced again with a lens fitted to them. Edges that bend under a
    rich model with a free centre are left out.

    Args:
        photo: A file, or an array (rows, columns[, blue green red]) of 8 or 16 bit.
        samples: Points a line.

    Returns:
        The edges, and how far they can be trusted; nobody has checked them.

    Raises:
        ReadError: the photo cannot be read.
        OptionError: the array is not a picture.

    Example:
        >>> import plumbline
        >>> found = plumbline.find_edges("facade.jpg")  # doctest: +SKIP
        >>> found.verdict.error_px  # doctest: +SKIP
        0.11
    """
    photograph = load(photo)
    light = linear_light(photograph.pixels)
    frame = Frame(*photograph.size)
    lines, lens = _long_edges(light, frame)
    points = [condensed(each, samples).points_px for each in lines]
    verdict = judged(points, frame)
    observed = _observed(photograph, points, verdict)
    return Found(observed, lines, lens, verdict, photograph.pixels, photograph.notes)


def _long_edges(light: Light, frame: Frame) -> tuple[tuple[Traced, ...], Lens]:
    ends, scale = segments(light)
    lens = voted_lens(ends, frame, scale)
    traced: list[Traced] = []
    for _ in range(2):
        chosen = _informative(gathered(ends, lens, scale, seeds=_SEEDS), ends, frame)
        traced = [_traced(light, group, ends, lens, scale) for group in chosen]
        traced = _straight(_without_twins([each for each in traced if each.found]), frame)
        better = _lens_of(traced, frame)
        if better is None:
            return tuple(traced), lens
        lens = better
    traced = [grown(light, each, lens) for each in traced]
    return tuple(_straight(_without_twins(traced), frame)), lens


def _informative(groups: Sequence[Gathered], ends: Array, frame: Frame) -> list[Gathered]:
    """The lines that tell most of the lens: long, far from the centre, and of both directions."""

    def worth(group: Gathered) -> float:
        points = ends[group.members].reshape(-1, 2)
        at = frame.normalise(points)
        centre = at.mean(axis=0)
        direction = np.linalg.svd(at - centre, full_matrices=False)[2][0]
        distance = abs(float(centre[0] * direction[1] - centre[1] * direction[0]))
        return group.span_px * (0.25 + min(distance, 1.0))

    families: tuple[list[Gathered], list[Gathered]] = ([], [])
    for group in sorted(groups, key=worth, reverse=True):
        span = np.ptp(ends[group.members].reshape(-1, 2), axis=0)
        families[int(span[1] > span[0])].append(group)
    level, upright = families
    share = max(MOST // 2, MOST - len(upright))
    return [*level[:share], *upright[: MOST - min(share, len(level))]]


def _traced(light: Light, group: Gathered, ends: Array, lens: Lens, scale: float) -> Traced:
    points = ends[group.members].reshape(-1, 2)
    axis = int(np.ptp(points[:, 1]) > np.ptp(points[:, 0]))
    points = points[np.argsort(points[:, axis])]
    picks = points[np.linspace(0, len(points) - 1, min(_PICKS, len(points))).astype(np.int64)]
    return trace(light, picks, lens, scatter_px=max(1.0, scale), sag_px=_SAG_PX * scale)


def _lens_of(traced: Sequence[Traced], frame: Frame) -> Lens | None:
    points = [condensed(each, SAMPLES).points_px for each in traced]
    if len(points) < _LEAST:
        return None
    return polynomial(points, one_coefficient(points, frame)).lens


def _without_twins(traced: Sequence[Traced]) -> list[Traced]:
    """Edges that are not those of longer ones."""
    kept: list[Traced] = []
    for each in sorted(traced, key=lambda one: -len(one.points_px)):
        if not any(_twins(each.points_px, other.points_px) for other in kept):
            kept.append(each)
    return kept


def _twins(points: Array, other: Array) -> bool:
    axis = int(np.ptp(other[:, 1]) > np.ptp(other[:, 0]))
    order = np.argsort(other[:, axis])
    along, across = other[order, axis], other[order, 1 - axis]
    common = (points[:, axis] >= along[0]) & (points[:, axis] <= along[-1])
    if np.mean(common) < _COMMON:
        return False
    gap = np.abs(np.interp(points[common, axis], along, across) - points[common, 1 - axis])
    return bool(np.median(gap) < _TWIN_PX)


def _straight(traced: Sequence[Traced], frame: Frame) -> list[Traced]:
    """Edges that a rich model with a free centre makes straight.

    A poor model would leave the long lines near the border bent and keep the short ones.
    """
    kept = list(traced)
    while len(kept) > _LEAST:
        points = [condensed(each, SAMPLES).points_px for each in kept]
        rich = polynomial(points, one_coefficient(points, frame), centre=True)
        rms = np.array(rich.line_rms_px)
        worst = int(np.argmax(rms))
        if rms[worst] <= max(_BENT_PX, _BENT * float(np.median(rms))):
            break
        del kept[worst]
    return kept


def _observed(photograph: Photograph, points: Sequence[Array], verdict: Verdict) -> Observations:
    photo = Photo(photograph.size, name=photograph.name)
    lines = tuple(
        Line(each, 0, str(number)) for number, each in enumerate(points, start=1) if len(each) >= 3
    )
    told = f"{count(len(lines), 'edge')} found in the photo; nobody has checked them"
    error = f"; their correction is uncertain by {px(verdict.error_px)}" if verdict.vouched else ""
    notes = (*photograph.notes, told + error)
    facts = () if photograph.facts is None else (photograph.facts.facts,)
    observations = Observations((photo,), lines, notes=notes)
    return Observations(
        observations.photos, observations.lines, facts or observations.lenses, observations.notes
    )
