"""What the pages share: the sessions, the live system, and the ways to command both."""

from __future__ import annotations

import contextlib
import logging
import re
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.core.commands import Door, Role, User
from remodel_console.core.drawing import drawn_paths, opened
from remodel_console.core.record import Record, Summary, in_chart_terms
from remodel_console.core.run_view import Event, Phase
from remodel_console.core.running import FULL, Attach, Decisions, decisions_of
from remodel_console.core.world import Card, Option, Part
from remodel_console.edge.kept_files import HandWires, SceneFiles, SettingsFile
from remodel_console.edge.order_drafts import OrderDraft, OrderDrafts
from remodel_console.edge.processes import Everything
from remodel_console.edge.users_file import UsersFile
from remodel_console.edge.workspace import GENERATED, Catalogue, Workspace
from remodel_console.errors import CommandError, expect_ros
from remodel_console.live import Desk, Live, Steering
from remodel_console.session import Session, Sessions
from remodel_console.watched import Meshes, Pictures, RunValues, Scene, TopicPlots
from remodel_run.progress import Answer
from remodel_run.record import Statistics

_LOG = logging.getLogger(__name__)

# How many tasks of the sample order are done, as by `make demo`.
SAMPLE_TASKS = 6
_NEEDED = (Part.ENGINE, Part.SUPERVISOR, Part.CELL)
_START_POLL_S = 0.5
_START_S = 300.0  # wall time in which they start, on a computer that is busy


class Supervisor(Protocol):
    """Commands to the use case supervisor; each command returns its answer to the person `by`.

    All raise CommandError if it is not running, does not answer, or refuses. What holds a run
    (pause, stop, protective stop, skip) is answered when nothing moves any more.
    """

    def run(self, order: str, tasks: int, by: str, *, again: bool, use_case: str = "") -> str:
        """Start an order: so many of its tasks, 0 for all; `again`: those that are done too.

        An empty use case is the supervisor's default.
        """

    def pause(self, by: str) -> str:
        """Have the run pause."""

    def resume(self, by: str) -> str:
        """Have the run go on."""

    def release(self, by: str) -> str:
        """Release the protective stops of persons; the run stays paused."""

    def stop(self, by: str) -> str:
        """Have the run stopped safely."""

    def protective_stop(self, by: str) -> str:
        """Stop all motion at once; the run goes on when it is resumed."""

    def skip(self, task: str, by: str) -> str:
        """Have a task left undone."""

    def retry(self, task: str, by: str) -> str:
        """Have a task done again."""

    def answer(self, question: int, choice: Answer, by: str) -> str:
        """Answer a question by its number."""


class Inputs(Protocol):
    """The values that states ask for; both calls raise CommandError if one is no longer open."""

    def answer(self, number: int, literal: str) -> None:
        """Send the text of a literal."""

    def refuse(self, number: int) -> None:
        """Enter no value."""


class Recorder(Protocol):
    """Access to recorded runs; each call raises CommandError if no node serves them."""

    def runs(self) -> tuple[Summary, ...]:
        """Return the runs, the latest first."""

    def orders(self) -> tuple[str, ...]:
        """Return the names of all orders."""

    def statistics(self, order: str) -> Statistics:
        """Return the statistics of an order's runs; of an empty name: of all runs."""

    def record(self, run: int) -> Record:
        """Return the record of a run, without its pictures."""

    def picture(self, run: int, position: int) -> bytes:
        """Return the picture of an entry, as jpeg or png."""


