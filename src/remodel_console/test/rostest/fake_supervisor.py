"""A use case supervisor and a cell's cameras, with no cell behind them.

The supervisor publishes by the planner's own code, so that the console is tested against that.
remodel_planner is not in package.xml: its tests depend on this package already.
"""

import threading

import actionlib
import numpy as np
import rospy
from remodel_msgs import msg, srv
from sensor_msgs.msg import Image

from remodel_console.edge.kept_files import as_jpeg
from remodel_run.progress import Answer, HandWire
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    Command,
    Commanded,
    Decided,
    Ending,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    Settled,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.state import FINISHED
from remodel_supervision.core.runs.sums import joined, statistics_of_run
from remodel_supervision.ros.server.state_publisher import (
    STATE,
    RunView,
    StatePublisher,
    sums_message,
)
from remodel_supervision.supervisors.ports import Doing
from remodel_tasks.core.use_case.fault import Do

WIRES = (
    ("W1", "Q1/1 to X3/2, BU, 1.5 mm2"),
    ("W2", "Q1/3 to X3/4, BU, 1.5 mm2"),
    ("W3", "K1/A1 to X1/1, RD, 1 mm2"),
    ("W4", "K1/A2 to X1/2, BK, 1 mm2"),
    ("W5", "K2/A1 to X1/3, RD, 1 mm2"),
    ("W6", "K2/A2 to X1/4, BK, 1 mm2"),
)


BY_HAND = tuple(
    HandWire(
        name, marker, "Q1/2", "X1/PE", "GNYE", section_mm2=16.0, length_m=0.482,
        reason="16 mm2 is thicker than the cell's 6 mm2",
    )
    for name, marker in (("W7", "PE1"), ("W8", ""))
)  # fmt: skip


