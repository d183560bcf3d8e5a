"""The tables and lists of a page."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from plumbline.models import CENTRE
from plumbline.report.page.figures import photo_name
from plumbline.report.page.markup import Element, Node, table, tag
from plumbline.report.terminal.comparison import coefficient_texts, figures
from plumbline.report.terminal.summary import decimals
from plumbline.result.calibration import Calibration
from plumbline.result.comparison import Candidate, Comparison
from plumbline.result.pair import PairCalibration
from plumbline.trust.check import Check
from plumbline.trust.straightness import edges_bend_px
from plumbline.trust.student import quantile
from plumbline.trust.suspect import Suspect
from plumbline.wording import count, number, px

_STRONG = 0.9
"""As `plumbline.result.notes` has it."""

_MOST_ROWS = 500
"""Lines and suspects of a table, the worst; chosen, because more fill ten pages."""

_MOST_PICKS = 3_000
"""Chosen, because more fill over fifty pages, which nobody reads; the JSON holds all."""


def coefficients(calibration: Calibration) -> Iterator[Element]:
    """Values, standard errors and intervals; beside them those of the jackknife."""
    errors = [(calibration.standard_errors, calibration.dof)]
    head = ["coefficient", "value", "start", "± std. error", "95 % interval"]
    left = calibration.jackknife
    if left is not None:
        deviations = np.sqrt(np.diag(left.covariance)).tolist()
        errors.append((dict(zip(calibration.free, deviations, strict=True)), left.dof))
        head += ["± line by line", "95 % interval"]
    rows: list[list[Node]] = []
    for name, value in calibration.coefficients.items():
        least, unit = (3, " px") if name in CENTRE else (6, "")
        digits = decimals(calibration.standard_errors.get(name, value), least)
        shown = number(value, f".{digits}f") + unit
        if name not in calibration.free:
            rows.append([name, shown, "held", *[""] * (len(head) - 3)])
            continue
        row: list[Node] = [name, shown, number(calibration.start[name], "g")]
        for deviation, dof in errors:
            error = deviation[name]
            reach = quantile(0.975, dof) * error
            row.append(f"± {error:.{digits}f}{unit}")
            ends = [number(value + sign * reach, f".{digits}f") for sign in (-1, 1)]
            row.append(f"{' … '.join(ends)}{unit}")
        rows.append(row)
    yield table(head, rows)
    yield tag(
        "p",
        f"σ̂ = {calibration.sigma_px:.3f} px, the scatter of one pick across its line, with "
        f"{count(calibration.dof, 'degree')} of freedom. {_standing(calibration)}",
        class_="muted",
    )


def _standing(calibration: Calibration) -> str:
    """What standard errors hold for."""
    straight_px = edges_bend_px(calibration.lines)
    if straight_px is None:
        return (
            "Standard errors hold for independent picking errors on straight edges; those line by "
            "line (jackknife) also see errors that the picks of one line share."
        )
    return (
        f"The edges are straight to {px(straight_px)} (rms), which standard errors hold: each "
        "weighs as it bends. Those line by line (jackknife) leave out parallel neighbours together "
        "and also see bends that these share."
    )


def correlations(calibration: Calibration) -> Element | None:
    """The correlation matrix of the free coefficients, strong ones marked."""
    if len(calibration.free) < 2:
        return None
    rows: list[list[Node]] = []
    for i, name in enumerate(calibration.free):
        values = [
            (number(value, "+.3f"), abs(value) > _STRONG) for value in calibration.correlation[i]
        ]
        marked = [
            tag("b", text) if strong and i != j else text for j, (text, strong) in enumerate(values)
        ]
        rows.append([name, *marked])
    return table(["", *calibration.free], rows)


def straightness(calibration: Calibration) -> Element:
    """Every line before and after, or the worst of many."""
    photos = calibration.observations.photos
    several = len(photos) > 1
    paired = isinstance(calibration, PairCalibration)
    head = ["part (row.column)" if paired else "line", *(["photo"] if several else [])]
    head.append("matches" if paired else "points")
    if calibration.robust:
        head.append("left out")
    head += ["rms before, px", "rms after, px", "largest after, px"]
    measured = calibration.lines
    worst = sorted(range(len(measured)), key=lambda n: -measured[n].largest_after_px)[:_MOST_ROWS]
    bent = calibration.bends is not None
    head += ["bend, px"] if bent else []
    rows: list[list[Node]] = []
    for index in sorted(worst):
        line, kept = measured[index], calibration.kept[index]
        row: list[Node] = [line.label, *([photo_name(photos[line.photo])] if several else [])]
        row.append(str(line.n_points))
        if calibration.robust:
            row.append(str(int(np.count_nonzero(~kept))))
        numbers = [line.rms_before_px, line.rms_after_px, line.largest_after_px]
        numbers += [line.bend_px or 0.0] if bent else []
        shown = [f"{value:.2f}" for value in numbers]
        if line.left_out:
            shown = ["left out", *[""] * (len(numbers) - 1)]
        rows.append([*row, *shown])
    return tag(
        "div", _only_the_worst(len(measured), "line"), table(head, rows, text=range(1 + several))
    )


def _only_the_worst(total: int, noun: str) -> Element | None:
    if total <= _MOST_ROWS:
        return None
    return tag("p", f"The {_MOST_ROWS} of {count(total, noun)} with the largest residuals.")


def suspects(calibration: Calibration) -> Element:
    """Every suspicious pick with its residual."""
    if not calibration.suspects:
        n_points = calibration.observations.n_points
        return tag("p", f"None of the {count(n_points, 'pick')} is suspicious.")
    rows: list[list[Node]] = [
        [
            f"{each.sentence}.",
            _finite(each.residual_px, ".2f"),
            _finite(each.studentised, ".1f"),
            _fate(calibration, each),
        ]
        for each in calibration.suspects[:_MOST_ROWS]
    ]
    head = ("what it looks like", "residual, px", "in its own σ̂", "fit")
    more = len(calibration.suspects) - len(rows)
    rest = tag("p", f"{more:,} more in the JSON of the result.") if more else None
    return tag("div", table(head, rows), rest)


def _fate(calibration: Calibration, suspect: Suspect) -> str:
    if not suspect.left_out:
        return "kept"
    return "left out" if calibration.robust else "kept; --robust would leave it out"


def _finite(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "beyond the fold"


def checks(calibration: Calibration) -> Element:
    """Whether lines are well placed and the result is to be trusted, and the remedies."""
    rows: list[list[Node]] = []
    for check in calibration.checks:
        verdict = _verdict(check)
        kind = "doubtful" if check.passed else "bad"
        remedy = tag("div", f"→ {check.remedy}", class_=kind) if check.remedy else None
        rows.append([check.name, verdict, tag("div", check.finding, remedy)])
    return table(("check", "", "finding and remedy"), rows, text=(0, 1, 2))


def _verdict(check: Check) -> Node:
    if check.passed and not check.doubtful:
        return tag("span", "✓ good", class_="good")
    if check.passed:
        return tag("span", "? doubtful", class_="doubtful")
    return tag("span", "✗ bad", class_="bad")


def comparison(compared: Comparison, *, quoted: bool) -> Iterator[Element]:
    """The models side by side, and the one to take.

    Args:
        compared: The models.
        quoted: Whether its error to quote is of the model that was fitted.
    """
    chosen = compared.candidates[compared.recommended]
    yield tag("p", tag("b", f"Recommended: {chosen.name}."), f" {compared.reason}.")
    notes = [note for note in compared.notes if quoted or note != compared.quote]
    if notes:
        yield tag("ul", *(tag("li", note) for note in notes))
    head = (
        "model",
        "coefficients",
        "rms, px",
        "ΔAICc",
        "left out, px",
        "off best, px",
        "error, px",
        "folds",
    )
    rows = [_candidate(each, index, compared) for index, each in enumerate(compared.candidates)]
    yield table(head, rows, text=(0, 1))
    yield tag(
        "p",
        "ΔAICc: AICc above the lowest. Left out: root mean square residual of lines that did not "
        "take part in the fit. Off best: the largest difference from the best row over the range "
        "of the picks. Error: the standard error to quote.",
        class_="muted",
    )


def _candidate(each: Candidate, index: int, compared: Comparison) -> list[Node]:
    name = tag("b", each.name) if index == compared.recommended else each.name
    equals = tag("div", f"= {', '.join(each.equals)}", class_="muted") if each.equals else None
    model = tag("div", name, equals)
    calibration = each.calibration
    if calibration is None or each.aicc is None:
        return [model, each.failure, *figures(each, compared)]
    values = tag("div", *(tag("div", text) for text in coefficient_texts(calibration)))
    return [model, values, *figures(each, compared)]


def errors(calibration: Calibration) -> Iterator[str]:
    """Where the error to quote comes from, in sentences."""
    sure, wide = calibration.displacement, calibration.jackknife_displacement
    if sure is None:
        return
    if calibration.quoted is not None:
        left = "" if wide is None else f", leaving out one line at a time {px(wide.worst_px)}"
        yield f"The error to quote and its parts: {calibration.quoted.sentence}."
        yield (
            f"Over the whole photo independent picking errors give {px(sure.worst_px)}{left}; what "
            "the picks give is drawn from both and widened for few degrees of freedom."
        )
    elif calibration.quotes_jackknife:
        yield (
            "The error to quote comes from leaving out one line at a time, and not from "
            f"independent picking errors, which give {px(sure.worst_px)}: picks of one line err "
            "together, or few lines carry the result."
        )
    elif wide is not None:
        yield (
            "The error to quote holds for independent picking errors; leaving out one line at a "
            f"time gives {px(wide.worst_px)}."
        )
    else:
        yield "The error to quote holds for independent picking errors only."


def further_notes(calibration: Calibration) -> list[str]:
    """The notes that no table of the page holds already."""
    told = {check.sentence for check in calibration.checks}
    return [note for note in calibration.notes if note not in told]


def picks(calibration: Calibration) -> Iterator[Element]:
    """Every pick with its residual, one small table a line."""
    photos, n_points = calibration.observations.photos, calibration.observations.n_points
    yield tag(
        "p",
        f"{count(n_points, 'pick')} in pixels of the photo, from the centre of its top-left "
        "pixel; residuals in pixels, in the order along each line.",
        class_="muted",
    )
    shown = 0
    blocks: list[Element] = []
    every = zip(
        calibration.observations.lines, calibration.residuals_px, calibration.kept, strict=True
    )
    for line, residuals_px, kept in every:
        if shown + len(kept) > _MOST_PICKS:
            break
        shown += len(kept)
        photo = f" in {photo_name(photos[line.photo])}" if len(photos) > 1 else ""
        title = tag("b", f"line {line.label}{photo}")
        rows: list[list[Node]] = [
            [
                str(number),
                f"{x:.2f}",
                f"{y:.2f}",
                _finite(residual, "+.2f") if fitted else "left out",
            ]
            for number, ((x, y), residual, fitted) in enumerate(
                zip(line.points_px.tolist(), residuals_px.tolist(), kept.tolist(), strict=True), 1
            )
        ]
        blocks.append(tag("div", title, table(("pick", "x", "y", "residual"), rows)))
    yield tag("div", *blocks, class_="picks")
    if shown < n_points:
        yield tag("p", f"{count(n_points - shown, 'more pick')} in the JSON of the result.")
