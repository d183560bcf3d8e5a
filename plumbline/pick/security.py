"""Nobody but the page that plumbline opened reads or changes anything.

Every address begins with a secret, which other programs and pages cannot guess. The `Host` header
must name this server, so that no foreign name that resolves to this machine gets in (DNS
rebinding), and `Origin` must be the page's own where a browser sends it, and on every request
that changes something. Bodies are JSON, which no foreign form can send, and small.
"""

from __future__ import annotations

import hmac

from starlette.types import ASGIApp, Message, Receive, Scope, Send

MOST_BODY = 2**17
"""Bytes of a request: a thousand clicks take 40,000."""

_HEADERS = (
    (
        b"content-security-policy",
        b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        b"connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
        b"require-trusted-types-for 'script'",
    ),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


class Guard:
    """Lets requests through to an app that know the secret and come from its own page.

    Args:
        app: The app; it sees paths without the secret.
        secret: What every path begins with.
        port: The port that is listened on.
    """

    def __init__(self, app: ASGIApp, secret: str, port: int) -> None:
        self._app = app
        self._secret = secret.encode()
        self._hosts = {f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")}
        self._origins = {b"http://" + host for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, or refuse it without a word of what is here."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self._app(scope, receive, send)
            return
        secret, _, rest = scope["path"].removeprefix("/").partition("/")
        known = hmac.compare_digest(secret.encode(), self._secret)
        if not (known and scope["path"].startswith("/") and self._own(scope)):
            await _refuse(send, 404 if not known else 403)
            return
        inner = dict(scope) | {"path": f"/{rest}", "raw_path": f"/{rest}".encode()}
        await self._app(inner, _limited(receive), _with_headers(send))

    def _own(self, scope: Scope) -> bool:
        headers = dict(scope["headers"])
        if headers.get(b"host") not in self._hosts:
            return False
        if headers.get(b"sec-fetch-site", b"none") not in (b"none", b"same-origin"):
            return False
        origin = headers.get(b"origin")
        if origin is not None and origin not in self._origins:
            return False
        if scope["method"] in ("GET", "HEAD"):
            return True
        kind = headers.get(b"content-type", b"").partition(b";")[0].strip()
        return scope["method"] == "POST" and origin is not None and kind == b"application/json"


class TooMuchError(Exception):
    """A request's body is larger than `MOST_BODY`."""


def _limited(receive: Receive) -> Receive:
    taken = 0

    async def limited() -> Message:
        nonlocal taken
        message = await receive()
        taken += len(message.get("body", b""))
        if taken > MOST_BODY:
            raise TooMuchError
        return message

    return limited


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = list(message.get("headers", ()))
            given = {name.lower() for name, _ in headers}
            if b"cache-control" not in given:
                headers.append((b"cache-control", b"no-store"))
            message = {**message, "headers": [*headers, *_HEADERS]}
        await send(message)

    return sending


async def _refuse(send: Send, status: int) -> None:
    headers = [(b"content-type", b"text/plain; charset=utf-8"), *_HEADERS]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": b"Not found.\n"})
