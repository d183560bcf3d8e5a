"""`plumbline compare`."""

from __future__ import annotations

from typing import Any

import click

from plumbline.cli import options

_HELP = """Compare the distortion models on the same picks, and recommend one.

Every model is fitted to POINTS. Models are judged by how straight they leave lines that took no
part in the fit, and by how many pixels their curves differ; a simpler model is recommended where
the difference does not matter. Equivalent models share a row.
`plumbline fit --model auto` fits the recommended one.

\b
Examples:
  plumbline compare building.pto
  plumbline compare picks.csv --photo facade.jpg
  plumbline compare building.pto --robust
  plumbline compare building.pto --json
"""


@click.command("compare", help=_HELP)
@click.argument("points", nargs=-1, required=True)
@options.reading
@click.option("--robust", is_flag=True, help="Leave suspicious picks out of all fits.")
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
def command(points: tuple[str, ...], robust: bool, as_json: bool, **options: Any) -> None:
    """Read, compare, print."""
    from rich.console import Console

    from plumbline.cli.tools.fit import compare_lenses
    from plumbline.cli.tools.narration import tell_notes
    from plumbline.reading.gathering import parts_of
    from plumbline.result.comparison import as_dict

    parts = parts_of(points, options)
    tell_notes(parts)
    comparisons = compare_lenses(parts, Console(stderr=True), robust=robust)
    if as_json:
        import json

        whole = {"comparisons": [as_dict(each) for each in comparisons]}
        click.echo(json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False))
        return
    from plumbline.report.terminal.comparison import print_comparison
    from plumbline.report.terminal.summary import WideConsole, print_title

    console = WideConsole()
    for part, comparison in zip(parts, comparisons, strict=True):
        if len(parts) > 1:
            print_title(console, part)
        print_comparison(console, comparison)
