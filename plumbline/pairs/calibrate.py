"""Calibrate from two pictures of one scene, one of them corrected."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plumbline.errors import OptionError, PairError
from plumbline.frame import Array, Frame
from plumbline.geometry.lens import Lens
from plumbline.models import CENTRE, get_model
from plumbline.observations import Line, Observations, Photo
from plumbline.observations.facts import LensFacts
from plumbline.pairs.fit import Fitted, fit_matches
from plumbline.pairs.matching import Matches, agreement, match
from plumbline.photos.brightness import brightness
from plumbline.result.pair import PairCalibration
from plumbline.trust.matched import Setting
from plumbline.wording import count, joined

_LEAST = 50
"""Matches that must agree; chosen: with fewer one wrong one in ten can hide."""

_PARTS = 4
"""Parts of the photo across and down, left out one after the other; chosen, so that each holds a
few dozen of the usual matches."""

_LEAST_REACH = 0.5
"""Share of the way to the corner that matches must reach at least; beyond it a lens bends most."""

_LEAST_PARTS = 6
"""Parts of 16 that must hold matches; chosen: three corners' worth."""

_ALIKE_PX = 0.05
"""A correction that moves the matches by less, root mean square, is none; chosen: two pictures
without one differed by 0.003 px, the weakest lenses of LensFun's database bend by some tenths."""


def calibrate_pair(
    original: NDArray[Any] | None = None,
    corrected: NDArray[Any] | None = None,
    *,
    points: tuple[ArrayLike, ArrayLike] | None = None,
    size: tuple[int, int] | None = None,
    model: str = "ptlens",
    free: Iterable[str] | None = None,
    hold: Iterable[str] = (),
    facts: LensFacts | None = None,
    name: str = "",
) -> PairCalibration:
    """Find the distortion that one of two pictures of a scene was corrected for.

    The corrected picture may be enlarged, cropped and shifted, and of any size; its scale and
    place are fitted with the lens, and wrong matches are left out.

    Args:
        original: The picture as the lens shows it, 8 or 16 bits: grey (h, w), or blue, green, red
            (h, w, 3).
        corrected: The same scene from the same place without distortion.
        points: Instead of pictures, matched points: in the original and in the corrected picture,
            pixels, shape (n, 2) each.
        size: Width and height of the original, where points are given.
        model: Name of the distortion model, see `plumbline.MODELS`.
        free: Coefficients to fit; all of the model's by default. `d` and `e`, the distortion
            centre in pixels, may be among them.
        hold: Coefficients to hold at 0 nevertheless.
        facts: What is known of the lens.
        name: The original's name.

    Returns:
        A calibration whose observations are the matches: one `Line` for each part of the photo.

    Raises:
        OptionError: an argument is unknown or contradicts the others.
        PairError: the pictures are not an original and its correction, or have too few points in
            common.

    Example:
        >>> import cv2, plumbline  # doctest: +SKIP
        >>> pictures = cv2.imread("raw.jpg"), cv2.imread("camera.jpg")  # doctest: +SKIP
        >>> plumbline.calibrate_pair(*pictures).coefficients  # doctest: +SKIP
        {'a': 0.006, 'b': -0.012, 'c': -0.035, 'd': 0.0, 'e': 0.0}
    """
    matches, size = _matches(original, corrected, points, size)
    chosen = get_model(model)
    names = (*chosen.coefficients, *CENTRE)
    wanted = tuple(chosen.coefficients) if free is None else tuple(free)
    for each in (*wanted, *hold):
        if each not in names:
            raise OptionError(f"there is no coefficient {each!r}", hint=f"use {', '.join(names)}")
    fitted_names = tuple(n for n in names if n in set(wanted) - set(hold))
    if not fitted_names:
        raise OptionError("no coefficient is free", hint="free one at least")
    frame = Frame(*size)
    known = facts or LensFacts()
    lens = Lens(chosen, frame, dict.fromkeys(names, 0.0), known.focal_length_px(frame))
    agreed = agreement(matches)
    place = agreed.scale * np.array(frame.centre_px) + np.array(agreed.offset_px)
    start = Setting(lens, agreed.scale, (float(place[0]), float(place[1])))
    fitted = fit_matches(start, fitted_names, matches.observed_px, matches.corrected_px)
    _refuse_few(fitted, matches, frame)
    calibration = _calibration(fitted, matches, fitted_names, Photo(size, name), known)
    _refuse_alike(calibration)
    return calibration


def _matches(
    original: Any, corrected: Any, points: Any, size: tuple[int, int] | None
) -> tuple[Matches, tuple[int, int]]:
    if points is not None:
        if original is not None or corrected is not None:
            raise OptionError("give pictures or points, not both")
        if size is None:
            raise OptionError(
                "the size of the original is not known", hint="give it with --size WIDTHxHEIGHT"
            )
        return _given(points, size), size
    if original is None or corrected is None:
        raise OptionError("a pair takes two pictures", hint="give an original and a corrected one")
    first, second = brightness(original), brightness(corrected)
    if first.shape == second.shape and np.array_equal(first, second):
        raise PairError(
            "the two pictures are identical", hint="give one of them without the correction"
        )
    return match(first, second), (first.shape[1], first.shape[0])


