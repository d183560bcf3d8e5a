"""ImageMagick's `-distort Barrel`, written as a small shell script.

    "$im" "$1" -virtual-pixel black -distort Barrel "0.03 -0.1 0.04 1.03 1024 768" "$2"

r_obs = r (A r³ + B r² + C r + D) with r over half the shorter side, about (X, Y) counted from
the pixel's edge: the model and the direction of `ptlens`. The centre lies on both sides, so a
shifted one moves the corrected picture by the shift. Source: ImageMagick, "Distorting Images".
"""

from __future__ import annotations

from plumbline.frame import Frame


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
    if any(centre_px):
        x, y = frame.width / 2 + centre_px[0], frame.height / 2 + centre_px[1]
        arguments += f" {x:.9g} {y:.9g}"
    rows = [
        "#!/bin/sh",
        f"# {mark}, for photos of {frame.width}x{frame.height} pixels and their like",
        "# usage: sh THIS PHOTO CORRECTED",
        "command -v magick >/dev/null && im=magick || im=convert  # ImageMagick 7, or 6",
        f'"$im" "$1" -virtual-pixel black -distort Barrel "{arguments}" "$2"',
    ]
    return ("\n".join(rows) + "\n").encode()
