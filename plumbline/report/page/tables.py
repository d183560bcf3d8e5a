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
from plumbline.trust.student import quantile
from plumbline.trust.suspect import Suspect
from plumbline.wording import count, px

_STRONG = 0.9


def coefficients(made: Calibration) -> Iterator[Element]:
    """Values, standard errors and intervals; beside them those of the jackknife."""
    errors = [(made.standard_errors, made.dof)]
    head = ["coefficient", "value", "start", "± std. error", "95 % interval"]
    left = made.jackknife
    if left is not None:
        deviations = np.sqrt(np.diag(left.covariance)).tolist()
        errors.append((dict(zip(made.free, deviations, strict=True)), left.dof))
        head += ["± line by line", "95 % interval"]
    rows: list[list[Node]] = []
    for name, value in made.coefficients.items():
        least, unit = (3, " px") if name in CENTRE else (6, "")
        digits = decimals(made.standard_errors.get(name, value), least)
        shown = f"{value:.{digits}f}{unit}"
        if name not in made.free:
            rows.append([name, shown, "held", *[""] * (len(head) - 3)])
            continue
        row: list[Node] = [name, shown, f"{made.start[name]:g}"]
        for deviation, dof in errors:
            error = deviation[name]
            reach = quantile(0.975, dof) * error
            row.append(f"± {error:.{digits}f}{unit}")
            row.append(f"{value - reach:.{digits}f} … {value + reach:.{digits}f}{unit}")
        rows.append(row)
    yield table(head, rows)
    yield tag(
        "p",
        f"σ̂ = {made.sigma_px:.3f} px, the scatter of one pick across its line, with "
        f"{count(made.dof, 'degree')} of freedom. Standard errors hold for independent picking "
        "errors on straight edges; those line by line (jackknife) also see errors that the picks "
        "of one line share.",
        class_="muted",
    )


def correlations(made: Calibration) -> Element | None:
    """The correlation matrix of the free coefficients, strong ones marked."""
    if len(made.free) < 2:
        return None
    rows: list[list[Node]] = []
    for i, name in enumerate(made.free):
        values = [(f"{value:+.3f}", abs(value) > _STRONG) for value in made.correlation[i]]
        marked = [
            tag("b", text) if strong and i != j else text for j, (text, strong) in enumerate(values)
        ]
        rows.append([name, *marked])
    return table(["", *made.free], rows)


def straightness(made: Calibration) -> Element:
    """Every line before and after."""
    photos = made.observations.photos
    several = len(photos) > 1
    paired = isinstance(made, PairCalibration)
    head = ["part (row.column)" if paired else "line", *(["photo"] if several else [])]
    head.append("matches" if paired else "points")
    if made.robust:
        head.append("left out")
    head += ["rms before, px", "rms after, px", "largest after, px"]
    rows: list[list[Node]] = []
    for line, kept in zip(made.lines, made.kept, strict=True):
        row: list[Node] = [line.label, *([photo_name(photos[line.photo])] if several else [])]
        row.append(str(line.n_points))
        if made.robust:
            row.append(str(int(np.count_nonzero(~kept))))
        numbers = (line.rms_before_px, line.rms_after_px, line.largest_after_px)
        shown = ["left out", "", ""] if line.left_out else [f"{number:.2f}" for number in numbers]
        rows.append([*row, *shown])
    return table(head, rows, text=range(1 + several))


def suspects(made: Calibration) -> Element:
    """Every suspicious pick with its residual."""
    if not made.suspects:
        n_points = made.observations.n_points
        return tag("p", f"None of the {count(n_points, 'pick')} is suspicious.")
    rows: list[list[Node]] = [
        [
            f"{each.sentence}.",
            _finite(each.residual_px, ".2f"),
            _finite(each.studentised, ".1f"),
            _fate(made, each),
        ]
        for each in made.suspects
    ]
    head = ("what it looks like", "residual, px", "in its own σ̂", "fit")
    return table(head, rows)


def _fate(made: Calibration, suspect: Suspect) -> str:
    if not suspect.left_out:
        return "kept"
    return "left out" if made.robust else "kept; --robust would leave it out"


def _finite(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "beyond the fold"


def checks(made: Calibration) -> Element:
    """Whether lines are well placed and the result is to be trusted, and the remedies."""
    rows: list[list[Node]] = []
    for check in made.checks:
        verdict = _verdict(check)
        kind = "doubtful" if check.passed else "bad"
        remedy = tag("div", f"→ {check.remedy}", class_=kind) if check.remedy else None
        rows.append([check.name, verdict, tag("div", check.finding, remedy)])
    return table(("check", "", "finding and remedy"), rows, text=(0, 1, 2))


def _verdict(check: Check) -> Node:
    if check.passed and not check.doubtful:
        return "✓ good"
    if check.passed:
        return tag("span", "? doubtful", class_="doubtful")
    return tag("span", "✗ bad", class_="bad")


def comparison(compared: Comparison) -> Iterator[Element]:
    """The models side by side, and the one to take."""
    chosen = compared.candidates[compared.recommended]
    yield tag("p", tag("b", f"Recommended: {chosen.name}."), f" {compared.reason}.")
    if compared.notes:
        yield tag("ul", *(tag("li", note) for note in compared.notes))
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
        "of the picks. Error: the largest standard error there, with what the models disagree by.",
        class_="muted",
    )


def _candidate(each: Candidate, index: int, compared: Comparison) -> list[Node]:
    name = tag("b", each.name) if index == compared.recommended else each.name
    equals = tag("div", f"= {', '.join(each.equals)}", class_="muted") if each.equals else None
    model = tag("div", name, equals)
    made = each.calibration
    if made is None or each.aicc is None:
        return [model, each.failure, *figures(each, compared)]
    values = tag("div", *(tag("div", text) for text in coefficient_texts(made)))
    return [model, values, *figures(each, compared)]


def quote(made: Calibration) -> Iterator[str]:
    """The error to quote, in sentences."""
    sure, other = made.quoted_displacement, made.displacement
    if sure is None or other is None:
        yield "The model folds inside the photo, so that the error of the correction is not known."
        return
    left = made.jackknife
    dof = left.dof if made.quotes_jackknife and left is not None else made.dof
    interval = px(quantile(0.975, dof) * sure.worst_px)
    yield (
        f"Error to quote: the correction is uncertain by {px(sure.worst_px)} {sure.worst_place}, "
        f"where it is worst (one standard error; 95 %: ± {interval})."
    )
    wide = made.jackknife_displacement
    if made.quotes_jackknife:
        yield (
            "It comes from leaving out one line at a time, and not from independent picking "
            f"errors, which would make {px(other.worst_px)}: picks of one line err together, or "
            "few lines carry the result."
        )
    elif wide is not None:
        yield (
            f"It holds for independent picking errors; leaving out one line at a time says "
            f"{px(wide.worst_px)}."
        )
    else:
        yield "It holds for independent picking errors; errors common to one line are not in it."
    more = made.model_error
    if more is not None:
        yield (
            f"Not in it is the model's own error: a richer model (with {more.names}) would move "
            f"the correction by up to {px(more.largest_px)} (± {px(more.error_px)})."
        )
