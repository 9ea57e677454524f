"""Order desk: from a design file that is dropped on the page to an order that the cell works on."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import run, ui
from nicegui.element import Element
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from remodel_console.core.commands import DONE, CommandResult, Role
from remodel_console.core.order_desk import Document
from remodel_console.core.world import ALL_PARTS, World
from remodel_console.edge.order_drafts import LISTS, DraftState, OrderDraft, OrderDrafts
from remodel_console.errors import CommandError
from remodel_console.web.elements import card, icon_button, unfolding
from remodel_console.web.guard import user_of
from remodel_console.web.order_panels import (
    ColumnsPanel,
    can_be_adopted,
    show_account,
    show_before_start,
    show_forecast,
    show_plan,
    show_triage,
)
from remodel_console.web.page import Page
from remodel_console.web.preferences_panel import PreferencesPanel
from remodel_run.findings import CellFit, Triage
from remodel_run.whole_task import counted


class DropZone(Element, component="static/drop_zone.js"):
    """Sends a file that is dropped or chosen to an address."""

    def __init__(
        self,
        address: str,
        words: str,
        sent: Callable[[str], Awaitable[object]],
        refused: Callable[[str], object],
        *,
        is_enabled: bool,
    ) -> None:
        """Build it.

        Args:
            address: that gets the content as the body of a POST, and the file's name as `name`.
            words: what a person reads on it.
            sent: gets the answer of the address.
            refused: gets why a file was not taken.
            is_enabled: files are taken.
        """
        super().__init__()
        self._props["address"] = address
        self._props["words"] = words
        self._props["enabled"] = is_enabled
        self.on("sent", lambda event: sent(str(event.args)))
        self.on("refused", lambda event: refused(str(event.args)))


_MOST_BYTES = 100_000_000  # as much as the planner reads


async def take_design(drafts: OrderDrafts, request: Request) -> Response:
    """Write the body of a request to a new draft, and return the draft's key.

    Of a file that is too large, or whose sender has gone, nothing is kept.
    """
    if not user_of(request.scope).role.may(Role.OPERATOR):
        return PlainTextResponse("A watcher sends no design files; this needs an operator.", 403)
    try:
        draft = drafts.new(request.query_params.get("name", ""))
    except CommandError as error:
        return PlainTextResponse(str(error), 409)
    is_whole = False
    try:
        with draft.file.open("wb") as file:
            async for chunk in request.stream():
                if file.tell() + len(chunk) > _MOST_BYTES:
                    return PlainTextResponse(
                        f"{draft.file.name}: is larger than {_MOST_BYTES // 1_000_000} MB, the "
                        "most that is read: is it a design file?",
                        413,
                    )
                await run.io_bound(file.write, chunk)
        is_whole = True
    finally:
        if not is_whole:
            drafts.remove(draft.key)
    return PlainTextResponse(draft.key)


ADDRESS = "/order_desk"
FILE_ADDRESS = f"{ADDRESS}/file"
_DRAFT = "draft"  # in the page's address: the key of its draft
_DROP = "Drop a .qet, KBL, VEC, WireViz, CSV or XLSX file here, or choose one"
_NONE = (
    "What the file contains, its board and the plan of its wires are shown here, to be checked "
    "before anything moves. Then the order is started."
)
_UNKNOWN_COLUMNS = "Choose below what the columns of this list mean, and have it read by that."
_BY_DESIGN = "as the design suggests"
_ARMS = {0: "the arms of the use case", 1: "one arm", 2: "two arms"}


class OrderDeskPage(Page):
    """The page of an order that is being prepared."""

    PARTS = ALL_PARTS

    def build(self) -> None:
        """Build the place for files, the list of drafts, and the area of the one that is open."""
        self._draft = self.console.drafts.get(self.query.get(_DRAFT, ""))
        self._sections: tuple[_Section, ...] = ()
        self._drawn: OrderDraft | None = None
        self._listed: tuple[str, ...] | None = None
        self._name = ""
        self._tasks: float | None = None
        self._trials = 10
        self._columns = ColumnsPanel(self, self._read)
        self._preferences = PreferencesPanel(self, self._change_preferences, self._plan)
        with ui.element("div").classes("order-desk").props('tabindex="0"') as desk:
            desk.props('role="region" aria-label="Order"')
            with ui.element("div").classes("across desk-head"):
                DropZone(FILE_ADDRESS, _DROP, self._take, self._refuse, is_enabled=self.is_operator)
                self._drafts = ui.element("div").classes("drafts")
                with ui.row().classes("doing") as self._doing:
                    self._does = ui.label().props('role="status"')
                    self._passed = ui.label().classes("soft")
                    self.button("Cancel", self._cancel, icon="close", look="quiet")
                self._timer = ui.timer(1.0, self._show_passed, active=False)
            with ui.element("div").classes("desk-area across") as self._area:
                ui.label(_NONE).classes("soft")

    def show(self, world: World) -> None:
        """Show the draft again if it has changed; other pages may show it, too."""
        draft = self._draft
        if draft is not None and self.console.drafts.get(draft.key) is None:
            draft = self._draft = None
        self._list_drafts()
        if draft is not self._drawn:
            self._drawn = draft
            self._area.clear()
            with self._area:
                self._sections = self._new_sections(draft) if draft else ()
                if draft is None:
                    ui.label("The draft was removed.").props('role="status"')
        doing = draft.now.doing if draft else ""
        stage = draft.now.stage if draft else ""
        self._does.text = f"{doing}…" + (f" stage {stage}" if stage else "") if doing else ""
        self._doing.set_visibility(bool(doing))
        self._timer.active = bool(doing)
        self._show_passed()
        if draft is not None:
            for section in self._sections:
                section.show(draft.now)

    # What is shown

    def _show_passed(self) -> None:
        """Show for how long the draft has been at work."""
        draft = self._draft
        if draft is not None and draft.now.doing:
            self._passed.text = f"{time.monotonic() - draft.now.since_s:.0f} s"

    def _list_drafts(self) -> None:
        drafts = self.console.drafts.all()
        here = self._draft.key if self._draft else ""
        listed = (here, *(each.key for each in drafts))
        if listed == self._listed:
            return
        self._listed = listed
        self._drafts.clear()
        with self._drafts:
            for draft in drafts:
                name = draft.name
                with ui.element("div").classes("draft here" if draft.key == here else "draft"):
                    link = ui.link(name, f"{ADDRESS}?{_DRAFT}={draft.key}")
                    if draft.key == here:
                        link.props('aria-current="page"')
                    ui.label(draft.made_at).classes("soft")
                    remove = icon_button(
                        "close", f"Remove {name}", partial(self._ask_remove, draft)
                    )
                    remove.props("size=sm").set_enabled(self.is_operator)

    def _new_sections(self, draft: OrderDraft) -> tuple[_Section, ...]:
        """Return the cards of a draft, each with what it shows: others keep what a person types."""
        return (
            _Section(
                lambda now: (now.error, now.columns is None), partial(self._show_error, draft)
            ),
            _Section(lambda now: now.columns, self._columns.show),
            _Section(lambda now: now.imported, partial(self._show_account, draft)),
            _Section(_triage_of, _show_triage),
            _Section(
                lambda now: (
                    *(now.imported, now.preferences, now.plan, now.no_plan, now.is_planned),
                    now.boards,
                ),
                lambda now: self._preferences.show(now, _board_of(draft, now)),
            ),
            _Section(
                lambda now: (
                    *(now.imported, now.use_case, now.arms, now.stored_as),
                    *(_has_two_arms(now), _triage_of(now)),
                ),
                partial(self._show_start, draft),
            ),
            _Section(
                lambda now: (now.plan, now.no_plan, now.is_planned, now.explanation, now.imported),
                show_plan,
            ),
            _Section(
                lambda now: (now.imported, now.stored_as, now.forecast),
                partial(self._show_rehearsal, draft),
            ),
            _Section(lambda now: now.boards, partial(self._show_board, draft)),
        )

    def _show_error(self, draft: OrderDraft, now: DraftState) -> None:
        if now.error:
            with card(draft.name, "This file is not read.").classes("across"):
                with ui.element("div").classes("ending bad").props('role="alert"'):
                    if now.columns is None or now.columns.has_ends:
                        ui.label(now.error).classes("lines")
                    else:
                        ui.label(_UNKNOWN_COLUMNS)
                        with unfolding("What the import says"):
                            ui.label(now.error).classes("lines")
                self.button("Read the file again", self._read, icon="refresh", look="quiet")

    def _show_account(self, draft: OrderDraft, now: DraftState) -> None:
        if now.imported is None:
            return
        with show_account(now.imported):
            if draft.file.suffix.lower() in LISTS:
                self.button("Columns", self._read_columns, icon="view_column", look="quiet")

    def _show_start(self, draft: OrderDraft, now: DraftState) -> None:
        """Add the card that plans by other options, stores the order, and starts it."""
        imported = now.imported
        if imported is None:
            return
        self._name = self._name or now.stored_as or imported.order
        with card("Start", "The order is stored in the production database, with its preferences."):
            with ui.row().classes("options"):
                choices = {"": _BY_DESIGN} | {name: name for name in imported.use_cases}
                use_case = ui.select(choices, value=now.use_case, label="Use case")
                arms = ui.select(_ARMS, value=now.arms, label="Planned for")
            for field in (use_case, arms):
                field.props("outlined dense").set_enabled(self.is_operator)

                async def change() -> None:
                    await self._plan(use_case.value, arms.value)

                field.on_value_change(change)
            name = ui.input("Name of the order", value=self._name).classes("wide")
            name.on_value_change(lambda: setattr(self, "_name", (name.value or "").strip()))
            tasks = ui.number(
                "Number of tasks", min=1, step=1, placeholder="all", value=self._tasks
            )
            tasks.on_value_change(lambda: setattr(self, "_tasks", tasks.value))
            for entry in (name, tasks):
                entry.props("outlined dense stack-label").classes("wide")
                entry.set_enabled(self.is_operator)
            if _has_two_arms(now):
                ui.label("The supervisor runs orders by one arm.").classes("soft")
            found = _triage_of(now)
            if found is not None:
                show_before_start(*found)
            if now.stored_as:
                ui.label(f"Stored as order '{now.stored_as}'.").props('role="status"')
            with ui.row().classes("controls"):
                self.button("Start the order", self._start, icon="play_arrow")
                self.button("Store it only", self._store, icon="save", look="quiet")

    def _show_rehearsal(self, draft: OrderDraft, now: DraftState) -> None:
        """Add the card that rehearses the order, and says what to expect."""
        if now.imported is None:
            return
        hint = "Carries the order out in the simulated cell many times, before the robot moves."
        with card("Rehearsal", hint).classes("across"):
            with ui.row().classes("controls"):
                trials = ui.number(
                    "Trials of each wire", value=self._trials, min=1, max=1000, step=1
                )
                trials.props("outlined dense stack-label").style("min-width: 180px")
                trials.on_value_change(lambda: setattr(self, "_trials", int(trials.value or 1)))
                trials.set_enabled(self.is_operator)

                self.button("Rehearse", self._rehearse, icon="theater_comedy", look="quiet")
                if can_be_adopted(now.forecast):
                    adopt = partial(self._rehearse, adopts=True)
                    self.button("Adopt what helps", adopt, icon="playlist_add_check", look="quiet")
            if now.forecast is not None:
                show_forecast(now.forecast, lambda name: f"{ADDRESS}/rehearsal/{draft.key}/{name}")
            else:
                ui.label("It was not rehearsed yet. A trial takes about a minute.").classes("soft")

    def _show_board(self, draft: OrderDraft, now: DraftState) -> None:
        address = _board_of(draft, now)
        if not address:
            return
        with card("Board", "Drawn to scale.").classes("across"):
            ui.link("Open in a tab of its own", address, new_tab=True).classes("soft")
            frame = ui.element("div").classes("board")
            with frame.props('tabindex="0" role="region" aria-label="Drawing of the board"'):
                picture = ui.element("img").props('alt="The board, with components and wires"')
                picture.props["src"] = address

    # Commands

    async def _take(self, key: str) -> None:
        """Open the draft of a file that was sent, and read it."""
        draft = self.console.drafts.get(key)
        if draft is not None:
            self._open(draft)
            await self._read()

    def _refuse(self, reason: str) -> None:
        ui.notify(reason, type="negative", multi_line=True, close_button="OK", timeout=0)

    def _open(self, draft: OrderDraft) -> None:
        self._draft, self._name, self._tasks = draft, "", None
        ui.run_javascript(f"history.replaceState(null, '', '?{_DRAFT}={draft.key}')")
        self.show(self.console.live.world)

    async def _read(self, mapping: str | None = None) -> None:
        draft = self._draft
        if draft is not None:
            what = f"import {draft.name}" + (", by a mapping" if mapping else "")
            await self.give(what, lambda: draft.read(mapping), shows_error=False)

    async def _read_columns(self) -> None:
        draft = self._draft
        if draft is not None:
            await self.give(f"read the headings of {draft.name}", draft.read_columns)

    async def _cancel(self) -> None:
        draft = self._draft
        if draft is not None:
            await self.give(f"cancel {draft.now.doing} of {draft.name}", draft.cancel)

    async def _plan(self, use_case: str | None = None, arms: int | None = None) -> None:
        draft = self._draft
        if draft is not None and draft.now.imported is not None:
            await self.give(f"plan {draft.name}", lambda: draft.plan(use_case, arms))

    async def _change_preferences(
        self, what: str, change: Callable[[Document], Document]
    ) -> CommandResult:
        draft = self._draft
        return await self.give(what, lambda: draft.set_preferences(change) if draft else None)

    async def _store(self) -> bool:
        """Store the order, if it is not, and return whether it is."""
        draft, name = self._draft, self._name
        if draft is None:
            return False
        if draft.now.stored_as == name:
            return True
        answer = await self.give(
            f"store order '{name}' of {draft.name}", lambda: self.console.store(draft, name)
        )
        return answer.state == DONE

    async def _rehearse(self, *, adopts: bool = False) -> None:
        draft, seeds, wires = self._draft, self._trials, int(self._tasks or 0)
        if draft is None or not await self._store():
            return
        what = ", and adopt what helps" if adopts else ""
        await self.give(
            f"rehearse order '{draft.now.stored_as}', {seeds} trials of each wire{what}",
            lambda: self.console.rehearse(draft, seeds, wires, adopts=adopts),
        )

    async def _start(self) -> None:
        draft, name, tasks = self._draft, self._name, int(self._tasks or 0)
        if draft is None or not await self._store():
            return
        now, by = draft.now, self.actor.name
        triage = now.imported.triage if now.imported else None
        use_case = now.use_case or (triage.use_case if triage else "")

        def start() -> str:
            self.console.require_order(name)
            return self.console.command(
                lambda supervisor: supervisor.run(name, tasks, by, again=False, use_case=use_case)
            )

        what = f"run order '{name}', use case {use_case}"
        what += f", its first {counted(tasks, 'task')}" if tasks else ""
        answer = await self.give(what, start)
        if answer.state == DONE:
            self.go_to("/overview")

    def _ask_remove(self, draft: OrderDraft) -> None:
        async def remove() -> None:
            what = f"remove the draft of {draft.name}"
            await self.give(what, lambda: self.console.drafts.remove(draft.key))

        if draft.now.stored_as:
            question = f"Remove {draft.name} here? The stored order stays."
        else:
            question = f"Remove {draft.name} and its preferences? It is not stored yet."
        self.ask(question, "Remove", remove)


class _Section:
    """A card that is drawn again only if what it shows has changed."""

    def __init__(
        self, key: Callable[[DraftState], object], show: Callable[[DraftState], None]
    ) -> None:
        self._key = key
        self._add = show
        self._shown: object = self  # equal to no key
        self._element = ui.element("div").classes("section")

    def show(self, now: DraftState) -> None:
        """Draw the card, if it has changed."""
        key = self._key(now)
        if key == self._shown:
            return
        self._shown = key
        self._element.clear()
        with self._element:
            self._add(now)


def _triage_of(now: DraftState) -> tuple[Triage | None, str, CellFit | None] | None:
    """Return who does which task, by the newest of import and plan; None before the import."""
    if now.imported is None:
        return None
    planned = now.plan.triage if now.plan else None
    return planned or now.imported.triage, now.imported.nothing_to_plan, now.imported.cell


def _board_of(draft: OrderDraft, now: DraftState) -> str:
    """Return the address of the drawing of the board; empty before it is drawn."""
    return f"{ADDRESS}/board/{draft.key}?v={now.boards}" if now.boards else ""


def _has_two_arms(now: DraftState) -> bool:
    return now.plan is not None and len(now.plan.arms) > 1


def _show_triage(now: DraftState) -> None:
    found = _triage_of(now)
    if found is not None:
        show_triage(*found)
