"""The groups of the simulations: lenses of LensFun's database, layouts of lines, noise.

The coefficients stand here as the database has them, so that nothing needs to be installed.
"""

from __future__ import annotations

from itertools import cycle

from tests.benchmarks.simulated import Group, Layout
from tests.truth import TrueLens

PTLENS: dict[str, tuple[tuple[float, float, float], tuple[int, int]]] = {
    "S120 5.2 mm": ((0.03458, -0.14652, -0.00567), (4000, 3000)),
    "G7 X 8.8 mm": ((0.03872, -0.15563, 0.02544), (5472, 3648)),
    "Sigma 14 mm": ((0.031106, -0.059086, 0.0), (3000, 2000)),
    "AF-P 10-20 at 10 mm": ((0.01265, -0.08749, 0.1144), (6000, 4000)),
    "E 10-18 at 14 mm": ((0.116361, -0.255284, 0.189679), (4912, 3264)),
    "FC6310 drone": ((0.00961599, -0.0582928, -0.00551691), (1920, 1080)),
    "Tamron 18-400 at 70 mm": ((-0.01648, 0.08537, -0.10046), (6000, 4000)),
    "M.Zuiko 14-42 at 16 mm": ((0.0738, -0.25191, 0.21409), (4608, 3456)),
    "Mavic Pro": ((0.0, -0.014, 0.033), (4000, 3000)),
    "IXUS 220 4.3 mm": ((0.02693, -0.08681, -0.06074), (2048, 1536)),
}
"""Barrel, pincushion and moustache lenses: a, b, c and the size of a photo."""

GOPRO = TrueLens("ptlens", {"a": 0.01049, "b": 0.01663, "c": -0.40901}, (4000, 3000))
"""GoPro Hero3+ black: its corners lie 2.8 half short sides from the centre once corrected."""

FACADE = Layout("façade", 12, 5, 6)
GRID = Layout("grid", 16, 12, 12)
FEW = Layout("few lines", 4, 12, 12)
UNEVEN = Layout("uneven", 12, 3, 20)
DENSE = Layout("dense", 10, 100, 100)
SLANTED = Layout("slanted", 14, 8, 10, slanted=True)
FRAMES = Layout("window frames", 16, 8, 12, paired=True)
HALF = Layout("left two thirds", 12, 10, 10, reach=0.67)
LAYOUTS = (FACADE, GRID, UNEVEN, DENSE, SLANTED, HALF)
NOISE_PX = (0.3, 0.1, 0.5, 1.0)


def lens(name: str, **moved: float) -> TrueLens:
    """A lens of the table, its centre moved by `d`, `e` pixels."""
    (a, b, c), size = PTLENS[name]
    return TrueLens("ptlens", {"a": a, "b": b, "c": c} | moved, size)


def portrait(one: TrueLens) -> TrueLens:
    """The same lens in front of a photo held upright."""
    width, height = one.size
    return TrueLens(one.name, one.coefficients, (height, width))


def _of_every_lens() -> list[Group]:
    """Three layouts and three levels of noise for each lens of the table."""
    noises = cycle(NOISE_PX)
    layouts = cycle(LAYOUTS)
    return [
        Group(name, lens(name), next(layouts), next(noises)) for name in PTLENS for _ in range(3)
    ]


_POLY3 = TrueLens("poly3", {"k1": -0.036}, (4032, 3024))
_POLY3_TELE = TrueLens("poly3", {"k1": 0.01651}, (4000, 3000))
_POLY5 = TrueLens("poly5", {"k1": -0.030571633, "k2": 0.004658548}, (3648, 2736))
_EVEN = TrueLens("radial:2,4,6", {"a2": 0.11, "a4": 0.02, "a6": 0.004}, (3000, 2000))
_BROWN = TrueLens("brown", {"k1": 0.09, "k2": 0.01, "k3": 0.002}, (3000, 2250))
_DECENTRED = TrueLens("brown", {"k1": 0.09, "k2": 0.01, "p1": 0.0015, "p2": -0.001}, (3000, 2250))
_DIVISION = TrueLens("division", {"l1": -0.1, "l2": -0.006}, (640, 480))
_CENTRE = ("a", "b", "c", "d", "e")

