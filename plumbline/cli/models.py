"""`plumbline models`."""

from __future__ import annotations

import click

_HELP = """List the distortion models.

Names are values of --model; each comes with its coefficients, equation and use. r is the distance
from the distortion centre; "ideal" is where a perfect perspective camera would put a point,
"observed" where the photograph shows it. Every model can also free the distortion centre d, e, in
pixels.

\b
Example:
  plumbline models
"""


@click.command("models", help=_HELP)
def command() -> None:
    """Print the models, a block each."""
    from plumbline.models import MODELS
    from plumbline.report.terminal.models import models_text

    click.echo(models_text(MODELS.values()))
