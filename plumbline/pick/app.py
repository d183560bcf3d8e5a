"""The web server's routes: the page's own files, tiles, actions, events."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any, TypeVar

import msgspec
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route
from starlette.types import Receive, Scope, Send

from plumbline.errors import OptionError, PlumblineError
from plumbline.pick import requests
from plumbline.pick.finishing import compared, finished
from plumbline.pick.security import TooMuchError
from plumbline.pick.session import Session
from plumbline.pick.tiles import tile
from plumbline.pick.words import on_page

_KINDS = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
_MOST_NAME = 40
"""Characters of a page's name: its own have 16."""

_T = TypeVar("_T", bound=msgspec.Struct)


def app_of(session: Session) -> Starlette:
    """The app of one session; it must stand behind `plumbline.pick.security.Guard`."""
    assets = _assets()

    async def asset(request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        if name not in assets:
            return _told({"error": "there is no such file"}, 404)
        content, kind = assets[name]
        return Response(content, media_type=kind)

    async def state(_: Request) -> Response:
        return _told(await run_in_threadpool(session.opening))

    async def act(request: Request) -> Response:
        asked = await _body(request, requests.Act)
        return _told(await run_in_threadpool(session.act, asked.page, asked.action))

    async def take(request: Request) -> Response:
        asked = await _body(request, requests.Page)
        await run_in_threadpool(session.holder.take, asked.page)
        return _told({})

    async def compare(request: Request) -> Response:
        await _body(request, requests.Page)
        return _told(await run_in_threadpool(compared, session))

    async def finish(request: Request) -> Response:
        await _body(request, requests.Page)
        return _told(await run_in_threadpool(finished, session))

    def tile_of(request: Request) -> Response:
        where: Mapping[str, Any] = request.path_params
        index = where["photo"]
        if index >= len(session.photos):
            raise OptionError("there is no such photo")
        corrected = request.query_params.get("corrected") is not None
        lens = session.lens if corrected else None
        content = tile(session.photos[index], where["level"], where["column"], where["row"], lens)
        kept = {"cache-control": "private, max-age=3600, immutable"}
        return Response(content, media_type="image/jpeg", headers=kept)

    app = Starlette(
        routes=[
            Route("/state", state),
            Route("/act", act, methods=["POST"]),
            Route("/take", take, methods=["POST"]),
            Route("/compare", compare, methods=["POST"]),
            Route("/finish", finish, methods=["POST"]),
            Route("/events/{page}", _Events(session)),
            Route("/tiles/{photo:int}/{level:int}/{column:int}/{row:int}", tile_of),
            Route("/", asset),
            Route("/{name}", asset),
        ],
        exception_handlers={PlumblineError: _refused, TooMuchError: _too_much},
    )
    app.router.redirect_slashes = False  # a redirect would name paths without the secret
    return app


class _Events:
    """The stream of events, as an app of its own: it must notice that a page goes away."""

    def __init__(self, session: Session) -> None:
        self._hub = session.hub

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        page = str(scope["path_params"]["page"])[:_MOST_NAME]
        await self._hub.stream(page, receive, send)


def _assets() -> dict[str, tuple[bytes, str]]:
    """The page's own files by name: no other file can be asked for."""
    found: dict[str, tuple[bytes, str]] = {}
    for file in files("plumbline.pick.page").iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix in _KINDS:
            found[file.name] = (file.read_bytes(), _KINDS[suffix])
    return found


async def _body(request: Request, kind: type[_T]) -> _T:
    """A request's body, checked.

    Raises:
        OptionError: it is not what the page sends.
    """
    content = await request.body()
    try:
        return msgspec.json.decode(content, type=kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise OptionError(f"the request is not understood: {error}") from None


def _told(payload: Any, status: int = 200) -> Response:
    return Response(msgspec.json.encode(payload), status, media_type="application/json")


async def _refused(_: Request, error: Exception) -> Response:
    if not isinstance(error, PlumblineError):
        raise error
    return _told({"error": on_page(error.message), "hint": on_page(error.hint)}, 400)


async def _too_much(_: Request, __: Exception) -> Response:
    return _told({"error": "the request is too large"}, 413)
