"""The command line: one file a verb, loaded when the verb is used."""

from __future__ import annotations

import _thread
import codecs
import contextlib
import io
import os
import sys
import threading
import warnings
from importlib import import_module

import click

from plumbline._version import __version__
from plumbline.errors import PlumblineError, printable
from plumbline.wording import spelt

VERBS = {
    "pick": "Pick lines on a page in the browser, with the fit running while you click.",
    "fit": "Find the distortion that makes picked lines straight.",
    "snap": "Move picks onto the photograph's edges, to a small part of a pixel.",
    "find": "Find a photograph's long straight edges without picks.",
    "board": "Calibrate from photographs of a chequerboard.",
    "pair": "Calibrate from a photograph and the same one corrected.",
    "check": "Say whether the picks determine the distortion, and what to pick next.",
    "compare": "Compare the distortion models on the same picks, and recommend one.",
    "report": "Show a calibration as a page with figures, tables and checksums.",
    "correct": "Take the lens distortion out of photographs.",
    "rectify": "Rectify a photograph of a plane to scale.",
    "measure": "Measure places, distances, angles and areas in a rectified photograph.",
    "convert": "Convert picked points to CSV, JSON or a Hugin project.",
    "lens": "Show which lens a photo would be corrected with, or store a calibration.",
    "zoom": "Join calibrations at several focal lengths into one lens.",
    "export": "Write a calibrated lens for another program.",
    "models": "List the distortion models.",
    "cache": "Show or clear the cache of compiled programs.",
}

_STOPPED = 130
"""Exit status after Ctrl-C: 128 and the signal's number, as shells have it."""

_EXAMPLES = """\b
Examples:
  plumbline fit building.pto
  plumbline fit picks.csv --photo facade.jpg
  plumbline correct facade.jpg --lens building.fit.pto
  plumbline convert grid.mrf grid.pto --photo facade.jpg --grid 7x9"""


class _Verbs(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in VERBS:
            return None
        return import_module(f"plumbline.cli.{cmd_name}").command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))


@click.group(
    cls=_Verbs,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=_EXAMPLES,
)
@click.version_option(__version__, message="plumbline %(version)s")
def command() -> None:
    """Calibrate a lens from straight lines.

    Pick points along straight edges of a photograph in any viewer; plumbline finds the
    distortion that makes every line straight again, states the error, and writes a Hugin
    project (PTO) and a LensFun profile (XML).
    """


def main() -> None:
    """Run the command line; an error becomes one red sentence, its remedy and an exit status."""
    codecs.register_error("spelt", spelt)
    for stream in (sys.stdout, sys.stderr):
        # A file name that is not text, or a terminal without Greek letters, must not stop us.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="spelt")
    sys.unraisablehook = _interrupted_again
    if not sys.warnoptions:  # what libraries tell programmers is nothing for the user
        warnings.simplefilter("ignore")
    sys.exit(_status())


def _status() -> int:
    """Run the command; the exit status."""
    try:
        status = command(prog_name="plumbline", standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        _complain("Stopped; only the files named above were written")
        return _STOPPED
    except PlumblineError as error:
        _complain(f"Error: {printable(error.message)}")
        if error.hint:
            click.echo(f"  {printable(error.hint)}.", err=True)
        return 1
    except BrokenPipeError:  # the reader of the output has closed it, as `head` does
        _drop_output()
        return 1
    except OSError as error:  # files raise errors of their own: this is standard output
        _drop_output()
        _complain(f"Error: the output cannot be written: {error.strerror}")
        return 1
    return status or 0


def _complain(sentence: str) -> None:
    click.secho(f"{sentence}.", fg="red", err=True)


def _drop_output() -> None:
    """Discard what is still to be printed, or Python complains about it at exit."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _interrupted_again(unraisable: sys.UnraisableHookArgs) -> None:
    """Raise Ctrl-C again where it arrived in a callback, which cannot raise anything."""
    if unraisable.exc_type is KeyboardInterrupt:
        threading.Timer(0.01, _thread.interrupt_main).start()
    else:
        sys.__unraisablehook__(unraisable)
