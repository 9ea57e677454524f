"""Access control: checks every request before a page or a web socket gets it."""

from __future__ import annotations

from http.cookies import SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from remodel_console.core.access import Door, Role, is_same_origin

TOKEN_COOKIE = "remodel_token"
_ROLE = "role"
_REFUSED = 4403  # close code of a web socket, in the range for applications
_LONGEST_FORM = 1024  # bytes

_FIRST = "This console is reachable from the network and requires its token."
_WRONG = "Wrong token. The terminal in which the console was started shows the token."
_ASK = """<!doctype html><html lang="en"><meta charset="utf-8"><title>REMODEL console</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
 body {{ font: 16px system-ui, sans-serif; display: grid; place-items: center; margin: 0;
   min-height: 100vh; background: #f5f6f8; color: #1c2733 }}
 form {{ background: #fff; padding: 32px; border-radius: 12px; width: 320px }}
 h1 {{ font-size: 20px; margin: 0 0 8px }} p {{ color: #5b6875; margin: 0 0 20px }}
 input, button {{ font: inherit; width: 100%; box-sizing: border-box; padding: 10px;
   border-radius: 8px; border: 1px solid #b8c1cb; margin-bottom: 12px }}
 button {{ border: 0; background: #0f5ea8; color: #fff }} p.wrong {{ color: #b3261e }}
</style>
<form method="post" action="/enter"><h1>REMODEL console</h1>
<p class="{style}">{words}</p>
<input name="token" type="password" placeholder="Token" aria-label="Token" autofocus required>
<button>Enter</button></form></html>"""


class Guard:
    """ASGI middleware: the Host, the Origin of web sockets and forms, and the token."""

    def __init__(self, app: ASGIApp, door: Door) -> None:
        """Stand before an app."""
        self._app = app
        self._door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or answer it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = await self._refusal(scope, receive)
        if refusal is None:
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await refusal(scope, receive, send)
        else:
            await receive()
            await send({"type": "websocket.close", "code": _REFUSED, "reason": "not allowed"})

    async def _refusal(self, scope: Scope, receive: Receive) -> Response | None:
        """Return the answer to what is not let through; mark what is with its role."""
        headers = Headers(scope=scope)
        if not self._door.knows_host(headers.get("host", "")):
            return Response("This console answers to 127.0.0.1 and localhost only.", 421)
        is_safe = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        if (not is_safe or scope["path"].startswith("/_nicegui_ws")) and not is_same_origin(
            headers
        ):
            return Response("Pages of other sites may not access this console.", 403)
        if scope["type"] == "http" and scope["path"] == "/enter":
            return await self._enter(scope, receive)
        role = self._door.role_of(_token_of(headers))
        if role is None:
            return _ask(_FIRST, "")
        scope.setdefault("state", {})[_ROLE] = role
        return None

    async def _enter(self, scope: Scope, receive: Receive) -> Response:
        """Answer the form, or an address that holds the token."""
        text = scope["query_string"] if scope["method"] == "GET" else await _body(receive)
        given = parse_qs(text.decode(errors="replace")).get("token", [""])[0].strip()
        if self._door.role_of(given) is None:
            return _ask(_WRONG, "wrong")
        answer = RedirectResponse("/", 303)
        answer.set_cookie(TOKEN_COOKIE, given, httponly=True, samesite="strict")
        return answer


def role_of(scope: Scope) -> Role:
    """Return the role of a request that was let through."""
    role: Role = scope["state"][_ROLE]
    return role


def _ask(words: str, style: str) -> Response:
    return HTMLResponse(_ASK.format(words=words, style=style), 401)


def _token_of(headers: Headers) -> str:
    cookies: SimpleCookie = SimpleCookie()
    cookies.load(headers.get("cookie", ""))
    return cookies[TOKEN_COOKIE].value if TOKEN_COOKIE in cookies else ""


async def _body(receive: Receive) -> bytes:
    """Return the body of a request, cut where no honest form is so long."""
    body, more = b"", True
    while more and len(body) <= _LONGEST_FORM:
        message = await receive()
        body += message.get("body", b"")
        more = message.get("more_body", False)
    return body[:_LONGEST_FORM]
