"""A use case supervisor and a cell's cameras, with no cell behind them."""

import actionlib
import numpy as np
import rospy
from remodel_msgs import msg, srv
from sensor_msgs.msg import Image

from remodel_console.edge.jpeg import as_jpeg

WIRES = (
    ("W1", "Q1/1 to X3/2, BU, 1.5 mm2"),
    ("W2", "Q1/3 to X3/4, BU, 1.5 mm2"),
    ("W3", "K1/A1 to X1/1, RD, 1 mm2"),
    ("W4", "K1/A2 to X1/2, BK, 1 mm2"),
    ("W5", "K2/A1 to X1/3, RD, 1 mm2"),
    ("W6", "K2/A2 to X1/4, BK, 1 mm2"),
)


def picture(height, width, red, green, blue):
    """Return a picture of a board with some wires on it."""
    pixels = np.full((height, width, 3), 205, np.uint8)
    for place in range(40, width, 70):
        pixels[30:-30, place : place + 6] = (red, green, blue)
    pixels[height // 2 - 20 : height // 2 + 20, 20:-20] = (120, 125, 130)
    return Image(height=height, width=width, encoding="rgb8", step=3 * width, data=pixels.tobytes())


class FakeSupervisor:
    """Tells a state, and remembers what it is asked."""

    def __init__(self):
        """Be idle."""
        self.asked = []
        self.state = msg.UseCaseState(phase="idle", cell="cell 1")
        self._publisher = rospy.Publisher(
            "remodel/use_case/state", msg.UseCaseState, queue_size=1, latch=True
        )
        self._services = [
            rospy.Service(f"remodel/use_case/{name}", kind, self._take(name, kind))
            for name, kind in (
                ("pause", srv.CommandRun),
                ("resume", srv.CommandRun),
                ("stop", srv.CommandRun),
                ("skip", srv.CommandTask),
                ("retry", srv.CommandTask),
                ("answer", srv.AnswerQuestion),
            )
        ]
        self._action = actionlib.ActionServer(
            "remodel/run_use_case", msg.RunUseCaseAction, self._take_goal, auto_start=False
        )
        self._action.start()
        self.tell()

    def tell(self, **fields):
        """Publish the state with some fields changed."""
        for name, value in fields.items():
            setattr(self.state, name, value)
        self._publisher.publish(self.state)

    def _take(self, name, kind):
        def take(request):
            values = [getattr(request, slot) for slot in request.__slots__]
            self.asked.append((name, *values))
            if values == ["W9", "operator"]:
                return kind._response_class(False, "there is no task W9")
            if name in ("pause", "resume"):
                self.tell(phase="paused" if name == "pause" else "running")
            if name == "answer":
                self.tell(phase="running", question=msg.OperatorQuestion())
            if name == "stop":
                self.tell(phase="ended", message="stopped by an operator")
            return kind._response_class(True, "it will be done")

        return take

    def _take_goal(self, handle):
        goal = handle.get_goal()
        self.asked.append(("run", goal.order, goal.tasks, goal.again))
        if goal.order == "nowhere":
            handle.set_rejected(None, "there is no order 'nowhere'; there are: cabinet 7")
            return
        handle.set_accepted()
        self.run(goal.order)

    def run(self, order):
        """Tell a run that is half-way, and asks."""
        states = ("done", "done", "set_aside", "running", "waiting", "waiting")
        tasks = [
            msg.TaskState(
                name=name,
                description=description,
                state=state,
                attempts=(1, 2, 3, 1, 0, 0)[place],
                first_pass=place == 0,
                taken_s=(41.0, 78.0, 120.0, 12.0, 0, 0)[place],
                expected_s=(0, 0, 0, 30.0, 44.0, 44.0)[place],
            )
            for place, ((name, description), state) in enumerate(zip(WIRES, states, strict=True))
        ]
        levels = [
            msg.LevelState("use_case", order, "waits for the answer of a person", rospy.Time(1)),
            msg.LevelState("task", "W4", "has failed twice", rospy.Time(2)),
            msg.LevelState("behavior", "Connect W4", "", rospy.Time(2)),
            msg.LevelState("action", "InsertCable", "lowers the hand, 40 %", rospy.Time(3)),
        ]
        failures = [
            msg.FailureState(
                rospy.Time(1), "W2", "grasp_missed", 205, "PickCable",
                "nothing is between the fingers", "retry", "it has failed once",
            ),
            msg.FailureState(
                rospy.Time(2), "W3", "component_not_found", 101, "LocateGearboxComponent",
                "no camera sees the label of K1", "set_aside", "it has failed 3 times",
            ),
            msg.FailureState(
                rospy.Time(3), "W4", "insertion_jammed", 303, "InsertCable",
                "22 N at 6 mm of 14 mm", "ask_operator", "two new parts have jammed too",
            ),
        ]  # fmt: skip
        question = msg.OperatorQuestion(
            1,
            "W4",
            "The wire jams in K1/A2 at 6 mm of 14 mm. It was tried three times, with two parts.",
            ["retry", "fixed", "mark_done", "skip", "replan", "stop"],
        )
        self.tell(
            stamp=rospy.Time(251), started=rospy.Time(0, 1),
            phase="asking", order=order, use_case="switchgear", run=12, tasks=tasks, task="W4",
            levels=levels, failures=failures, question=question, interruptions=1,
        )  # fmt: skip


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
            text="22 N at 6 mm of 14 mm", picture=picture(240, 320, 170, 40, 30),
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
    """Serves the record of one run, a few entries at once."""

    AT_ONCE = 5

    def __init__(self):
        """Begin to serve."""
        self._entries = recorded_run()
        self._services = [
            rospy.Service("remodel/use_case/runs", srv.ListRuns, self._list),
            rospy.Service("remodel/use_case/record", srv.GetRun, self._get),
        ]

    def _list(self, _request):
        run = msg.RunSummary(
            run=12, order="cabinet 7", cell="cell 1", started=rospy.Time(1795200000), taken_s=16.0,
            ended=True, done=0, tasks=2,
        )  # fmt: skip
        return srv.ListRunsResponse(True, "", [run], ["cabinet 7", "cabinet 8"])

    def _get(self, request):
        if request.run != 12:
            return srv.GetRunResponse(False, f"there is no run {request.run}", [], 0)
        count = min(request.count or self.AT_ONCE, self.AT_ONCE)
        found = self._entries[request.first - 1 : request.first - 1 + count]
        if not request.with_pictures:
            found = [without_picture(one) for one in found]
        return srv.GetRunResponse(True, "", found, len(self._entries))


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
        """Tell whether somebody looks."""
        return all(publisher.get_num_connections() for publisher in self._looks.values())

    def look(self):
        """Publish what both cameras see."""
        self._looks["overhead"].publish(picture(480, 640, 20, 60, 170))
        self._looks["wrist"].publish(picture(480, 640, 170, 40, 30))

    def _take(self, request):
        return srv.TakePictureResponse(True, request.camera, picture(600, 1200, 40, 40, 40))
