"""Is the result to be trusted? Checks of a finished fit, each with its remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.frame import Array
from plumbline.models import CENTRE
from plumbline.trust.assessment import Assessment
from plumbline.trust.check import Check
from plumbline.trust.next_line import worthwhile_line
from plumbline.trust.nuisances import DECENTRING, RADIAL
from plumbline.trust.rival import agreement_check
from plumbline.trust.straightness import straightness_before
from plumbline.trust.suspect import Suspect
from plumbline.wording import count, joined, listed, number, px

_CONDITION = 300.0
"""Condition number of the balanced Jacobian from which on coefficients can hardly be told apart:
chosen; a, b and c on lines at several distances have 60 to 150."""

_LEAST_PX, _LITTLE = 1.0, 1 / 20
"""An error is small below a pixel, or a twentieth of the distortion: chosen, because nobody sees
the first, and the second still removes 95 % of the bend."""


_SIGNIFICANT = 3.3
"""Standard errors from which on one more power is needed: chosen, one in a thousand by chance."""

_MATTERS_PX = 0.1
"""What less than this moves nobody can pick: chosen, as for the choice of a model."""

_WORSE = 1.25
"""How much less straight a line gets before it is named: chosen, beyond what five picks of σ̂
scatter by."""

_MORE = "pick more lines, nearer to the corners"


def after_fit(trust: Assessment) -> tuple[Check, ...]:
    """What can be said of picks and lens once they are fitted."""
    found = (
        _agreement(trust),
        _condition(trust),
        _correction(trust),
        _steady(trust),
        _model(trust),
        centre_check(trust),
        _worse_lines(trust),
        _same_edges(trust),
        suspects_check(trust.suspects, trust.observations.n_points, robust=trust.robust),
    )
    return tuple(check for check in found if check is not None)


def _agreement(trust: Assessment) -> Check | None:
    n_points, radius_px = trust.observations.n_points, trust.lens.frame.radius_px
    return agreement_check(trust.rival_px, trust.suspects, n_points, trust.sigma_px, radius_px)


def _condition(trust: Assessment) -> Check:
    normal = trust.weighed.normal
    scale = np.sqrt(np.diag(normal))
    square = np.outer(scale, scale)
    balanced = np.divide(normal, square, out=np.zeros_like(normal), where=square > 0)
    least, most = np.linalg.eigvalsh(balanced)[[0, -1]].tolist()
    number = float(np.sqrt(most / least)) if least > 0 else float("inf")
    finding = f"condition number of the problem {number:,.0f}; good up to {_CONDITION:,.0f}"
    if number <= _CONDITION:
        return Check("condition", True, finding)
    remedy = (
        "the free coefficients can hardly be told apart; pick lines at other distances from the "
        "centre, or free fewer"
    )
    return Check("condition", False, finding, remedy)


def _correction(trust: Assessment) -> Check:
    sure = trust.quoted
    if sure is None:
        return Check(
            "correction",
            False,
            "the model folds inside the photo, so that the error of the correction is not known",
            "free fewer coefficients, or pick lines closer to the corners",
        )
    more, advice = worthwhile_line(trust), ""
    if more is not None:
        advice = f"{more[0].words}, would lower that to about ±{px(more[1])}"
    if sure.worst_px <= max(_LEAST_PX, abs(trust.finding.corner_px) * _LITTLE):
        finding = f"{sure.sentence}; {advice}" if advice else sure.sentence
        return Check("correction", True, finding)
    if not advice and sure.missed_px > sure.picks_px:
        advice = "no line helps much; a free distortion centre (--free) or another model may"
    return Check("correction", False, sure.sentence, advice or _MORE)


def _steady(trust: Assessment) -> Check | None:
    if trust.displacement is None:
        return None
    steady = trust.steadiness
    if steady is None:
        return Check(
            "line by line",
            False,
            "there is a line without which the others do not determine the lens, so that errors "
            "common to the picks of one line cannot be seen",
            "pick more lines",
        )
    left, made = "one line", "independent picking errors"
    if trust.bends is not None:
        left, made = "one line and its parallel neighbours", "noise and each line's own bend"
    told = (
        f"leaving out {left} at a time makes the correction uncertain by "
        f"±{px(steady.left_out_px)}, {steady.ratio:.1f} times what {made} "
        f"explain (±{px(steady.own_px)}); for lines placed like these, chance alone gives up to "
        f"{steady.limit:.1f} times"
    )
    if not steady.alarmed:
        return Check("line by line", True, told)
    if trust.besides.unlike(RADIAL) or trust.besides.unlike(DECENTRING):
        return Check("line by line", True, f"{told}; the model is the likelier reason", "", True)
    remedy = (
        "edges are not quite straight, or few lines carry the result; the error to quote allows "
        "for this"
    )
    return Check("line by line", False, told, remedy)


def _model(trust: Assessment) -> Check | None:
    more = trust.model_error
    if more is None:
        return None
    finding = (
        f"a richer model (with {more.names}) would move the correction by up to "
        f"{px(more.largest_px)} (± {px(more.error_px)})"
    )
    alone = more.largest_px > max(_SIGNIFICANT * more.error_px, _MATTERS_PX)
    if alone or trust.besides.unlike(RADIAL):
        return Check(
            "model",
            False,
            f"{finding}: this model does not follow the lens",
            "see plumbline compare",
        )
    sure = trust.quoted
    if sure is None or more.largest_px <= max(sure.worst_px, _MATTERS_PX):
        return Check("model", True, finding)
    finding += ", more than the error to quote; the picks cannot tell whether it is needed"
    return Check("model", True, finding, doubtful=True)


def centre_check(trust: Assessment) -> Check | None:
    """Whether the picks put the distortion centre elsewhere than it is held."""
    held = trust.nuisances.centre
    if len(held) < len(CENTRE):
        return None
    step = trust.besides.centre_step
    if step is None or not trust.besides.unlike(DECENTRING):
        return Check("centre", True, "the picks do not contradict the distortion centre")
    spread = trust.nuisances.spreads[: len(held)]
    k = step.n_free
    shifts = step.change[k:] * spread
    errors = np.sqrt(np.diag(step.covariance)[k:]) * spread
    where = ", ".join(
        f"{name} = {number(trust.lens.coefficients[name] + shift, '+.1f')} ± {error:.1f} px"
        for name, shift, error in zip(held, shifts.tolist(), errors.tolist(), strict=True)
    )
    remedy = f"free it: --free {','.join((*trust.free, *held))}"
    return Check("centre", False, f"the picks put the distortion centre at {where}", remedy)


def _worse_lines(trust: Assessment) -> Check | None:
    """Lines that the correction makes less straight."""
    linear = trust.linearised
    number = np.maximum(np.bincount(linear.line[linear.kept], minlength=linear.n_lines), 1)

    def spread(values: Array) -> Array:
        squares = np.where(linear.kept, values, 0.0) ** 2
        return np.sqrt(np.bincount(linear.line, squares, linear.n_lines) / number)

    before = np.concatenate(straightness_before(trust.observations, trust.kept))
    was, now = spread(before), spread(np.where(linear.kept, linear.image_px, 0.0))
    # A line that was straight by chance bends by as much as σ̂ without anything being wrong.
    worse = np.flatnonzero((now > _WORSE * was) & (now > _WORSE * trust.sigma_px))
    if not len(worse):
        return None
    labels = [trust.observations.lines[line].label for line in worse.tolist()]
    told = listed(
        [f"{n} ({was[i]:.2f} to {now[i]:.2f} px)" for i, n in zip(worse, labels, strict=True)]
    )
    return Check(
        "straighter",
        False,
        f"the correction makes {count(len(labels), 'line')} less straight: {told}",
        "look whether their picks lie on one edge each, and compare the models",
    )


def _same_edges(trust: Assessment) -> Check | None:
    """Lines that run along one edge."""
    first, times = np.unique(trust.edges, return_counts=True)
    if not np.any(times > 1):
        return None
    labels = [line.label for line in trust.observations.lines]
    told = [
        joined([labels[line] for line in np.flatnonzero(trust.edges == edge).tolist()])
        for edge in first[times > 1].tolist()
    ]
    return Check(
        "edges",
        True,
        f"picked more than once along one edge: lines {listed(told)}; their picks count as further "
        "measurements, and the jackknife leaves them out together",
        doubtful=True,
    )


def suspects_check(suspects: Sequence[Suspect], n_points: int, *, robust: bool) -> Check:
    """Which picks are wrong, and what to do about them.

    Args:
        suspects: The suspicious picks.
        n_points: Number of all picks.
        robust: Whether suspicious picks were left out.
    """
    out = sum(len(suspect.picks) for suspect in suspects if suspect.left_out)
    odd = sum(not suspect.left_out for suspect in suspects)
    if not suspects:
        return Check("suspects", True, f"none of the {count(n_points, 'pick')} is suspicious")
    oddities = "1 oddity" if odd == 1 else f"{odd:,} oddities"
    kind = "(a bent line or a place picked twice)"
    look = "look at it" if out + odd == 1 else "look at each of them"
    if not out:
        return Check("suspects", False, f"{oddities} {kind} on the lines", look)
    finding = f"{count(out, 'pick')} of {n_points:,} "
    if robust:
        finding += "left out as suspicious"
    else:
        finding += "is suspicious" if out == 1 else "are suspicious"
        look += f", or leave {'it' if out == 1 else 'them'} out with --robust"
    if odd:
        finding += f", and {oddities} besides {kind}"
    return Check("suspects", False, finding, look)


def doubt(trust: Assessment) -> str:
    """Why the fitted model is not to be trusted, in half a sentence; empty where nothing is."""
    for check in (_agreement(trust), centre_check(trust), _model(trust)):
        if check is not None and not check.passed:
            return f"{check.finding}: {check.remedy}"
    return ""