def picture(height, width, red, green, blue):
    """Return a picture of a board with some wires on it."""
    pixels = np.full((height, width, 3), 205, np.uint8)
    for place in range(40, width, 70):
        pixels[30:-30, place : place + 6] = (red, green, blue)
    pixels[height // 2 - 20 : height // 2 + 20, 20:-20] = (120, 125, 130)
    return Image(height=height, width=width, encoding="rgb8", step=3 * width, data=pixels.tobytes())


EXPECTED_S = {"W4": 30.0}  # else 44
JAM = "22 N at 6 mm of 14 mm"


def attempt(task, number, took_s, *codes):
    """Return the events of an attempt that has ended; it fails if a code is given."""
    operations = [
        OperationEnded(
            task,
            Operation(
                "/Connect b/Insert",
                "InsertCable",
                outcome="x",
                error_code=code,
                text="",
                ended_s=float(code),
                elapsed_s=30.0,
                goal_id="",
                parameters=(("component_id", "K1"), ("terminal_id", "A1")),
                measurements=(),
            ),
        )
        for code in codes
    ]
    outcome = "failed" if codes else FINISHED
    begun = TaskBegun(task, number, part=Part.WHOLE, behavior=f"Connect {task}", chart="", at_s=0.0)
    return [begun, *operations, TaskEnded(task, outcome, took_s, not codes)]


def decided(task, fault, code, ability, text, do, because):
    """Return a decision about a task."""
    return Decided(
        task,
        fault,
        code=code,
        ability=ability,
        state_path="",
        text=text,
        do=do,
        change=(),
        because=because,
        by="policy",
        at_s=1.0,
    )


def half_way(order):
    """Return the events of a run whose fourth of six tasks is under way."""
    return [
        RunBegun(
            order, "cabinet", "cell 1", tuple(name for name, _ in WIRES), serial="SN-0042",
            by_hand=BY_HAND,
        ),
        Planned(tuple(name for name, _ in WIRES), "the run begins"),
        *attempt("W1", 1, 41.0),
        *attempt("W2", 1, 37.0, 205),
        decided(
            "W2", "grasp_missed", code=205, ability="PickCable",
            text="nothing is between the fingers", do=Do.RETRY, because="it has failed once",
        ),
        *attempt("W2", 2, 41.0),
        Interrupted("the engine was lost"),
        *attempt("W3", 1, 40.0, 101),
        *attempt("W3", 2, 40.0, 101),
        *attempt("W3", 3, 40.0, 101),
        decided(
            "W3", "component_not_found", code=101, ability="LocateGearboxComponent",
            text="no camera sees the label of K1", do=Do.SET_ASIDE, because="it has failed 3 times",
        ),
        TaskBegun("W4", 1, part=Part.WHOLE, behavior="Connect W4", chart="", at_s=0.0),
    ]  # fmt: skip


class FakeSupervisor:
    """Publishes a run as the planner does, and remembers what it is asked; it has no cell.

    Attributes:
        asked: names and values of the requests, the latest last.
        standstill: cleared while the fake cell moves; a pause is answered when it is set.
    """

    def __init__(self):
        """Be idle."""
        self.asked = []
        self.standstill = threading.Event()
        self.standstill.set()
        self.publisher = StatePublisher()
        self._is_new, self._closed, self._is_gone = True, "", False
        self.state = None
        self._fields = {}
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._services = [
            rospy.Service(f"remodel/use_case/{name}", kind, self._take(name, kind))
            for name, kind in (
                ("pause", srv.CommandRun),
                ("resume", srv.CommandRun),
                ("stop", srv.CommandRun),
                ("protective_stop", srv.CommandRun),
                ("release", srv.CommandRun),
                ("skip", srv.CommandTask),
                ("retry", srv.CommandTask),
                ("answer", srv.AnswerQuestion),
            )
        ]
        self._action = actionlib.ActionServer(
            "remodel/run_use_case", msg.RunUseCaseAction, self._take_goal, auto_start=False
        )
        self._action.start()
        threading.Thread(target=self._publish, daemon=True).start()

    def close(self, why):
        """Take no order, because of this; an empty text: take one."""
        self._closed, self._is_new = why, True
        self._changed.set()

    def add(self, *events, **fields):
        """Let events happen, and have fields of the view changed."""
        with self._lock:
            self.state = state_after(events, self.state)
            self._fields |= fields
        self._changed.set()

    def run(self, order):
        """Publish a run that is half-way."""
        self.state = None
        self.add(
            *half_way(order),
            run=12,
            doing="W4: placing a new wire",
            doing_now=Doing("InsertCable", "lowers the hand", 40.0, 3.0),
            started=rospy.Time.now() - rospy.Duration(240),
        )

    def leave(self):
        """Be gone, as a process that was killed."""
        with self._lock:
            self._is_gone = True
            self.publisher._state.unregister()

    def come_back(self):
        """Publish the run again."""
        with self._lock:
            topic = rospy.Publisher(STATE, msg.UseCaseState, latch=True, queue_size=1)
            self.publisher._state = topic
            self._is_gone = False
        self.add(Interrupted("the supervisor was restarted"))

    def restart(self):
        """Begin again without what was published, as a process does that resumes a run."""
        self._is_new = True
        self.add(Interrupted("the supervisor was restarted"))

    def ask(self):
        """Ask about the task under way."""
        text = f"The wire jams in K1/A2: {JAM}. It was tried three times, with two parts."
        cause = ("insertion_jammed", 303, "InsertCable", JAM)
        self.add(
            *attempt("W4", 1, 12.0, 303)[1:],
            decided("W4", *cause, Do.ASK_OPERATOR, "two new parts have jammed too"),
            Asked(
                1, "W4", text=text, choices=tuple(Answer), at_s=rospy.get_time(), timeout_s=600.0
            ),
            doing_now=None,
        )

    def _publish(self):
        """Publish as the run server does: from one thread, each change and at idle."""
        while not rospy.is_shutdown():
            with self._lock:
                view = self._view() if self.state else None
                is_new, self._is_new = self._is_new, False
            if self._is_gone:
                self._changed.wait(0.1)
                continue
            if is_new:
                self.publisher.idle("cell 1", self._closed, starting=bool(self._closed))
            if view:
                self.publisher.publish(view)
            self._changed.wait(max(0.01, self.publisher.flush()))
            self._changed.clear()

    def _view(self):
        return RunView(
            state=self.state,
            state_path="/Connect b/Insert",
            expected_s=lambda name: EXPECTED_S.get(name, 44.0),
            descriptions=dict(WIRES),
            **self._fields,
        )

    def _take(self, name, kind):
        def take(request):
            values = [getattr(request, slot) for slot in request.__slots__]
            self.asked.append((name, *values))
            if kind is srv.CommandTask and request.task not in self.state.tasks:
                return kind._response_class(False, f"there is no task {request.task}")
            getattr(self, f"_on_{name}")(request)
            return kind._response_class(True, "")

        return take

    def _on_pause(self, request):
        self.add(Commanded(Command.PAUSE, "", request.by), moving=True)
        self.standstill.wait(60.0)
        self.add(moving=False)

    def _on_resume(self, request):
        self.add(Commanded(Command.RESUME, "", request.by))

    def _on_stop(self, _request):
        self.add(RunEnded(Ending.STOPPED, "stopped by an operator"))

    def _on_protective_stop(self, request):
        self.add(Commanded(Command.PROTECTIVE_STOP, "", request.by))

    def _on_release(self, request):
        self.add(Commanded(Command.RELEASE, "", request.by), controllers=())

    def _on_skip(self, request):
        self.add(Commanded(Command.SKIP, request.task, request.by))

    def _on_retry(self, request):
        self.add(Commanded(Command.RETRY, request.task, request.by))

    def _on_answer(self, request):
        answered = Answered(request.question, Answer(request.choice), request.by)
        again = TaskBegun("W4", 2, part=Part.AGAIN, behavior="Connect W4", chart="", at_s=0.0)
        self.add(answered, Settled("W4", (), 3), again)

    def _take_goal(self, handle):
        goal = handle.get_goal()
        self.asked.append(("run", goal.order, goal.tasks, goal.again))
        if goal.order == "nowhere":
            handle.set_rejected(None, "there is no order 'nowhere'; there are: cabinet 7")
            return
        handle.set_accepted()
        self.run(goal.order)


START_S = 1000.0  # ROS time at which the recorded run begins


def entry(time_s, kind, **fields):
    """Return an entry of a record; `picture` is an image."""
    picture = fields.pop("picture", None)
    made = msg.RunEntry(stamp=rospy.Time.from_sec(START_S + time_s), kind=kind, **fields)
    if picture is not None:
        made.has_picture = True
        made.picture.format = "jpeg"
        size = (picture.height, picture.width, picture.step)
        made.picture.data = as_jpeg(picture.data, *size, picture.encoding)
    return made


def recorded_run():
    """Return the record of a run of two tasks, one of which fails at first."""
    entries = [
        entry(0, "run", text="order cabinet 7 begins"),
        entry(1, "task", task="W1", text="running, attempt 1"),
    ]
    for start_s, path in ((2, "/Greet"), (4, "/Search/Look"), (9, "/Search/Look closer")):
        entries.append(
            entry(start_s, "state", task="W1", behavior="Errand", state_path=path),
        )
        for step in range(4):
            entries.append(
                entry(
                    start_s + 0.4 * step, "feedback", task="W1", ability="InsertCable",
                    text="pushes the end in", names=["completed_percentage", "force_n"],
                    values=[25.0 * step, 2.0 + start_s * step / 2],
                )
            )  # fmt: skip
    entries += [
        entry(
            12, "failure", task="W1", fault="insertion_jammed", error_code=303,
            text="22 N at 6 mm of 14 mm", picture=picture(240, 320, 170, 40, blue=30),
        ),
        entry(12.1, "decision", task="W1", text="replan", because="two new parts have jammed"),
        entry(13, "task", task="W2", text="running, attempt 1"),
        entry(14, "state", task="W2", behavior="Errand", state_path="/Report"),
        entry(15, "operator", task="W2", text="skips W2", because="Ada"),
        entry(16, "run", text="ended: 0 of 2 tasks done"),
    ]  # fmt: skip
    for position, one in enumerate(entries, start=1):
        one.position = position
    return entries


class FakeRecords:
    """Serves the records of two runs, a few entries at once; the second has no failure."""

    AT_ONCE = 5

    def __init__(self, start_s=START_S):
        """Begin to serve the record of a run that began at a ROS time [s]."""
        self.listed = 0
        self._entries = {12: recorded_run(), 13: without_failure(recorded_run())}
        for entries in self._entries.values():
            for one in entries:
                one.stamp += rospy.Duration(start_s - START_S)
        self._services = [
            rospy.Service("remodel/use_case/runs", srv.ListRuns, self._list),
            rospy.Service("remodel/use_case/record", srv.GetRun, self._get),
            rospy.Service("remodel/use_case/statistics", srv.GetStatistics, self._statistics),
        ]

    def _list(self, _request):
        self.listed += 1
        runs = [
            msg.RunSummary(
                run=run, order="cabinet 7", cell="cell 1", started=rospy.Time(1795200000),
                ended=True, sums=msg.RunSums(tasks=2, interrupted=1, open=1, taken_s=16.0),
            )
            for run in self._entries
        ]  # fmt: skip
        return srv.ListRunsResponse(True, "", runs, ["cabinet 7", "cabinet 8"])

    def _statistics(self, request):
        """Answer by the supervisor's own code, of two runs whose fourth task is under way."""
        orders = {12: "cabinet 7", 13: "cabinet 8"}
        runs = [
            statistics_of_run(run, state_after(events), events)
            for run, order in orders.items()
            if request.order in ("", order)
            for events in (half_way(order),)
        ]
        found = joined(runs)
        runs, yields = zip(*found.yields, strict=True)
        utilisations = [share for _, share in found.utilisations]
        parts = (found.terminals, found.wires)
        columns = [column for part in parts for column in zip(*part, strict=True)]
        sums = [sums_message(each) for _, each in found.sums]
        return srv.GetStatisticsResponse(True, "", runs, sums, yields, utilisations, *columns)

    def _get(self, request):
        if request.run not in self._entries:
            return srv.GetRunResponse(False, f"there is no run {request.run}", [], 0)
        count = min(request.count or self.AT_ONCE, self.AT_ONCE)
        entries = self._entries[request.run]
        found = entries[request.first - 1 : request.first - 1 + count]
        if not request.with_pictures:
            found = [without_picture(one) for one in found]
        return srv.GetRunResponse(True, "", found, len(entries))


def without_failure(entries):
    """Return the record of a run in which nothing failed."""
    kept = [one for one in entries if one.kind not in ("failure", "decision")]
    for position, one in enumerate(kept, start=1):
        one.position = position
    return kept


def without_picture(entry_):
    """Return an entry that only says that it has a picture."""
    fields = {name: getattr(entry_, name) for name in entry_.__slots__ if name != "picture"}
    return msg.RunEntry(**fields)


class FakeCameras:
    """Publishes a look, and renders the scene when it is asked."""

    def __init__(self):
        """Advertise what a cell does."""
        self._looks = {
            camera: rospy.Publisher(f"cell/{camera}/image_raw", Image, queue_size=1)
            for camera in ("overhead", "wrist")
        }
        self._service = rospy.Service("cell/take_picture", srv.TakePicture, self._take)

    def is_followed(self):
        """Return whether a page subscribes."""
        return all(publisher.get_num_connections() for publisher in self._looks.values())

    def look(self):
        """Publish what both cameras see."""
        self._looks["overhead"].publish(picture(480, 640, 20, 60, blue=170))
        self._looks["wrist"].publish(picture(480, 640, 170, 40, blue=30))

    def _take(self, request):
        return srv.TakePictureResponse(True, request.camera, picture(600, 1200, 40, 40, blue=40))
