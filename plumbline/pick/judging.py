"""Judge documents in a process of its own, so that no click waits for it.

`python -m plumbline.pick.judging` reads documents from its standard input, one a line, and writes
what it finds to its standard output; it ends when its input does, however the server ended.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import msgspec

from plumbline.pick.document import Document

_POLITE = 5
"""By how much the process gives way to the server's (nice)."""


class Judge:
    """Has the newest document judged; older ones are passed over.

    Args:
        done: Called with the revision and what was found, in a thread of its own.
    """

    def __init__(self, done: Callable[[int, dict[str, Any]], None]) -> None:
        self._done = done
        self._next: tuple[int, Document] | None = None
        self._changed = threading.Condition()
        self._stopped = False
        self._process: subprocess.Popen[bytes] | None = None
        threading.Thread(target=self._run, name="judge", daemon=True).start()

    def ask(self, revision: int, document: Document) -> None:
        """Judge this document next."""
        with self._changed:
            self._next = revision, document
            self._changed.notify()

    def stop(self) -> None:
        """End, whatever is in hand."""
        with self._changed:
            self._stopped = True
            self._changed.notify()
            process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopped or self._next is not None)
                if self._stopped:
                    return
                asked, self._next = self._next, None
            if asked is not None:
                revision, document = asked
                found = self._judged(document)
                if found is not None:
                    self._done(revision, found)

    def _judged(self, document: Document) -> dict[str, Any] | None:
        """What the process says; None where it ended before it said anything."""
        process = self._running()
        if process.stdin is None or process.stdout is None:
            return None
        try:
            process.stdin.write(msgspec.json.encode(document) + b"\n")
            process.stdin.flush()
            answer = process.stdout.readline()
        except OSError:
            return None
        return msgspec.json.decode(answer) if answer else None

    def _running(self) -> subprocess.Popen[bytes]:
        """The process, begun anew if it ended."""
        with self._changed:
            if self._process is None or self._process.poll() is not None:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "plumbline.pick.judging"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                )
            return self._process


def main() -> None:
    """Judge what comes in until no more comes."""
    from plumbline.pick.advice import judgement
    from plumbline.pick.live import judged

    if hasattr(os, "nice"):
        os.nice(_POLITE)
    for line in sys.stdin.buffer:
        document = msgspec.json.decode(line, type=Document)
        found = judgement(judged(document), document)
        sys.stdout.buffer.write(msgspec.json.encode(found) + b"\n")
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
