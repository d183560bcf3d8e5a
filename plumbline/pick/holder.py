"""Which of several open pages may pick: the one that asked last, else any that is left."""

from __future__ import annotations

import threading

from plumbline.errors import OptionError
from plumbline.pick.events import Hub


class Holder:
    """Lets one page pick, and tells all which.

    Args:
        hub: Tells the pages.
    """

    def __init__(self, hub: Hub) -> None:
        self.page = ""
        self._hub = hub
        self._open: set[str] = set()
        self._lock = threading.Lock()
        hub.on_open, hub.on_close = self._opened, self._closed

    def take(self, page: str) -> None:
        """Let this page pick, and no other."""
        self.page = page
        self._hub.publish("holder", page)

    def refuse_reader(self, page: str) -> None:
        """Refuse a page that only reads.

        Raises:
            OptionError: another page picks.
        """
        if not self.page:
            self.take(page)
        if self.page != page:
            raise OptionError(
                "these picks are open on another page", hint="take over here, or go on there"
            )

    def _opened(self, page: str) -> None:
        with self._lock:
            self._open.add(page)
            free = self.page not in self._open
        self.take(page if free else self.page)

    def _closed(self, page: str) -> None:
        with self._lock:
            self._open.discard(page)
            left = next(iter(self._open), "")
        if self.page == page and left:
            self.take(left)
