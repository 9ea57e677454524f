"""Commands: their spelling, which is the FlexBE App's, who may give them, answers and record.

On this computer alone no user is needed, unless there is a file of users. A console that others can
reach always has one. Requests are let in for a host name that the console answers to, so that no
foreign page can reach it by a name of its own that leads here (DNS rebinding); web sockets besides
only from pages of the console itself.

A command is matched against its whole text, with no blanks around it, and with the case given. An
answer has the command and whether it was carried out in its first line, then the words:

    done: load my_first_behavior
    loaded 'my_first_behavior' from /charts/my_first_behavior.xml
"""

from __future__ import annotations

import ast
import hmac
import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from urllib.parse import urlsplit

from remodel_console.errors import CommandError

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


DONE, FAILED, REFUSED = "done", "failed", "refused"


@dataclass(frozen=True)
class CommandResult:
    """The result of a command: `state` is DONE, FAILED or REFUSED."""

    state: str
    command: str
    words: str

    def __str__(self) -> str:
        return f"{self.state}: {self.command}\n{self.words}"


def read_answer(text: str) -> CommandResult:
    """Return the answer that a text is.

    Raises:
        ValueError: if it is none.
    """
    head, _, words = text.partition("\n")
    state, mark, command = head.partition(": ")
    if not mark or state not in (DONE, FAILED, REFUSED):
        raise ValueError(f"no answer to a command: {text!r}")
    return CommandResult(state, command, words)


_GONE = ("Errno", "timeout exceeded", "unavailable", "unable to connect", "Connection refused")
_CUT = ("transport error", "unable to receive")


def trouble_words(service: str, reason: str, limit_s: float) -> str:
    """Return why a service could not be called, as an operator reads it.

    Args:
        service: its name.
        reason: what ROS says; empty if there was no answer in time.
        limit_s: in which it had to answer [s].
    """
    who = "the supervisor" if "/use_case/" in service else "its node"
    if not reason:
        return f"{service}: {who} has not answered within {limit_s:.0f} s"
    if any(word in reason for word in _CUT):
        return f"{service}: {who} ended, or lost its connection, before it answered"
    if any(word in reason for word in _GONE):
        return f"{service}: {who} is not running, or does not answer"
    return f"{service} could not be called: {reason}"


class Verb(Enum):
    """What a command does: its usage, its pattern, and its help."""

    HELP = ("help", r"cmd|commands|help", "list the commands")
    LOAD = ("load NAME", r"load (?P<name>.+)", "edit the behavior of that name")
    SYNTHESIZE = (
        "synthesize NAME i: START g: CHART",
        r"synthesize (?P<name>\w+) i: ?(?P<initial>.+?) g: ?(?P<goal>.+)",
        "add the chart in the file CHART, started at START (start: its own initial state), to the "
        "behavior as the container NAME",
    )
    SAVE = ("save", r"save", "check the behavior; without errors, write it and its chart")
    EDIT = (
        "edit [PATH]",
        r"edit(?: (?P<path>/.*))?",
        "open that container; without PATH, the behavior",
    )
    SHOW = ("show", r"show", "print the chart that is edited")
    CHECK = ("check", r"check", "list all errors of the behavior, and write nothing")
    NOTE = ("note TEXT", r"note(?: (?P<text>.+))?", "add the text to the behavior's description")
    AUTOCONNECT = (
        "autoconnect",
        r"autoconnect",
        "connect unconnected outcomes to those of their name",
    )
    AUTOLAYOUT = ("autolayout", r"autolayout", "no effect: save lays out every behavior")
    UPDATE = ("update NAME", r"update (?P<name>.+)", "no effect: every check reads the files again")
    FIND = (
        "findStateUsage PACKAGE.CLASS",
        r"findStateUsage[ (]['\"]?(?P<state>[\w.]+)['\"]?\)?",
        "list the charts that use a state class",
    )
    ATTACH = ("attach [LEVEL]", r"attach(?: (?P<level>-?\d+))?", "supervise the running behavior")
    LOCK = ("lock [N]", r"lock(?: (?P<level>-?\d+))?", "lock the N-th level of the active state")
    UNLOCK = ("unlock", r"unlock", "release the lock")
    STATEMACHINE = (
        "statemachine [NAME]",
        r"statemachine(?:[ (]['\"]?(?P<name>\w*)['\"]?\)?)?",
        "needs a selection on a canvas: refused here",
    )
    SWITCH = ("switch", r"switch|goforit", "continue in the version saved since the start")

    def __init__(self, usage: str, pattern: str, help_text: str) -> None:
        self.usage = usage
        self.pattern = re.compile(pattern)
        self.help_text = help_text


@dataclass(frozen=True)
class Command:
    """A command that was understood: its verb, and what was given with it."""

    text: str
    verb: Verb
    given: Mapping[str, str] = field(default_factory=dict)


def read_command(text: str) -> Command:
    """Return the command that a text is.

    Raises:
        CommandError: if it is none.
    """
    for verb in Verb:
        found = verb.pattern.fullmatch(text)
        if found:
            return Command(text, verb, {k: v for k, v in found.groupdict().items() if v})
    word = text.split(" ", 1)[0]
    usages = [verb.usage for verb in Verb if verb.usage.split(" ")[0] == word]
    hint = f"usage: {usages[0]}" if usages else "'help' lists the commands"
    raise CommandError(f"'{text}' is no command; {hint}")


def help_lines() -> str:
    """Return the list of all commands."""
    width = max(len(verb.usage) for verb in Verb)
    return "\n".join(f"{verb.usage:{width}}  {verb.help_text}" for verb in Verb)


def is_allowed(given: str, wanted: str) -> bool:
    """Return whether a key is accepted, in a time that does not depend on where it differs.

    A key of blanks counts as none; without a wanted key, every key opens.
    """
    wanted = wanted.strip()
    if not wanted:
        return True
    return hmac.compare_digest(given.strip().encode(), wanted.encode())


def as_literal(text: str) -> str:
    """Return the text of a Python literal: the one typed, or what was typed as a text."""
    return (
        text.strip() if _value(text) is not None or text.strip() == "None" else repr(text.strip())
    )


def value_words(text: str) -> str:
    """Return what the typed text is sent as."""
    if not text.strip():
        return "A number, a list such as [1.5, 'A7'], or a text."
    literal = as_literal(text)
    return f"Sends the {_KINDS.get(type(ast.literal_eval(literal)), 'value')} {literal}"


_KINDS = {
    str: "text",
    int: "number",
    float: "number",
    bool: "truth value",
    list: "list",
    tuple: "tuple",
    dict: "mapping",
    set: "set",
    type(None): "value",
}


def _value(text: str) -> object:
    """Return the value of a literal; None if the text is none."""
    try:
        return ast.literal_eval(text.strip())
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return None
