"""Snap rough picks to the edges of their photograph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.edges.colours import LateralColour, lateral_colour
from plumbline.edges.light import Light, linear_light
from plumbline.edges.photograph import Photograph, PhotoSource, load, photos_of
from plumbline.edges.rough_lens import RoughLens, one_coefficient, polynomial
from plumbline.edges.trace import SCATTER_PX, Traced, condensed, trace
from plumbline.errors import DegenerateLinesError, OptionError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens
from plumbline.observations import Line, Observations
from plumbline.wording import count

SAMPLES = 32
"""Samples a line that are handed on: neighbours stand farther apart than an edge's blur, and a
line of more says no more, since edges bend by themselves."""

_SCATTER_PX = (1.0, 10.0)
"""Scatter of picks that is reckoned with at least and at most: few picks look better than they
are, and with more than 10 px every edge would be near."""

_KNOWN_SAG_PX = 1.5
"""How far an edge may bend from a lens that was fitted to edges: what a radial polynomial leaves
of real lenses, and what edges bend by themselves."""

_LEAST_LINES = 3
"""Edges from which a lens is fitted again: two predict each other only."""

_BENT = 6.0
"""Times the median rms of all lines from which a line is bent among straight ones."""

_BENT_PX = 0.5
"""Root mean square residual that no straight edge reaches: edges that were traced on photographs
bend by .06 to .5 px at most."""


@dataclass(frozen=True, eq=False)
class Snapped:
    """What became of picks.

    Attributes:
        observations: The same lines, those that were snapped with samples of their edges.
        lines: What was traced for each line, every sample of it; or why it was refused.
        lens: The lens that predicted where edges run; a rough one, not a calibration.
        notes: What the photos tell of themselves, in plain sentences.
        colour: Lateral chromatic aberration along the edges of a single photo; None where it
            cannot be measured.
    """

    observations: Observations
    lines: tuple[Traced, ...]
    lens: Lens
    notes: tuple[str, ...] = ()
    colour: LateralColour | None = None

    @property
    def n_snapped(self) -> int:
        """Number of lines that were snapped."""
        return sum(line.found for line in self.lines)


def snap(
    observations: Observations,
    photo: PhotoSource | Sequence[PhotoSource | None] | None = None,
    *,
    lens: Lens | None = None,
    samples: int = SAMPLES,
) -> Snapped:
    """Move picks onto the edges that they mean, to a small part of a pixel.

    The edge is predicted from the picks and the lens; the lens is found from the picks, and again
    from the edges. A line whose edge cannot be told keeps its picks, and the notes of the
    observations say why.

    Args:
        observations: Picks in photos of one lens.
        photo: The photo as a file or an array (rows, columns[, blue green red]) of 8 or 16 bit,
            or one for each photo of the observations; by default the files beside the points.
        lens: The lens, where one is known already.
        samples: Points a line that is snapped gets.

    Returns:
        The observations with samples for picks.

    Raises:
        OptionError: a photo is missing, has another size, or there are several lenses.
        ReadError: a photo cannot be read.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("picks.csv", photo="facade.jpg")  # doctest: +SKIP
        >>> snapped = plumbline.snap(obs, "facade.jpg")  # doctest: +SKIP
        >>> plumbline.calibrate(snapped.observations)  # doctest: +SKIP
    """
    if len({observations.photos[line.photo].lens for line in observations.lines}) > 1:
        raise OptionError(
            "the observations are of several lenses",
            hint="snap those of one lens at a time (--image N, or Observations.of_lens)",
        )
    sources = photos_of(observations, photo)
    photographs = [
        None if source is None else load(source, each.size)
        for source, each in zip(sources, observations.photos, strict=True)
    ]
    lights = [None if each is None else linear_light(each.pixels) for each in photographs]
    traced, guide = _trace_all(observations, lights, lens)
    notes = tuple(note for each in photographs if each is not None for note in each.notes)
    colour = _colour(photographs, traced)
    notes += () if colour is None else (colour.note,)
    observed = _with_samples(observations, traced, notes, samples)
    return Snapped(observed, traced, guide, notes, colour)


def _colour(
    photographs: Sequence[Photograph | None], traced: Sequence[Traced]
) -> LateralColour | None:
    """The colours of a single photo, where enough edges show them."""
    single = photographs[0] if len(photographs) == 1 else None
    if single is None:
        return None
    try:
        return lateral_colour(single.pixels, traced, halved_colours=single.halved_colours)
    except DegenerateLinesError:
        return None


def _trace_all(
    observations: Observations, lights: Sequence[Light | None], lens: Lens | None
) -> tuple[tuple[Traced, ...], Lens]:
    lines = observations.lines
    frame = observations.photos[lines[0].photo].frame
    first = one_coefficient([line.points_px for line in lines], frame)
    scatter = float(np.clip(1.5 * first.scatter_px, *_SCATTER_PX)) if lens is None else SCATTER_PX
    rough = lens or first.lens
    traced = [_traced(line, lights, rough, scatter, None) for line in lines]
    for sag in (_KNOWN_SAG_PX, None):  # all again, then those that were refused with more room
        better = _lens_of(traced, first)
        if better is None:
            return tuple(traced), rough
        rough = better.lens if lens is None else lens
        traced = [
            each if sag is None and each.found else _traced(line, lights, rough, scatter, sag)
            for line, each in zip(lines, traced, strict=True)
        ]
    return _without_bent(traced, first), rough


def _traced(
    line: Line, lights: Sequence[Light | None], lens: Lens, scatter: float, sag: float | None
) -> Traced:
    light = lights[line.photo]
    if light is None:
        raise OptionError(f"the photo of line {line.label} is missing")
    return trace(light, line.points_px, lens, scatter_px=scatter, sag_px=sag)


def _lens_of(traced: Sequence[Traced], first: RoughLens) -> RoughLens | None:
    """A lens fitted to the edges that were traced; None where they are too few."""
    found = [condensed(each, SAMPLES).points_px for each in traced if each.found]
    found = [points for points in found if len(points) >= _LEAST_LINES]
    if len(found) < _LEAST_LINES:
        return None
    return polynomial(found, one_coefficient(found, first.lens.frame))


def _without_bent(traced: Sequence[Traced], first: RoughLens) -> tuple[Traced, ...]:
    """The same with lines refused that bend where the others are straight."""
    which = [index for index, each in enumerate(traced) if each.found]
    fitted = _lens_of(traced, first)
    if fitted is None or len(fitted.line_rms_px) != len(which):
        return tuple(traced)
    usual = float(np.median(fitted.line_rms_px))
    judged = list(traced)
    for index, rms in zip(which, fitted.line_rms_px, strict=True):
        if rms > max(_BENT_PX, _BENT * usual):
            reason = f"the edge bends by {rms:.1f} px (rms) where the others are straight"
            nothing: Array = np.empty((0, 2))
            judged[index] = replace(
                judged[index], points_px=nothing, errors_px=nothing[:, 0], refusal=reason
            )
    return tuple(judged)


def _with_samples(
    observations: Observations,
    traced: Sequence[Traced],
    notes: Sequence[str],
    samples: int,
) -> Observations:
    lines = tuple(
        replace(line, points_px=condensed(each, samples).points_px, rows=None)
        if each.found
        else line
        for line, each in zip(observations.lines, traced, strict=True)
    )
    number = sum(each.found for each in traced)
    told = [
        *notes,
        f"{number} of {count(len(lines), 'line')} snapped to the photo's edges",
    ]
    told += [
        f"line {line.label} keeps its picks: {each.refusal}"
        for line, each in zip(lines, traced, strict=True)
        if not each.found
    ]
    return replace(observations, lines=lines, notes=(*observations.notes, *told))
