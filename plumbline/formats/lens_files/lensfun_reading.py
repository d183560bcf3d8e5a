"""LensFun databases (XML), read: what LensFun's own library does not tell, and what it refuses.

The library does not tell a lens's aspect ratio, and the released one (0.3) refuses database
version 2, in which the model `acm` stands. Files are checked here before the library sees them.
Sample and source: `plumbline.formats.lens_files.lensfun`.
"""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.errors import printable
from plumbline.formats.base import Source
from plumbline.formats.lens_files.lensfun import Distortion
from plumbline.formats.xmltext import Element, parsed

DEFAULT_ASPECT = 1.5
"""Width over height where a file tells none: LensFun's own default, a frame of 36 × 24 mm."""
_LARGEST = 1e9
"""Of a focal length or coefficient; chosen, larger numbers overflow further on."""
_HINT = "take the file again from LensFun, or correct this line"
_NAMES = {
    "poly3": ("k1",),
    "poly5": ("k1", "k2"),
    "ptlens": ("a", "b", "c"),
    "acm": ("k1", "k2", "k3", "k4", "k5"),
}


@dataclass(frozen=True)
class LensfunEntry:
    """A lens of a LensFun database.

    Attributes:
        maker: Maker of the lens.
        model: Its name.
        mounts: Names of its mounts.
        kind: "rectilinear", or the projection it has instead.
        crop_factor: Of the camera it was calibrated on.
        aspect_ratio: Longer side over shorter side of the calibration's pictures.
        centre: Offset of the distortion centre in half short sides.
        distortions: Its distortion over focal length, ascending.
    """

    maker: str
    model: str
    mounts: tuple[str, ...]
    kind: str
    crop_factor: float
    aspect_ratio: float
    centre: tuple[float, float]
    distortions: tuple[Distortion, ...]


@dataclass(frozen=True)
class LensfunFile:
    """A LensFun database file: its version and its lenses."""

    version: int
    lenses: tuple[LensfunEntry, ...]


def read_lensfun(source: Source) -> LensfunFile:
    """Read a LensFun database file; entities and network are off.

    Raises:
        ReadError: the file is damaged or not a LensFun database.
    """
    root = parsed(source, _HINT)
    if root.tag != "lensdatabase":
        raise source.error("this is not a LensFun database", root.sourceline, _HINT)
    version = root.get("version", "0")
    if version not in ("0", "1", "2"):
        raise source.error(
            f"this is a LensFun database of version {printable(version)[:20]}; 1 and 2 are read",
            root.sourceline,
            _HINT,
        )
    lenses = tuple(_lens(source, element) for element in root.iter("lens"))
    return LensfunFile(int(version), lenses)


def _lens(source: Source, element: Element) -> LensfunEntry:
    centre = element.find("center")
    across, down = (0.0, 0.0)
    if centre is not None:
        across, down = (_attribute(source, centre, name, 0.0) for name in ("x", "y"))
    entries = (_distortion(source, each) for each in element.iter("distortion"))
    found = {each.focal_mm: each for each in entries if each}  # LensFun keeps the last, too
    kind = element.find("type")
    return LensfunEntry(
        _text(element, "maker"),
        _text(element, "model"),
        tuple(printable((each.text or "").strip()) for each in element.findall("mount")),
        "rectilinear" if kind is None else printable((kind.text or "").strip()),
        _positive(source, element, "cropfactor", 1.0),
        _aspect(source, element),
        (across, down),
        tuple(found[focal_mm] for focal_mm in sorted(found)),
    )


def _distortion(source: Source, element: Element) -> Distortion | None:
    model = element.get("model", "")
    if model == "none":
        return None
    if model not in _NAMES:
        raise source.error(
            f"the distortion model {printable(model)[:40]!r} is not known",
            element.sourceline,
            _HINT,
        )
    focal_mm = _attribute(source, element, "focal", None)
    if focal_mm <= 0:
        raise source.error("the focal length is not above zero", element.sourceline, _HINT)
    values = {name: _attribute(source, element, name, 0.0) for name in _NAMES[model]}
    if focal_mm > _LARGEST or max(map(abs, values.values())) > _LARGEST:
        raise source.error("a value is impossibly large", element.sourceline, _HINT)
    return Distortion(model, focal_mm, values)


def _attribute(source: Source, element: Element, name: str, default: float | None) -> float:
    text = element.get(name, "")
    if not text:
        if default is None:
            raise source.error(f"<{element.tag}> has no {name}", element.sourceline, _HINT)
        return default
    return source.number(text.strip(), element.sourceline, what=f"the value of {name}")


def _text(element: Element, tag: str) -> str:
    """The text of a tag in no particular language; LensFun keeps the last, too."""
    found = [each for each in element.findall(tag) if not each.get("lang", "")]
    return printable((found[-1].text or "").strip()) if found else ""


def _positive(source: Source, element: Element, tag: str, default: float) -> float:
    child = element.find(tag)
    if child is None:
        return default
    value = source.number((child.text or "").strip(), child.sourceline, what=f"the {tag}")
    if value <= 0:
        raise source.error(f"the {tag} is not above zero", child.sourceline, _HINT)
    return value


def _aspect(source: Source, element: Element) -> float:
    child = element.find("aspect-ratio")
    if child is None:
        return DEFAULT_ASPECT
    over, colon, under = (child.text or "").partition(":")
    row = child.sourceline
    longer = source.number(over.strip(), row, what="the aspect ratio")
    shorter = source.number(under.strip(), row, what="the aspect ratio") if colon else 1.0
    if not (longer > 0 and shorter > 0 and 0.01 <= longer / shorter <= 100):
        raise source.error("the aspect ratio is impossible", row, _HINT)
    return max(longer / shorter, shorter / longer)
