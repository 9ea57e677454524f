"""Who may do what: tokens and roles, and from where a page may talk to the console.

On this computer alone no token is needed, unless one is set. A console that others can reach always
has one. Requests are let in for a host name that the console answers to, so that no foreign page
can reach it by a name of its own that leads here (DNS rebinding); web sockets besides only from
pages of the console itself.
"""

from __future__ import annotations

import hmac
import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from urllib.parse import urlsplit

_LOCAL_NAMES = ("localhost",)
_LONGEST_NAME = 40  # letters of a person's name in the record


class Role(Enum):
    """What a client of the console may do."""

    OPERATOR = "operator"
    WATCHER = "watcher"


@dataclass(frozen=True)
class Actor:
    """Who gives a command, for the record."""

    name: str
    address: str
    role: Role


@dataclass(frozen=True)
class Door:
    """Who is let in.

    Attributes:
        host: address that the console is bound to.
        token: grants access to operators; empty: everybody on this computer is one.
        watch_token: grants read-only access; empty: there is none.
    """

    host: str
    token: str = ""
    watch_token: str = ""

    def __post_init__(self) -> None:
        """Refuse a door that stands open to a network."""
        if not is_local(self.host) and not self.token:
            raise ValueError(
                f"a console on {self.host} needs a token, because other computers can reach it"
            )
        if self.token and self.token == self.watch_token:
            raise ValueError("the tokens of operators and of observers must differ")

    def role_of(self, token: str) -> Role | None:
        """Return the role that a token gives; None if it opens nothing."""
        if self.watch_token and _is_same(token, self.watch_token):
            return Role.WATCHER
        if not self.token or _is_same(token, self.token):
            return Role.OPERATOR
        return None

    def knows_host(self, header: str) -> bool:
        """Return whether a Host header names this console; on a network the token decides."""
        name = urlsplit(f"//{header}").hostname or ""
        return not is_local(self.host) or is_local(name)


def is_local(host: str) -> bool:
    """Return whether a host name is this computer's, and no other can reach it."""
    if host in _LOCAL_NAMES:
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def is_same_origin(headers: Mapping[str, str]) -> bool:
    """Return whether a request comes from a page of the host that it is for.

    Browsers send an Origin with each web socket and each form; whatever sends none is no page.
    """
    origin = headers.get("origin")
    if origin is None:
        return True
    return urlsplit(origin).netloc.lower() == headers.get("host", "").lower()


def tidy_name(text: str) -> str:
    """Return a person's name as it is recorded: printable, of one line, and short."""
    return " ".join("".join(filter(str.isprintable, text)).split())[:_LONGEST_NAME]


def _is_same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode(), wanted.encode())
