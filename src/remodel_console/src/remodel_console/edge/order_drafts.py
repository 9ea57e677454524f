"""Orders before they are stored: a design file, what was read of it, preferences, and a plan.

A draft has a database of its own, so that nothing reaches the production database before a person
says so. It outlives the page that it was made on.
"""

from __future__ import annotations

import json
import secrets
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import msgspec

from remodel_console.core.order_desk import (
    Document,
    ListColumns,
    has_entries,
    new_document,
    write_document,
)
from remodel_console.edge.processes import LIMIT_S, Finished, PlannerProcess
from remodel_console.errors import CommandError
from remodel_run.findings import Imported, NoPlan, Plan
from remodel_run.rehearsal import Forecast

T = TypeVar("T")
_MOST_KEPT = 30  # each may have 100 MB
# Files of a draft; no design file has a name that begins with a dot.
_OWN = ".draft"
_PLAN, _BOARD, _DATABASE = f"{_OWN}/plan.json", f"{_OWN}/board.svg", f"{_OWN}/orders.sqlite"
_PREFERENCES, _MAPPING = f"{_OWN}/preferences.yaml", f"{_OWN}/mapping.yaml"
_SEARCH_S = "2"
_REHEARSAL = f"{_OWN}/rehearsal"
# The first seed of a rehearsal, and how long one may take [s of wall time]: a hundred wires with
# ten seeds on two cores take ten hours.
_SEED, _REHEARSAL_S = 100, 48 * 3600.0
_CANCELLED = "cancelled"
LISTS = (".csv", ".tsv", ".txt", ".xlsx", ".xlsm")  # files whose columns may need a mapping


@dataclass(frozen=True)
class DraftState:
    """What a page shows of a draft; it changes as a whole.

    Attributes:
        doing: what is under way, such as "planning"; empty if nothing is.
        stage: of it, such as `2/4: laying out the board`; empty if the command names none.
        since_s: when it began, by the monotonic clock.
        error: why the file cannot be read.
        use_case: by which it is planned and run; empty for what the design is.
        arms: that it is planned for at most; 0 for those of the use case.
        mapping: YAML of what the columns of a list mean; empty for those that are known.
        columns: of the list, for a person to choose what they mean; None if they were not read.
        boards: how often the board was drawn.
        is_planned: the plan, or why there is none, is of the present preferences.
        explanation: of the plan, in lines.
        stored_as: name of the order in the production database; empty before it is stored.
        forecast: what a rehearsal says of the stored order; None before.
    """

    doing: str = ""
    stage: str = ""
    since_s: float = 0.0
    error: str = ""
    imported: Imported | None = None
    use_case: str = ""
    arms: int = 0
    mapping: str = ""
    columns: ListColumns | None = None
    boards: int = 0
    preferences: Document = field(default_factory=new_document)
    plan: Plan | None = None
    no_plan: NoPlan | None = None
    is_planned: bool = False
    explanation: str = ""
    stored_as: str = ""
    forecast: Forecast | None = None


