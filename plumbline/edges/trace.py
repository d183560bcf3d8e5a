"""Trace one edge between rough picks: the single-line step that everything else repeats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.edges.guide import Guide, GuideError, through_picks
from plumbline.edges.light import Light
from plumbline.edges.refine import Samples, refined
from plumbline.edges.response import Kind
from plumbline.edges.search import SAME_PX, Curve, Wanted, apart, curves
from plumbline.edges.strip import cut
from plumbline.errors import OptionError
from plumbline.frame import Array
from plumbline.geometry.lens import Lens

SCATTER_PX = 2.0
"""Scatter of picks that nothing is known of: hand picks on façades scatter by 1 to 3 px."""

LEAST_SUPPORT = 0.3
"""Share of a line with an edge under it below which it is refused: façades with trees before
them kept 0.4 and more, chance edges in texture reached 0.2."""

_SEARCH_ROWS = 64
"""Stretches that the search looks at: enough to tell a gap, few enough for one click."""

_EXTRA_PX = 3.0
"""Room beside three times the scatter for what the lens known so far is wrong by."""

_AWAY = 3.0
"""Picks farther from the edge than this many times their scatter were meant for another."""

_AS_GOOD = 0.05
"""Support by which a rival may be worse and still be as good."""

_PARALLEL_PX = 2.0
"""Change of the distance of two curves over their length up to which they are parallel edges of
one structure: both are straight, and either will do."""

_CLIPPED = 0.5
"""Share of clipped samples from which an edge is refused (chosen, because the median then is)."""

_RIVAL_NODES = 33
"""Places at which a rival's curve is given: chosen, it is drawn."""
_RIVALS = 4
"""Chosen: more nobody steps through."""


@dataclass(frozen=True, eq=False)
class Rival:
    """Another edge that the picks could mean.

    Attributes:
        points_px: A few points along it, shape (k, 2).
        support: Share of it with an edge under it, 0 to 1.
    """

    points_px: Array
    support: float


@dataclass(frozen=True, eq=False)
class Traced:
    """An edge of a photo, sampled; or why there is none.

    Attributes:
        points_px: Samples along the edge, shape (n, 2); empty where it is refused.
        errors_px: Standard error of each across the edge, shape (n,).
        support: Share of the way between the picks with this edge under it, 0 to 1.
        kind: "rising" or "falling" light to the right of or below the edge, "dark" for a groove,
            "bright" for a wire, "either" for a change of both signs; None where there is none.
        width_px: Standard deviation of its blur.
        distance_px: Root mean square distance of the picks from it.
        rivals: Other edges that the picks could mean, the best first.
        refusal: Why it is refused; empty where it is not.
        doubt: Why a rival may be meant as well; empty where none is as good.
    """

    points_px: Array
    errors_px: Array
    support: float = 0.0
    kind: Kind | None = None
    width_px: float = 0.0
    distance_px: float = 0.0
    rivals: tuple[Rival, ...] = ()
    refusal: str = ""
    doubt: str = ""

    @property
    def found(self) -> bool:
        """Whether there is an edge."""
        return not self.refusal


def trace(
    image: Light,
    picks_px: Array,
    lens: Lens | None = None,
    *,
    scatter_px: float = SCATTER_PX,
    sag_px: float | None = None,
    rival: int = 0,
    choosing: bool = False,
) -> Traced:
    """Trace the edge that rough picks mean.

    Args:
        image: Linear light, shape (height, width), from `plumbline.edges.light.linear_light`.
        picks_px: Shape (n, 2), at least two, x and y in pixels of the image.
        lens: The lens as far as it is known; predicts how the edge bends between the picks.
        scatter_px: Standard deviation of a pick across the edge.
        sag_px: How far the edge's middle may be from where the lens bends it to; by default what
            that scatter allows.
        rival: 0 for the edge that is most likely meant, 1 for the next, and so on.
        choosing: Whether somebody looks at the edge, and may ask for a rival: of two that are as
            good the first is then found, with a doubt, and not refused.

    Returns:
        The edge; a refusal is a value, not an error.

    Raises:
        OptionError: the picks are not an array (n, 2) of numbers, or fewer than two.
    """
    picks = np.asarray(picks_px, dtype=np.float64)
    if picks.ndim != 2 or picks.shape[1] != 2 or len(picks) < 2 or not np.isfinite(picks).all():
        raise OptionError("give at least two picks of a line as an array of shape (n, 2)")
    try:
        guide = through_picks(picks, lens, (image.shape[1], image.shape[0]))
    except GuideError as error:
        return _refused(str(error))
    wanted = _wanted(guide, picks, lens, scatter_px, sag_px)
    margin = 6  # what the search's kernel takes off a strip
    strip = cut(image, guide, int(np.ceil(wanted.reach_px)) + margin, _SEARCH_ROWS)
    found = curves(strip, guide.share(strip.along), wanted)
    good = [curve for curve in found if curve.support >= LEAST_SUPPORT]
    if not good:
        best = max((curve.support for curve in found), default=0.0)
        return _refused(_weak(best), best)
    if rival:
        good = [good[0], *_elsewhere(good[0], good[1:])]
    chosen = good[min(rival, len(good) - 1)]
    others = [curve for curve in good if curve is not chosen]
    rivals = tuple(_rival(guide, curve) for curve in _elsewhere(chosen, others)[:_RIVALS])
    samples = refined(image, guide, chosen)
    if samples is None:
        return _refused(_weak(0.0), 0.0, rivals)
    reason = "" if rival else _ambiguous(image, guide, chosen, others, samples)
    most = np.inf if rival else _AWAY * scatter_px  # a rival is asked for by name
    if choosing:
        return replace(_judged(samples, picks, float(most), rivals, ""), doubt=reason)
    return _judged(samples, picks, float(most), rivals, reason)


