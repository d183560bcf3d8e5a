"""Calibrate a lens from straight lines: the entry points of the fit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plumbline.calibration import Calibration, ResidualKind
from plumbline.errors import OptionError, PlumblineError
from plumbline.fit.blocks import Packed, pack
from plumbline.fit.notes import after_fit
from plumbline.fit.options import Plan, plan
from plumbline.fit.solve import BATCH, solve, solve_many
from plumbline.fit.straightness import straightness_before
from plumbline.fit.task import Solution, Task
from plumbline.fit.uncertainty import (
    degrees_of_freedom,
    refuse_collapsed,
    refuse_unobservable,
    unit_covariance,
)
from plumbline.frame import Array, Frame
from plumbline.lens import Lens
from plumbline.models import CENTRE, Model, get_model
from plumbline.observations import LensFacts, Observations

Start = Mapping[str, float] | Literal["file"] | None

_SETTLED_PX = 1e-4


def calibrate(
    observations: Observations,
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    start: Start = None,
    residual: ResidualKind = "image",
) -> Calibration:
    """Find the distortion that makes every picked line straight.

    Args:
        observations: Photos of one lens and the lines picked in them.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: Coefficients to fit; None for what the project asks for, else all of the model's.
            `d` and `e`, the distortion centre in pixels, may be among them.
        hold: Coefficients to hold nevertheless.
        start: Start vector by name; coefficients it leaves out start at 0. None starts from
            nothing and cannot end in a wrong minimum; "file" takes the project's values. Held
            coefficients stay at their start value; `d` and `e` at the project's.
        residual: "image" minimises distances in the photograph's own pixels, where picking
            errors live; "corrected" those in the corrected photo, as Hugin does.

    Returns:
        The calibration. One that did not end in a minimum says so in `converged`.

    Raises:
        OptionError: an argument is unknown or contradicts the observations.
        DegenerateLinesError: the lines cannot determine the free coefficients.
        CollapsedFitError: they would, but only by a nonsensical lens.

    Example:
        >>> import plumbline
        >>> obs = plumbline.read("building.pto")  # doctest: +SKIP
        >>> plumbline.calibrate(obs).coefficients  # doctest: +SKIP
        {'a': 0.032, 'b': -0.098, 'c': 0.042, 'd': 0.0, 'e': 0.0}
    """
    prepared = _prepare(observations, get_model(model), free, hold, start, residual)
    solution = solve(prepared.model, prepared.task)
    if prepared.plan.staged:
        return _finish(prepared, solution)
    staged = solve(prepared.model, prepared.task._replace(staged=True))
    return _with_better_minimum(prepared, _finish(prepared, solution), staged)


def calibrate_many(
    observations: Sequence[Observations],
    model: str = "ptlens",
    *,
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    residual: ResidualKind = "image",
) -> list[Calibration]:
    """Calibrate many lenses at once, in compiled batches of problems of like size.

    Args:
        observations: Each the photos and lines of one lens.
        model: As for `calibrate`.
        free: As for `calibrate`.
        hold: As for `calibrate`.
        residual: As for `calibrate`.

    Returns:
        One calibration each, in the same order, the same as `calibrate` gives.

    Raises:
        PlumblineError: as `calibrate`; the sentence names the number of the lens from 0.
    """
    chosen, held = None if free is None else tuple(free), tuple(hold)
    prepared: list[_Prepared] = []
    batches: dict[tuple[int, int], list[int]] = {}
    for index, each in enumerate(observations):
        with _numbered(index):
            made = _prepare(each, get_model(model), chosen, held, None, residual)
        prepared.append(made)
        batches.setdefault(made.packed.shape, []).append(index)
    results: dict[int, Calibration] = {}
    for members in batches.values():
        for first in range(0, len(members), BATCH):
            chunk = members[first : first + BATCH]
            solved = solve_many(get_model(model), [prepared[i].task for i in chunk])
            for index, solution in zip(chunk, solved, strict=True):
                with _numbered(index):
                    results[index] = _finish(prepared[index], solution)
    return [results[index] for index in range(len(prepared))]


class _numbered:  # noqa: N801
    """Say which lens of many an error is about."""

    def __init__(self, index: int) -> None:
        self.index = index

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, _: object) -> None:
        if isinstance(error, PlumblineError):
            error.message = f"lens {self.index}: {error.message}"
            error.args = (error.message,)


@dataclass(frozen=True)
class _Prepared:
    """A problem ready to be solved, with all that is needed to make sense of the solution."""

    observations: Observations
    model: Model
    plan: Plan
    residual: ResidualKind
    packed: Packed
    task: Task
    blank: Lens
    dof: int


def _prepare(
    observations: Observations,
    model: Model,
    free: Iterable[str] | None,
    hold: Iterable[str],
    start: Start,
    residual: ResidualKind,
) -> _Prepared:
    if residual not in ("image", "corrected"):
        raise OptionError(f"the residual is image or corrected, not {residual!r}")
    facts = _only_lens(observations)
    chosen = plan(model, facts, free, hold, start)
    frame = _common_frame(observations, chosen, model)
    blank = Lens(model, frame, dict(chosen.start), focal_px=facts.focal_length_px(frame))
    packed = pack(observations, blank.unit_px)
    dof = degrees_of_freedom(observations.n_points, len(observations.lines), len(chosen.free))
    names = (*model.coefficients, *CENTRE)
    to_unit = _pixels_of_centre(blank)
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
    return _Prepared(observations, model, chosen, residual, packed, task, blank, dof)


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


def _pixels_of_centre(lens: Lens) -> Array:
    """What each coefficient is multiplied with on the way out: `d`, `e` come in pixels."""
    size = np.ones(len(lens.model.coefficients) + 2)
    size[-2:] = lens.unit_px / np.array([lens.frame.pixel_aspect, 1.0])
    return size


def _finish(prepared: _Prepared, solution: Solution) -> Calibration:
    model, packed, chosen = prepared.model, prepared.packed, prepared.plan
    names = (*model.coefficients, *CENTRE)
    to_px = _pixels_of_centre(prepared.blank)
    found = dict(zip(names, (solution.coefficients * to_px).tolist(), strict=True))
    held = {name: value for name, value in chosen.start.items() if name not in chosen.free}
    lens = replace(prepared.blank, coefficients=found | held)
    at = solution.residuals
    refuse_collapsed(lens, packed.unpack(at.determinant), packed.unpack(at.excess))
    fitted = packed.unpack(at.image if prepared.residual == "image" else at.corrected)
    sigma_px = float(np.sqrt(fitted @ fitted / prepared.dof))
    jacobian = packed.unpack(solution.jacobian)[:, prepared.task.free]
    scale = to_px[prepared.task.free]
    unit = unit_covariance(jacobian.T @ jacobian) * np.outer(scale, scale)
    corner_px = refuse_unobservable(lens, chosen.free, unit, sigma_px)
    corrected = packed.unpack(at.corrected)
    ends = np.cumsum(packed.sizes)[:-1]
    off_px = float(solution.last_step) * lens.unit_px
    converged = bool(off_px < _SETTLED_PX)
    made = Calibration(
        observations=prepared.observations,
        lens=lens,
        free=chosen.free,
        start=dict(chosen.start),
        residual=prepared.residual,
        covariance=sigma_px**2 * unit,
        sigma_px=sigma_px,
        dof=prepared.dof,
        residuals_px=tuple(np.split(fitted, ends)),
        before_px=straightness_before(prepared.observations),
        rms_corrected_px=float(np.sqrt(np.mean(corrected**2))),
        converged=converged,
        reason="the fit ended in a minimum"
        if converged
        else f"the fit stopped after {int(solution.steps)} steps without reaching a minimum",
    )
    notes = (*prepared.observations.notes, *chosen.notes, *after_fit(made, corner_px))
    return replace(made, notes=notes)


def _with_better_minimum(prepared: _Prepared, made: Calibration, staged: Solution) -> Calibration:
    """Report it if the fit from zero ends lower than the one from the user's start vector."""
    try:
        from_zero = _finish(prepared, staged)
    except PlumblineError:
        return made
    if from_zero.rms_after_px > made.rms_after_px * (1 - 1e-6) - 1e-9:
        return made
    values = ", ".join(f"{n} = {from_zero.coefficients[n]:.6g}" for n in from_zero.free)
    note = (
        f"this start vector leads to a worse fit ({made.rms_after_px:.4g} px) than starting from "
        f"zero does ({from_zero.rms_after_px:.4g} px with {values}): leave out --start"
    )
    return replace(made, notes=(*made.notes, note))
