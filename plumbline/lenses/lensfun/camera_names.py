"""Cameras of a LensFun database by name."""

from __future__ import annotations

from typing import Any

from plumbline.lenses.lensfun.database import Database
from plumbline.photos.cameras import same_camera


def find_camera(database: Database, maker: str, model: str) -> Any | None:
    """The camera of that name, as EXIF spells it or as people do; None if it is not there."""
    if not model:
        return None
    found = database.library.find_cameras(maker or None, model)
    if not found:
        said = _words(f"{maker} {model}")
        found = [
            camera
            for camera in database.library.cameras
            if _words(camera.model) <= said <= _words(f"{camera.maker} {camera.model}")
            or same_camera(f"{maker} {model}", with_maker(str(camera.maker), str(camera.model)))
        ]
    return found[0] if found else None


def _words(name: str) -> set[str]:
    return set(name.casefold().split())


def similar_cameras(database: Database, maker: str, model: str) -> list[str]:
    """Names of cameras whose names are alike, for a question."""
    found = database.library.find_cameras(maker or None, model, True) if model else []
    return list(dict.fromkeys(camera_name(camera) for camera in found))[:5]


def camera_name(camera: Any) -> str:
    """Maker and model, the maker only once."""
    return with_maker(str(camera.maker), str(camera.model))


def with_maker(maker: str, model: str) -> str:
    """Maker and model, the maker only once."""
    alike = model.casefold().startswith(maker.casefold().split()[0]) if maker else True
    return model if alike else f"{maker} {model}"