def condensed(traced: Traced, number: int) -> Traced:
    """The same edge by fewer samples, each the weighted mean over a stretch of equal length.

    Args:
        traced: An edge with more samples.
        number: How many.
    """
    points, errors = traced.points_px, traced.errors_px
    if len(points) <= number:
        return traced
    centre = points.mean(axis=0)
    axis = np.linalg.svd(points - centre, full_matrices=False)[2][0]
    along = (points - centre) @ axis
    low, high = along.min(), along.max()
    part = np.minimum(((along - low) / (high - low) * number).astype(np.int64), number - 1)
    weight = 1 / np.maximum(errors, 1e-3) ** 2
    total = np.bincount(part, weight, number)
    full = total > 0
    means = [np.bincount(part, weight * points[:, axis], number)[full] for axis in (0, 1)]
    condensed_px = np.stack(means, axis=-1) / total[full, None]
    return replace(traced, points_px=condensed_px, errors_px=1 / np.sqrt(total[full]))


def _wanted(
    guide: Guide, picks: Array, lens: Lens | None, scatter_px: float, sag_px: float | None
) -> Wanted:
    along, offset = guide.offsets(picks)
    share = np.clip(guide.share(along), 0, 1)
    reach = 3 * scatter_px + _EXTRA_PX
    if sag_px is None:
        sag_px = 1.5 * scatter_px + 1
        if lens is None:
            sag_px = max(sag_px, 0.01 * len(guide.across)) if len(picks) < 3 else 2 * sag_px
    return Wanted(share, offset, scatter_px, reach, sag_px)


def _rival(guide: Guide, curve: Curve) -> Rival:
    along = np.linspace(guide.along[0], guide.along[-1], _RIVAL_NODES)
    return Rival(guide.points(along, curve.offset(guide.share(along))), curve.support)


def _elsewhere(chosen: Curve, others: Sequence[Curve]) -> list[Curve]:
    """Curves that part from a chosen one and from each other; they may fork from it."""
    kept = [chosen]
    for other in others:
        if np.min(np.max(np.abs(apart(other, kept)), axis=-1)) > SAME_PX:
            kept.append(other)
    return kept[1:]


def _ambiguous(
    image: Light, guide: Guide, chosen: Curve, others: Sequence[Curve], samples: Samples
) -> str:
    """Whether another curve is as good and, measured as well, is not parallel."""
    for other, gap in zip(others, apart(chosen, others), strict=True):
        if other.score < chosen.score - _AS_GOOD or np.ptp(gap) < _PARALLEL_PX:
            continue
        measured = refined(image, guide, other)
        if measured is None or measured.support < samples.support - _AS_GOOD:
            continue
        along = np.linspace(guide.along[0], guide.along[-1], _RIVAL_NODES)
        really = measured.smooth(along) - samples.smooth(along)
        if np.ptp(really) > _PARALLEL_PX:
            far = np.max(np.abs(really))
            return f"an edge that leaves it by {far:.0f} px is as good, and either may be meant"
    return ""


def _judged(
    samples: Samples, picks: Array, most_px: float, rivals: tuple[Rival, ...], reason: str
) -> Traced:
    along, offset = samples.guide.offsets(picks)
    good = samples.good
    support = samples.support
    if good.sum() < 3 or support < LEAST_SUPPORT:
        return _refused(_weak(support), support, rivals)
    edge = np.interp(along, samples.along[good], samples.offset[good])
    distance = float(np.sqrt(np.mean((offset - edge) ** 2)) * np.mean(samples.guide.cosine))
    if samples.clipped >= _CLIPPED:
        reason = "its bright side is clipped"
    if distance > most_px:
        reason = f"the picks are {distance:.1f} px away from the nearest edge"
    if reason:
        return replace(_refused(reason, support, rivals), distance_px=distance)
    profile = samples.profile
    return Traced(
        samples.points_px,
        samples.error_px[good],
        support,
        profile.kind,
        profile.width_px,
        distance,
        rivals,
    )


def _weak(support: float) -> str:
    if support == 0:
        return "there is no edge near the picks"
    return f"an edge runs under {100 * support:.0f} % of the line only"


def _refused(reason: str, support: float = 0.0, rivals: tuple[Rival, ...] = ()) -> Traced:
    none = np.empty((0, 2))
    return Traced(none, none[:, 0], support, rivals=rivals, refusal=reason)
