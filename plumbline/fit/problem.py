"""From observations and the user's wishes to arrays for the solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plumbline.errors import (
    DegenerateLinesError,
    OptionError,
    PlumblineError,
    or_error,
    refuse_other_type,
)
from plumbline.fit.options import FitPlan, fit_plan
from plumbline.fit.program.blocks import Packed, pack, unpack
from plumbline.fit.program.task import FitTask
from plumbline.fit.refusals import degrees_of_freedom, reach_of_lines, refuse_blind
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens, refuse_impossible
from plumbline.geometry.lines import line_numbers
from plumbline.models import CENTRE, Model
from plumbline.observations import Observations
from plumbline.observations.facts import LensFacts
from plumbline.trust.assessment import ResidualKind

Start = Mapping[str, float] | Literal["file"] | None


@dataclass(frozen=True)
class Problem:
    """A problem ready to be solved, with all that is needed to make sense of the solution.

    Attributes:
        observations: What it is about.
        model: The distortion model.
        plan: What is free, and where everything starts.
        residual: Which residual is minimised.
        packed: All picks.
        kept: Which of them are fitted, in the order of the lines, shape (n,).
        task: The problem for the solver.
        blank: The lens before the fit.
        to_px: What each coefficient is multiplied with on the way out: `d`, `e` come in pixels.
        dof: Degrees of freedom.
    """

    observations: Observations
    model: Model
    plan: FitPlan
    residual: ResidualKind
    packed: Packed
    kept: NDArray[np.bool_]
    task: FitTask
    blank: Lens
    to_px: Array
    dof: int

    def keeping(self, kept: NDArray[np.bool_]) -> Problem:
        """The same problem fitted to some of the picks.

        Raises:
            DegenerateLinesError: they are too few.
        """
        weight = np.zeros(self.packed.block.weight.size)
        weight[self.packed.cells] = kept
        block = self.packed.block._replace(weight=weight.reshape(self.packed.shape))
        n_lines = len(np.unique(line_numbers(self.packed.sizes)[kept]))
        dof = degrees_of_freedom(int(np.count_nonzero(kept)), n_lines, len(self.plan.free))
        return replace(self, kept=kept, task=self.task._replace(block=block), dof=dof)


def prepare(
    observations: Observations,
    model: Model,
    free: Iterable[str] | None,
    hold: Iterable[str],
    start: Start,
    residual: ResidualKind,
) -> Problem:
    """Check what the user asks for and pack it for the solver; arguments as for `calibrate`.

    Raises:
        OptionError: an argument is unknown or contradicts the observations.
        DegenerateLinesError: the lines cannot show any distortion.
    """
    (problem,) = prepare_many([observations], model, free, hold, start, residual)
    if isinstance(problem, PlumblineError):
        raise problem
    return problem


def prepare_many(
    observations: Sequence[Observations],
    model: Model,
    free: Iterable[str] | None,
    hold: Iterable[str],
    start: Start,
    residual: ResidualKind,
) -> list[Problem | PlumblineError]:
    """The same for lenses whose blocks have one shape; what is wrong with one is in its place.

    Raises:
        OptionError: the residual is unknown.
    """
    if residual not in ("image", "corrected"):
        raise OptionError(f"the residual is image or corrected, not {residual!r}")
    chosen, held = None if free is None else tuple(free), tuple(hold)
    plans = [or_error(partial(_planned, each, model, chosen, held, start)) for each in observations]
    sound = [plan for plan in plans if not isinstance(plan, PlumblineError)]
    ready = iter(_packed_together(sound, residual) if sound else ())
    return [plan if isinstance(plan, PlumblineError) else next(ready) for plan in plans]


class _Planned(NamedTuple):
    """What is to be fitted to the picks of one lens, and the lens before the fit."""

    observations: Observations
    plan: FitPlan
    blank: Lens
    dof: int


def _planned(
    observations: Observations,
    model: Model,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...],
    start: Start,
) -> _Planned:
    facts = only_lens(observations)
    if not observations.lines:
        raise DegenerateLinesError(
            f"{observations.named}there are no lines", hint="pick points along straight edges"
        )
    chosen = fit_plan(model, facts, free, hold, start)
    frame = _common_frame(observations, chosen, model)
    facts.refuse_contradiction(frame)
    blank = Lens(model, frame, dict(chosen.start), focal_px=facts.focal_length_px(frame))
    diagonal_px = float(np.hypot(*frame.size))
    refuse_impossible(
        blank.vector, float(np.hypot(chosen.start["d"], chosen.start["e"])) / diagonal_px
    )
    n_points, n_lines = observations.n_points, len(observations.lines)
    dof = degrees_of_freedom(n_points, n_lines, len(chosen.free))
    return _Planned(observations, chosen, blank, dof)


def _packed_together(
    planned: Sequence[_Planned], residual: ResidualKind
) -> list[Problem | PlumblineError]:
    """Problems of what is planned, or why no fit is worth trying."""
    packed = pack([each.observations for each in planned], [each.blank.unit_px for each in planned])
    problems = [_problem(*each, residual) for each in zip(planned, packed, strict=True)]
    points = unpack(packed, [each.block.xy for each in packed])
    radii = np.array([each.blank.frame.radius_px / each.blank.unit_px for each in problems])
    centres = np.stack([each.task.start[-2:] for each in problems])
    counts = np.array([len(each.kept) for each in problems])
    sizes = np.concatenate([each.packed.sizes for each in problems])
    with np.errstate(invalid="ignore"):  # points that are not finite are refused one by one
        seen = (points - np.repeat(centres, counts, axis=0)) / np.repeat(radii, counts)[:, None]
        distance, half_length = reach_of_lines(seen, sizes)
    ends = np.cumsum([len(each.packed.sizes) for each in problems])[:-1]
    reaches = zip(np.split(distance, ends), np.split(half_length, ends), strict=True)
    return [
        or_error(partial(_sighted, problem, *reach))
        for problem, reach in zip(problems, reaches, strict=True)
    ]


def _sighted(problem: Problem, distance: Array, half_length: Array) -> Problem:
    """The problem, unless no line of its can show any distortion: told before a fit is tried."""
    if not np.all(np.isfinite(problem.packed.block.xy)):
        problem.observations.checked()  # says which point it is
    refuse_blind(
        distance,
        half_length,
        problem.blank.frame.radius_px,
        known_centre=not set(CENTRE) & set(problem.plan.free),
    )
    return problem


def _problem(planned: _Planned, packed: Packed, residual: ResidualKind) -> Problem:
    observations, chosen, blank, dof = planned
    model, unit_px = blank.model, blank.unit_px
    radius = blank.frame.radius_px / unit_px
    to_px = np.ones(len(model.coefficients) + 2)
    to_px[-2:] = 1 / blank.frame.per_px(unit_px)
    names = (*model.coefficients, *CENTRE)
    task = FitTask(
        block=packed.block,
        start=np.array([chosen.start[name] for name in names]) / to_px,
        free=np.array([name in chosen.free for name in names]),
        staged=chosen.staged,
        image=residual == "image",
        unit_px=unit_px,
        gauge_radius=model.gauge * radius,
        corner=blank.frame.corner_radius * radius,
        aspect=float(blank.frame.pixel_aspect),
    )
    kept = np.ones(len(packed.cells), dtype=np.bool_)
    return Problem(observations, model, chosen, residual, packed, kept, task, blank, to_px, dof)


def only_lens(observations: Observations) -> LensFacts:
    """Facts about the one lens that took the photos.

    Raises:
        OptionError: there are several, or these are no observations.
    """
    refuse_other_type(
        observations,
        Observations,
        "Observations",
        "read them with plumbline.read, or make them with Observations.from_arrays",
    )
    if len(observations.lenses) != 1:
        raise OptionError(
            f"these observations are of {len(observations.lenses)} lenses",
            hint="calibrate each by itself: calibrate_many([obs.of_lens(0), obs.of_lens(1), …])",
        )
    return observations.lenses[0]


def _common_frame(observations: Observations, chosen: FitPlan, model: Model) -> Frame:
    """The frame of all photos; upright and sideways photos may mix while nothing is off-centre."""
    frames = [photo.frame for photo in observations.photos]
    first = frames[0]
    for photo, frame in zip(observations.photos, frames, strict=True):
        turned = frame.pixel_aspect == first.pixel_aspect == 1 and frame.size == first.size[::-1]
        if frame.pixel_aspect != first.pixel_aspect:
            raise OptionError(
                f"the photos of one lens have contradictory pixels: {first.pixel_aspect:g} and "
                f"{frame.pixel_aspect:g} times as wide as high",
                hint="fit them one at a time (--image N)",
            )
        if frame != first and not turned:
            raise OptionError(
                f"the photos of one lens have contradictory sizes: {first.width}x{first.height} "
                f"and {frame.width}x{frame.height}" + (f" ({photo.name})" if photo.name else ""),
                hint="fit photos of different sizes one at a time (--image N)",
            )
        off_centre = [n for n in (*CENTRE, *model.tangential) if n in chosen.free]
        off_centre += [n for n in (*CENTRE, *model.tangential) if chosen.start[n]]
        if frame != first and off_centre:
            raise OptionError(
                f"{off_centre[0]} means different things in upright and sideways photos",
                hint="fit them one orientation at a time, or hold it at 0",
            )
    return first
