"""The user's own calibrations: result and zoom JSONs in the user's data folder."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from plumbline.errors import OptionError, ReadError, UnsettledError, WriteError
from plumbline.files import RESULT, ZOOM, read_bytes, write_atomically
from plumbline.formats.base import Source
from plumbline.lenses.names import likeness, numbers_of, same_range
from plumbline.lenses.profile import LensProfile
from plumbline.lenses.request import LensRequest
from plumbline.lenses.sources import stored_lens_profile
from plumbline.lenses.stored import StoredLens
from plumbline.lenses.stored_files import stored_lenses
from plumbline.lenses.zoom import json as zoom_json
from plumbline.lenses.zoom.json import StoredZoom
from plumbline.observations.facts import LensFacts
from plumbline.photos.cameras import same_camera
from plumbline.photos.exif import PhotoFacts
from plumbline.result.files import consistent_results
from plumbline.result.given import refuse_unsettled
from plumbline.wording import listed

_MOST_FILES = 10_000  # chosen to end in a folder that holds something else


def folder() -> Path:
    """Where the user's own calibrations are."""
    from platformdirs import user_data_path

    return user_data_path("plumbline", appauthor=False) / "lenses"


def add(path: str, *, overwrite: bool = False) -> Path:
    """Copy a result or zoom JSON into the store.

    Args:
        path: The file.
        overwrite: Replace a stored one of the same camera, lens and focal length.

    Raises:
        ReadError: the file is damaged, or no such JSON.
        OptionError: it does not tell the camera or the focal length, so nothing could find it.
        UnsettledError: its fit did not reach a minimum.
        WriteError: there is one already, or the store cannot be written.
    """
    source = Source(path, read_bytes(path))
    head = source.head.lstrip()[:1024]
    if f'"{ZOOM}"' in head:
        lens = zoom_json.read_zoom(source).lens
        low, high = lens.range_mm
        name = _name(path, lens.facts, f"{low:g}-{high:g}mm")
    elif f'"{RESULT}"' in head:
        results = list(consistent_results(source.text(), path))
        if len(results) != 1:
            raise OptionError(
                f"{path} holds {len(results)} calibrations",
                hint="fit each lens by itself (--image N), or join them with plumbline zoom",
            )
        refuse_unsettled(results)
        facts = results[0].observations.lenses[0]
        focal_mm = facts.focal_length_mm(results[0].lens.frame)
        if focal_mm is None:
            raise OptionError(
                f"{path} does not give its focal length, so no photo could find it",
                hint="fit again with --focal, or with --photo and a photo whose EXIF gives it",
            )
        name = _name(path, facts, f"{focal_mm:.4g}mm")
    else:
        raise ReadError(
            "this is not a calibration or zoom lens written by plumbline",
            path=path,
            hint="write one with plumbline fit POINTS -o result.json, or plumbline zoom",
        )
    target = folder() / name
    if target.exists() and not overwrite:
        raise WriteError(
            "there is a calibration of this camera, lens and focal length already",
            path=target,
            hint="replace it with --overwrite",
        )
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(
            f"the folder cannot be created: {error.strerror or error}",
            path=target.parent,
            hint="make it writable, or name the file with --lens instead",
        ) from None
    write_atomically({target: source.content})
    return target


def find_profile(
    photo: PhotoFacts, request: LensRequest
) -> tuple[LensProfile | None, tuple[str, ...]]:
    """The user's own calibration for a photo, if there is one.

    Returns:
        The profile or None, and notes on calibrations that were not used.

    Raises:
        OptionError: the photo does not name its lens, and calibrations of several fit.
    """
    notes: list[str] = []
    found: list[tuple[float, LensProfile]] = []
    misses: list[str] = []
    names: set[str] = set()
    focal_mm = request.focal_mm or photo.facts.focal_mm
    for path in files():
        try:
            stored, facts, calibrated = read_kept(path)
        except (ReadError, UnsettledError) as error:
            notes.append(f"a calibration of your own was left aside: {error.message}")
            continue
        if not _fits(facts, photo, request):
            continue
        try:
            if isinstance(stored, StoredZoom):
                profile = stored.profile(photo, request)
            else:
                known = replace(stored, facts=replace(facts, focal_mm=calibrated[0]))
                profile = stored_lens_profile(known, str(path), focal_mm)
        except OptionError:
            misses.append("–".join(f"{each:.4g}" for each in dict.fromkeys(calibrated)) + " mm")
            continue
        nearest = min(max(focal_mm or calibrated[0], calibrated[0]), calibrated[1])
        found.append((abs((focal_mm or nearest) - nearest), profile))
        names |= {facts.model} - {""}
    if not found:
        if misses:
            notes.append(
                f"your own calibrations of this camera, at {listed(misses)}, do not cover the photo"
            )
        return None, tuple(notes)
    if len(names) > 1 and not (request.lens_name or photo.facts.model):
        raise OptionError(
            "the photo does not name its lens, and your own calibrations of several match: "
            + listed(sorted(names)),
            hint="say which with --lens-name, or name a file with --lens",
        )
    if not (request.lens_name or photo.facts.model):
        notes.append(
            "the photo does not name its lens: your own calibration of this camera was taken"
        )
    return min(found, key=lambda each: each[0])[1], tuple(notes)


def read_kept(path: Path) -> tuple[StoredZoom | StoredLens, LensFacts, tuple[float, float]]:
    """A calibration of the store, what it says of itself, and its focal lengths.

    Raises:
        ReadError: it is damaged.
        UnsettledError: its fit did not reach a minimum.
    """
    source = Source(str(path), read_bytes(path))
    if f'"{ZOOM}"' in source.head[:1024]:
        zoom = zoom_json.read_zoom(source)
        return zoom, zoom.lens.facts, zoom.lens.range_mm
    stored = next(iter(stored_lenses(source)))
    own = stored.facts.focal_length_mm(stored.lens.frame) or 0.0
    return stored, stored.facts, (own, own)


def files() -> list[Path]:
    """The files of the store, in the order of their names."""
    try:
        return sorted(folder().glob("*.json"))[:_MOST_FILES]
    except OSError:
        return []


def _fits(facts: LensFacts, photo: PhotoFacts, request: LensRequest) -> bool:
    """Whether a calibration is of the photo's camera and lens, as far as both tell."""
    camera = request.like or request.camera or photo.facts.camera
    if not camera or not same_camera(facts.camera, camera):
        return False
    lens = request.lens_name or photo.facts.model
    if not facts.model:
        return True
    if not lens:
        return same_range(photo.lens_range_mm, numbers_of(facts.model).range_mm)
    return likeness(lens, facts.model) == 1.0


def _name(path: str, facts: LensFacts, focal: str) -> str:
    if not facts.camera:
        raise OptionError(
            f"{path} does not name its camera, so no photo could find it",
            hint="fit again with --photo and a photo whose EXIF names the camera",
        )
    words = " ".join(filter(None, (facts.camera, facts.model, focal)))
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", words).strip("_.")[:150] + ".json"
