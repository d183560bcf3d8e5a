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


_INTERRUPTED = """
import os, signal
from plumbline.imaging.workers import processes

if __name__ == "__main__":
    with processes(1) as pool:
        worker = pool.submit(os.getpid).result()
        for _ in range(3):
            os.kill(worker, signal.SIGINT)
        assert pool.submit(os.getpid).result() == worker
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
"""


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals are those of POSIX")
def test_an_interrupt_is_the_parent_s_alone() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _INTERRUPTED],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