def _given(points: Any, size: tuple[int, int]) -> Matches:
    arrays: list[Array] = []
    for each in points:
        array = np.asarray(each, dtype=np.float64)
        if array.ndim != 2 or array.shape[1] != 2:
            raise OptionError(
                f"matched points have shape {array.shape}", hint="give two arrays of shape (n, 2)"
            )
        if not np.isfinite(array).all():
            raise OptionError("a matched point is not finite", hint="correct or remove it")
        arrays.append(array)
    if len(arrays) != 2 or len(arrays[0]) != len(arrays[1]):
        raise OptionError(
            "there are more points of one picture than of the other",
            hint="give two arrays of shape (n, 2), row by row the same point",
        )
    outside = ~Frame(*size).contains(arrays[0])
    if outside.any():
        x, y = arrays[0][outside][0]
        raise OptionError(
            f"the point ({x:g}, {y:g}) lies outside the {size[0]}x{size[1]} original",
            hint="check its size; pixels count from 0 at the top left",
        )
    return Matches(*arrays)


def _refuse_few(fitted: Fitted, matches: Matches, frame: Frame) -> None:
    kept = matches.observed_px[fitted.kept]
    if len(kept) < _LEAST:
        raise PairError(
            f"of {count(len(matches), 'matched point')} only {len(kept)} agree on one lens",
            hint="take pictures with more detail; one of them as the lens shows it, the other "
            "corrected",
        )
    held = np.bincount(parts_of(kept, frame), minlength=_PARTS**2) > 0
    radius = np.linalg.norm(frame.normalise(kept, frame.radius_px), axis=1) / frame.corner_radius
    inner, outer = (float(np.quantile(radius, q)) for q in (0.01, 0.99))
    if held.sum() < _LEAST_PARTS or outer < _LEAST_REACH:
        raise PairError(
            f"the matches lie in {held.sum()} of {_PARTS**2} parts of the photo{_side(held)}, "
            f"between {100 * inner:.0f} and {100 * outer:.0f} % of the way to the corner: the rest "
            "of the radius is not covered",
            hint="take a scene with detail all over the photo",
        )


def _side(held: NDArray[np.bool_]) -> str:
    """In which part of the photo all matches lie, where it is one side of it."""
    rows, columns = np.nonzero(held.reshape(_PARTS, _PARTS))
    half = _PARTS // 2
    words: list[str] = []
    for places, low, high in ((rows, "top", "bottom"), (columns, "left", "right")):
        if (places < half).all() or (places >= half).all():
            words.append(low if places[0] < half else high)
    return f", all at the {joined(words)}" if words else ""


def parts_of(observed_px: Array, frame: Frame) -> NDArray[np.int64]:
    """Which of the photo's parts each point lies in, row by row, shape (n,)."""
    across = np.clip((observed_px + 0.5) * _PARTS / np.array(frame.size), 0, _PARTS - 1)
    column, row = across.astype(np.int64).T
    return row * _PARTS + column


def _calibration(
    fitted: Fitted, matches: Matches, free: tuple[str, ...], photo: Photo, facts: LensFacts
) -> PairCalibration:
    lens = fitted.setting.lens
    part = parts_of(matches.observed_px, lens.frame)
    members = [np.flatnonzero(part == each) for each in np.unique(part)]
    lines = tuple(
        Line(
            matches.observed_px[which],
            label=f"part {part[which[0]] // _PARTS + 1}.{part[which[0]] % _PARTS + 1}",
            corrected_px=matches.corrected_px[which],
        )
        for which in members
    )
    setting = fitted.setting
    rest = matches.observed_px - setting.observed(matches.corrected_px)
    distance = np.nan_to_num(np.linalg.norm(rest, axis=1), nan=np.inf)
    ideal = lens.undistort_or_nan(matches.observed_px[fitted.kept])
    there = (
        np.array(lens.frame.centre_px)
        + (matches.corrected_px[fitted.kept] - np.array(setting.place_px)) / setting.scale
    )
    return PairCalibration(
        observations=Observations((photo,), lines, (facts,)),
        lens=lens,
        free=free,
        start=dict.fromkeys(lens.coefficients, 0.0),
        residual="image",
        covariance=fitted.covariance,
        sigma_px=fitted.sigma_px,
        dof=fitted.dof,
        residuals_px=tuple(distance[which] for which in members),
        rms_corrected_px=float(np.sqrt(np.nanmean(((ideal - there) ** 2).sum(axis=1)))),
        converged=fitted.converged,
        reason="the fit reached a minimum" if fitted.converged else "the fit did not settle",
        remarks=(_remark(setting), *_left_out(fitted)),
        kept=tuple(fitted.kept[which] for which in members),
        robust=True,
        scale=setting.scale,
        place_px=setting.place_px,
    )


def _remark(setting: Setting) -> str:
    x, y = setting.place_px
    verb = "enlarged" if setting.scale >= 1 else "reduced"
    return (
        f"the corrected picture shows the original {verb} {setting.scale:.4f} times, its centre at "
        f"({x:.1f}, {y:.1f})"
    )


def _left_out(fitted: Fitted) -> list[str]:
    out = int((~fitted.kept).sum())
    if not out:
        return []
    return [
        f"{out:,} of {len(fitted.kept):,} matches were left out: they do not agree with the others"
    ]


def _refuse_alike(calibration: PairCalibration) -> None:
    """Refuse pictures that differ by a scale and a shift alone."""
    bent_px = np.sqrt(max(calibration.rms_before_px**2 - calibration.rms_after_px**2, 0.0))
    if bent_px > _ALIKE_PX:
        return
    raise PairError(
        f"the two pictures differ by a scale ({calibration.scale:.4f}) and a shift alone: "
        "neither of them is corrected, or both are",
        hint="give one of them without the correction",
    )
