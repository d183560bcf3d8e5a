"""The programs that a lens can be exported to, and how each file is made."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import atan, degrees

from plumbline._version import __version__
from plumbline.files import MARK
from plumbline.formats.known import written
from plumbline.formats.lens_files.imagemagick import barrel
from plumbline.formats.lens_files.lenses_txt import lenses_txt
from plumbline.formats.lens_files.lensfun import Distortion, LensfunLens, lensfun_xml
from plumbline.formats.lens_files.opencv_yaml import opencv_yaml
from plumbline.formats.lens_files.ptlens_profile import (
    PTLensCamera,
    PTLensLens,
    ptlens_profile,
    without_maker,
)
from plumbline.formats.panotools.hugin_ini import HuginLens, hugin_ini
from plumbline.formats.panotools.pto_writing import new_project
from plumbline.geometry.lens import Lens
from plumbline.lenses.stored import StoredLens
from plumbline.observations import Observations, Photo
from plumbline.observations.facts import LensFacts
from plumbline.writing.head import centre_of, crop_factor, focal_mm, lens_name, lensfun_head

_MARK = f"{MARK} {__version__}"


@dataclass(frozen=True)
class Target:
    """What a lens can be exported to.

    Attributes:
        models: The models it holds as they are; others are refitted to the first.
        centre: Whether it holds a distortion centre.
        write: Makes the file of a lens that it holds.
    """

    models: tuple[str, ...]
    centre: bool
    write: Callable[[StoredLens], bytes]


def _known_focal_px(stored: StoredLens) -> float | None:
    return stored.facts.focal_length_px(stored.lens.frame)


def _ptlens_values(lens: Lens) -> Mapping[str, float]:
    """a, b, c, d, e of a lens that is ptlens or poly3."""
    return {**lens.coefficients, **(lens.model.ptlens_values(lens.coefficients) or {})}


def _abc(lens: Lens) -> tuple[float, float, float]:
    values = _ptlens_values(lens)
    return values["a"], values["b"], values["c"]


def _focal_mm(stored: StoredLens) -> float:
    return focal_mm(stored.facts, stored.lens.frame)


def _name(stored: StoredLens) -> str:
    return lens_name(stored.facts, stored.observations)


def _head(stored: StoredLens) -> LensfunLens:
    lens = stored.lens
    return lensfun_head([stored.facts], lens.frame, _name(stored), _MARK, centre_of(lens))


def _lensfun(stored: StoredLens) -> bytes:
    lens = stored.lens
    values = {name: lens.coefficients[name] for name in lens.model.coefficients}
    return lensfun_xml(_head(stored), [Distortion(lens.model.name, _focal_mm(stored), values)])


def _lenses_txt(stored: StoredLens) -> bytes:
    lens = stored.lens
    values = [lens.coefficients[name] for name in lens.model.coefficients]
    return lenses_txt(_head(stored), [(_focal_mm(stored), values)], _MARK)


def _pto(stored: StoredLens) -> bytes:
    photos = (Photo(stored.lens.frame.size, (*stored.photos, "")[0]),)
    observations = stored.observations or Observations(photos, (), (stored.facts,))
    return new_project(observations, {0: _ptlens_values(stored.lens)})


def _hugin_ini(stored: StoredLens) -> bytes:
    facts, frame = stored.facts, stored.lens.frame
    maker, model = _camera(facts)
    return hugin_ini(
        HuginLens(
            frame.size,
            _ptlens_values(stored.lens),
            facts.projection,
            facts.hfov_deg or _hfov(stored),
            facts.crop_factor,
            maker,
            model,
            facts.focal_length_mm(frame),
        ),
        _MARK,
    )


def _hfov(stored: StoredLens) -> float | None:
    focal_px = _known_focal_px(stored)
    return degrees(2 * atan(stored.lens.frame.width / 2 / focal_px)) if focal_px else None


def _ptlens(stored: StoredLens) -> bytes:
    facts, crop = stored.facts, crop_factor([stored.facts])
    maker, model = _camera(facts)
    menu_model = without_maker(model, maker)
    group = frozenset({re.sub(r"[^a-z0-9]", "", f"{maker}{menu_model}".casefold()) or "camera"})
    lens = PTLensLens(_name(stored), group, crop, ((_focal_mm(stored), _abc(stored.lens)),))
    camera = PTLensCamera(maker, menu_model, maker, model, group, crop)
    return ptlens_profile(camera, lens, _MARK)


def _camera(facts: LensFacts) -> tuple[str, str]:
    """Maker and model of the camera, as EXIF has them where it told them."""
    if facts.exif_model:
        return facts.exif_make or facts.exif_model.split()[0], facts.exif_model
    camera = facts.camera or "Unknown camera"
    if facts.maker and camera.startswith(f"{facts.maker} "):
        return facts.maker, camera.removeprefix(f"{facts.maker} ")
    maker, _, model = camera.partition(" ")
    return maker, model


def _imagemagick(stored: StoredLens) -> bytes:
    lens = stored.lens
    centre = (lens.coefficients["d"], lens.coefficients["e"])
    return barrel(_abc(lens), lens.frame, centre, _MARK)


def _opencv(stored: StoredLens) -> bytes:
    return opencv_yaml(stored.lens, stored.homography, _MARK)


_TARGETS = {
    "lensfun": Target(("ptlens", "poly3", "poly5", "acm"), True, _lensfun),
    "lenses-txt": Target(("ptlens", "poly3"), False, _lenses_txt),
    "pto": Target(("ptlens", "poly3"), True, _pto),
    "hugin-ini": Target(("ptlens", "poly3"), True, _hugin_ini),
    "ptlens": Target(("ptlens", "poly3"), False, _ptlens),
    "imagemagick": Target(("ptlens", "poly3"), True, _imagemagick),
    "opencv": Target(("opencv",), True, _opencv),
}
TARGETS = {name: _TARGETS[name] for name in written("lens")}
"""What `export` writes; `stmap` and `json` are not lenses in other words and stand apart."""
