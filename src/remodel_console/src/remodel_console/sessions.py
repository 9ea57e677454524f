"""The editing sessions: one for each page of the editor, and the one of `/flexbe/uicommand`."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from flexbe_synthesizer.core.export.instantiate import Instantiation
from remodel_console.core.editor.inspection import ServerRequest
from remodel_console.session import Session

Ask = Callable[[ServerRequest], tuple[Instantiation, ...]]


@dataclass(frozen=True)
class _Kept:
    """A page's session, whether a browser still shows the page, and who opened it."""

    session: Session
    is_shown: Callable[[], bool]
    who: str


@dataclass(frozen=True)
class Left:
    """Unsaved changes of a chart on a page that was closed; `changed_at`: time of the last one."""

    key: str
    name: str
    changed_at: str


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

    def take(self, key: str, is_shown: Callable[[], bool], who: str = "") -> tuple[str, Session]:
        """Return the session of a page and its key: the one of the key if no page shows it.

        Args:
            key: that the page's address has; empty or unknown for a new session.
            is_shown: returns whether a browser still shows the page.
            who: the user of the page, for others who open the same chart.
        """
        self._forget_all_but(key)
        kept = self._pages.get(key)
        if kept is not None and not kept.is_shown():
            session = kept.session
        else:
            key, session = secrets.token_urlsafe(9), self._make()
            session.on_change, session.on_save = self._on_change, self._count
            session.ask_server = self._ask_server
        self._pages[key] = _Kept(session, is_shown, who)
        return key, session

    def is_shown(self, key: str) -> bool:
        """Return whether a browser shows the page of a session."""
        kept = self._pages.get(key)
        return kept is not None and kept.is_shown()

    def left_unsaved(self) -> tuple[Left, ...]:
        """Return the charts with unsaved changes that no page shows, each once: the latest."""
        latest: dict[str, tuple[float, Left]] = {}
        for key, kept in self._pages.items():
            session, chart = kept.session, kept.session.chart
            if chart is None or session.is_kept or kept.is_shown():
                continue
            at = time.strftime("%H:%M", time.localtime(session.changed_at_s))
            found = session.changed_at_s, Left(key, chart.name, at)
            latest[chart.file] = max(latest.get(chart.file, found), found, key=lambda one: one[0])
        return tuple(left for _, left in latest.values())

    def others_at(self, key: str) -> tuple[str, ...]:
        """Return who else has the chart of a session open on a page."""
        own = self._pages.get(key)
        if own is None or own.session.chart is None:
            return ()
        file = own.session.chart.file
        return tuple(
            kept.who
            for other, kept in self._pages.items()
            if other != key
            and kept.session.chart is not None
            and kept.session.chart.file == file
            and kept.is_shown()
        )

    def discard(self, key: str) -> None:
        """Forget a session that no page shows, with its unsaved changes."""
        kept = self._pages.get(key)
        if kept is not None and not kept.is_shown():
            del self._pages[key]
            self._on_change()

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
