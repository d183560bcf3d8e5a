"""Photos, match points, tapes and lines of an independent scene, as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from plumbline.ground.rectification import Rectification
from plumbline.ground.rectify import rectify
from plumbline.lenses.request import LensRequest
from tests.ground.scenes import Scene
from tests.truth import Array

SCENE = Scene(height=1.6, pitch=9, roll=0.5)
LENS = LensRequest(ptlens={"b": -0.02})
NAMES = "ABCDEFGH"
GROUND = np.array(
    [[-1.4, 4.5], [1.4, 4.5], [5.0, 25.0], [-5.0, 25.0], [0.0, 10.0], [1.5, 14.0], [-2.0, 18.0]]
)
FOCAL_MM, EQUIVALENT_MM = 8.2, 39.5


def photo(folder: Path, size: tuple[int, int] = (2048, 1536), *, exif: bool = True) -> Path:
    """A grey photo with the EXIF of a compact camera; 39.5 mm is told as 40."""
    path = folder / "road.jpg"
    tags = Image.Exif()
    if exif:
        tags[0x010F], tags[0x0110] = "NIKON", "E995"
        own = tags.get_ifd(0x8769)
        own[0x920A], own[0xA405] = FOCAL_MM, round(EQUIVALENT_MM)
    Image.new("RGB", size, (120, 130, 140)).save(path, exif=tags)
    return path


def rows(
    ground: Array = GROUND, scene: Scene = SCENE, names: str = NAMES
) -> list[tuple[float, float, float, float, str]]:
    """x, y, X, Y, name of each point."""
    seen = scene.photo(ground)
    return [
        (x, y, east, north, name)
        for (x, y), (east, north), name in zip(
            seen.tolist(), ground.tolist(), names[: len(ground)], strict=True
        )
    ]


def csv(folder: Path, name: str, lines: Sequence[Sequence[object]], header: str = "") -> str:
    """A table as a file."""
    path = folder / name
    body = "".join(",".join(map(str, line)) + "\n" for line in lines)
    path.write_text((header + "\n" if header else "") + body, encoding="utf-8")
    return str(path)


def matches(folder: Path, lines: Sequence[Sequence[object]] | None = None) -> str:
    """A file of match points."""
    return csv(folder, "points.csv", rows() if lines is None else lines, "x,y,X,Y,name")


def tapes(folder: Path, pairs: Sequence[str], ground: Array = GROUND) -> str:
    """A file of tape distances between points, as "AB"."""
    ends = [(NAMES.index(first), NAMES.index(second)) for first, second in pairs]
    lines = [
        (first, second, float(np.hypot(*(ground[i] - ground[j]))))
        for (first, second), (i, j) in zip(pairs, ends, strict=True)
    ]
    return csv(folder, "tapes.csv", lines, "from,to,metres")


def edges(folder: Path, header: str = "line,x,y", last: Sequence[str] = ()) -> str:
    """Two lane edges and the horizon, traced without error."""
    lines: list[list[object]] = []
    for name, x in (("left", -1.75), ("right", 1.75)):
        along = np.geomspace(8, 60, 8)
        places = np.column_stack((np.full(8, x), along))
        picks: list[list[object]] = SCENE.photo(places).tolist()
        lines += [[name, *pick, *last] for pick in picks]
    return csv(folder, "edges.csv", lines, header)


def rectified(folder: Path, points: str | None = None, **request: object) -> Rectification:
    """The scene rectified."""
    return rectify(photo(folder), points or matches(folder), LENS, **request)
