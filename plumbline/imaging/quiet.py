"""What C libraries print, kept from the user: libjpeg, libpng, libtiff and OpenCV."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Generator
from contextlib import contextmanager

_STDERR = 2
"""The file descriptor that C libraries write their messages to."""


@contextmanager
def libraries_silenced() -> Generator[None]:
    """Send the process's standard error to nowhere, but for what Python itself prints.

    The decoders' lines name no file and tell nothing that plumbline does not tell itself. Nothing
    is done where Python's standard error is not the process's own.
    """
    ours = sys.stderr
    try:
        own = ours.fileno() == _STDERR
    except (AttributeError, OSError, ValueError):
        own = False
    if not own or not isinstance(ours, io.TextIOWrapper):
        yield
        return
    ours.flush()
    kept = os.dup(_STDERR)
    speaking = os.fdopen(
        kept, "w", encoding=ours.encoding, errors=ours.errors, buffering=1, closefd=False
    )
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, _STDERR)
    os.close(nowhere)
    sys.stderr = speaking
    try:
        yield
    finally:
        speaking.flush()
        sys.stderr = ours
        os.dup2(kept, _STDERR)
        os.close(kept)
