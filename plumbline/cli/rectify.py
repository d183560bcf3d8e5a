"""`plumbline rectify`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import lens_options, option_types as types, options

_HELP = """Rectify a photograph of a plane to scale.

PHOTO shows a road, a floor or another plane. --points names a file of match points: where each is
seen in the photo (pixels) and where it lies on the plane (metres), as x,y,X,Y,name,sigma; QGIS's
.points and Global Mapper's tables are read too. Without X and Y, tape distances between the points
(--tapes) take their place. Camera, points, tapes and lines are adjusted together, each with its own
standard error, and the unevenness of the plane is part of the budget. The lens is found as by
correct. Written are the rectified picture with its world file, and what measure reads.

\b
Examples:
  plumbline rectify road.jpg --points points.csv --lens coolpix.json
  plumbline rectify road.jpg --points picks.csv --tapes tapes.csv --lines edges.csv
  plumbline rectify road.jpg --points points.csv --parallel left,right --lines edges.csv -o road.tif
  plumbline rectify door.jpg --points ruler.csv --square-on --ptlens a=0 --resolution 0.001
"""


@click.command("rectify", help=_HELP)
@click.argument("photo")
@click.option("--points", required=True, metavar="MATCH", help="Match points: x,y,X,Y,name,sigma.")
@click.option("--tapes", metavar="FILE", help="Tape distances: from,to,metres,sigma.")
@click.option(
    "--lines",
    metavar="FILE",
    help="Straight lines picked in the photo, as fit reads them; a column parallel names sets.",
)
@click.option(
    "--parallel",
    type=types.Names(),
    multiple=True,
    metavar="LINES",
    help="Lines that are parallel on the plane, as left,right; may be given several times.",
)
@click.option(
    "--right-angle",
    "right_angles",
    type=types.Names(),
    multiple=True,
    metavar="A,B,C",
    help="Three points with a right angle at the second; may be given several times.",
)
@click.option("--horizon", metavar="LINE", help="The line that is the horizon.")
@click.option(
    "--aerial",
    metavar="PICTURE",
    help="X and Y are pixels of this picture, which has a world file beside it.",
)
@click.option(
    "--square-on", is_flag=True, help="The camera was held square to the plane; two points do."
)
@click.option(
    "--sigma-pick", type=types.Positive(), default=0.5, show_default=True, metavar="PX",
    help="Standard error of a pick.",
)  # fmt: skip
@click.option(
    "--sigma-ground", type=types.Positive(), default=0.01, show_default=True, metavar="M",
    help="Standard error of a coordinate on the ground.",
)  # fmt: skip
@click.option(
    "--sigma-tape", type=types.Positive(), default=0.01, show_default=True, metavar="M",
    help="Standard error of a tape.",
)  # fmt: skip
@click.option(
    "--flatness", type=types.Positive(), default=0.02, show_default=True, metavar="M",
    help="Standard deviation of the plane's unevenness.",
)  # fmt: skip
@click.option(
    "--focal-px", type=types.Positive(), metavar="PX", help="Focal length in pixels of the photo."
)
@click.option(
    "--sigma-focal", type=click.FloatRange(0, 100), default=2.0, show_default=True,
    metavar="PERCENT", help="Standard error of the focal length; 0 holds it.",
)  # fmt: skip
@click.option(
    "--refine",
    type=types.Names(),
    metavar="NAMES",
    help="Coefficients of the lens to adjust too, as b or a,b,c; d,e is its centre.",
)
@lens_options.choosing
@click.option(
    "-o",
    "--output",
    metavar="PICTURE",
    help="The rectified picture; NAME_rectified beside the photo by default.",
)
@click.option(
    "--save",
    metavar="FILE.json",
    help="The rectification, for measure and report; beside the picture by default.",
)
@click.option("--no-picture", is_flag=True, help="Write the rectification only.")
@click.option(
    "--resolution", type=types.Positive(), default=0.01, show_default=True, metavar="M",
    help="Side of a pixel on the ground.",
)  # fmt: skip
@click.option(
    "--extent",
    default="points",
    show_default=True,
    metavar="WHAT",
    help="What to show: points, photo, or the corners X0,Y0,X1,Y1.",
)
@click.option(
    "--coarsest", type=types.Positive(), default=0.25, show_default=True, metavar="M",
    help="Cut what the photo shows with larger pixels on the ground.",
)  # fmt: skip
@click.option(
    "--border",
    type=click.Choice(["black", "white", "transparent"]),
    help="What stands where nothing is shown; transparent where the format can.",
)
@click.option(
    "--quality", type=click.IntRange(1, 100), default=95, show_default=True,
    help="Quality of JPEG and WebP.",
)  # fmt: skip
@click.option("--crs", metavar="EPSG", help="Coordinate system of X and Y, as EPSG:25832.")
@click.option("--dxf", metavar="FILE", help="Also write frame, points, tapes and ellipses for CAD.")
@click.option(
    "--overlay",
    metavar="AERIAL",
    help="Also write the comparison with this picture with a world file, as NAME_overlay.png: "
    "the aerial picture red, the photo green.",
)
@click.option(
    "--grid-like",
    metavar="PICTURE",
    help="Take the grid of this picture with a world file, in place of extent and resolution.",
)
@click.option(
    "--mosaic",
    metavar="FILE",
    help="Also write this picture blended with that of --grid-like, softly at their edges.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the rectification as JSON.")
@options.overwriting
@click.option("-q", "--quiet", is_flag=True, help="Print only errors and notes.")
def command(photo: str, **how: Any) -> None:
    """Gather, adjust, write, print."""
    from plumbline.cli.tools import rectify

    names = (
        *("lens", "ptlens", "camera", "lens_name", "like"),
        *("focal", "crop_factor", "full_size"),
    )
    context = click.get_current_context()
    if how["no_picture"]:
        useless = {"output", "resolution", "extent", "coarsest", "border", "quality", "crs"}
        useless |= {"overlay", "grid_like", "mosaic"}
        options.refuse_useless(context, "--no-picture", useless)
    request = lens_options.request_of(**{name: how.pop(name) for name in names})
    rectify.run(photo, request, how)
