"""What the server tells pages unasked: a stream of events to each open page."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

import msgspec
from starlette.types import Receive, Send

_MOST_WAITING = 200
"""Events that wait for a page; one that takes none of so many is gone."""

_HEARTBEAT_S = 10.0
"""Seconds between signs of life, so that a broken connection is noticed by either side."""


class Hub:
    """Passes events on to all open pages; threads may publish.

    Attributes:
        on_open: Called with the page's name when a page opens its stream.
        on_close: Called with it when the stream ends.
    """

    def __init__(self) -> None:
        self.on_open: Callable[[str], None] = lambda _: None
        self.on_close: Callable[[str], None] = lambda _: None
        self._queues: dict[asyncio.Queue[bytes], asyncio.AbstractEventLoop] = {}

    def publish(self, name: str, payload: Any) -> None:
        """Tell all pages."""
        event = b"event: %s\ndata: %s\n\n" % (name.encode(), msgspec.json.encode(payload))
        for queue, loop in list(self._queues.items()):
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(self._put, queue, event)

    def _put(self, queue: asyncio.Queue[bytes], event: bytes) -> None:
        try:
            queue.put_nowait(event)
        except asyncio.QueueFull:
            self._queues.pop(queue, None)

    async def stream(self, page: str, receive: Receive, send: Send) -> None:
        """Send events to one page until it goes away.

        Args:
            page: The page's name.
            receive: Of ASGI.
            send: Of ASGI.
        """
        queue: asyncio.Queue[bytes] = asyncio.Queue(_MOST_WAITING)
        self._queues[queue] = asyncio.get_running_loop()
        headers = [(b"content-type", b"text/event-stream"), (b"cache-control", b"no-store")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        self.on_open(page)
        tasks = [asyncio.create_task(each) for each in (_pump(queue, send), _gone(receive))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._queues.pop(queue, None)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self.on_close(page)


async def _pump(queue: asyncio.Queue[bytes], send: Send) -> None:
    event = b": open\n\n"
    while True:
        await send({"type": "http.response.body", "body": event, "more_body": True})
        try:
            event = await asyncio.wait_for(queue.get(), _HEARTBEAT_S)
        except TimeoutError:
            event = b": alive\n\n"


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
