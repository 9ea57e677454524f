"""Access control: checks every request before a page or a web socket gets it."""

from __future__ import annotations

import asyncio
import html
from collections.abc import Callable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from remodel_console.core.commands import (
    DONE,
    REFUSED,
    Actor,
    CommandResult,
    Door,
    Role,
    User,
    is_same_origin,
    tidy_name,
)
from remodel_console.edge.users_file import UsersFile

USER_COOKIE = "remodel_user"
ENTER, LEAVE = "/enter", "/leave"
_USER = "user"
_REFUSED = 4403  # close code of a web socket, in the range for applications
_LONGEST_FORM = 1024  # bytes
_YEAR_S = 365 * 24 * 3600

_FIRST = "Sign in to use this console."
_WRONG = "Wrong name or password. After a wrong password, wait a moment before you try again."
_ASK = """<!doctype html><html lang="en"><meta charset="utf-8"><title>REMODEL console</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
 :root {{ color-scheme: light dark }}
 body {{ font: 16px system-ui, sans-serif; display: grid; place-items: center; margin: 0;
   min-height: 100vh; background: light-dark(#f3f5f7, #12171d); color: light-dark(#1c2733, #e4eaf0) }}
 main {{ background: light-dark(#fff, #1a2129); padding: 32px; border-radius: 12px; width: 320px;
   max-width: calc(100vw - 32px); box-sizing: border-box }}
 h1 {{ font-size: 20px; margin: 0 0 8px }} p {{ color: light-dark(#5b6875, #9aa8b6); margin: 0 0 20px }}
 label {{ display: block; margin-bottom: 12px }}
 input, button {{ font: inherit; width: 100%; box-sizing: border-box; padding: 10px;
   border-radius: 8px; border: 1px solid #8d99a5; background: light-dark(#fff, #12171d); color: inherit }}
 button {{ border: 0; background: light-dark(#0f5ea8, #6db3f2); color: light-dark(#fff, #0b1a28) }}
 p.wrong {{ color: light-dark(#b3261e, #f2a19b) }}
</style><main><h1>REMODEL console</h1><p class="{style}" role="status">{words}</p>{form}</main></html>"""  # noqa: E501
_FORM = """<form method="post" action="/enter">
<label>Name <input name="name" autocomplete="username" autofocus required></label>
<label>Password <input name="password" type="password" autocomplete="current-password" required></label>
<button>Sign in</button></form>"""  # noqa: E501


class Guard:
    """ASGI middleware: the Host, the Origin of web sockets and forms, and the user."""

    def __init__(
        self,
        app: ASGIApp,
        door: Door,
        users: UsersFile | None = None,
        record: Callable[[Actor, CommandResult], None] = lambda actor, answer: None,
    ) -> None:
        """Stand before an app; `record` gets who signs in, and who fails to."""
        self._app = app
        self._door = door
        self._users = users
        self._record = record

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
        """Return the answer to what is not let through; mark what is with its user."""
        headers = Headers(scope=scope)
        if not self._door.knows_host(headers.get("host", "")):
            return Response(
                "This console answers to 127.0.0.1 and localhost only, and to what its option "
                "--public-host names.",
                421,
            )
        is_safe = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        if (not is_safe or scope["path"].startswith("/_nicegui_ws")) and not is_same_origin(
            headers
        ):
            return Response("Pages of other sites may not access this console.", 403)
        if scope["type"] == "http" and self._signs_in and scope["path"] in (ENTER, LEAVE):
            return await self._enter_or_leave(scope, receive)
        user = self._user(scope, headers)
        if user is None:
            return self._unknown(headers)
        scope.setdefault("state", {})[_USER] = user
        return None

    @property
    def _signs_in(self) -> bool:
        """Return whether users sign in here, and are not named by a proxy."""
        return self._users is not None and not self._door.user_header

    def _user(self, scope: Scope, headers: Headers) -> User | None:
        """Return the user of a request; None if there is none."""
        if self._users is None:
            return User()
        if not self._door.user_header:
            return self._users.user(_cookie_of(headers))
        address = (scope.get("client") or ("",))[0]
        named = headers.getlist(self._door.user_header)
        if address not in self._door.proxies or len(named) != 1:
            return None
        account = self._users.account(named[0])
        return User(named[0], account.role) if account else None

    def _unknown(self, headers: Headers) -> Response:
        """Return the answer to a request whose user is not known."""
        header = self._door.user_header
        if not header:
            return _ask(_FIRST)
        name = tidy_name(headers.get(header, ""))
        words = (
            f"The user '{name}' has no role here. Where the console runs, one is given by: "
            f"rosrun remodel_console users add '{name}' --role watcher --without-password"
            if name
            else "This console is reached through its proxy only, which names the user."
        )
        return HTMLResponse(_ASK.format(words=html.escape(words), style="wrong", form=""), 403)

    async def _enter_or_leave(self, scope: Scope, receive: Receive) -> Response:
        """Sign a user in or out."""
        answer = RedirectResponse("/", 303)
        if scope["path"] == LEAVE:
            answer.delete_cookie(USER_COOKIE, httponly=True, samesite="strict")
            return answer
        if scope["method"] != "POST" or self._users is None:
            return answer
        given = parse_qs((await _body(receive)).decode(errors="replace"))
        name, password = given.get("name", [""])[0].strip(), given.get("password", [""])[0]
        cookie = await asyncio.to_thread(self._users.sign_in, name, password)
        account = self._users.account(name)
        actor = Actor(
            tidy_name(name),
            (scope.get("client") or ("?",))[0],
            account.role if account and cookie else Role.WATCHER,
        )
        words = "" if cookie else "wrong name or password"
        self._record(actor, CommandResult(DONE if cookie else REFUSED, "sign in", words))
        if not cookie:
            return _ask(_WRONG, "wrong")
        is_secure = scope.get("scheme") == "https"
        answer.set_cookie(
            USER_COOKIE, cookie, max_age=_YEAR_S, httponly=True, samesite="strict", secure=is_secure
        )
        return answer


def user_of(scope: Scope) -> User:
    """Return the user of a request that was let through."""
    user: User = scope["state"][_USER]
    return user


def _ask(words: str, style: str = "") -> Response:
    return HTMLResponse(_ASK.format(words=words, style=style, form=_FORM), 401)


def _cookie_of(headers: Headers) -> str:
    cookies: SimpleCookie = SimpleCookie()
    try:
        cookies.load(headers.get("cookie", ""))
    except CookieError:
        return ""
    return cookies[USER_COOKIE].value if USER_COOKIE in cookies else ""


async def _body(receive: Receive) -> bytes:
    """Return the body of a request, cut where no honest form is so long."""
    body, more = b"", True
    while more and len(body) <= _LONGEST_FORM:
        message = await receive()
        body += message.get("body", b"")
        more = message.get("more_body", False)
    return body[:_LONGEST_FORM]
