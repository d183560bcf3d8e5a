"""Who corrects the photographs of a batch: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Generator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import connection, get_context, parent_process
from typing import Any

from plumbline.errors import OptionError


def processes(jobs: int) -> Executor:
    """A pool of processes that end when this one does, even if it is killed.

    Ctrl-C, which a terminal sends to all of them, is this one's alone to answer.
    """
    return _Pool(jobs, mp_context=get_context("spawn"), initializer=_end_with_parent)


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


class _Pool(ProcessPoolExecutor):
    """A pool whose processes, which start as work comes in, are not to be interrupted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with _interrupts_held():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def _interrupts_held() -> Generator[None]:
    """Hold Ctrl-C back for a moment; processes that are started meanwhile never see it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    """Let this worker end when its parent has: a pool's workers wait for work for ever."""
    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
