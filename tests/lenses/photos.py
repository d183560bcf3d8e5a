"""Small photographs with EXIF, and the real ones for development."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

REAL = Path(__file__).parents[2].parent / "shared" / "data" / "photos"


def real(name: str) -> Path:
    """A camera original; the test is skipped where it is absent."""
    path = REAL / name
    if not path.is_file():
        pytest.skip(f"{name} is not here: it is for development only")
    return path


def photo(
    path: Path,
    size: tuple[int, int] = (400, 300),
    *,
    make: str = "",
    model: str = "",
    lens: str = "",
    focal: float | None = None,
    orientation: int | None = None,
    told: tuple[int, int] | None = None,
    software: str = "",
    lens_range: tuple[float, float] | None = None,
) -> Path:
    """A grey JPEG whose EXIF says what is given."""
    exif = Image.Exif()
    for tag, value in ((0x010F, make), (0x0110, model), (0x0131, software)):
        if value:
            exif[tag] = value
    if orientation:
        exif[0x0112] = orientation
    inner = exif.get_ifd(0x8769)
    if focal:
        inner[0x920A] = focal
    if lens:
        inner[0xA434] = lens
    if told:
        inner[0xA002], inner[0xA003] = told
    if lens_range:
        inner[0xA432] = (*lens_range, 3.5, 5.6)
    Image.new("L", size, 128).save(path, exif=exif)
    return path