_SPECIAL = [
    Group("GoPro Hero3+", GOPRO, GRID, 0.3),
    Group("GoPro Hero3+", GOPRO, FACADE, 0.5),
    Group("GoPro Hero3+", GOPRO, DENSE, 1.0),
    Group("GoPro Hero3+", GOPRO, UNEVEN, 0.3),
    Group("S120 5.2 mm, portrait", portrait(lens("S120 5.2 mm")), GRID, 0.5),
    Group("FC6310 drone, portrait", portrait(lens("FC6310 drone")), FACADE, 0.3),
    Group("S120 5.2 mm", lens("S120 5.2 mm"), FEW, 0.3),
    Group("G7 X 8.8 mm", lens("G7 X 8.8 mm"), FEW, 0.5),
    Group("E 10-18 at 14 mm", lens("E 10-18 at 14 mm"), FEW, 0.3),
    Group("Mavic Pro", lens("Mavic Pro"), FEW, 0.1),
    Group("S120 off centre", lens("S120 5.2 mm", d=35.0, e=-22.0), GRID, 0.3, free=_CENTRE),
    Group("G7 X off centre", lens("G7 X 8.8 mm", d=-60.0, e=40.0), SLANTED, 0.5, free=_CENTRE),
    Group("IXUS off centre", lens("IXUS 220 4.3 mm", d=18.0, e=9.0), UNEVEN, 0.3, free=_CENTRE),
    Group("E 10-18 off centre", lens("E 10-18 at 14 mm", d=25.0, e=25.0), DENSE, 1.0, free=_CENTRE),
    Group("S120 5.2 mm", lens("S120 5.2 mm"), HALF, 0.3, free=_CENTRE),
    Group("Olympus 14-42 at 18 mm", _POLY3, FACADE, 0.3, "poly3"),
    Group("Olympus 14-42 at 18 mm", _POLY3, FEW, 0.5, "poly3"),
    Group("SX510 at 129 mm", _POLY3_TELE, GRID, 0.3, "poly3"),
    Group("G12 6.1 mm", _POLY5, GRID, 0.3, "poly5"),
    Group("G12 6.1 mm", _POLY5, UNEVEN, 0.5, "poly5"),
    Group("even powers", _EVEN, GRID, 0.3, "radial:2,4,6"),
    Group("even powers", _EVEN, DENSE, 1.0, "radial:2,4,6"),
    Group("Brown", _BROWN, GRID, 0.3, "brown", ("k1", "k2", "k3")),
    Group("Brown decentred", _DECENTRED, GRID, 0.3, "brown", ("k1", "k2", "p1", "p2")),
    Group("Brown decentred", _DECENTRED, UNEVEN, 0.5, "brown", ("k1", "k2", "p1", "p2")),
    Group("division", _DIVISION, GRID, 0.3, "division"),
    Group("division", _DIVISION, SLANTED, 0.1, "division"),
]

ALIKE = (*_of_every_lens(), *_SPECIAL)
"""Groups whose truth is of the family that is fitted."""

UNLIKE = (
    Group("division, as ptlens", _DIVISION, GRID, 0.3),
    Group("Brown, as ptlens", _BROWN, GRID, 0.3),
    Group("G12 6.1 mm, as ptlens", _POLY5, FACADE, 0.3),
    Group("GoPro Hero3+, as division", GOPRO, GRID, 0.3, "division"),
    Group("S120, as radial:2,4,6", lens("S120 5.2 mm"), FACADE, 0.3, "radial:2,4,6"),
)
"""Groups whose truth is of another family: what their fits are off is the model's error."""
