"""What the user asks of a fit, resolved against the model and the project."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from plumbline.errors import OptionError, UnsupportedModelError
from plumbline.models import CENTRE, Model
from plumbline.observations.facts import LensFacts
from plumbline.wording import number


@dataclass(frozen=True)
class FitPlan:
    """Which coefficients are fitted, and where everything starts.

    Attributes:
        free: Names of the free coefficients, in the model's order, the centre last.
        start: A value for every coefficient; those not free are held there.
        staged: Whether the free ones are found from nothing.
        notes: What was decided for the user, in plain sentences.
    """

    free: tuple[str, ...]
    start: Mapping[str, float]
    staged: bool
    notes: tuple[str, ...]


def fit_plan(
    model: Model,
    facts: LensFacts,
    free: Iterable[str] | None,
    hold: Iterable[str],
    start: Mapping[str, float] | Literal["file"] | None,
) -> FitPlan:
    """Decide what is free, what is held and where the fit starts.

    Args:
        model: The distortion model.
        facts: What the project says of the lens.
        free: Coefficients to fit; None for what the project asks for, else all of the model's.
        hold: Coefficients to hold nevertheless.
        start: Start vector; None to start from zero; "file" for the project's values.

    Raises:
        OptionError: an unknown coefficient, nothing left to fit, a sheared or fisheye photo,
            or a project without values to start from.
    """
    _refuse_geometry(facts)
    names = (*model.coefficients, *CENTRE)
    stored = _stored_in(model, facts)
    notes: list[str] = []
    chosen = _free(model, names, facts, free, hold, notes)
    values = dict.fromkeys(names, 0.0) | {n: stored.get(n, 0.0) for n in CENTRE}
    if start == "file":
        if not facts.stored:
            raise OptionError(
                "the file stores no lens values to start from",
                hint="give the start vector itself, as in --start a=0.01,b=-0.02",
            )
        if set(model.coefficients).isdisjoint(stored):
            raise UnsupportedModelError(
                f"the file's a, b, c cannot start the model {model.label}",
                hint="give the start vector itself, or fit with --model ptlens",
            )
        values |= stored
    elif start is not None:
        values |= _known(names, start, "the start vector names")
    else:
        _note_ignored(stored, chosen, notes)
    return FitPlan(chosen, values, start is None, tuple(notes))


def _refuse_geometry(facts: LensFacts) -> None:
    if facts.projection != "rectilinear":
        raise OptionError(
            f"the photo is marked as {facts.projection}, in which straight edges are not "
            "straight lines",
            hint="only rectilinear lenses can be calibrated for now; if the mark is wrong, set the "
            "lens type to Normal (f0) in the project",
        )
    sheared = {n: facts.stored[n] for n in ("g", "t") if facts.stored.get(n)}
    if sheared:
        listed = ", ".join(f"{name} = {number(value, 'g')}" for name, value in sheared.items())
        raise OptionError(
            f"the project shears the photo ({listed}), which no lens model here describes",
            hint="set the shear g and t to 0 in the project",
        )


def _stored_in(model: Model, facts: LensFacts) -> dict[str, float]:
    """The project's lens values under the model's own names."""
    names = _hugin_names(model)
    return {new: facts.stored[old] for old, new in names.items() if old in facts.stored}


def _hugin_names(model: Model) -> dict[str, str]:
    """The model's own names for what a project calls a, b, c, d, e."""
    return {theirs: mine for mine, theirs in model.of_ptlens.items()} | {n: n for n in CENTRE}


def _free(
    model: Model,
    names: tuple[str, ...],
    facts: LensFacts,
    free: Iterable[str] | None,
    hold: Iterable[str],
    notes: list[str],
) -> tuple[str, ...]:
    wanted = set(model.coefficients)
    if free is not None:
        wanted = set(_known(names, dict.fromkeys(free, 0.0), "the free coefficients include"))
    elif facts.requested:
        renamed = _hugin_names(model)
        asked = {renamed[n] for n in facts.requested if n in renamed}
        listed = ", ".join(n for n in names if n in asked)
        if not asked & set(model.coefficients):
            wanted |= asked
            rest = ", ".join(model.coefficients)
            if asked:
                notes.append(
                    f"the project asks to optimise {listed} alone; {rest} are fitted too, since "
                    "without distortion its centre cannot be found"
                )
        else:
            wanted = asked
            if wanted != set(model.coefficients):
                notes.append(f"the project asks to optimise {listed}; use --free for others")
    wanted -= set(_known(names, dict.fromkeys(hold, 0.0), "the held coefficients include"))
    if not wanted:
        raise OptionError(
            "every coefficient is held, so there is nothing to fit",
            hint=f"free some of {', '.join(model.coefficients)} with --free",
        )
    return tuple(name for name in names if name in wanted)


def as_names(names: Iterable[str], what: str) -> tuple[str, ...]:
    """Names of coefficients as callers give them.

    Raises:
        OptionError: these are no names.
    """
    try:
        return tuple(names)
    except TypeError:
        raise OptionError(
            f"{what}: names of coefficients expected, not {type(names).__name__}",
            hint=f'give a tuple, as in {what}=("a", "b")',
        ) from None


def _known(names: tuple[str, ...], given: Mapping[str, float], where: str) -> dict[str, float]:
    if not hasattr(given, "items"):
        raise OptionError(
            f"a start vector by name expected, not {type(given).__name__}",
            hint='give a dictionary, as in start={"a": 0.01}',
        )
    for name in given:
        if name not in names:
            raise OptionError(
                f"{where} an unknown coefficient {name!r}",
                hint=f"the coefficients are {', '.join(names)}",
            )
    try:
        return {name: float(value) for name, value in given.items()}
    except (TypeError, ValueError) as error:
        raise OptionError(f"{where} a value that is not a number: {error}") from None


def _note_ignored(stored: Mapping[str, float], free: tuple[str, ...], notes: list[str]) -> None:
    ignored = {n: v for n, v in stored.items() if v and n not in CENTRE}
    if ignored:
        listed = ", ".join(f"{name} = {number(value, '.6g')}" for name, value in ignored.items())
        notes.append(
            f"not used: the file's {listed}; the fit starts at 0 (--start file takes them)"
        )
    centre = {n: v for n, v in stored.items() if v and n in CENTRE and n not in free}
    if centre:
        listed = ", ".join(f"{name} = {number(value, '.6g')} px" for name, value in centre.items())
        notes.append(f"held: the project's distortion centre {listed}")
