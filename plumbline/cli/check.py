"""`plumbline check`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import options

_HELP = """Say whether the picks determine the distortion, and what to pick next.

Before a fit: whether the lines reach the edges and corners, how much of the photo is extrapolated,
whether lines run too close to the centre, and the rule of LensFun's profile makers. After a fit:
the error of the correction and which line would reduce it most, how much the result depends on
single lines, whether a richer model would differ, and which picks are suspicious. ✓ marks what is
good, ? what is doubtful, and ✗ what is bad, with its remedy. No file is written.

\b
Examples:
  plumbline check building.pto
  plumbline check picks.csv --photo facade.jpg --model poly3
"""


@click.command("check", help=_HELP)
@click.argument("points", nargs=-1, required=True)
@options.model
@options.coefficients
@options.reading
@options.focal
@click.option("--json", "as_json", is_flag=True, help="Print the checks as JSON.")
def command(
    points: tuple[str, ...],
    model: str,
    free: tuple[str, ...] | None,
    hold: tuple[str, ...] | None,
    as_json: bool,
    **reading: Any,
) -> None:
    """Read, check, fit, check, print."""
    from rich.console import Console

    from plumbline.cli.tools.check import check_lenses
    from plumbline.cli.tools.narration import tell_notes
    from plumbline.reading.gathering import parts_of
    from plumbline.report.terminal.checks import print_checks, print_suspects
    from plumbline.report.terminal.summary import WideConsole, print_title
    from plumbline.result.checked import as_dict

    options.refuse_unknown(model, {"--free": free, "--hold": hold})
    parts = parts_of(points, reading)
    tell_notes(parts)
    found = check_lenses(parts, Console(stderr=True), model=model, free=free, hold=hold or ())
    if as_json:
        import json

        lenses = [as_dict(each) for each in found]
        click.echo(json.dumps({"lenses": lenses}, indent=2, ensure_ascii=False))
    else:
        console = WideConsole()
        for part, each in zip(parts, found, strict=True):
            if len(parts) > 1:
                print_title(console, part)
            print_checks(console, each.checks)
            print_suspects(console, each.suspects, everything=True)
    for each in found:
        if each.error is not None:
            raise each.error
