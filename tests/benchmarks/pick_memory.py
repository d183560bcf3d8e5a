"""Whether the page and its server grow: `python -m tests.benchmarks.pick_memory [ACTIONS]`.

Chromium moves one click of a traced line to and fro, 500 times by default, with undo and redo
between. After every hundredth action it says how much memory the page's heap (after collecting
garbage) and the server take, how long an action takes from the key to the answer, and how large the
saved file is: the file grows, since its history has no end. Needs Chromium, Linux and the test
requirements.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tests.pick.browser import Driven, browsing
from tests.pick.served import FACADE, served

_KEYS = ("Shift+ArrowRight", "Shift+ArrowLeft", "Control+z", "Control+Shift+z")
_MEBIBYTE = 2**20


@dataclass(frozen=True)
class Taken:
    """What is taken after so many actions.

    Attributes:
        actions: How many.
        heap_mib: The page's heap.
        server_mib: The server's resident memory.
        action_ms: From a key to the answer drawn, the mean of the last actions; 50 ms are waiting.
        file_kib: The saved file.
    """

    actions: int
    heap_mib: float
    server_mib: float
    action_ms: float
    file_kib: float


def measure(actions: int, step: int = 100) -> list[Taken]:
    """Act, and look after every `step` actions."""
    found: list[Taken] = []
    with tempfile.TemporaryDirectory() as folder:
        photo = Path(folder) / "facade.jpg"
        shutil.copy(FACADE, photo)
        picks = FACADE.with_name("picks.csv")
        with browsing() as browser, served(photo, picks) as server:
            driven = Driven(browser, server)
            driven.page.wait_for_selector("#stage[data-ready=yes]")
            driven.press("n", "s")  # the first line's edge is traced
            driven.click(server.state()["lines"][0]["clicks"][0])
            driven.press("Escape")
            status = Path(f"/proc/{server.process.pid}/status")
            for done in range(step, actions + 1, step):
                start = time.perf_counter()
                for index in range(step):
                    driven.press(_KEYS[index % len(_KEYS)])
                took = (time.perf_counter() - start) / step
                resident = next(
                    int(line.split()[1])
                    for line in status.read_text().splitlines()
                    if line.startswith("VmRSS")
                )
                found.append(
                    Taken(
                        done,
                        driven.heap_bytes() / _MEBIBYTE,
                        resident / 1024,
                        took * 1e3,
                        photo.with_suffix(".plumbline.json").stat().st_size / 1024,
                    )
                )
    return found


def main(actions: int) -> None:
    """Print the table."""
    print("actions   heap MiB   server MiB   ms an action   file KiB")
    for row in measure(actions):
        print(
            f"{row.actions:>7} {row.heap_mib:>10.1f} {row.server_mib:>12.0f} "
            f"{row.action_ms:>14.0f} {row.file_kib:>10.0f}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
