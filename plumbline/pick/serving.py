"""Serve a session on 127.0.0.1 until the user stops it."""

from __future__ import annotations

import asyncio
import os
import secrets
import signal
import socket
import sys
import webbrowser
from collections.abc import Callable

import uvicorn

from plumbline.errors import OptionError
from plumbline.pick.app import app_of
from plumbline.pick.security import Guard
from plumbline.pick.session import Session

HOST = "127.0.0.1"

_SECRET_BYTES = 24
"""192 bits: not guessed in the life of a server."""

_MOST_CONNECTIONS = 200
"""Connections at once. Chosen, because one browser opens six to a server, and pages are few."""

_LONGEST_S = 2
"""Seconds that open streams get when the server stops."""


def serve(
    session: Session,
    port: int,
    announce: Callable[[str, bool], None],
    *,
    browser: bool,
) -> None:
    """Serve until Ctrl-C.

    Args:
        session: What is served.
        port: The port; 0 for any that is free.
        announce: Called with the address, and whether a browser was opened.
        browser: Open the user's browser.

    Raises:
        OptionError: the port is in use or not permitted.
    """
    listening = _listening(port)
    port = listening.getsockname()[1]
    secret = secrets.token_urlsafe(_SECRET_BYTES)
    address = f"http://{HOST}:{port}/{secret}/"
    config = uvicorn.Config(
        Guard(app_of(session), secret, port),
        log_level="critical",
        access_log=False,
        limit_concurrency=_MOST_CONNECTIONS,
        timeout_graceful_shutdown=_LONGEST_S,
        server_header=False,
        http="h11",
        ws="none",
        lifespan="off",
    )
    server = _Server(config, lambda: announce(address, browser and opened(address)))
    # Uvicorn raises a signal again once it has stopped; SIGTERM would then end without a last save.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    session.begin()
    try:
        server.run(sockets=[listening])
    finally:
        session.end()


class _Server(uvicorn.Server):
    """A server that says when it listens."""

    def __init__(self, config: uvicorn.Config, started: Callable[[], None]) -> None:
        super().__init__(config)
        self._started = started

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to listen, and say so."""
        await super().startup(sockets)
        await asyncio.to_thread(self._started)


def opened(address: str) -> bool:
    """Open the user's browser on an address; whether there is one with a screen."""
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not shown and not os.environ.get("BROWSER"):
        return False
    try:
        return webbrowser.open(address)
    except webbrowser.Error:
        return False


def _listening(port: int) -> socket.socket:
    listening = socket.socket()
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
    except (OSError, OverflowError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or error
        raise OptionError(
            f"port {port} cannot be used: {reason}",
            hint="leave out --port for any that is free, or name another",
        ) from None
    return listening
