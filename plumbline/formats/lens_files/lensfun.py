"""LensFun databases (XML), written.

    <lensdatabase version="1">
        <lens>
            <maker>Sigma</maker> <model>Sigma 18-35mm f/1.8 DC HSM</model> <mount>Generic</mount>
            <cropfactor>1.534</cropfactor> <aspect-ratio>1.5</aspect-ratio>
            <calibration>
                <distortion model="ptlens" focal="18" a="0.01" b="-0.05" c="0"/>

Several focal lengths of one lens become several `<distortion>` entries. `acm` needs database
version 2, which released LensFun (0.3) refuses. LensFun measures radii in half short sides of
the calibration sensor, so the aspect ratio and the crop factor are always written. Source:
LensFun 0.3.4 and its development version.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from plumbline.errors import OptionError, UnsupportedModelError

MODELS = ("ptlens", "poly3", "poly5", "acm")


@dataclass(frozen=True)
class LensfunLens:
    """The head of a LensFun lens.

    Attributes:
        maker: Maker of the lens.
        model: Its name.
        mount: Name of the mount.
        crop_factor: Of the camera it was calibrated on.
        aspect_ratio: Longer side over shorter side of the photos.
        centre: Offset of the distortion centre in half short sides.
        comment: What the reader of the file should know; may be empty.
    """

    maker: str
    model: str
    mount: str
    crop_factor: float
    aspect_ratio: float
    centre: tuple[float, float] = (0.0, 0.0)
    comment: str = ""


@dataclass(frozen=True)
class Distortion:
    """One `<distortion>` entry.

    Attributes:
        model: "ptlens", "poly3", "poly5" or "acm".
        focal_mm: Focal length.
        coefficients: Its coefficients by LensFun's names.
    """

    model: str
    focal_mm: float
    coefficients: Mapping[str, float]


def lensfun_xml(head: LensfunLens, entries: Sequence[Distortion]) -> bytes:
    """A LensFun database with one lens.

    Args:
        head: The lens.
        entries: Its distortion at one or more focal lengths.

    Raises:
        UnsupportedModelError: LensFun does not know a model.
        OptionError: two entries have the same focal length.
    """
    focals = [entry.focal_mm for entry in entries]
    if len(set(focals)) < len(focals):
        raise OptionError(
            "two calibrations have the same focal length, and a LensFun lens holds one of each",
            hint="link the photos to one lens in the project, or select one with --image N",
        )
    for entry in entries:
        if entry.model not in MODELS:
            raise UnsupportedModelError(
                f"LensFun does not know the model {entry.model}",
                hint=f"fit with --model {', '.join(MODELS[:-1])} or {MODELS[-1]}",
            )
    version = "2" if any(entry.model == "acm" for entry in entries) else "1"
    root = etree.Element("lensdatabase", version=version)
    if head.comment:
        root.append(etree.Comment(" " + re.sub("-(?=-|$)", "- ", _characters(head.comment)) + " "))
    lens = etree.SubElement(root, "lens")
    _child(lens, "maker", head.maker)
    _child(lens, "model", head.model)
    _child(lens, "mount", head.mount)
    _child(lens, "cropfactor", number(head.crop_factor))
    _child(lens, "aspect-ratio", number(head.aspect_ratio))
    if any(head.centre):
        etree.SubElement(lens, "center", x=number(head.centre[0]), y=number(head.centre[1]))
    calibration = etree.SubElement(lens, "calibration")
    for entry in sorted(entries, key=lambda entry: entry.focal_mm):
        values = {name: number(value) for name, value in entry.coefficients.items()}
        focal = {"focal": number(entry.focal_mm)}
        etree.SubElement(calibration, "distortion", {"model": entry.model} | focal | values)
    etree.indent(root, space="    ")
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8") + b"\n"


def _child(parent: Any, tag: str, text: str) -> None:
    etree.SubElement(parent, tag).text = _characters(text)


def _characters(text: str) -> str:
    """Those characters of a text that XML can hold and people can see."""
    return "".join(c for c in text if c.isprintable())


def number(value: float) -> str:
    """At least 7 significant digits, without an exponent."""
    text = f"{Decimal(f'{value:.9g}'):f}"
    return text if float(text) else "0"
