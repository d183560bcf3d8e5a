"""`lenses.txt` of the LensFun contributors' script, written.

    Sigma 18-35mm f/1.8 DC HSM | Art: Sigma, Canon EF, 1.5, 3:2
    distortion(18mm) = 0.00123, -0.04567, 0.03456

First the lens: name, maker, mount, crop factor and aspect ratio; then a line for each focal
length: one number for `poly3`, three for `ptlens`. Source: LensFun's `calibrate.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from plumbline.formats.lens_files.lensfun import LensfunLens


def lenses_txt(
    head: LensfunLens, entries: Sequence[tuple[float, Sequence[float]]], mark: str
) -> bytes:
    """The lines of one lens.

    Args:
        head: The lens; its centre cannot be held.
        entries: For each focal length in millimetres k1, or a, b, c.
        mark: A comment for the first line.
    """
    ratio = Fraction(head.aspect_ratio).limit_denominator(20)
    aspect = f"{ratio.numerator}:{ratio.denominator}"
    if abs(float(ratio) / head.aspect_ratio - 1) > 1e-3:
        aspect = f"{head.aspect_ratio:.7g}"
    name, maker, mount = (_plain(text) for text in (head.model, head.maker, head.mount))
    maker, mount = (text.replace(",", " ") for text in (maker, mount))
    rows = [f"# {mark}", f"{name}: {maker}, {mount}, {head.crop_factor:.7g}, {aspect}"]
    for focal_mm, values in entries:
        numbers = ", ".join(f"{value:.9f}" for value in values)
        rows.append(f"distortion({focal_mm:.6g}mm) = {numbers}")
    return ("\n".join(rows) + "\n").encode()


def _plain(text: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
