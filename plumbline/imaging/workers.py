"""Who corrects the photographs of a batch: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import os
import threading
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import connection, get_context, parent_process
from typing import Any

from plumbline.errors import OptionError


def processes(jobs: int) -> Executor:
    """A pool of processes that end when this one does, even if it is killed."""
    context = get_context("spawn")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_end_with_parent)


def dask_client(address: str) -> Any:
    """A client of the Dask scheduler at an address such as tcp://host:8786.

    Raises:
        OptionError: Dask is not installed, or nothing answers there.
    """
    try:
        from distributed import Client
    except ImportError:
        raise OptionError(
            "--scheduler needs Dask", hint="install it: pip install 'plumbline-lens[dask]'"
        ) from None
    try:
        return Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise OptionError(
            f"the scheduler {address} does not answer: {error}",
            hint="give the address that `dask scheduler` prints, as tcp://host:8786",
        ) from None


def _end_with_parent() -> None:
    """Let this worker end when its parent has: a pool's workers wait for work for ever."""
    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