@dataclass(eq=False, repr=False)  # some of it is secret
class Console:
    """Everything that a page needs.

    Attributes:
        own_database: URL of the production database; empty if the console was given none. While
            `everything` runs, that of its own is used.
        users: None: everybody on this computer may do everything.
        pictures: the newest ones of the cell's cameras.
        scene: the cell in three dimensions.
        meshes: of its robots, and of those in recordings.
        scenes: recordings of the cell in three dimensions.
        hand_wires: the wires by hand, and which of them are placed.
        values: userdata that the states of the run have found and left behind.
        plots: values of the topics that are plotted.
        steering: commands to the engine.
        supervisor: None until ROS is running.
        recorder: None until ROS is running.
        inputs: None until ROS is running.
        reset_cell: has a simulated cell rebuild its panel without wires; None until ROS is
            running.
        names: of all charts and behaviors, as they were listed last.
        generated: those of them that the supervisor has made.
        too_large: why files in the chart folders are not opened, by their names.
    """

    door: Door
    desk: Desk
    live: Live
    sessions: Sessions
    workspace: Workspace
    catalogue: Catalogue
    settings: SettingsFile
    scenes: SceneFiles
    drafts: OrderDrafts
    hand_wires: HandWires
    own_database: str
    everything: Everything
    users: UsersFile | None = None
    pictures: Pictures = field(default_factory=Pictures)
    scene: Scene = field(default_factory=Scene)
    meshes: Meshes = field(default_factory=Meshes)
    values: RunValues = field(default_factory=RunValues)
    plots: TopicPlots = field(default_factory=TopicPlots)
    supervisor: Supervisor | None = None
    recorder: Recorder | None = None
    inputs: Inputs | None = None
    reset_cell: Callable[[], str] | None = None
    names: tuple[str, ...] = ()
    generated: frozenset[str] = frozenset()
    too_large: dict[str, str] = field(default_factory=dict)
    _decisions_of: int = 0  # checksum of the behavior whose decisions were searched for last

    def __post_init__(self) -> None:
        self.hand_wires.on_change = self.live.refresh
        self.live.on_hand_wires = self.hand_wires.keep
        self.steering = Steering(self.live, self.sessions.commands, self.catalogue)

    @property
    def session(self) -> Session:
        """Return the session of `/flexbe/uicommand`, whose behavior Runtime control offers."""
        return self.sessions.commands

    @property
    def database(self) -> str:
        """Return the URL of the production database; empty without one."""
        return self.everything.database if self.everything.is_running else self.own_database

    @property
    def shown_database(self) -> str:
        """Return that URL without its password."""
        return re.sub(r"(?<=//)([^:@/]*):[^@/]*@", r"\1@", self.database)

    def start_everything(self, by: str, *, fake: bool) -> str:
        """Start what an order needs, and the sample order as soon as it can run.

        Args:
            by: who starts it.
            fake: with a cell that has no physics.

        Raises:
            CommandError: if it cannot be started.
        """
        order = self.everything.start(fake=fake, interfaces=not self.live.world.has_mirror)
        threading.Thread(target=self._run_sample, args=(order, by), daemon=True).start()
        return f"starting; log: {self.everything.log}"

    def stop_everything(self) -> None:
        """End what was started here, and return when it has ended."""
        self.everything.stop()
        self.live.refresh()

    def _run_sample(self, order: str, by: str) -> None:
        """Start the sample order once all that it needs is there, on an empty panel.

        Not in a real cell that has come up meanwhile, and not once another order has begun.
        """
        end_s = time.monotonic() + _START_S
        trouble = "engine, supervisor and cell are not all there"
        while self.everything.is_running and time.monotonic() < end_s:
            world = self.live.world
            if not world.takes_sample:
                return
            if self.supervisor is not None and all(map(world.has, _NEEDED)):
                try:
                    self.supervisor.run(order, SAMPLE_TASKS, by, again=True)
                except CommandError as error:
                    trouble = str(error)
                else:
                    return
            threading.Event().wait(_START_POLL_S)
        if self.everything.is_running:
            _LOG.warning("the sample order is not started: %s", trouble)
        self.live.refresh()  # the nodes have ended, perhaps before any answered

    def add_plot(self, plot: str) -> None:
        """Have one more field of a topic plotted, `/TOPIC.FIELD`.

        Raises:
            CommandError: if there is no such field, or it is plotted already.
        """
        expect_ros(self.plots.source).check(plot)
        try:
            self.settings.change(lambda now: replace(now, plots=(*now.plots, plot)))
        except ValueError as error:
            raise CommandError(str(error)) from error

    def list_names(self) -> tuple[str, ...]:
        """List the names of all charts and behaviors again, and return them; reads their files."""
        behaviors = self.catalogue.behaviors()
        found = {one.name for one in behaviors}
        self.generated = frozenset(
            one.name for one in behaviors if one.behavior.package == GENERATED
        )
        try:
            found |= set(self.workspace.names())
            self.too_large = self.workspace.too_large()
        except CommandError:
            _LOG.exception("cannot list the charts")
        self.names = tuple(sorted(found))
        return self.names

    def command(self, deed: Callable[[Supervisor], str]) -> str:
        """Command the use case supervisor, and return its answer.

        Raises:
            CommandError: if ROS is not running, or the supervisor refuses.
        """
        return deed(expect_ros(self.supervisor))

    def role_of(self, user: User) -> Role:
        """Return what a user may do now."""
        if self.users is None:
            return user.role
        account = self.users.account(user.name)
        return account.role if account else Role.WATCHER

    def store(self, draft: OrderDraft, name: str) -> str:
        """Store a draft as an order of the production database, and return the answer.

        Raises:
            CommandError: if the console knows no database, or the planner refuses.
        """
        if not self.database:
            raise CommandError(
                "the console was started without a production database; give it that of the "
                "supervisor: --database URL, or REMODEL_DATABASE in its environment"
            )
        if not name:
            raise CommandError("give the order a name")
        return draft.store(name, self.database)

    def rehearse(self, draft: OrderDraft, seeds: int, wires: int, *, adopts: bool) -> str:
        """Rehearse a stored order; see OrderDraft.rehearse."""
        return draft.rehearse(self.database, seeds, wires, adopts=adopts)

    def require_order(self, name: str) -> None:
        """Check that the supervisor knows an order.

        Raises:
            CommandError: if it does not, or does not answer.
        """
        if name not in expect_ros(self.recorder).orders():
            raise CommandError(
                f"the supervisor has no order '{name}': it works with another production database "
                "than this console; start both with the same one"
            )

    def take(self, event: Event) -> None:
        """Take in an event of the engine; find the decisions of a new behavior."""
        self.steering.take(event)
        run = self.live.world.run
        if run.phase is Phase.RUNNING and run.behavior_id != self._decisions_of:
            self._decisions_of = run.behavior_id
            find = threading.Thread(target=self._find_decisions, args=(run.behavior_id,))
            find.daemon = True
            find.start()

    def _find_decisions(self, behavior_id: int) -> None:
        found = Decisions(behavior_id)
        with contextlib.suppress(CommandError):  # no chart says what it does
            chart = self.chart_to_watch(self.steering.running_name())
            found = decisions_of(chart, behavior_id)
        self.live.set_decisions(found)

    def answer(self, card: Card, option: Option, by: str) -> str:
        """Give an answer to what waits for a person, and return the answer to that.

        Raises:
            CommandError: if it can no longer be given.
        """
        act = option.act
        if card.question is not None:
            number = card.question.number
            return self.command(lambda supervisor: supervisor.answer(number, act, by))
        if card.must_attach:
            self.steering.order(Attach(FULL))
        self.steering.order(act)
        return ""

    def enter(self, number: int, literal: str | None) -> None:
        """Enter the text of a literal that a state asks for, or None to enter no value.

        Raises:
            CommandError: if the state no longer waits for it, or ROS is not running.
        """
        inputs = expect_ros(self.inputs)
        if literal is None:
            inputs.refuse(number)
        else:
            inputs.answer(number, literal)

    def record(self, run: int) -> Record:
        """Return the record of a run, its states in terms of the charts that are saved here.

        Raises:
            CommandError: if it cannot be read.
        """
        if self.recorder is None:
            raise CommandError("no supervisor is running that has records")
        record = self.recorder.record(run)
        return in_chart_terms(record, self._drawn_paths)

    def _drawn_paths(self, behavior: str) -> frozenset[str]:
        """Return the paths of a behavior's chart; none if it is not saved here."""
        try:
            return drawn_paths(self.chart_to_watch(behavior))
        except CommandError:
            return frozenset()

    def chart_to_watch(self, name: str) -> Chart:
        """Return the saved chart of a behavior, with the behaviors in it drawn open.

        Raises:
            CommandError: if there is no such behavior.
        """
        return opened(self.workspace.find(name), self.workspace.charts())
