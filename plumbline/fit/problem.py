"""From observations and the user's wishes to arrays for the solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plumbline.calibration import ResidualKind
from plumbline.errors import DegenerateLinesError, OptionError
from plumbline.facts import LensFacts
from plumbline.fit.blocks import Packed, pack
from plumbline.fit.options import Plan, plan
from plumbline.fit.task import Task
from plumbline.fit.uncertainty import degrees_of_freedom, refuse_blind
from plumbline.frame import Array, Frame
from plumbline.lens import Lens
from plumbline.models import CENTRE, Model
from plumbline.observations import Observations
from plumbline.straightness import line_numbers

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
        dof: Degrees of freedom.
    """

    observations: Observations
    model: Model
    plan: Plan
    residual: ResidualKind
    packed: Packed
    kept: NDArray[np.bool_]
    task: Task
    blank: Lens
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
    if residual not in ("image", "corrected"):
        raise OptionError(f"the residual is image or corrected, not {residual!r}")
    facts = _only_lens(observations)
    if not observations.lines:
        raise DegenerateLinesError(
            f"{observations.named}there are no lines", hint="pick points along straight edges"
        )
    chosen = plan(model, facts, free, hold, start)
    frame = _common_frame(observations, chosen, model)
    facts.refuse_contradiction(frame)
    blank = Lens(model, frame, dict(chosen.start), focal_px=facts.focal_length_px(frame))
    packed = pack(observations, blank.unit_px)
    if not np.all(np.isfinite(packed.block.xy)):
        observations.checked()  # says which point it is
    dof = degrees_of_freedom(observations.n_points, len(observations.lines), len(chosen.free))
    names = (*model.coefficients, *CENTRE)
    to_unit = pixels_of_centre(blank)
    centre = np.array([chosen.start[name] for name in CENTRE]) / to_unit[-2:]
    points = packed.unpack(packed.block.xy) - centre
    refuse_blind(
        points * blank.unit_px / frame.radius_px,
        packed.sizes,
        frame.radius_px,
        known_centre=not set(CENTRE) & set(chosen.free),
    )
    task = Task(
        block=packed.block,
        start=np.array([chosen.start[name] for name in names]) / to_unit,
        free=np.array([name in chosen.free for name in names]),
        staged=chosen.staged,
        image=residual == "image",
        unit_px=blank.unit_px,
        gauge_radius=model.gauge * frame.radius_px / blank.unit_px,
        corner=frame.corner_radius * frame.radius_px / blank.unit_px,
    )
    kept = np.ones(observations.n_points, dtype=np.bool_)
    return Problem(observations, model, chosen, residual, packed, kept, task, blank, dof)


def _only_lens(observations: Observations) -> LensFacts:
    if len(observations.lenses) != 1:
        raise OptionError(
            f"these observations are of {len(observations.lenses)} lenses",
            hint="calibrate each by itself: calibrate_many([obs.of_lens(0), obs.of_lens(1), …])",
        )
    return observations.lenses[0]


def _common_frame(observations: Observations, chosen: Plan, model: Model) -> Frame:
    """The frame of all photos; upright and sideways photos may mix while nothing is off-centre."""
    frames = [photo.frame for photo in observations.photos]
    first = frames[0]
    for photo, frame in zip(observations.photos, frames, strict=True):
        turned = frame.pixel_aspect == 1 and frame.size == first.size[::-1]
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


def pixels_of_centre(lens: Lens) -> Array:
    """What each coefficient is multiplied with on the way out: `d`, `e` come in pixels."""
    size = np.ones(len(lens.model.coefficients) + 2)
    size[-2:] = 1 / lens.frame.per_px(lens.unit_px)
    return size
