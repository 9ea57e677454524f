"""Editing sessions: one for each page of the editor, and the one of `/flexbe/uicommand`."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import PurePath

from flexbe_synthesizer.core.chart.model import Chart, Container
from flexbe_synthesizer.core.chart.names import behavior_file
from flexbe_synthesizer.core.chart.xml_tree import decoded
from flexbe_synthesizer.core.export.layout import Instantiation
from remodel_console.core.chart_edit import with_name
from remodel_console.core.commands import Command, Verb, help_lines
from remodel_console.core.editing import (
    Draft,
    as_container,
    change_at,
    connected,
    container_at,
    new_draft,
    read_path,
    with_container,
)
from remodel_console.core.server_states import ServerRequest, chart_from_states
from remodel_console.core.settings import Settings
from remodel_console.edge.workspace import Workspace
from remodel_console.errors import ChartErrorsError, CommandError
from remodel_run.whole_task import counted

_MOST_UNDONE = 200  # changes that can be taken back
Drafts = tuple[Draft, ...]
START = "start"  # what the deliverable's command line writes for "where the chart itself starts"


class Session:
    """The edited behavior, and the open container in it.

    Attributes:
        is_saved: nothing has changed since it was loaded or saved.
        changed_at_s: when it was changed last [s], wall time.
        is_kept: it is saved, or kept as a draft: nothing is lost without this session.
        on_save: called after a chart was saved.
        on_change: called after each command that was carried out.
        ask_server: calls a synthesis server; None until ROS is running.
    """

    def __init__(
        self,
        workspace: Workspace,
        settings: Callable[[], Settings] = Settings,
        *,
        opens_drafts: bool = True,
    ) -> None:
        """Begin with nothing loaded.

        Args:
            workspace: where charts lie.
            settings: returns what is configured now.
            opens_drafts: load the draft that was kept of a chart in place of the chart.
        """
        self._workspace = workspace
        self._opens_drafts = opens_drafts
        self._settings = settings
        self.ask_server: Callable[[ServerRequest], tuple[Instantiation, ...]] | None = None
        self._lock = threading.Lock()
        self._path: tuple[str, ...] = ()
        self._draft: Draft | None = None
        self.is_saved = True
        self.changed_at_s = time.time()
        self._kept_text: str | None = None
        self._before: Drafts = ()
        self._undone: Drafts = ()
        self.on_change: Callable[[], None] = lambda: None
        self.on_save: Callable[[], None] = lambda: None
        self._deeds: Mapping[Verb, Callable[[Mapping[str, str]], str]] = {
            Verb.HELP: lambda _given: help_lines(),
            Verb.LOAD: self._load,
            Verb.SAVE: self._save,
            Verb.EDIT: self._edit,
            Verb.SHOW: lambda _given: self._drafted().text,
            Verb.CHECK: self._check,
            Verb.NOTE: self._note,
            Verb.AUTOCONNECT: self._autoconnect,
            Verb.AUTOLAYOUT: lambda _given: "save lays out every behavior",
            Verb.UPDATE: self._update,
            Verb.FIND: self._find,
        }

    @property
    def chart(self) -> Chart | None:
        """Return what is edited, None before the first `load`."""
        return None if self._draft is None else self._draft.chart

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to undo."""
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Return whether there is an undone change to redo."""
        return bool(self._undone)

    @property
    def saved_text(self) -> str:
        """Return the text of the file as it was loaded or saved; empty if there is none."""
        draft = self._draft
        if draft is None or draft.origin is None:
            return ""
        return decoded(draft.origin, draft.chart.file)

    @property
    def text(self) -> str:
        """Return the XML of what is edited, as it would be saved; empty before the first `load`."""
        return "" if self._draft is None else self._draft.text

    @property
    def is_kept(self) -> bool:
        """Return whether what is edited is on disk, as the chart or as its draft."""
        return self.is_saved or (self._draft is not None and self._draft.text == self._kept_text)

    def save_or_keep(self) -> str:
        """Save the chart, or keep it as a draft while it has errors; return the answer.

        Raises:
            CommandError: if neither is possible; then nothing has changed.
        """
        with self._changing():
            try:
                return self._save({})
            except ChartErrorsError as error:
                draft = self._drafted()
                file = self._workspace.keep(draft)
                self._kept_text = draft.text
                errors = counted(error.count, "error")
                return f"kept '{draft.chart.name}' as a draft, which has {errors}: {file}"

    def carry_out(self, command: Command) -> str:
        """Carry a command out and return the answer.

        Raises:
            CommandError: if it cannot be carried out; then nothing has changed.
        """
        given = command.given
        if command.verb is Verb.SYNTHESIZE:
            return self.synthesize(self._path, given["name"], given["initial"], given["goal"])
        deed = self._deeds.get(command.verb)
        if deed is None:
            raise CommandError(f"'{command.text}' {command.verb.help_text}")
        with self._changing():
            return deed(given)

    def change(self, change: Callable[[Chart], Chart]) -> None:
        """Change the chart that is edited.

        Raises:
            CommandError: if nothing is loaded, or the change cannot be made.
        """
        with self._changing():
            self._change(change(self._loaded()))

    def retype(self, text: str) -> None:
        """Take a text that was typed in place of that of the chart.

        Raises:
            CommandError: if nothing is loaded, or the text does not have the form of a chart.
        """
        with self._changing():
            self._take(self._drafted().retyped(text))

    def undo(self) -> str:
        """Undo the last change, and return the answer.

        Raises:
            CommandError: if there is none.
        """
        with self._changing():
            if not self._before:
                raise CommandError("there is nothing to undo")
            self._before, self._undone = self._stepped(self._before, self._undone)
            return "undid the last change"

    def redo(self) -> str:
        """Redo the change that was undone last, and return the answer.

        Raises:
            CommandError: if there is none.
        """
        with self._changing():
            if not self._undone:
                raise CommandError("there is nothing to redo")
            self._undone, self._before = self._stepped(self._undone, self._before)
            return "redid the last undone change"

    def _stepped(self, back: Drafts, forth: Drafts) -> tuple[Drafts, Drafts]:
        """Edit the last draft of one pile; return the piles, with the present draft on the other.

        The file stays as it was loaded or saved last.
        """
        now = self._drafted()
        self._draft = replace(back[-1], origin=now.origin)
        self.is_saved = self._is_as_saved()
        return back[:-1], (*forth, now)

    def open(self, chart: Chart) -> None:
        """Edit a chart that is new."""
        draft = new_draft(chart)
        with self._changing():
            self._begin(draft)
            self.is_saved = False

    def copy_as(self, name: str) -> str:
        """Edit a copy of the chart under another name, and return the answer.

        The file of the copy lies beside that of the chart, and is written by Save.

        Raises:
            CommandError: if nothing is loaded, or the name is taken.
        """
        with self._changing():
            draft = self._drafted()
            file = str(PurePath(draft.chart.file).parent / f"{behavior_file(name)}.xml")
            if name in self._workspace.names() or self._workspace.has_file(file):
                raise CommandError(f"there is a behavior '{name}' already, or its file {file}")
            copy = draft.changed(with_name(draft.chart, name))
            self._begin(Draft(replace(copy.chart, file=file), copy.text))
            self.is_saved = False
            return f"'{name}' is a copy of '{draft.chart.name}'"

    def synthesize(self, path: tuple[str, ...], name: str, initial: str, goal: str) -> str:
        """Add the chart of a file as a container, and return the answer.

        Args:
            path: ids of the containers that it goes into.
            name: id of the container that it becomes.
            initial: where it starts; empty or `start` for where the chart does.
            goal: path of the file.

        Raises:
            CommandError: if the chart cannot be used; then nothing has changed.
        """
        file = self._loaded().file
        container = self._container(path, name, initial, goal)
        with self._changing():
            if self._loaded().file != file:
                raise CommandError(f"{goal} is not added: another behavior was loaded meanwhile")
            return self._put(path, container, goal)

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Hold other threads back meanwhile; what is raised inside is no change."""
        with self._lock:
            yield
        self.on_change()

    def _drafted(self) -> Draft:
        if self._draft is None:
            raise CommandError("no behavior is loaded; 'load NAME' loads one")
        return self._draft

    def _loaded(self) -> Chart:
        return self._drafted().chart

    def _change(self, chart: Chart) -> None:
        draft = self._drafted()
        if chart is not draft.chart:
            self._take(draft.changed(chart))

    def _take(self, draft: Draft) -> None:
        """Make a draft the one that is edited."""
        before = self._drafted()
        if draft.text != before.text:
            self._before, self._undone = (*self._before[-_MOST_UNDONE:], before), ()
            self._draft = draft
            self.is_saved, self.changed_at_s = self._is_as_saved(), time.time()

    def _begin(self, draft: Draft) -> None:
        """Make a draft the one that is edited, without a past."""
        self._draft, self._path, self._before, self._undone = draft, (), (), ()
        self.changed_at_s = time.time()
        self._kept_text = None

    def _is_as_saved(self) -> bool:
        draft = self._drafted()
        return draft.origin is not None and self.saved_text == draft.text

    def _load(self, given: Mapping[str, str]) -> str:
        lost = "" if self.is_kept else "; the unsaved changes are lost"
        name = given["name"]
        draft = (self._opens_drafts and self._workspace.never_saved(name)) or (
            self._workspace.load(name)
        )
        kept, chart = self._workspace.kept(draft) if self._opens_drafts else None, draft.chart
        self._begin(kept or draft)
        if kept is None:
            self.is_saved = True
            return f"loaded '{chart.name}' from {chart.file}{lost}"
        self.is_saved, self._kept_text = self._is_as_saved(), kept.text
        return f"loaded the draft of '{chart.name}' that was kept beside {chart.file}{lost}"

    def _container(self, path: tuple[str, ...], name: str, initial: str, goal: str) -> Container:
        """Return the chart of a file as a container, as the server makes it or as it is.

        It may take a while, and only the client that asked waits for it.
        """
        settings, initial = self._settings(), "" if initial == START else initial
        folder = str(PurePath(self._loaded().file).parent)
        if not settings.is_synthesis_enabled:
            raise CommandError("synthesis is switched off; the Configuration page switches it on")
        if not settings.synthesis_topic:
            return as_container(self._workspace.read(goal), name, initial, folder)
        where = "/".join(("", *path, name))
        topic, system = settings.synthesis_topic, settings.system
        source = self._served(ServerRequest(topic, system, where, initial, goal=goal), name)
        return as_container(source, name, "", folder)

    def _put(self, path: tuple[str, ...], container: Container, goal: str) -> str:
        chart = self._loaded()
        self._change(change_at(chart, path, lambda scope: with_container(scope, container)))
        where = "/".join(("", *path, container.id))
        return f"{goal} is in '{chart.name}' as {where}; 'save' checks and writes it"

    def _served(self, request: ServerRequest, name: str) -> Chart:
        """Return what a synthesis server makes of a request, as a chart of that name."""
        if self.ask_server is None:
            raise CommandError("ROS is not running, so no synthesis server can be asked")
        states = self.ask_server(request)
        return chart_from_states(states, name, self._workspace.library())

    def _save(self, _given: Mapping[str, str]) -> str:
        draft = self._drafted()
        written = self._workspace.save(draft)
        self._draft, self.is_saved = replace(draft, origin=draft.content), True
        self.on_save()
        what = f"wrote {', '.join(map(str, written))}" if written else "nothing has changed"
        return f"saved '{draft.chart.name}': {what}"

    def _check(self, _given: Mapping[str, str]) -> str:
        draft = self._drafted()
        problems = self._workspace.look(draft.text, draft.chart.file).problems
        return "\n".join(map(str, problems)) or "no errors and no warnings"

    def _edit(self, given: Mapping[str, str]) -> str:
        path = read_path(given.get("path", "/"))
        scope = container_at(self._loaded(), path)
        self._path = path
        inside = ", ".join(node.id for node in scope.nodes)
        return f"in /{'/'.join(path)}, which holds {inside}"

    def _note(self, given: Mapping[str, str]) -> str:
        if "text" not in given:
            raise CommandError("'note TEXT' needs the text to add to the description")
        chart = self._loaded()
        lines = (chart.description, given["text"])
        self._change(replace(chart, description="\n".join(filter(None, lines))))
        return f"noted in the description of '{chart.name}'"

    def _autoconnect(self, _given: Mapping[str, str]) -> str:
        chart = self._loaded()
        events = self._workspace.events(chart)

        def connect(scope: Chart) -> Chart:
            return connected(scope, events.get(scope.name, {}))

        changed = change_at(chart, self._path, connect)
        self._change(changed)
        return (
            "connected the unconnected outcomes" if changed != chart else "found nothing to connect"
        )

    def _update(self, given: Mapping[str, str]) -> str:
        chart = self._workspace.find(given["name"])
        return f"'{chart.name}' is read again from {chart.file} at every check"

    def _find(self, given: Mapping[str, str]) -> str:
        users = tuple(self._workspace.users_of(given["state"]))
        return "\n".join(users) or f"no chart uses {given['state']}"


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
