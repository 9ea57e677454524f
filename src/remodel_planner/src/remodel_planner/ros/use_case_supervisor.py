"""The use case supervisor: does what core/supervision says comes next, and keeps what happens."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import rospy
from remodel_msgs.msg import Panel

from flexbe_synthesizer.core.codec import write_chart
from flexbe_synthesizer.core.model import Chart
from remodel_planner.core.planning.problem import End as WireEnd
from remodel_planner.core.recovery.fault import Do, FaultTable
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.events import (
    Answered,
    AsLeft,
    Blocked,
    Chosen,
    Command,
    Commanded,
    Event,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunEnded,
    Settled,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_planner.core.supervision.judge import failure_of, judged
from remodel_planner.core.supervision.question import question_about
from remodel_planner.core.supervision.state import RunState, Stage, TaskProgress
from remodel_planner.core.supervision.step import (
    Ask,
    Decide,
    End,
    Execute,
    Plan,
    Settle,
    Step,
    Wait,
    next_step,
    said,
)
from remodel_planner.core.use_case.task_chart import content_mark
from remodel_planner.edge.chart_folder import keep_chart
from remodel_planner.edge.known_behaviors import describes
from remodel_planner.edge.run_log import RunLog
from remodel_planner.edge.task_leases import Holding, TaskLeases
from remodel_planner.edge.work_planner import WorkPlanner
from remodel_planner.errors import CellError, InstanceError, LostError, UseCaseError
from remodel_planner.ros.ability_feedback import Doing
from remodel_planner.ros.behavior_synthesizer import BehaviorSynthesizer
from remodel_planner.ros.cell import Cell
from remodel_planner.ros.inspection import Inspection, UnseenError
from remodel_planner.ros.task_supervisor import Sight, TaskSupervisor

# [s] of wall time between two looks at what is waited for.
_LOOK_S = 0.2

# remodel_msgs/ErrorCode SERVER_LOST; [s] of wall time that such a server gets to come back before
# the next try counts, longer than it takes to start anew; and between two looks.
_SERVER_LOST = 4
_SERVER_PATIENCE_S = 20.0
_SERVER_LOOK_S = 0.02

# A cell's answer to a claim -> how the other cell has left the task.
_AS_LEFT = {
    Holding.ELSEWHERE: AsLeft.RUNNING,
    Holding.DONE: AsLeft.DONE,
    Holding.SET_ASIDE: AsLeft.SET_ASIDE,
}


@dataclass(frozen=True)
class Work:
    """What a run is about, beside its events.

    Attributes:
        planner: of the order.
        faults: that there are.
        panel: that the cell builds; None if it stands there.
        keep_panel: whether wires may be on it already.
        channels: where each task's part is presented, by the task's name.
        leases: on the tasks.
        charts: folder of the task charts; one that the synthesizer may read.
        attended: whether there is an operator who can be asked.
        patience_s: [s] wall time that a lost process gets to come back.
        timeout_s: [s] ROS time after which the run stops; 0: never.
    """

    planner: WorkPlanner
    faults: FaultTable
    panel: Panel | None
    keep_panel: bool
    channels: dict[str, str]
    leases: TaskLeases
    charts: Path
    attended: bool
    patience_s: float
    timeout_s: float = 0.0


@dataclass(frozen=True)
class Peers:
    """The nodes that a run needs."""

    cell: Cell
    synthesizer: BehaviorSynthesizer
    tasks: TaskSupervisor
    inspection: Inspection

    def wait(self, limit_s: float) -> None:
        """Wait until all are there; LostError if one is not within a limit of wall time [s]."""
        for peer in (self.cell, self.synthesizer, self.tasks, self.inspection):
            peer.wait(limit_s)


KeepPictures = Callable[[str, tuple[Sight, ...]], tuple[str, ...]]


class UseCaseSupervisor:
    """Takes one run to its end.

    Attributes:
        state: what is known of the run; replaced at each event, never changed.
        doing: what is being done now, for a person.
    """

    def __init__(
        self,
        run: int,
        state: RunState,
        log: RunLog,
        work: Work,
        peers: Peers,
        keep_pictures: KeepPictures,
        on_change: Callable[[], None],
    ) -> None:
        """Take over a run.

        Args:
            run: its number.
            state: what is known of it.
            log: keeps its events.
            work: what it is about.
            peers: nodes that it needs.
            keep_pictures: writes a behavior's pictures into the run's folder.
            on_change: called when state or doing have changed, from several threads.
        """
        self.run = run
        self.state = state
        self.doing = ""
        self.work = work
        self._log = log
        self._peers = peers
        self._keep_pictures = keep_pictures
        self._on_change = on_change
        self._lock = threading.RLock()
        self._changed = threading.Event()
        self._lost_lease = False
        self._begun_s = 0.0
        # A run whose order of tasks is decided was taken up by a supervisor before.
        self._began_before = not state.to_plan
        # Where the cell answered that has the panel.
        self._loaded_at = ""

    @property
    def doing_now(self) -> Doing | None:
        """What an ability says that it does; None if none does anything."""
        return self._peers.tasks.abilities.latest

    @property
    def state_path(self) -> str:
        """The path of the state in which the engine is; empty if it says none."""
        return self._peers.tasks.state_path

    def supervise(self) -> RunState:
        """Do what comes next until the run has ended, and return how it ended.

        What is lost meanwhile is waited for, and the run goes on from where it was.
        """
        self._begun_s = rospy.get_time()
        with self._peers.tasks.recording(settling=self._began_before):
            if self._began_before:
                self._recover("the use case supervisor was started anew")
            while (step := next_step(self.state)) is not None and not rospy.is_shutdown():
                try:
                    self._do(step)
                except LostError as error:
                    self._recover(str(error))
                except (CellError, InstanceError, UseCaseError) as error:
                    self._append(Blocked(str(error)))
        return self.state

    def command(self, event: Commanded) -> None:
        """Do what an operator asks for.

        Raises:
            CellError: if that makes no sense now.
        """
        with self._lock:
            if self.state.ended is not None:
                raise CellError("the run has ended")
            if event.command in (Command.SKIP, Command.RETRY):
                self._require_sense(event)
            self._append(event)
            if event.command in (Command.PAUSE, Command.RESUME):
                self._peers.tasks.pause(event.command is Command.PAUSE)

    def answer(self, event: Answered) -> None:
        """Take an operator's answer.

        Raises:
            CellError: if that was not asked.
        """
        with self._lock:
            asked = self.state.question
            if asked is None or asked.number != event.number:
                open_now = f"question {asked.number}" if asked else "none"
                raise CellError(f"question {event.number} is not open; open is {open_now}")
            if event.choice not in asked.choices:
                choices = ", ".join(choice.value for choice in asked.choices)
                raise CellError(f"{event.choice.value} is no answer to it; there are {choices}")
            self._append(event)

    def _do(self, step: Step) -> None:
        self._say_doing(said(step))
        if self._is_overdue() and not isinstance(step, End):
            self._append(Blocked(f"its time of {self.work.timeout_s:g} s has passed"))
            return
        match step:
            case Plan():
                self._append(Planned(self._planned(), step.because))
            case Execute():
                self._execute(step.task, step.part)
            case Settle():
                self._settle(step.task)
            case Decide():
                self._decide(step.task)
            case Ask():
                self._ask(step.task)
            case Wait():
                self._wait()
            case End():
                self._append(RunEnded(step.ending, step.because))

    def _planned(self) -> tuple[str, ...]:
        """Return the waiting tasks in their best order; those that were begun before come last."""
        tasks = self.state.tasks
        order = self.work.planner.plan(self.state.waiting)
        return tuple(sorted(order, key=lambda name: tasks[name].attempts > 0))

    def _execute(self, name: str, part: Part) -> None:
        if not self._has(name):
            return
        task = self.state.tasks[name]
        self._await_server(task)
        chosen = self._chosen(task, part)
        chart = self.work.planner.chart(name, part, task.connected, task.decisions, chosen)
        with self._renewed(name):
            self._synthesize(chart)
            self._load_panel()
            if part is Part.WHOLE:
                self._peers.cell.feed(name, self.work.channels.get(name, ""))
            self._run(name, part, chart, chosen)

    def _chosen(self, task: TaskProgress, part: Part) -> tuple[Chosen, ...]:
        """Return the parameters by which a task is tried that learning chose."""
        if part is Part.CLEAR:
            return ()
        seed = f"run {self.run}, {task.name}, attempt {task.attempts + 1}"
        return self.work.planner.choose(task.name, task.decisions, seed)

    def _await_server(self, task: TaskProgress) -> None:
        """Give the ability server that a task has lost a while to come back before the next try."""
        last = task.decisions[-1] if task.decisions else None
        if last is None or last.code != _SERVER_LOST or not last.ability:
            return
        self._say_doing(f"{task.name}: waiting for the server of {last.ability}")
        end = time.monotonic() + min(self.work.patience_s, _SERVER_PATIENCE_S)
        abilities = self._peers.tasks.abilities
        while not abilities.is_there(last.ability) and time.monotonic() < end:
            if self.state.stop or rospy.is_shutdown():
                return
            self._changed.clear()
            self._changed.wait(_SERVER_LOOK_S)

    def _run(self, name: str, part: Part, chart: Chart, chosen: tuple[Chosen, ...]) -> None:
        """Run a behavior of a task, and keep what it does."""
        # Clearing the hand belongs to the attempt before.
        attempt = self.state.tasks[name].attempts + (part is not Part.CLEAR)
        xml, begun_s = write_chart(chart), rospy.get_time()
        self._append(TaskBegun(name, attempt, part, chart.name, xml, begun_s, chosen))

        def keep(operation: Operation) -> None:
            self._append(OperationEnded(name, operation))
            self.work.planner.learn(name, operation)

        def is_to_stop() -> bool:
            state = self.state
            told = bool(state.stop) or name in state.skipped
            return told or self._lost_lease or self._is_overdue()

        outcome = self._peers.tasks.run(chart.name, keep, is_to_stop)
        if self._lost_lease:
            self._append(TaskElsewhere(name, "", AsLeft.RUNNING))
            return
        label = f"{name}-{attempt}-{part.value}"
        pictures = self._keep_pictures(label, self._pictures())
        placed = self._peers.cell.placed(name)
        path = self._peers.tasks.path()
        self._append(TaskEnded(name, outcome, rospy.get_time(), placed, path, pictures))

    def _pictures(self) -> tuple[Sight, ...]:
        """Return what abilities saw in the behavior that ended, and the cell as it is now."""
        after = self._peers.cell.picture("scene")
        return (*self._peers.tasks.sights(), Sight("scene", rospy.get_time(), after))

    def _settle(self, name: str) -> None:
        if not self._has(name):
            return
        self._peers.tasks.stop_all()
        self._load_panel()
        planned = self.work.planner.task(name, self.state.tasks[name].decisions)
        task = planned.decomposition.task
        connected = []
        try:
            for end in WireEnd:
                terminal = task.terminals[end]
                component = planned.component_of[terminal]
                short = terminal.removeprefix(f"{component}:")
                if self._peers.inspection.is_connected(name, end.letter, component, short):
                    connected.append(end.letter)
        except UnseenError as error:
            self._append(Settled(name, tuple(connected), 1, error.code, str(error)))
            return
        left = len(planned.left(connected))
        self._append(Settled(name, tuple(connected), left))

    def _decide(self, name: str) -> None:
        now_s = rospy.get_time()
        state, planner = self.state, self.work.planner
        task = state.tasks[name]
        possible = {Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.NEW_PART, Do.SET_ASIDE, Do.STOP}
        if state.waiting:
            possible.add(Do.REPLAN)
        if self.work.attended:
            possible.add(Do.ASK_OPERATOR)
        failure = failure_of(task, self.work.faults, now_s)
        if planner.has_other_method(name, task.decisions, failure.state_path):
            possible.add(Do.OTHER_METHOD)
        policy = planner.use_case.recovery
        bounds = planner.task(name, task.decisions).bounds(failure.state_path)
        unpromising = planner.experience.unpromising(
            failure.fault.name, possible, self._log.tried_responses()
        )
        faults = self.work.faults
        self._append(judged(state, name, faults, policy, possible, now_s, bounds, unpromising))

    def _ask(self, name: str) -> None:
        self._append(question_about(self.state, name, self.work.faults))

    def _wait(self) -> None:
        """Wait for a command or an answer; meanwhile look after other cells' tasks."""
        self._changed.clear()
        self._changed.wait(_LOOK_S)
        for name in self.state.in_stage(Stage.ELSEWHERE):
            claim = self.work.leases.claim(name)
            if claim.holding in (Holding.DONE, Holding.SET_ASIDE):
                self._append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
            elif claim.holding is not Holding.ELSEWHERE:
                self._append(TaskReturned(name, claim.cell))

    def _has(self, name: str) -> bool:
        """Tell whether this cell has a task; if another one has it, or has had it, keep that."""
        task = self.state.tasks[name]
        if name == self.state.current:
            if self.work.leases.renew(name):
                return True
            self._append(TaskElsewhere(name, "", AsLeft.RUNNING))
            return False
        claim = self.work.leases.claim(name)
        if claim.holding is Holding.MINE:
            return True
        if claim.holding is Holding.MINE_IN_DOUBT:
            is_known = task.stage is Stage.DOUBTFUL or (
                task.attempts > 0 and claim.cell == self.state.cell
            )
            if not is_known:
                self._append(TaskReturned(name, claim.cell))
            return is_known
        self._append(TaskElsewhere(name, claim.cell, _AS_LEFT[claim.holding]))
        return False

    @contextmanager
    def _renewed(self, name: str) -> Iterator[None]:
        """Renew the lease of a task again and again meanwhile."""
        over = threading.Event()
        self._lost_lease = False

        def renew() -> None:
            while not over.wait(self.work.leases.lease_s / 3):
                try:
                    self._lost_lease = not self.work.leases.renew(name)
                except LostError as error:
                    rospy.logwarn("the lease of %s cannot be renewed: %s", name, error)

        thread = threading.Thread(target=renew, name="lease", daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def _synthesize(self, chart: Chart) -> None:
        """Have the behavior of a chart made, unless it exists with the same content."""
        chart_file, _ = keep_chart(chart, self.work.charts)
        if not describes(chart.name, content_mark(chart)):
            self._peers.synthesizer.synthesize(str(chart_file), chart.name)

    def _load_panel(self) -> None:
        """Have the cell build the panel, unless it has: a cell that was started anew has not."""
        if self.work.panel is None or self._peers.cell.address() == self._loaded_at:
            return
        begun = any(task.attempts for task in self.state.tasks.values())
        self._peers.cell.load(self.work.panel, keep=self.work.keep_panel or begun)
        self._loaded_at = self._peers.cell.address()

    def _recover(self, because: str) -> None:
        """Wait for what was lost, and stop what runs; what it was doing is in doubt."""
        rospy.logwarn("run %d: %s", self.run, because)
        self._append(Interrupted(because))
        self._say_doing(f"waiting, since {because}")
        self._loaded_at = ""
        try:
            self._peers.wait(self.work.patience_s)
            self._peers.tasks.stop_all()
        except LostError as error:
            self._append(Blocked(str(error)))

    def _require_sense(self, event: Commanded) -> None:
        if event.task not in self.state.tasks:
            raise CellError(
                f"there is no task {event.task!r}; there are {', '.join(self.state.tasks)}"
            )
        stage = self.state.tasks[event.task].stage
        wanted = event.command is Command.RETRY
        if wanted and stage is not Stage.SET_ASIDE:
            raise CellError(f"{event.task} is {stage.value}; only what is set aside is tried again")
        if not wanted and (stage.is_lasting or stage in (Stage.ELSEWHERE, Stage.ASKING)):
            raise CellError(f"{event.task} is {stage.value}; it cannot be skipped")

    def _is_overdue(self) -> bool:
        limit_s = self.work.timeout_s
        return 0 < limit_s < rospy.get_time() - self._begun_s

    def _append(self, event: Event) -> None:
        with self._lock:
            self.state = self._log.append(self.run, event, self.state)
        self._changed.set()
        self._on_change()

    def _say_doing(self, text: str) -> None:
        self.doing = text
        self._on_change()
