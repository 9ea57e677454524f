"""The editing sessions: one for each page of the editor, and the one of `/flexbe/uicommand`."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from flexbe_synthesizer.core.export.instantiate import Instantiation
from remodel_console.core.editor.synthesis_request import ServerRequest
from remodel_console.session import Session

Ask = Callable[[ServerRequest], tuple[Instantiation, ...]]


@dataclass(frozen=True)
class _Kept:
    """A page's session, and whether a browser still shows the page."""

    session: Session
    is_shown: Callable[[], bool]


class Sessions:
    """Makes and keeps sessions.

    A session with unsaved changes outlives its page: a reload of the page continues it, and so can
    another page of the editor.

    Attributes:
        commands: the session of `/flexbe/uicommand`.
        save_count: how often any session has saved a chart.
    """

    def __init__(self, make: Callable[[], Session], commands: Session) -> None:
        """Begin with the session of the commands; `make` returns one for a page of the editor."""
        self._make = make
        self._pages: dict[str, _Kept] = {}
        self._on_change: Callable[[], None] = lambda: None
        self._ask_server: Ask | None = None
        self.save_count = 0
        self.commands = commands
        self.commands.on_save = self._count

    def on_change(self, wake: Callable[[], None]) -> None:
        """Have a function called after each command that a session has carried out."""
        self._on_change = wake
        for session in self._all():
            session.on_change = wake

    def connect(self, ask_server: Ask) -> None:
        """Have all sessions ask synthesis servers so."""
        self._ask_server = ask_server
        for session in self._all():
            session.ask_server = ask_server

    def take(self, key: str, is_shown: Callable[[], bool]) -> tuple[str, Session]:
        """Return the session of a page and its key: the one of the key if no page shows it.

        Args:
            key: that the page's address has; empty or unknown for a new session.
            is_shown: returns whether a browser still shows the page.
        """
        self._forget_all_but(key)
        kept = self._pages.get(key)
        if kept is not None and not kept.is_shown():
            session = kept.session
        else:
            key, session = secrets.token_urlsafe(9), self._make()
            session.on_change, session.on_save = self._on_change, self._count
            session.ask_server = self._ask_server
        self._pages[key] = _Kept(session, is_shown)
        return key, session

    def is_shown(self, key: str) -> bool:
        """Return whether a browser shows the page of a session."""
        kept = self._pages.get(key)
        return kept is not None and kept.is_shown()

    def left_unsaved(self) -> dict[str, str]:
        """Return the names of charts with unsaved changes that no page shows, by session key."""
        return {
            key: kept.session.chart.name
            for key, kept in self._pages.items()
            if not kept.session.is_kept and kept.session.chart and not kept.is_shown()
        }

    def discard(self, key: str) -> None:
        """Forget a session that no page shows, with its unsaved changes."""
        kept = self._pages.get(key)
        if kept is not None and not kept.is_shown():
            del self._pages[key]

    def _all(self) -> Iterator[Session]:
        yield self.commands
        yield from (kept.session for kept in self._pages.values())

    def _count(self) -> None:
        self.save_count += 1

    def _forget_all_but(self, wanted: str) -> None:
        """Forget the other sessions without unsaved changes that no page shows."""
        self._pages = {
            key: kept
            for key, kept in self._pages.items()
            if key == wanted or kept.is_shown() or not kept.session.is_kept
        }
