"""One run of `plumbline pick`: the document, its photos, and everything the page may do to them."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import msgspec

from plumbline.errors import PlumblineError, printable
from plumbline.geometry.lens import Lens
from plumbline.models import MODELS
from plumbline.pick import requests
from plumbline.pick.document import Document
from plumbline.pick.editing import Edited, Editor, Tracer
from plumbline.pick.events import Hub
from plumbline.pick.finding import Finder
from plumbline.pick.holder import Holder
from plumbline.pick.judging import Judge
from plumbline.pick.live import Fitted, fit_now, guide, warm_up
from plumbline.pick.mending import mended
from plumbline.pick.photos import LoadedPhoto
from plumbline.pick.saving import Keeper
from plumbline.pick.telling import told

_LONGEST_S = 15.0
"""Seconds that work in hand gets when the session ends: chosen, compiling takes five."""
_WATCH_S = 2.0
"""Seconds between looks at the photos on disk, and between tries to save what is not saved."""


_TOLD_FACTS = ("maker", "model", "mount", "focal_mm", "crop_factor")
"""What LensFun calls a lens by (`plumbline.pick.requests.Describe`)."""


class Session:
    """What one server holds.

    Args:
        document: What was picked before.
        photos: The photos, in the order of the document's.
        keeper: Saves the document.
        tracer: Traces edges; None where picks are free only.
        notes: What to tell the user at the beginning.
    """

    def __init__(
        self,
        document: Document,
        photos: Sequence[LoadedPhoto],
        keeper: Keeper,
        tracer: Tracer | None,
        notes: Sequence[str] = (),
    ) -> None:
        self.hub = Hub()
        self.holder = Holder(self.hub)
        self.photos = tuple(photos)
        self.keeper = keeper
        self.document = document
        self.fitted = Fitted(None, "the picks are being fitted")
        self._notes = tuple(notes)
        self._editor = Editor(tracer)
        self._revision = 0
        self._unsaved = ""
        self._warm = False
        self._trouble = ""
        self._judgement: dict[str, Any] = {}
        self._lock = threading.RLock()
        self._saver = ThreadPoolExecutor(1, "save")
        self._finder = Finder()
        self._found_lens: Lens | None = None
        self._guide: Future[Lens | None] | None = None
        # An action waits for the guide, and mending for the action: never in one queue.
        self._guesser = ThreadPoolExecutor(1, "guide")
        self._mender = ThreadPoolExecutor(1, "mend")
        self._judge = Judge(self._judged)
        self._stopped = threading.Event()
        self._at_work: list[threading.Thread] = []

    def begin(self) -> None:
        """Load photos, make programs ready and fit, all in the background."""
        for work in (self._load, self._ready, self._watch):
            self._at_work.append(threading.Thread(target=work, daemon=True))
            self._at_work[-1].start()

    def end(self) -> None:
        """Save what is not saved, and stop."""
        self._stopped.set()
        self._judge.stop()
        self._finder.stop()
        with self._lock:
            if self._unsaved:
                self._save(self.document)
        self._saver.shutdown(wait=True)
        self._guesser.shutdown(wait=False)
        self._mender.shutdown(wait=False, cancel_futures=True)
        self.keeper.close()
        for thread in self._at_work:  # Python must not end while one is inside a C library
            thread.join(_LONGEST_S)

    @property
    def lens(self) -> Lens | None:
        """The lens as far as it is known."""
        return None if self.fitted.calibration is None else self.fitted.calibration.lens

    def act(self, page: str, request: requests.Request) -> dict[str, Any]:
        """Do what the page asks for, save it, and fit.

        Raises:
            OptionError: another page picks, or the request names what is not there.
        """
        with self._lock:
            self.holder.refuse_reader(page)
            edited = self._edited(request)
            saving: Future[None] | None = None
            if edited.document is not self.document:
                saving = self._take(edited.document)
                if not isinstance(request, requests.Undo | requests.Redo):
                    self._mender.submit(self._mend, self._revision)
            if saving is not None:
                saving.result()
            return self.state() | {
                "selected": edited.line,
                "refusal": printable(edited.refusal),
                "doubt": printable(edited.doubt),
            }

    def state(self) -> dict[str, Any]:
        """The document and its fit, for the page."""
        with self._lock:
            document = self.document
            return {
                "revision": self._revision,
                "lines": document.lines,
                "settings": document.settings,
                "undo": document.done[-1].name if document.done else "",
                "redo": document.undone[-1].name if document.undone else "",
                "fit": told(self.fitted, document),
                "unsaved": printable(self._unsaved),
                "proposals": self._editor.proposed(document),
                "facts": {name: getattr(document.facts, name) for name in _TOLD_FACTS},
            }

    def opening(self) -> dict[str, Any]:
        """All that a page needs when it opens."""
        with self._lock:
            return self.state() | {
                "photos": [
                    {
                        "name": printable(photo.path.name),
                        "width": photo.size[0],
                        "height": photo.size[1],
                        "levels": photo.n_levels,
                    }
                    for photo in self.photos
                ],
                "file": printable(self.keeper.path.name),
                "snapping": self._editor.tracer is not None,
                "models": [
                    {"name": model.name, "coefficients": model.coefficients}
                    for model in MODELS.values()
                    if model.unit != "focal length"
                ],
                "judgement": self._judgement,
                "notes": [printable(note) for note in self._notes],
                "holder": self.holder.page,
                "ready": self._warm,
                "trouble": printable(self._trouble),
            }

    def _edited(self, request: requests.Request) -> Edited:
        lens = None if self._guide is None else self._guide.result()
        return self._editor.edited(self.document, request, lens)

    def _take(self, document: Document) -> Future[None]:
        """Make a document the one that is shown, fitted and saved."""
        self.document = document
        self._revision += 1
        saving = self._saver.submit(self._save, document)
        self._fit()
        return saving

    def _fit(self) -> None:
        self.fitted = fit_now(self.document)
        self._guide = self._guesser.submit(guide, self.document, self.fitted, self._found_lens)
        self._judge.ask(self._revision, self.document)

    def _mend(self, revision: int) -> None:
        """Trace an odd line again, unless something else was done meanwhile."""
        with self._lock:
            document, fitted = self.document, self.fitted
        change = mended(document, fitted, self._editor.tracer)
        with self._lock:
            if change is None or revision != self._revision:
                return
            self._take(document.amended(change)).result()
            state = self.state()
        self.hub.publish("state", state)

    def _save(self, document: Document) -> None:
        try:
            self.keeper.write(document)
            self._unsaved = ""
        except PlumblineError as error:
            self._unsaved = f"not saved: {error.message}" + (
                f"; {error.hint}" if error.hint else ""
            )

    def _load(self) -> None:
        """Decode all photos, then look for edges in them."""
        for number, photo in enumerate(self.photos):
            photo.picked_sha256 = self.document.photos[number].sha256
            photo.load()
        self._know()
        self._look_at_photos()
        if self._editor.tracer is None:
            return
        for number, photo in enumerate(self.photos):
            if photo.failure is None:
                self._propose(number, photo)

    def _know(self) -> None:
        """Keep which bytes are picked in, from the first time on."""
        with self._lock:
            records = tuple(
                record if record.sha256 else msgspec.structs.replace(record, sha256=photo.sha256)
                for record, photo in zip(self.document.photos, self.photos, strict=True)
            )
            if records != self.document.photos:
                self.document = msgspec.structs.replace(self.document, photos=records)
                self._saver.submit(self._save, self.document)

    def _propose(self, number: int, photo: LoadedPhoto) -> None:
        first = len(self._editor.proposals)
        found = self._finder.find(photo.path, photo.size, number, first)
        if found is None:
            return
        with self._lock:
            proposals = (*self._editor.proposals, *found.proposals)
            self._editor = Editor(self._editor.tracer, proposals)
            if number == 0:
                self._found_lens = found.lens
                self._guide = self._guesser.submit(
                    guide, self.document, self.fitted, self._found_lens
                )
            state = self.state()
        self.hub.publish("state", state)

    def _ready(self) -> None:
        with self._lock:
            self._fit()
            state = self.state()
        self.hub.publish("state", state)
        warm_up(self.document.settings, self.photos[0].size)
        self._warm = True
        self.hub.publish("ready", True)

    def _judged(self, revision: int, judgement: dict[str, Any]) -> None:
        found = judgement | {"revision": revision}
        with self._lock:
            if revision != self._revision:
                return
            self._judgement = found
        self.hub.publish("judgement", found)

    def _watch(self) -> None:
        """Look after the disk: photos that change, picks that could not be saved."""
        while not self._stopped.wait(_WATCH_S):
            self._look_at_photos()
            if self._unsaved:
                with self._lock:
                    self._saver.submit(self._save, self.document).result()
                    unsaved = self._unsaved
                self.hub.publish("unsaved", printable(unsaved))

    def _look_at_photos(self) -> None:
        """Tell the pages what is wrong with the photos."""
        trouble = "; ".join(filter(None, (photo.trouble for photo in self.photos)))
        if trouble != self._trouble:
            self._trouble = trouble
            self.hub.publish("trouble", printable(trouble))
