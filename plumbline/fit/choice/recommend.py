"""Which of the models fitted to the same picks to take.

The model with the lowest AICc is not yet the one to take. Of models that fit nearly alike one is
lowest by chance, and one with few coefficients states a small error whatever it cannot follow.
Therefore the truth is taken to be one of the fitted curves, give or take that one's own error,
each with its Akaike weight (K. Burnham and D. Anderson, 2002, section 2.9). How far a row may then
be off, its own picking errors and the choice of model together, is its overall error (their
unconditional standard error, section 4.3). Of the rows whose overall error is at most a fifth
larger than the smallest, or so small that it does not matter, that with the fewest coefficients is
taken. What is quoted with it is the error of its own fit, as everywhere: see `Calibration.quoted`.
Rows that the picks rule out, by an AICc higher by 10 ("essentially no support", section 2.6), are
taken only where their curve is within 0.1 px of the best.

The distortion centre, and the tangential terms that act like it, are ill-posed. Models that free
them are recommended only where lines left out of the fit become straighter by them, and AICc falls
by 6, which is evidence of 20 to 1; elsewhere they still count as what the truth may be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import exp, hypot, isfinite, sqrt
from typing import NamedTuple

from plumbline.frame import Array
from plumbline.models import CENTRE, get_model
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate
from plumbline.trust.displacement import difference_px

MATTERS_PX = 0.1
"""Chosen, because nobody picks or sees a tenth of a pixel."""
_AS_GOOD = 1.2
"""Chosen, because errors are themselves known to about a fifth."""
_NO_SUPPORT = 10.0
"""Essentially no support: K. Burnham and D. Anderson 2002, section 2.6."""
_CENTRE_GAIN = 6.0
"""Evidence of 20 to 1, exp(6 / 2): chosen."""


class Choice(NamedTuple):
    """What is recommended.

    Attributes:
        candidates: All rows, with their errors and their differences from the best.
        best: Index of the row that fits best for its number of coefficients.
        recommended: Index of the row to take.
        against_first: Index of the row that speaks most against the first: the best, or where the
            first is the best, the one that adds most to its overall error.
        against_first_px: How far apart their curves are.
    """

    candidates: tuple[Candidate, ...]
    best: int
    recommended: int
    against_first: int
    against_first_px: float


def choose(candidates: Sequence[Candidate], points_px: Array) -> Choice:
    """Choose one of several fits to the same picks.

    Args:
        candidates: The fits, simple ones first; those without an AICc do not take part.
        points_px: Observed points over which curves are compared, shape (n, 2).
    """
    allowed = _allowed(candidates)
    best = min(allowed, key=lambda i: aicc(candidates[i]))
    weights = _weights(candidates)
    apart = {
        i: {j: curves_apart_px(each, candidates[j], points_px) for j in {*weights, best}}
        for i, each in enumerate(candidates)
        if each.calibration
    }
    compared = tuple(
        replace(each, difference_px=apart[i][best] if i in apart else None)
        for i, each in enumerate(candidates)
    )
    overall_px = {
        i: _overall_px(candidates[i], candidates, weights, apart[i])
        for i in allowed
        if not ruled_out(candidates[i], candidates[best]) or apart[i][best] <= MATTERS_PX
    }
    limit_px = max(MATTERS_PX / 2, _AS_GOOD * min(overall_px.values()))
    good = [i for i, size_px in overall_px.items() if size_px <= limit_px]
    taken = min(good, key=lambda i: (len(candidates[i].free), overall_px[i]))
    against = max(weights, key=lambda j: weights[j] * apart[0][j]) if 0 in apart else 0
    against = best if best != 0 else against
    return Choice(compared, best, taken, against, apart.get(0, {}).get(against, 0.0))


def _allowed(candidates: Sequence[Candidate]) -> list[int]:
    """The rows to choose from: those with a free centre or tangential terms where it helps."""
    usable = [index for index, each in enumerate(candidates) if each.aicc is not None]
    if not any(isfinite(aicc(candidates[index])) for index in usable):
        return usable[:1]  # too few picks to compare anything
    plain = [index for index in usable if not _decentred(candidates[index])]
    if not plain:
        return usable
    held = candidates[min(plain, key=lambda i: aicc(candidates[i]))]
    return [i for i in usable if i in plain or _helps(candidates[i], held)]


def _decentred(candidate: Candidate) -> bool:
    """Whether a row frees the distortion centre, or the tangential terms that act like it."""
    model = get_model(candidate.model)
    return model.decentred(candidate.free) or not set(CENTRE).isdisjoint(candidate.free)


def _helps(freed: Candidate, held: Candidate) -> bool:
    """Whether a free centre straightens lines left out, and is more than chance."""
    if freed.left_out_px is None or held.left_out_px is None:
        return False
    gain = aicc(held) - aicc(freed)
    return freed.left_out_px < held.left_out_px and gain > _CENTRE_GAIN


def _weights(candidates: Sequence[Candidate]) -> dict[int, float]:
    """Akaike weights of all rows that have an AICc; of the first usable one if none has."""
    known = {i: each.aicc for i, each in enumerate(candidates) if each.aicc is not None}
    finite = {i: value for i, value in known.items() if isfinite(value)}
    if not finite:
        return {min(known): 1.0}
    lowest = min(finite.values())
    raw = {i: exp((lowest - value) / 2) for i, value in finite.items()}
    return {i: value / sum(raw.values()) for i, value in raw.items()}


def _overall_px(
    mine: Candidate,
    candidates: Sequence[Candidate],
    weights: dict[int, float],
    apart: dict[int, float],
) -> float:
    """The unconditional standard error, and never less than the row's own."""
    off_px = (sqrt(w) * hypot(error_px(candidates[j]), apart[j]) for j, w in weights.items())
    return max(error_px(mine), hypot(*off_px))


def ruled_out(candidate: Candidate, best: Candidate) -> bool:
    """Whether the picks rule a row out, beside the best one."""
    return aicc(candidate) > aicc(best) + _NO_SUPPORT


def aicc(candidate: Candidate) -> float:
    """AICc; infinite where there is none."""
    return float("inf") if candidate.aicc is None else candidate.aicc


def error_px(candidate: Candidate) -> float:
    """The largest standard error of a row's own; 0 where there is none."""
    return candidate.error_px or 0.0


def curves_apart_px(one: Candidate, other: Candidate, points_px: Array) -> float:
    """The largest difference of the curves of two rows that were fitted."""
    here, there = _calibration_of(one).lens, _calibration_of(other).lens
    perspective = here.model.decentred(one.free) or there.model.decentred(other.free)
    return difference_px(here, there, points_px, perspective=perspective)


def _calibration_of(candidate: Candidate) -> Calibration:
    if candidate.calibration is None:
        raise ValueError(f"{candidate.name} was not fitted: {candidate.failure}")
    return candidate.calibration