class OrderDraft:
    """One draft. Its commands are carried out one after the other; they may take minutes.

    Attributes:
        key: names it.
        file: the design file.
        name: what a person calls it: two drafts of one file have two names.
        made_at: the time of day.
        now: what a page shows.
    """

    def __init__(
        self,
        key: str,
        folder: Path,
        file_name: str,
        planner: PlannerProcess,
        wake: Callable[[], None],
        *,
        number: int = 1,
    ) -> None:
        """Begin with a file that is not read yet; `number` counts the drafts of one file."""
        self.key = key
        self.folder = folder
        self.name = file_name if number == 1 else f"{file_name} ({number})"
        self.number = number
        self.made_at = time.strftime("%H:%M:%S")
        self.file = folder / file_name
        self.now = DraftState()
        self._planner = planner
        self._wake = wake
        self._busy = threading.Lock()
        self._is_cancelled = False
        self._changing = threading.Lock()
        self._database = f"sqlite:///{folder / _DATABASE}"

    @property
    def board(self) -> Path:
        """Return the drawing of the board."""
        return self.folder / _BOARD

    def read(self, mapping: str | None = None) -> str:
        """Read the file, draw its board and plan it, and return the answer.

        Args:
            mapping: YAML of what the columns of a list mean from now on; None: as it is.

        Raises:
            CommandError: the command's own error, if the file is refused.
        """
        with self._doing("reading the file"):
            if mapping is not None:
                self._change(mapping=mapping)
            self._change(imported=None, plan=None, no_plan=None, explanation="")
            (self.folder / _DATABASE).unlink(missing_ok=True)
            try:
                printed = self._run(
                    "import", self.file.name, *self._mapping(), *self._by(), "--json"
                )
            except CommandError as error:
                self._change(error=_CANCELLED if self._is_cancelled else str(error))
                if self.file.suffix.lower() in LISTS and not self._is_cancelled:
                    self._read_columns()
                raise
            imported = read_findings(printed, Imported)
            self._change(error="", imported=imported, stored_as="", columns=None, forecast=None)
        with self._doing("drawing the board"):
            self._run("layout", imported.order, "--output", _BOARD)
            self._change(boards=self.now.boards + 1)
        if imported.triage is not None and not imported.triage.is_long:
            self.plan()
        return f"read {self.file.name}: {imported.counts['wires']} wires"

    def plan(self, use_case: str | None = None, arms: int | None = None) -> str:
        """Plan by the present preferences, and return the answer.

        An order without a plan is an answer, too: `now` says why there is none.

        Args:
            use_case: by which the order is planned and run from now on; None: as it is.
            arms: that it is planned for from now on; None: as it is.
        """
        with self._doing("planning"):
            if use_case is not None:
                self._change(use_case=use_case, is_planned=False)
            if arms is not None:
                self._change(arms=arms, is_planned=False)
            before = self.now
            if before.imported is None:
                raise CommandError("the file is not read yet")
            order = before.imported.order
            options = ["--order", order, *self._by(), *self._preferences()]
            planning = ("plan", *options, "--output", _PLAN, "--time-limit", _SEARCH_S, "--json")
            finished = self._finish(*planning)
            if finished.code != 0:
                found = _no_plan(finished)
                self._change(plan=None, no_plan=found, explanation="", **self._is_of(before))
                return f"no plan: {found.error.splitlines()[0]}"
            plan = read_findings(finished.printed, Plan)
            explained = self._run("explain", *options, _PLAN)
            self._change(plan=plan, no_plan=None, explanation=explained, **self._is_of(before))
            return f"planned: {plan.makespan_s:.0f} s, cost {plan.cost}"

    def store(self, order: str, database: str) -> str:
        """Store the order, with its preferences, in the production database.

        Raises:
            CommandError: the command's own error, if there is an order of that name already.
        """
        with self._doing("storing the order"):
            words = ["import", self.file.name, "--order", order, *self._mapping(), *self._by()]
            if has_entries(self.now.preferences):
                words += self._preferences()
            self._run(*words, database=database)
            self._change(stored_as=order)
            return f"stored order '{order}'"

    def rehearse(self, database: str, seeds: int, wires: int, *, adopts: bool = False) -> str:
        """Rehearse the stored order, and return the answer; it takes minutes for each wire.

        Args:
            database: URL of the production database, which keeps the rehearsal.
            seeds: with how many each wire is rehearsed.
            wires: how many, from the first; 0 for all.
            adopts: what helps is entered into the order's preferences. Trials that were made
                already are not repeated.

        Raises:
            CommandError: the command's own error, if the cell cannot carry the order out.
        """
        with self._doing("rehearsing"):
            words = ["rehearse", self.now.stored_as, "--seeds", f"{_SEED}-{_SEED + seeds - 1}"]
            words += ["--wires", str(wires)] if wires else []
            words += ["--use-case", self.now.use_case] if self.now.use_case else []
            words += ["--adopt"] if adopts else []
            words += ["--states", str(self.folder / _REHEARSAL), "--json"]
            printed = self._run(*words, database=database, limit_s=_REHEARSAL_S)
            found = read_findings(printed, Forecast)
            self._change(forecast=found)
            return f"rehearsed: {found.all_at_once:.0%} without a failure"

    def picture(self, name: str) -> Path:
        """Return the file of a picture of a rehearsal, whether it is there or not."""
        return self.folder / _REHEARSAL / "pictures" / plain_file_name(name)

    def read_columns(self) -> str:
        """Read the columns of a list, for a person to choose what they mean."""
        with self._doing("reading the headings"):
            self._read_columns()
            return "read the headings"

    def cancel(self) -> str:
        """End at once what is under way, and return the answer."""
        if self.now.doing:
            self._is_cancelled = True
            self._planner.end_in(self.folder)
        return "cancelled"

    def set_preferences(self, change: Callable[[Document], Document]) -> str:
        """Change the preferences; the plan stays as it is until it is planned again."""
        with self._changing:
            preferences = change(self.now.preferences)
            if preferences != self.now.preferences:
                self.now = replace(
                    self.now, preferences=preferences, is_planned=False, stored_as=""
                )
        self._wake()
        return "changed the preferences"

    def end(self) -> None:
        """End what is under way, and remove the files."""
        self._planner.end_in(self.folder)
        shutil.rmtree(self.folder, ignore_errors=True)

    def _read_columns(self) -> None:
        """Read the columns; a file that is no list has none."""
        words = ("import", self.file.name, *self._mapping(), "--print-mapping", "--json")
        finished = self._finish(*words)
        if finished.code == 0:
            self._change(columns=read_findings(finished.printed, ListColumns))

    def _is_of(self, before: DraftState) -> dict[str, object]:
        """Return whether the plan is of what a person sees now; others may have changed it."""
        now = self.now
        same = (now.preferences, now.use_case, now.arms)
        return {"is_planned": same == (before.preferences, before.use_case, before.arms)}

    def _by(self) -> list[str]:
        now = self.now
        words = ["--arms", str(now.arms)] if now.arms else []
        return [*words, "--use-case", now.use_case] if now.use_case else words

    def _mapping(self) -> list[str]:
        if not self.now.mapping.strip():
            return []
        (self.folder / _MAPPING).write_text(self.now.mapping, encoding="utf-8")
        return ["--mapping", _MAPPING]

    def _preferences(self) -> list[str]:
        text = write_document(self.now.preferences)
        (self.folder / _PREFERENCES).write_text(text, encoding="utf-8")
        return ["--preferences", _PREFERENCES]

    def _finish(self, *words: str, database: str = "", limit_s: float = LIMIT_S) -> Finished:
        if self._is_cancelled:
            raise CommandError(_CANCELLED)
        return self._planner.run(
            list(words),
            self.folder,
            database or self._database,
            lambda stage: self._change(stage=stage),
            limit_s,
        )

    def _run(self, *words: str, database: str = "", limit_s: float = LIMIT_S) -> str:
        finished = self._finish(*words, database=database, limit_s=limit_s)
        if finished.code != 0:
            raise CommandError(_own_words(finished))
        return finished.printed

    def _change(self, **changed: object) -> None:
        with self._changing:
            self.now = replace(self.now, **changed)  # type: ignore[arg-type]  # of its fields
        self._wake()

    @contextmanager
    def _doing(self, what: str) -> Iterator[None]:
        """Hold other commands of this draft back meanwhile."""
        with self._busy:
            self._is_cancelled = False
            self._change(doing=what, stage="", since_s=time.monotonic())
            try:
                yield
            except CommandError as error:
                if self._is_cancelled:
                    raise CommandError(_CANCELLED) from error
                raise
            else:
                if self._is_cancelled:  # just when the command had ended
                    raise CommandError(_CANCELLED)
            finally:
                self._change(doing="", stage="")


