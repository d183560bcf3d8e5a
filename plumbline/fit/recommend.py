"""Which of the models fitted to the same picks to take, and why.

The model with the lowest AICc is not yet the one to take. Of models that fit nearly alike one is
lowest by chance, and one with few coefficients states a small error whatever it cannot follow. A
model is therefore enough only where its curve agrees with those of its rivals: to 0.1 px, or to
one and a half of the largest standard error that it states itself. Its rivals are the models that
the picks do not rule out beside it: those with no more coefficients unless their AICc is higher by
10 ("essentially no support", K. Burnham and D. Anderson, 2002, section 2.6), and those with more if
it is higher by 2 at the most ("substantial support"). A model that is ruled out itself, by 10, is
enough only where the difference does not matter, since what it cannot follow swells the error that
it states. Of the models that are enough, that with the fewest coefficients is taken.

The distortion centre, and the tangential terms that act like it, are ill-posed. Models that free
them take part only where lines left out of the fit become straighter by them, and AICc falls by 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from plumbline.calibration import Calibration
from plumbline.comparison import Candidate
from plumbline.displacement import difference_px
from plumbline.frame import Array
from plumbline.models import CENTRE
from plumbline.wording import px

MATTERS_PX = 0.1
_STATED = 1.5
_NO_SUPPORT, _MUCH_SUPPORT = 10.0, 2.0
_CENTRE_GAIN = 3.0
_DECENTRED = {*CENTRE, "p1", "p2"}


class Rival(NamedTuple):
    """A row that another one does not agree with.

    Attributes:
        row: Its index.
        difference_px: The largest difference of their curves.
    """

    row: int
    difference_px: float


class Choice(NamedTuple):
    """What is recommended.

    Attributes:
        candidates: All rows, with their differences from the best.
        best: Index of the row that fits best for its number of coefficients.
        recommended: Index of the row to take.
        against_first: What the first row is not enough for: the rival that differs most, if any.
        against: The same for the recommended row, where no row is enough.
    """

    candidates: tuple[Candidate, ...]
    best: int
    recommended: int
    against_first: Rival | None
    against: Rival | None


def choose(candidates: Sequence[Candidate], points_px: Array) -> Choice:
    """Choose one of several fits to the same picks.

    Args:
        candidates: The fits, simple ones first; those without an AICc do not take part.
        points_px: Observed points over which curves are compared, shape (n, 2).
    """
    allowed = _allowed(candidates)
    order = sorted(allowed, key=lambda i: (len(candidates[i].free), i > 0, _aicc(candidates[i])))
    best = min(order, key=lambda i: _aicc(candidates[i]))
    against = {i: _strongest(i, candidates, allowed, points_px) for i in order}
    taken = next((i for i in order if against[i] is None), best)
    compared = tuple(
        replace(each, difference_px=_difference_px(each, candidates[best], points_px))
        if each.calibration
        else each
        for each in candidates
    )
    return Choice(compared, best, taken, against.get(0), against[taken])


def _allowed(candidates: Sequence[Candidate]) -> list[int]:
    """The rows that take part: those with a free centre or tangential terms where it helps."""
    usable = [index for index, each in enumerate(candidates) if each.aicc is not None]
    if not any(np.isfinite(_aicc(candidates[index])) for index in usable):
        return usable[:1]  # too few picks to compare anything
    plain = [index for index in usable if not _DECENTRED & {*candidates[index].free}]
    if not plain:
        return usable
    held = candidates[min(plain, key=lambda i: _aicc(candidates[i]))]
    return [i for i in usable if i in plain or _helps(candidates[i], held)]


def _helps(freed: Candidate, held: Candidate) -> bool:
    """Whether a free centre straightens lines left out, and is more than chance."""
    if freed.left_out_px is None or held.left_out_px is None:
        return False
    gain = _aicc(held) - _aicc(freed)
    return freed.left_out_px < held.left_out_px and gain > _CENTRE_GAIN


def _strongest(
    index: int, candidates: Sequence[Candidate], allowed: Sequence[int], points_px: Array
) -> Rival | None:
    """The rival that a row differs most from; None where it agrees with all: it is enough."""
    mine = candidates[index]
    lowest = min(_aicc(candidates[other]) for other in allowed)
    ruled_out = _aicc(mine) > lowest + _NO_SUPPORT
    allowance_px = max(MATTERS_PX, 0.0 if ruled_out else _STATED * (mine.error_px or 0.0))
    rivals = [
        Rival(other, _difference_px(mine, candidates[other], points_px))
        for other in allowed
        if other != index and _is_rival(candidates[other], mine)
    ]
    found = max(rivals, key=lambda rival: rival.difference_px, default=None)
    return None if found is None or found.difference_px <= allowance_px else found


def _is_rival(other: Candidate, mine: Candidate) -> bool:
    richer = len(other.free) > len(mine.free)
    return _aicc(other) <= _aicc(mine) + (_MUCH_SUPPORT if richer else _NO_SUPPORT)


def _aicc(candidate: Candidate) -> float:
    return np.inf if candidate.aicc is None else candidate.aicc


def _made(candidate: Candidate) -> Calibration:
    if candidate.calibration is None:
        raise ValueError(f"{candidate.name} was not fitted: {candidate.failure}")
    return candidate.calibration


def _difference_px(one: Candidate, other: Candidate, points_px: Array) -> float:
    here, there = _made(one).lens, _made(other).lens
    tangential = {*here.model.tangential, *there.model.tangential}
    perspective = bool(tangential & {*one.free, *other.free})
    return difference_px(here, there, points_px, perspective=perspective)


def reason(choice: Choice) -> str:
    """Whether b alone is enough and why, and why that row is taken: one sentence."""
    taken = choice.candidates[choice.recommended]
    why = _why_taken(choice)
    if choice.recommended == 0:
        return f"b alone is enough: {why}"
    return f"{_why_not_alone(choice)}; {taken.name} is recommended: {why}"


def _why_taken(choice: Choice) -> str:
    best, taken = choice.candidates[choice.best], choice.candidates[choice.recommended]
    if not np.isfinite(_aicc(taken)):
        return "so few picks cannot tell models apart, and none has fewer coefficients"
    if choice.against is not None:
        rival = choice.candidates[choice.against.row].name
        return (
            "no model fits better for its number of coefficients, but the picks do not rule out "
            f"{rival}, whose curve is up to {px(choice.against.difference_px)} away; more lines "
            "near the edges of the photo would tell"
        )
    if taken is best:
        return "no model fits better for its number of coefficients"
    off_px, error_px = taken.difference_px or 0.0, taken.error_px or 0.0
    if len(taken.free) > len(best.free):
        return (
            f"its standard error of {px(error_px)}, taken 1.5 times, allows for all models that "
            f"the picks do not rule out; that of {best.name}, which fits best for its number of "
            "coefficients, does not"
        )
    if off_px <= MATTERS_PX:
        what = f"which is less than {px(MATTERS_PX)} and does not matter"
    else:
        what = f"which its own standard error of {px(error_px)}, taken 1.5 times, allows for"
    return (
        f"within the range of the picks its curve is up to {px(off_px)} off that of {best.name}, "
        f"which fits best, {what}"
    )


def _why_not_alone(choice: Choice) -> str:
    alone, taken = choice.candidates[0], choice.candidates[choice.recommended]
    if alone.calibration is None:
        return f"b alone cannot be fitted: {alone.failure}"
    if alone.failure or choice.against_first is None:
        return f"b alone cannot be taken: {alone.failure}"
    rival = choice.candidates[choice.against_first.row]
    gain = _aicc(alone) - _aicc(rival)
    better = "fits better" if gain > 0 else "the picks do not rule out"
    return (
        "b alone is not enough: within the range of the picks its curve is up to "
        f"{px(choice.against_first.difference_px)} off that of {rival.name}, which {better}"
        + left_out(alone, taken)
    )


def left_out(one: Candidate, other: Candidate) -> str:
    """How straight either leaves lines that took no part in its fit."""
    if one.left_out_px is None or other.left_out_px is None:
        return ""
    return (
        f", and lines left out of the fit are straight to {px(one.left_out_px)} against "
        f"{px(other.left_out_px)}"
    )
