"""Is the result to be trusted? Checks of a finished fit, each with its remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbline.trust.assessment import Assessment
from plumbline.trust.check import Check
from plumbline.trust.next_line import next_line
from plumbline.trust.suspect import Suspect
from plumbline.wording import count, px

_CONDITION = 300.0
_UNSTEADY = 1.5
_LEAST_PX = 1.0
_WORTH = 0.9
_SIGNIFICANT = 2.5
_MATTERS_PX = 0.1


def after_fit(trust: Assessment) -> tuple[Check, ...]:
    """What can be said of picks and lens once they are fitted."""
    found = (
        _condition(trust),
        _correction(trust),
        _steady(trust),
        _model(trust),
        suspects_check(trust.suspects, trust.observations.n_points, robust=trust.robust),
    )
    return tuple(check for check in found if check is not None)


def _condition(trust: Assessment) -> Check:
    normal = trust.linearised.normal
    scale = np.sqrt(np.diag(normal))
    square = np.outer(scale, scale)
    balanced = np.divide(normal, square, out=np.zeros_like(normal), where=square > 0)
    least, most = np.linalg.eigvalsh(balanced)[[0, -1]].tolist()
    number = float(np.sqrt(most / least)) if least > 0 else float("inf")
    finding = f"condition number of the problem {number:,.0f}"
    if number <= _CONDITION:
        return Check("condition", True, finding)
    remedy = (
        "the free coefficients can hardly be told apart; pick lines at other distances from the "
        "centre, or free fewer"
    )
    return Check("condition", False, finding, remedy)


def _correction(trust: Assessment) -> Check:
    sure = trust.quoted_displacement
    if sure is None:
        return Check(
            "correction",
            False,
            "the model folds inside the photo, so that the error of the correction is not known",
            "free fewer coefficients, or pick lines closer to the corners",
        )
    finding = (
        f"the correction is uncertain by {px(sure.worst_px)} {sure.worst_place}, where it is worst "
        "(one standard error)"
    )
    more = next_line(trust)
    advice = ""
    if more is not None and more.to_px < _WORTH * more.from_px:
        lower = sure.worst_px * more.to_px / more.from_px
        advice = f"one more line {more.place} would lower that to about {px(lower)}"
    if sure.worst_px <= max(_LEAST_PX, abs(trust.finding.corner_px) / 20):
        return Check("correction", True, f"{finding}; {advice}" if advice else finding)
    return Check("correction", False, finding, advice or "pick more lines, nearer to the corners")


def _steady(trust: Assessment) -> Check | None:
    sure, wide = trust.displacement, trust.jackknife_displacement
    if sure is None:
        return None
    if wide is None:
        return Check(
            "line by line",
            False,
            "there is a line without which the others do not determine the lens, so that errors "
            "common to the picks of one line cannot be seen",
            "pick more lines",
        )
    ratio = wide.worst_px / sure.worst_px if sure.worst_px > 0 else 1.0
    if ratio <= _UNSTEADY:
        return Check(
            "line by line",
            True,
            f"quote {px(max(sure.worst_px, wide.worst_px))}, the larger of what independent "
            f"picking errors make ({px(sure.worst_px)}) and what leaving out one line at a time "
            f"says ({px(wide.worst_px)})",
        )
    return Check(
        "line by line",
        False,
        f"leaving out one line at a time, the correction is uncertain by {px(wide.worst_px)}, "
        f"{ratio:.1f} times what independent picking errors would make ({px(sure.worst_px)})",
        f"edges are not quite straight, or few lines carry the result; quote {px(wide.worst_px)}",
    )


def _model(trust: Assessment) -> Check | None:
    more = trust.model_error
    if more is None:
        return None
    finding = (
        f"a richer model (with {more.names}) would move the correction by up to "
        f"{px(more.largest_px)} (± {px(more.error_px)})"
    )
    if more.largest_px > max(_SIGNIFICANT * more.error_px, _MATTERS_PX):
        return Check("model", False, finding, "see plumbline compare")
    sure = trust.quoted_displacement
    if sure is None or more.largest_px <= max(sure.worst_px, _MATTERS_PX):
        return Check("model", True, finding)
    finding += ", more than the error to quote; the picks cannot tell whether it is needed"
    return Check("model", True, finding, doubtful=True)


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
