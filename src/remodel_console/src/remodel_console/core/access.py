"""Who may do what: roles, and from where a page may talk to the console.

On this computer alone no user is needed, unless there is a file of users. A console that others can
reach always has one. Requests are let in for a host name that the console answers to, so that no
foreign page can reach it by a name of its own that leads here (DNS rebinding); web sockets besides
only from pages of the console itself.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from urllib.parse import urlsplit

_LOCAL_NAMES = ("localhost",)
_LONGEST_NAME = 40  # letters of a person's name in the record
_USER_NAME = re.compile(r"[\w.@+-]{1,40}")


class Role(Enum):
    """What a client of the console may do; each role may do what those before it may."""

    WATCHER = "watcher"
    OPERATOR = "operator"
    ENGINEER = "engineer"

    def may(self, needed: Role) -> bool:
        """Return whether the role is enough for what needs another one."""
        order = list(Role)
        return order.index(self) >= order.index(needed)


@dataclass(frozen=True)
class Actor:
    """Who gives a command, for the record."""

    name: str
    address: str
    role: Role


@dataclass(frozen=True)
class User:
    """Who uses the pages; of a console without users the name is empty, and everybody may all."""

    name: str = ""
    role: Role = Role.ENGINEER


@dataclass(frozen=True)
class Account:
    """What a file of users says of one: the role, and the hash of the password; empty: none."""

    role: Role
    password: str = ""


@dataclass(frozen=True)
class Door:
    """Where the console is, and how it learns who uses it.

    Attributes:
        host: address that the console is bound to.
        has_users: they are named, by signing in or by a proxy.
        user_header: header in which a proxy names the user; empty: users sign in.
        proxies: addresses whose header is believed.
        public_hosts: names by which a proxy's users reach the console.
    """

    host: str
    has_users: bool = False
    user_header: str = ""
    proxies: tuple[str, ...] = ("127.0.0.1", "::1")
    public_hosts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a door that stands open to a network."""
        if not is_local(self.host) and not self.has_users:
            raise ValueError(
                f"a console on {self.host} needs users, because other computers can reach it: "
                "rosrun remodel_console users add NAME --role engineer"
            )
        if self.user_header and not self.has_users:
            raise ValueError(
                "a proxy names the users, and their roles stand in a file: "
                "rosrun remodel_console users add NAME --role engineer --without-password"
            )

    def knows_host(self, header: str) -> bool:
        """Return whether a Host header names this console; on a network the user decides."""
        name = urlsplit(f"//{header}").hostname or ""
        return not is_local(self.host) or is_local(name) or name in self.public_hosts


def require_user_name(name: str) -> None:
    """Return if a text can be the name of a user.

    Raises:
        ValueError: if it cannot.
    """
    if not _USER_NAME.fullmatch(name):
        raise ValueError(
            f"{name!r} is no name of a user: 1 to 40 letters, digits or one of _ . @ + -"
        )


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
