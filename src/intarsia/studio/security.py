"""Security layer around all routes: host, origin, token and cookie checks, and limits on what is received."""

from __future__ import annotations

import asyncio
import hmac
import os
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.exceptions import HTTPException
from starlette.requests import cookie_parser
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse

from .requests import LIMITS

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Any, Receive, Send], Awaitable[None]]

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}
ENTERED = """<!doctype html><title>intarsia</title><link rel="icon" href="data:,">
<meta http-equiv="refresh" content="0;url=/">
"""
READS = ("GET", "HEAD")
TOO_LARGE = "this is too large."
SLOWEST = 20.0  # s between two parts of a body
LARGE = {"/api/exemplars": LIMITS["upload"], "/api/images": LIMITS["image"]}


class Safety:
    """Refuses requests that come neither from the studio's own page nor from a program with the token."""

    def __init__(self, app: App, token: str | None = None) -> None:
        self.app, self.token = app, token or os.urandom(16).hex()
        self.host, self.port = "127.0.0.1", 0
        self._cookie = os.urandom(16).hex()  # not the token: a browser sends it to other ports of the same host
        self._entrances: dict[str, Callable[[], object]] = {}

    @property
    def cookie(self) -> str:
        """The name of the cookie, with the port, as cookies are shared by all ports."""
        return f"intarsia-{self.port}"

    def entrance(self, used: Callable[[], object]) -> str:
        """Return an address that lets one browser in, once; `used` is called then."""
        code = os.urandom(16).hex()
        self._entrances[code] = used
        return f"http://{self.host}:{self.port}/?enter={code}"

    async def __call__(self, scope: Any, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self.app(scope, receive, send)
            return

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        refusal = self._refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, sent)
            return
        await self.app(scope, self._limited(scope, receive), sent)

    def _refusal(self, scope: Any) -> Any:
        """Return the answer to a request that is refused; None if it is let in."""
        headers = Headers(scope=scope)
        if "content-length" in headers and "transfer-encoding" in headers:
            return error(400, "this tells its length in two ways; send Content-Length or Transfer-Encoding.")
        own = {f"{host}:{self.port}" for host in (self.host, "127.0.0.1", "localhost")}
        if headers.get("host") not in own:
            return error(403, "this host is not served here.")
        origin, site = headers.get("origin"), headers.get("sec-fetch-site")
        if origin is not None and origin not in {f"http://{host}" for host in own}:
            return error(403, "requests from other pages are not served.")
        entering = scope["path"] == "/" and headers.get("sec-fetch-mode") == "navigate"  # by a link on any page
        if site not in (None, "same-origin") and (scope["method"] not in READS or not (site == "none" or entering)):
            return error(403, "requests from other pages are not served.")
        query = QueryParams(scope["query_string"])
        if scope["path"] == "/" and scope["method"] == "GET" and "enter" in query:
            return self._entered(query["enter"], headers)
        if not self._known(headers):
            return _not_known(scope["path"])
        if scope["method"] not in READS and headers.get("x-intarsia") != "1":
            return error(403, "a request that changes something carries the header X-Intarsia: 1.")
        return None

    def _known(self, headers: Headers) -> bool:
        """Return whether a request has the token as `Authorization: Bearer`, or comes from the page with its cookie."""
        if (bearer := headers.get("authorization", "")).startswith("Bearer "):
            return hmac.compare_digest(bearer[7:].encode(), self.token.encode())
        given = cookie_parser(headers.get("cookie", "")).get(self.cookie, "")
        own = headers.get("sec-fetch-site") in ("same-origin", "none")  # set by browsers; no page can forge it
        return own and hmac.compare_digest(given.encode(), self._cookie.encode())

    def _entered(self, code: str, headers: Headers) -> Any:
        """Let a browser in whose code is good, or that is in already.

        It loads the page by itself: if it was sent here by a file, the browser would not send the cookie with a
        redirect.
        """
        used = self._entrances.pop(code, None)
        if used is None and not self._known(headers):
            return _not_known("/")
        if used is not None:
            used()
        answer = HTMLResponse(ENTERED)
        answer.set_cookie(self.cookie, self._cookie, httponly=True, samesite="strict", path="/")
        return answer

    def _limited(self, scope: Any, receive: Receive) -> Receive:
        """Return `receive` with limits on size and time."""
        most, got = LARGE.get(scope["path"], LIMITS["json"]), 0
        length = Headers(scope=scope).get("content-length", "")
        announced, whole = int(length) if length.isdigit() else 0, False

        async def limited() -> Message:
            nonlocal got, whole
            if announced > most:
                raise HTTPException(413, TOO_LARGE)
            if whole:  # after a body only a disconnect follows
                return await receive()
            try:
                message = await asyncio.wait_for(receive(), SLOWEST)
            except TimeoutError:
                raise HTTPException(408, "the rest of this did not come.") from None
            whole = not message.get("more_body", False)
            got += len(message.get("body", b""))
            if got > most:
                raise HTTPException(413, TOO_LARGE)
            return message

        return limited


def _not_known(path: str) -> Any:
    line = "open the address that intarsia studio printed last: each of them lets one browser in, once."
    return error(401, line) if path.startswith("/api/") else PlainTextResponse(f"intarsia: {line}\n", 401)


def error(status: int, line: str) -> JSONResponse:
    return JSONResponse({"error": line}, status)
