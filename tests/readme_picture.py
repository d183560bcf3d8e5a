"""Draw the picture of the README: `python -m tests.readme_picture`.

Above, the photograph of the sample `grid_winmorph` with its picks and a straight line through the
ends of each picked line; below, the same photograph and picks, corrected with the fit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

import plumbline
from plumbline.frame import Array

FOLDER = Path(__file__).parents[1] / "sample_projects"
PICTURE = FOLDER / "before_and_after.jpg"
SHOWN_WIDTH = 900
SKY_BLUE, ORANGE = (233, 180, 86), (0, 94, 213)  # Okabe and Ito's palette, blue-green-red


def corrected(photo: Any, lens: plumbline.Lens) -> Any:
    """The photo resampled so that straight edges are straight."""
    height, width = photo.shape[:2]
    x, y = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    source = lens.distort(np.stack((x, y), axis=-1)).astype(np.float32)
    return cv2.remap(photo, source[..., 0], source[..., 1], cv2.INTER_CUBIC)


def with_picks(photo: Any, lines: list[Array]) -> Any:
    """The photo, reduced, with every line's picks and the chord through its ends."""
    height, width = photo.shape[:2]
    scale = SHOWN_WIDTH / width
    size = (SHOWN_WIDTH, round(height * scale))
    shown = cv2.resize(photo, size, interpolation=cv2.INTER_AREA)
    fraction = 4  # bits of a pixel that cv2 draws between
    for points in lines:
        at = np.round(((points + 0.5) * scale - 0.5) * 2**fraction).astype(int)
        (x0, y0), (x1, y1) = at[0].tolist(), at[-1].tolist()
        cv2.line(shown, (x0, y0), (x1, y1), ORANGE, 1, cv2.LINE_AA, fraction)
        for x, y in at.tolist():
            cv2.circle(shown, (x, y), 3 << fraction, SKY_BLUE, -1, cv2.LINE_AA, fraction)
    return shown


def main() -> None:
    """Make the picture."""
    folder = FOLDER / "grid_winmorph"
    observations = plumbline.read(folder / "grid.mrf", photo=folder / "facade.jpg", grid=(7, 9))
    made = plumbline.calibrate(observations)
    photo = cv2.imread(str(folder / "facade.jpg"))
    lines = [line.points_px for line in observations.lines]
    above = with_picks(photo, lines)
    below = with_picks(
        corrected(photo, made.lens), [made.lens.undistort(points) for points in lines]
    )
    gap = np.full((8, SHOWN_WIDTH, 3), 255, np.uint8)
    cv2.imwrite(str(PICTURE), np.vstack((above, gap, below)), [cv2.IMWRITE_JPEG_QUALITY, 82])


if __name__ == "__main__":
    main()
