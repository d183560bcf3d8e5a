"""Coefficients over focal length: straight, as LensFun has it, or by a polynomial.

Every method is linear in the values: at a focal length f it is a sum of weights times the
values at the calibrated focal lengths,

    value(f) = Σᵢ wᵢ(f) yᵢ

LensFun takes coefficient × focal length through a cubic Hermite over the two neighbours on
either side, tangents half the difference of the neighbours whatever their spacing, secants at
the ends, and divides by the focal length. Source: LensFun 0.3.4, `_lf_interpolate` and
`lfLens::InterpolateDistortion`; for `acm`, LensFun 0.4, `__parameter_scales`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from plumbline.errors import OptionError
from plumbline.formats.lens_files.lensfun import Distortion
from plumbline.frame import Array

Method = Literal["linear", "hermite", "polynomial"]


def linear_weights(focals_mm: Array, at_mm: float) -> Array:
    """Weights of linear interpolation, clamped at the ends."""
    weights = np.zeros(len(focals_mm))
    right = int(np.searchsorted(focals_mm, at_mm))
    if right in (0, len(focals_mm)):
        weights[min(right, len(focals_mm) - 1)] = 1.0
        return weights
    t = (at_mm - focals_mm[right - 1]) / (focals_mm[right] - focals_mm[right - 1])
    weights[right - 1], weights[right] = 1 - t, t
    return weights


def hermite_weights(focals_mm: Array, at_mm: float, exponent: float = 1.0) -> Array:
    """Weights of LensFun's interpolation, clamped at the ends.

    Args:
        focals_mm: Calibrated focal lengths, ascending.
        at_mm: The focal length wanted.
        exponent: The power of the focal length that the coefficient is multiplied by.
    """
    n = len(focals_mm)
    weights = np.zeros(n)
    right = int(np.searchsorted(focals_mm, at_mm))
    if right in (0, n):
        weights[min(right, n - 1)] = 1.0
        return weights
    i, j = right - 1, right
    t = (at_mm - focals_mm[i]) / (focals_mm[j] - focals_mm[i])
    weights[i], weights[j] = 2 * t**3 - 3 * t**2 + 1, -2 * t**3 + 3 * t**2
    for tangent, before, after in (
        (t**3 - 2 * t**2 + t, i - 1, j),
        (t**3 - t**2, i, j + 1),
    ):
        if before < 0 or after >= n:
            weights[i] -= tangent
            weights[j] += tangent
        else:
            weights[before] -= tangent / 2
            weights[after] += tangent / 2
    return weights * focals_mm**exponent / at_mm**exponent


def polynomial_weights(focals_mm: Array, at_mm: float, degree: int, errors: Array) -> Array:
    """Weights of a least-squares polynomial weighted by the values' standard errors.

    Args:
        focals_mm: Calibrated focal lengths, ascending.
        at_mm: The focal length wanted.
        degree: Degree of the polynomial.
        errors: Standard errors of the values; all equal where none is known.

    Raises:
        OptionError: there are too few focal lengths.
    """
    if not 0 <= degree < len(focals_mm):
        raise OptionError(
            f"a polynomial of degree {degree} needs {degree + 1} focal lengths, and there are "
            f"{len(focals_mm)}",
            hint="give a lower --degree, or calibrate at more focal lengths",
        )
    scale = float(focals_mm[-1])
    design = np.vander(focals_mm / scale, degree + 1)
    solve = np.linalg.pinv(design / errors[:, None]) / errors[None, :]
    return (np.vander([at_mm / scale], degree + 1) @ solve)[0]


def polynomial(focals_mm: Array, values: Array, degree: int, errors: Array) -> Array:
    """The polynomial of `polynomial_weights`: its coefficients, the highest power first."""
    scale = float(focals_mm[-1])
    design = np.vander(focals_mm / scale, degree + 1)
    solved = np.linalg.pinv(design / errors[:, None]) @ (values / errors)
    return solved / scale ** np.arange(degree, -1, -1)


def lensfun_values(entries: Sequence[Distortion], at_mm: float) -> Distortion:
    """What LensFun makes of a lens's entries, ascending, at a focal length.

    Only entries of the first one's model count, as in LensFun.
    """
    first = entries[0]
    same = [entry for entry in entries if entry.model == first.model]
    focals = np.array([entry.focal_mm for entry in same])
    names = list(first.coefficients)
    found: dict[str, float] = {}
    for index, name in enumerate(names):
        exponent = 1.0
        if first.model == "acm" and index < 3:
            exponent = 2.0 * (index + 1)
        weights = hermite_weights(focals, at_mm, exponent)
        found[name] = float(weights @ np.array([entry.coefficients[name] for entry in same]))
    return replace(first, focal_mm=at_mm, coefficients=found)
