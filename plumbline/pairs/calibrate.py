"""Calibrate from two pictures of one scene, one of them corrected."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
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
from plumbline.pairs.refine import refined
from plumbline.pairs.refusals import PARTS, parts_of, refuse_alike, refuse_few
from plumbline.photos.brightness import Grey, brightness
from plumbline.result.pair import PairCalibration
from plumbline.trust.matched import Setting

Pictures = tuple[Grey, Grey]


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
    pictures = _pictures(original, corrected, points)
    if pictures is None:
        matches, size = _given(points, size)
    else:
        matches, size = match(*pictures), pictures[0].shape[::-1]
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
    fitted = _fit(_start(lens, matches), fitted_names, matches)
    refuse_few(fitted, matches, frame)
    remarks: list[str] = []
    if pictures is not None:
        better = refined(*pictures, fitted.setting, matches.only(fitted.kept))
        remarks.append(_refined(len(better), len(matches)))
        matches, fitted = better, _fit(fitted.setting, fitted_names, better)
        refuse_few(fitted, matches, frame)
    calibration = _calibration(fitted, matches, fitted_names, Photo(size, name), known)
    refuse_alike(calibration)
    return replace(calibration, remarks=(*calibration.remarks, *remarks))


def _fit(start: Setting, free: tuple[str, ...], matches: Matches) -> Fitted:
    return fit_matches(start, free, matches.observed_px, matches.corrected_px)


def _start(lens: Lens, matches: Matches) -> Setting:
    """A lens without distortion, and the scale and place that some matches agree on."""
    agreed = agreement(matches)
    x, y = agreed.scale * np.array(lens.frame.centre_px) + np.array(agreed.offset_px)
    return Setting(lens, agreed.scale, (float(x), float(y)))


def _pictures(original: Any, corrected: Any, points: Any) -> Pictures | None:
    """Both pictures' brightness; None where points are given instead."""
    if points is not None:
        if original is not None or corrected is not None:
            raise OptionError("give pictures or points, not both")
        return None
    if original is None or corrected is None:
        raise OptionError("a pair takes two pictures", hint="give an original and a corrected one")
    first, second = brightness(original), brightness(corrected)
    if first.shape == second.shape and np.array_equal(first, second):
        raise PairError(
            "the two pictures are identical", hint="give one of them without the correction"
        )
    return first, second


def _given(points: Any, size: tuple[int, int] | None) -> tuple[Matches, tuple[int, int]]:
    """Matched points, checked, and the original's size."""
    if size is None:
        raise OptionError(
            "the size of the original is not known", hint="give it with --size WIDTHxHEIGHT"
        )
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
    return Matches(*arrays), size


def _calibration(
    fitted: Fitted, matches: Matches, free: tuple[str, ...], photo: Photo, facts: LensFacts
) -> PairCalibration:
    lens = fitted.setting.lens
    part = parts_of(matches.observed_px, lens.frame)
    members = [np.flatnonzero(part == each) for each in np.unique(part)]
    lines = tuple(
        Line(
            matches.observed_px[which],
            label=f"part {part[which[0]] // PARTS + 1}.{part[which[0]] % PARTS + 1}",
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


def _refined(kept: int, found: int) -> str:
    return (
        f"{kept:,} of {found:,} matches were refined; the others lie close to these, or their "
        "surroundings do not agree"
    )


def _left_out(fitted: Fitted) -> list[str]:
    out = int((~fitted.kept).sum())
    if not out:
        return []
    return [
        f"{out:,} of {len(fitted.kept):,} matches were left out: they do not agree with the others"
    ]
