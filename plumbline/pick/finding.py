"""Find edges to propose, in a process of its own: it takes seconds of processor time.

`python -m plumbline.pick.finding` reads a photo's name from its standard input, and writes what
`plumbline.edges.find` finds to its standard output: nothing, where the photo cannot be read. It
ends when its input does, however the server ended.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import msgspec

from plumbline.frame import Frame
from plumbline.geometry.lens import Lens
from plumbline.models import get_model
from plumbline.pick.document import Point, Proposal

_POLITE = 10
"""By how much the process gives way to clicks and their judgement (nice)."""


class _Edge(msgspec.Struct, frozen=True):
    points: tuple[Point, ...]
    errors: tuple[float, ...]


class _Told(msgspec.Struct, frozen=True):
    edges: tuple[_Edge, ...]
    model: str
    coefficients: dict[str, float]


@dataclass(frozen=True)
class Found:
    """What was found in one photo.

    Attributes:
        proposals: The edges.
        lens: The lens that makes them straight, a rough one.
    """

    proposals: tuple[Proposal, ...]
    lens: Lens


class Finder:
    """Looks for edges in photos, one after the other."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._stopped = False

    def find(self, path: Path, size: tuple[int, int], photo: int, first: int) -> Found | None:
        """Look for edges in one photo; waits for them.

        Args:
            path: The photo's file.
            size: Its width and height.
            photo: Its number.
            first: The number of the first proposal.

        Returns:
            None where nothing was found, or the search was stopped.
        """
        if self._stopped:
            return None
        self._process = subprocess.Popen(
            [sys.executable, "-m", "plumbline.pick.finding"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        with self._process as process:
            answer = _answer(process, path)
        if not answer:
            return None
        told = msgspec.json.decode(answer, type=_Told)
        proposals = [
            Proposal(number, photo, edge.points, edge.errors)
            for number, edge in enumerate(told.edges, first)
        ]
        lens = Lens(get_model(told.model), Frame(*size), told.coefficients)
        return Found(tuple(proposals), lens)

    def stop(self) -> None:
        """End the search in hand, and begin no other."""
        self._stopped = True
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()


def _answer(process: subprocess.Popen[bytes], path: Path) -> bytes:
    """What the process says of a photo; nothing where it was stopped."""
    if process.stdin is None or process.stdout is None:
        return b""
    try:
        process.stdin.write(msgspec.json.encode(os.fsencode(path)) + b"\n")
        process.stdin.flush()
    except OSError:
        return b""
    return process.stdout.read()


def _end_with_server() -> None:
    """End with the server, whose end closes this process's input."""
    os.read(sys.stdin.fileno(), 1)
    os._exit(1)


def main(path: str) -> None:
    """Write the edges of one photo."""
    threading.Thread(target=_end_with_server, daemon=True).start()
    from plumbline.edges.find import find_edges
    from plumbline.edges.snap import SAMPLES
    from plumbline.edges.trace import condensed
    from plumbline.errors import PlumblineError

    if hasattr(os, "nice"):
        os.nice(_POLITE)
    try:
        found = find_edges(path)
    except PlumblineError:
        return
    edges = [condensed(each, SAMPLES) for each in found.lines]
    told = _Told(
        tuple(
            _Edge(
                tuple((x, y) for x, y in each.points_px.round(4).tolist()),
                tuple(each.errors_px.round(4).tolist()),
            )
            for each in edges
        ),
        found.lens.model.label,
        dict(found.lens.coefficients),
    )
    sys.stdout.buffer.write(msgspec.json.encode(told))


if __name__ == "__main__":
    main(os.fsdecode(msgspec.json.decode(sys.stdin.buffer.readline(), type=bytes)))
