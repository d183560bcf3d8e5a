"""Workers of a batch: they end with their parent, however that ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

_BATCH = """
import os, time
from plumbline.imaging.workers import processes

if __name__ == "__main__":
    pool = processes(2)
    futures = [pool.submit(os.getpid) for _ in range(8)]
    print(*{future.result() for future in futures}, flush=True)
    time.sleep(60)
"""


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="signals are those of POSIX")
def test_workers_end_when_their_parent_is_killed() -> None:
    parent = subprocess.Popen(
        [sys.executable, "-c", _BATCH], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    with parent:
        assert parent.stdout is not None
        workers = [int(word) for word in parent.stdout.readline().split()]
        assert workers
        assert all(map(_runs, workers))
        parent.kill()
    ended_by = time.monotonic() + 20
    while any(map(_runs, workers)):
        assert time.monotonic() < ended_by, "a worker outlives its parent"
        time.sleep(0.05)
