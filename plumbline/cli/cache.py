"""`plumbline cache`."""

from __future__ import annotations

import click

_HELP = """Show or clear the cache of compiled programs.

The first fit of each kind takes a few seconds to compile; the program is kept in the user's cache
folder, or in the folder that PLUMBLINE_CACHE_DIR names. Only speed depends on it.

\b
Examples:
  plumbline cache
  plumbline cache --clear
"""


@click.command("cache", help=_HELP)
@click.option("--clear", "clearing", is_flag=True, help="Delete the cached programs.")
def command(clearing: bool) -> None:
    """Print where the cache is and how much it holds, and clear it if asked to."""
    from plumbline.errors import printable
    from plumbline.fit.program.compiled import cache_folder, clear, kept
    from plumbline.wording import count

    folder = cache_folder()
    files = kept(folder)
    size = sum(path.stat().st_size for path in files) / 2**20
    click.echo(f"{printable(str(folder))}: {count(len(files), 'file')}, {size:.1f} MiB")
    if clearing:
        click.echo(f"Removed {count(clear(folder), 'file')}.")
