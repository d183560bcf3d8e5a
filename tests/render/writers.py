"""Writes picks the way other programs do: a Hugin project, a CSV table, a WinMorph file.

Picks count from the centre of the top-left pixel; WinMorph counts from its corner, in fractions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log2

from .optics import Array, View
from .photo import APERTURE, EXPOSURE_S
from .picks import Line

EXPOSURE = log2(APERTURE**2 / EXPOSURE_S)  # the EXIF's aperture and time as an exposure value


@dataclass(frozen=True)
class Shot:
    """One photograph of a project and the lines picked in it."""

    name: str
    view: View
    lines: Sequence[Line]


def hugin(shots: Sequence[Shot]) -> str:
    """Return a Hugin 2022 project: every line's points paired with their own reversal."""
    wide, high = shots[0].view.width, shots[0].view.height
    text = ["# hugin project file", "#hugin_ptoversion 2"]
    text.append(
        f'p f0 w{wide} h{high} v{_fov(shots[0].view)}  k0 E{EXPOSURE:.6g} R0 n"TIFF_m c:LZW r:CROP"'
    )
    text += ["m i0", "", "# image lines"]
    for number, shot in enumerate(shots):
        view = shot.view
        text.append(f"#-hugin  cropFactor={view.lens.crop:g}")
        text.append(
            f"i w{view.width} h{view.height} f0 v{_fov(view)} Ra0 Rb0 Rc0 Rd0 Re0 "
            f"Eev{EXPOSURE:.10g} Er1 Eb1 r0 p0 y0 TrX0 TrY0 TrZ0 Tpy0 Tpp0 j0 "
            "a0 b0 c0 d0 e0 g0 t0 "
            "Va1 Vb0 Vc0 Vd0 Vx0 Vy0  Vm5 u10 "
            f'n"{shot.name}"'
        )
        if number + 1 == len(shots):
            text += ["", ""]
    text.append("# specify variables that should be optimized")
    text += [f"v a{number} b{number} c{number}" for number in range(len(shots))]
    text += ["v", "", "", "# control points"]
    for number, shot in enumerate(shots):
        for kind, line in enumerate(shot.lines, start=3):
            text += _pairs(number, kind, line.points)
    text += ["", "#hugin_optimizeReferenceImage 0", "#hugin_blender enblend", "", "*", ""]
    return "\n".join(text)


def _fov(view: View) -> str:
    return f"{view.lens.hfov(view.width, view.height):.10g}"


def _pairs(image: int, kind: int, points: Array) -> list[str]:
    if len(points) % 2:
        raise ValueError("an odd number of picks would pair the middle one with itself")
    return [
        f"c n{image} N{image} x{p[0]:.6f} y{p[1]:.6f} X{q[0]:.6f} Y{q[1]:.6f} t{kind}"
        for p, q in zip(points, points[::-1], strict=True)
    ]


def csv(lines: Sequence[Line]) -> str:
    """Return a table of line, x, y with one decimal, as a viewer's status bar shows them."""
    rows = ["line,x,y"]
    for number, line in enumerate(lines, start=1):
        rows += [f"{number},{x:.1f},{y:.1f}" for x, y in line.points.tolist()]
    return "\n".join([*rows, ""])


def winmorph(view: View, grid: Array) -> str:
    """Return a WinMorph file with one shape that runs over the grid row by row."""
    rows = ["  Shape1", f"  Points = {grid.shape[0] * grid.shape[1]}", "  Closed = 0"]
    for x, y in grid.reshape(-1, 2).tolist():
        rows.append(f"  {(x + 0.5) / view.width:.6f} {(y + 0.5) / view.height:.6f}")
    return "\n".join([*rows, "  Sets = 0", ""])
