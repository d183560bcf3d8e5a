"""What LensFun's database calls a lens: its maker, model and mount, so that LensFun finds it."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

from plumbline.lenses.lensfun.camera_names import find_camera
from plumbline.lenses.lensfun.database import Database, common_database
from plumbline.observations.facts import LensFacts
from plumbline.photos.cameras import same_camera

_SAME_CROP = 0.008
"""Relative difference below which a crop factor is the camera's: chosen, since LensFun leaves out a
lens whose crop factor is half a percent above the camera's, and users who mean another one write
more than that."""


@dataclass(frozen=True)
class Labels:
    """A lens as LensFun's database spells it.

    Attributes:
        facts: What is known of the lens, in the database's words where it has them.
        notes: What was taken from the database, in plain sentences.
    """

    facts: LensFacts
    notes: tuple[str, ...] = ()


def spelt(facts: LensFacts) -> Labels:
    """Maker, model, mount and crop factor as the database has them for this camera and lens.

    LensFun takes a lens for a camera only if their mounts are one word, and the entry of a file
    that is installed before the database's own only if name and crop factor agree.
    """
    if not facts.camera and not facts.model:
        return Labels(facts)
    database = common_database()
    camera = find_camera(database, "", facts.camera)
    if camera is not None:
        facts = _of_camera(facts, camera)
    lens = _lens(database, camera, facts)
    if lens is None:
        makers = Counter(str(each.maker) for each in database.library.lenses)
        same = [maker for maker, _ in makers.most_common() if same_camera(maker, facts.maker)]
        return Labels(replace(facts, maker=same[0]) if same else facts)
    mounts = [str(mount) for mount in lens.mounts]
    mount = facts.mount if facts.mount in mounts or not mounts else mounts[0]
    focals = sorted(each.focal for each in lens.calib_distortion)
    span = f" at {focals[0]:g} to {focals[-1]:g} mm" if focals else " without distortion"
    note = (
        f"LensFun's database has this lens, {lens.model},{span}: where this file is installed, it "
        "takes that entry's place, other focal lengths, TCA and vignetting included"
    )
    named = replace(facts, maker=str(lens.maker), model=str(lens.model), mount=mount)
    return Labels(named, (note,))


def _of_camera(facts: LensFacts, camera: Any) -> LensFacts:
    """The mount of the camera where none is told, and its crop factor where it is as large."""
    crop = facts.crop_factor
    within = max(_SAME_CROP, facts.crop_factor_error or 0.0)
    if crop is not None and abs(crop / camera.crop_factor - 1) <= within:
        # Numbers in single precision are written as the database has them.
        crop = float(f"{camera.crop_factor:.4g}")
    mount = facts.mount or str(camera.mount)
    if mount.casefold() == str(camera.mount).casefold():
        mount = str(camera.mount)
    return replace(facts, mount=mount, crop_factor=crop)


def _lens(database: Database, camera: Any, facts: LensFacts) -> Any | None:
    """The database's lens of the same name, however its maker and its blanks are written."""
    if not facts.model:
        return None
    wanted = _bare(facts.model, facts.maker)
    library = database.library
    able = library.lenses if camera is None else library.find_lenses(camera, None, facts.model)
    for each in able:
        if _bare(str(each.model), str(each.maker)) in (wanted, _bare(facts.model, str(each.maker))):
            return each
    return None


def _bare(model: str, maker: str) -> str:
    """A name without its maker, blanks and signs."""
    squeezed = re.sub(r"[^a-z0-9.]", "", model.casefold())
    return squeezed.removeprefix(re.sub(r"[^a-z0-9.]", "", maker.casefold()))