class OrderDrafts:
    """Keeps the drafts, as long as the console runs."""

    def __init__(self, folder: Path, planner: PlannerProcess) -> None:
        self._folder = folder
        self._planner = planner
        self._drafts: dict[str, OrderDraft] = {}
        self._lock = threading.Lock()
        self.on_change: Callable[[], None] = lambda: None

    def all(self) -> tuple[OrderDraft, ...]:
        """Return all drafts, the newest first."""
        return tuple(reversed(tuple(self._drafts.values())))

    def get(self, key: str) -> OrderDraft | None:
        """Return a draft by its key; None if it is gone."""
        return self._drafts.get(key)

    def new(self, file_name: str) -> OrderDraft:
        """Return a draft for a file, which is still to be written.

        Args:
            file_name: as a browser says it; only its last part counts, and letters of a file name.

        Raises:
            CommandError: if there are too many drafts; none is removed, as a person may need it.
        """
        if len(self._drafts) >= _MOST_KEPT:
            raise CommandError(f"there are {_MOST_KEPT} drafts; remove one that is done first")
        key = secrets.token_urlsafe(8)
        folder = self._folder / key
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        (folder / _OWN).mkdir(parents=True)
        name = plain_file_name(file_name)
        with self._lock:
            before = [each.number for each in self._drafts.values() if each.file.name == name]
            number = max(before, default=0) + 1
            draft = OrderDraft(key, folder, name, self._planner, self._woken, number=number)
            self._drafts[key] = draft
        return draft

    def remove(self, key: str) -> None:
        """Remove a draft, and end what it does."""
        with self._lock:
            draft = self._drafts.pop(key, None)
        if draft is not None:
            draft.end()
            self._woken()

    def end(self) -> None:
        """Remove all files."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _woken(self) -> None:
        self.on_change()


def plain_file_name(text: str) -> str:
    """Return a file name without folders, control characters and leading dashes or dots."""
    name = text.replace("\\", "/").rpartition("/")[2]
    name = "".join(each for each in name if each.isprintable()).strip().lstrip("-.")
    return name[-120:] or "design"


def _no_plan(finished: Finished) -> NoPlan:
    if finished.printed.strip():
        return read_findings(finished.printed, NoPlan)
    return NoPlan(_own_words(finished))


def _own_words(finished: Finished) -> str:
    """Return the error of a command, without the name of the command in front."""
    words = finished.error or f"it ended with exit code {finished.code}"
    for command in ("import", "plan", "layout", "explain", "rehearse"):
        words = words.removeprefix(f"{command}: ")
    return words


def read_findings(text: str, kind: type[T]) -> T:
    """Return what a command has printed.

    Raises:
        CommandError: if it is something else, such as of another version.
    """
    try:
        return msgspec.convert(json.loads(text), kind)
    except (ValueError, msgspec.ValidationError) as error:
        raise CommandError(
            f"the planner's answer cannot be read ({error}): are the console and remodel_planner "
            "of one version?"
        ) from error
