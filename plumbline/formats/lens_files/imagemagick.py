"""ImageMagick's `-distort Barrel`, written as a small shell script.

    "$im" "$1" -virtual-pixel black -distort Barrel "0.03 -0.1 0.04 1.03" "$2"

r_obs = r (A r³ + B r² + C r + D) with r over half the shorter side, about (X, Y) counted from
the pixel's edge: the model and the direction of `ptlens`. The centre lies on both sides, so a
shifted one moves the corrected picture by the shift. It is written as shares of the width and the
height, so that it fits photos of any size that lie as those of the calibration. Source:
ImageMagick, "Distorting Images".
"""

from __future__ import annotations

from plumbline.frame import Frame

_SAME_SHAPE = 0.02
"""Chosen because photos of one camera, resized to whole pixels, differ by less than 1 %."""


def barrel(
    abc: tuple[float, float, float], frame: Frame, centre_px: tuple[float, float], mark: str
) -> bytes:
    """A script that corrects a photo.

    Args:
        abc: The coefficients.
        frame: The photo's frame, at square pixels.
        centre_px: Offset of the distortion centre from the image centre.
        mark: A comment for the head.
    """
    values = [*abc, 1.0 - sum(abc)]
    arguments = " ".join(f"{value:.12g}" for value in values)
    rows = [
        "#!/bin/sh",
        f"# {mark}, for photos of {frame.width}x{frame.height} pixels and their like",
        "# usage: sh THIS PHOTO CORRECTED",
        "command -v magick >/dev/null && im=magick || im=convert  # ImageMagick 7, or 6",
    ]
    if any(centre_px):
        x, y = 0.5 + centre_px[0] / frame.width, 0.5 + centre_px[1] / frame.height
        arguments += f" %[fx:w*{x:.9g}] %[fx:h*{y:.9g}]"
        shape = f"%[fx:abs(w/h/{frame.width / frame.height:.6g}-1)<{_SAME_SHAPE}]"
        rows += [
            f'[ "$("$im" "$1" -format \'{shape}\' info:)" = 1 ] || {{',
            f'  echo "$1: not a whole photo that lies as {frame.width}x{frame.height} does" >&2',
            "  exit 1",
            "}",
        ]
    rows.append(f'"$im" "$1" -virtual-pixel black -distort Barrel "{arguments}" "$2"')
    return ("\n".join(rows) + "\n").encode()
