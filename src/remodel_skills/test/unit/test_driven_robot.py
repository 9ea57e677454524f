"""What drivers publish is what skills read, and what skills command is what drivers take."""

import threading
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3, WrenchStamped
from refusals import refused
from remodel_msgs import srv
from scripted_device import PANEL
from sensor_msgs.msg import JointState

from remodel_skills.edge.robot_file import read_robot
from remodel_skills.ros import driven_cell, driven_robot
from remodel_skills.ros.driven_cell import DrivenFixture, DrivenMagazine
from remodel_skills.ros.driven_robot import DrivenArm, DrivenCamera, DrivenGripper, Inbox
from remodel_states.core.codes import Code
from remodel_vision.ros.image_message import image
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.panel import WireEnd

TICK_S = 1 / 120
HELD_N = 12.0


class Topics:
    """Topics without a master: what is published is kept, and messages are delivered at once."""

    def __init__(self):
        self.sent, self.callbacks = {}, {}

    def publisher(self, topic, kind, **_):
        kept = self.sent.setdefault(topic, [])
        return SimpleNamespace(publish=kept.append)

    def subscriber(self, topic, kind, callback, **_):
        self.callbacks.setdefault(topic, []).append(callback)
        return SimpleNamespace(unregister=lambda: self.callbacks[topic].remove(callback))

    def deliver(self, topic, message):
        for callback in list(self.callbacks[topic]):
            callback(message)


@pytest.fixture
def ros(monkeypatch):
    topics = Topics()
    monkeypatch.setattr(rospy, "Publisher", topics.publisher)
    monkeypatch.setattr(rospy, "Subscriber", topics.subscriber)
    return topics


def built(ros, name):
    """Return a robot of a shipped file that stands at its home: design, topics and arm."""
    cell = read_robot(name)
    design = cell.design.robots[0]
    topics = cell.robots[design.name]
    arm = DrivenArm(Inbox(), design, topics, TICK_S)
    ros.deliver(topics.joint_states, joints_at(topics, design, 5.0))
    deliver_fingers(ros, topics, 0.02)
    return design, topics, arm


def deliver_fingers(ros, topics, position, efforts=()):
    names = list(topics.fingers)
    fingers = JointState(name=names, position=[position] * 2, effort=list(efforts))
    ros.deliver(topics.fingers_topic, fingers)


def wrench(at_s, *force):
    message = WrenchStamped()
    message.header.stamp = rospy.Time.from_sec(at_s)
    message.wrench.force = Vector3(*force)
    return message


def test_the_force_is_that_of_the_wrist_on_the_hand_in_the_world(ros):
    _, topics, arm = built(ros, "franka_ros")
    # Franka reports what acts on the hand, whose z axis points down.
    ros.deliver(topics.wrench[0], wrench(1.0, 0.0, 0.0, 3.0))
    assert arm.force == pytest.approx([0.0, 0.0, 3.0], abs=1e-6)
    # One reading more is filtered: 4 of the 8 ms of its time constant have passed.
    ros.deliver(topics.wrench[0], wrench(1.004, 0.0, 0.0, 5.0))
    assert arm.force == pytest.approx([0.0, 0.0, 4.0], abs=1e-6)


def test_what_was_not_heard_of_is_named_with_its_topic(ros):
    _, topics, arm = built(ros, "franka_ros")
    assert arm.sensors.missing == ["/franka_state_controller/F_ext: geometry_msgs/WrenchStamped"]
    ros.deliver(topics.wrench[0], wrench(1.0, 0.0, 0.0, 0.0))
    assert arm.sensors.missing == []


def test_a_commanded_pose_is_in_the_frame_of_the_driver_and_due_after_a_tick_and_its_lead(ros):
    design, topics, arm = built(ros, "franka_ros")
    arm.go(design.home)
    (message,) = ros.sent[topics.motion[0]]
    assert message.header.frame_id == "panda_link0"
    assert message.header.stamp.to_sec() == pytest.approx(5.0 + 3 * TICK_S, abs=1e-6)
    position = message.pose.position
    at = design.arm.world_from_base.apply(np.array([position.x, position.y, position.z]))
    assert at == pytest.approx(design.home.position, abs=1e-6)
    # The hand points down: half a turn about x, then its yaw.
    assert (message.pose.orientation.z, message.pose.orientation.w) == pytest.approx((0, 0))


def test_joints_are_commanded_by_their_names(ros):
    design, topics, arm = built(ros, "ros_control_arm")
    arm.go(design.home)
    (message,) = ros.sent[topics.motion[0]]
    assert message.joint_names == list(topics.joints)
    assert message.points[0].positions == pytest.approx(design.arm.joints_for(design.home))
    assert message.points[0].time_from_start.to_sec() == pytest.approx(3 * TICK_S, abs=1e-6)


def test_a_push_takes_one_step_for_each_wrench_of_the_time_since_the_last(ros):
    design, topics, arm = built(ros, "ros_control_arm")
    steps = []
    joints = design.arm.joints_for(design.home)

    def step(force, time_step):
        steps.append((force[2], time_step))
        return joints

    ros.deliver(topics.wrench[0], wrench(1.0, 0.0, 0.0, 0.0))
    arm.press(SimpleNamespace(step=step))
    arm.control()
    assert steps == [], "nothing new was felt"
    ros.deliver(topics.wrench[0], wrench(1.002, 0.0, 0.0, 6.0))
    arm.control()
    arm.control()
    assert steps == [(pytest.approx(6.0), pytest.approx(0.002))], "not filtered"
    assert len(ros.sent[topics.motion[0]]) == 1
    arm.go_joints(joints)
    ros.deliver(topics.wrench[0], wrench(1.004, 0.0, 0.0, 6.0))
    arm.control()
    assert len(steps) == 1, "another command ends a push"


def test_fingers_close_fast_to_a_wire_and_slowly_onto_it(ros):
    design, topics, arm = built(ros, "ros_control_arm")
    gripper = DrivenGripper(arm, design, topics)
    gripper.close_on(0.003, 0.002)
    (message,) = ros.sent[topics.gripper[0]]
    near, closed = message.points
    assert near.positions == [pytest.approx(0.0025)] * 2
    assert closed.positions == [0.0, 0.0]
    slow_s = closed.time_from_start.to_sec() - near.time_from_start.to_sec()
    assert 0.0025 / slow_s < 0.02 < (0.02 - 0.0025) / near.time_from_start.to_sec()


def test_fingers_that_measure_no_force_hold_what_they_have_stopped_on(ros):
    design, topics, arm = built(ros, "ros_control_arm")
    gripper = DrivenGripper(arm, design, topics)
    gripper.close_on(0.003, 0.002)
    deliver_fingers(ros, topics, 0.0015)
    assert gripper.load == design.gripper.grip_force
    deliver_fingers(ros, topics, 0.0)
    assert gripper.load == 0.0
    deliver_fingers(ros, topics, 0.0015, efforts=[HELD_N, HELD_N + 1.0])
    assert gripper.load == HELD_N
    assert gripper.gap == pytest.approx(0.003)


def test_a_message_that_is_not_installed_is_named_with_its_package(ros, monkeypatch):
    design, topics, arm = built(ros, "franka_ros")
    monkeypatch.setattr(driven_robot, "get_message_class", lambda kind: None)
    with pytest.raises(AbilityError, match=r"control_msgs/.* is not installed; install .* control"):
        DrivenGripper(arm, design, topics)


def test_an_action_goal_closes_the_hand_with_its_grip_force(ros, monkeypatch):
    design, topics, arm = built(ros, "franka_ros")

    def goal():
        return SimpleNamespace(goal=SimpleNamespace(command=SimpleNamespace()))

    monkeypatch.setattr(driven_robot, "get_message_class", lambda kind: goal)
    DrivenGripper(arm, design, topics).close_on(0.003, 0.002)
    (message,) = ros.sent[topics.gripper[0]]
    assert message.goal.command.position == 0.0
    assert message.goal.command.max_effort == design.gripper.grip_force


class Arrivals(nullcontext):
    """An inbox whose messages come by a script: one whenever the cell waits."""

    def __init__(self, *script):
        super().__init__()
        self._script = list(script)

    def notify_all(self):
        return None

    def wait(self, _limit_s):
        self._script.pop(0)()

    def wait_for(self, condition, _limit_s):
        return bool(condition())


def joints_at(topics, design, stamp_s):
    state = JointState(name=list(topics.joints), position=design.arm.joints_for(design.home))
    state.header.stamp = rospy.Time.from_sec(stamp_s)
    return state


@pytest.fixture
def complete(monkeypatch):
    """Let any panel fit a cell, all of whose drivers' interfaces are there."""
    monkeypatch.setattr(driven_cell, "find_panel_problems", lambda design, panel: ())
    monkeypatch.setattr(driven_cell, "missing_interfaces", lambda *_: [])
    monkeypatch.setattr(driven_cell, "ros_graph", lambda: ())


@pytest.fixture
def cell(ros, complete, monkeypatch):
    """Return a cell, its arm at home, whose drivers publish what a test delivers."""
    topics = read_robot("ros_control_arm")
    design, robot = topics.design.robots[0], topics.robots["robot_1"]
    subscribe = ros.subscriber

    def heard(topic, kind, callback, **options):
        made = subscribe(topic, kind, callback, **options)
        if topic == robot.joint_states:
            ros.deliver(topic, joints_at(robot, design, 5.0))
            deliver_fingers(ros, robot, 0.02)
        if topic == robot.wrench[0]:
            ros.deliver(topic, wrench(5.0, 0.0, 0.0, 0.0))
        return made

    monkeypatch.setattr(rospy, "Subscriber", heard)
    return driven_cell.DrivenCell(topics, PANEL)


def joints_arrive(cell, ros, at_s):
    topics, design = cell._topics.robots["robot_1"], cell.design.robots[0]
    return lambda: ros.deliver(topics.joint_states, joints_at(topics, design, at_s))


def force_arrives(cell, ros, at_s):
    topic = cell._topics.robots["robot_1"].wrench[0]
    return lambda: ros.deliver(topic, wrench(at_s, 0.0, 0.0, 1.0))


def scripted(cell, *arrivals):
    """Let messages arrive, one whenever the cell waits; return its arm."""
    cell._inbox.arrived = Arrivals(*arrivals)
    return cell._arms["robot_1"]


def test_a_tick_is_over_when_the_joints_of_its_end_have_arrived(cell, ros):
    scripted(cell, *(joints_arrive(cell, ros, at_s) for at_s in (5.004, 5.0 + TICK_S, 9.0)))
    cell.tick()
    assert cell.clock.now_s == pytest.approx(5.0 + TICK_S, abs=1e-6)


def test_each_wrench_of_a_tick_is_answered_before_it_is_over(cell, ros):
    design, times = cell.design.robots[0], []
    forces = (force_arrives(cell, ros, at_s) for at_s in (5.004, 5.008))
    arm = scripted(cell, *forces, joints_arrive(cell, ros, 5.0 + TICK_S))
    joints = design.arm.joints_for(design.home)

    def step(_force, time_step):
        times.append(time_step)
        return joints

    arm.press(SimpleNamespace(step=step))
    cell.tick()
    assert times == [pytest.approx(0.004), pytest.approx(0.004)]


def test_a_push_that_feels_nothing_any_more_stops_and_a_person_is_asked(cell, ros):
    arm = scripted(cell, joints_arrive(cell, ros, 5.2))
    arm.press(SimpleNamespace(step=lambda force, time_step: pytest.fail("nothing was felt")))
    with refused(Code.MOTION_FAULT, "/wrist_ft_sensor has published no force"):
        cell.tick()


def test_an_arm_that_says_nothing_more_is_named(cell, monkeypatch):
    monkeypatch.setattr(driven_cell, "SILENCE_S", -1.0)
    scripted(cell, lambda: None)
    with refused(Code.MOTION_FAULT, "robot_1 has published no joint states"):
        cell.tick()


@pytest.mark.usefixtures("ros", "complete")
def test_drivers_that_are_silent_at_the_start_are_named(monkeypatch):
    monkeypatch.setattr(driven_cell, "START_S", 0.01)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    with pytest.raises(CellError) as error:
        driven_cell.DrivenCell(read_robot("ros_control_arm"), PANEL)
    assert "robot_1: /joint_states: joint lbr_iiwa_joint_1\n" in str(error.value)
    assert "robot_1: /wrist_ft_sensor: geometry_msgs/WrenchStamped\n" in str(error.value)


def test_an_arm_that_is_not_at_its_home_is_not_moved():
    robot = read_robot("ros_control_arm").design.robots[0]
    driven_cell.require_home(robot, robot.home.at(z=robot.home.z + 0.01))
    with pytest.raises(CellError, match=r"robot_1 stands at .*, 50 mm from its home, x 20, y -460"):
        driven_cell.require_home(robot, robot.home.at(z=robot.home.z + 0.05))


@pytest.fixture
def services(monkeypatch):
    """Return the requests that services got, and what they answer, by their names."""
    asked, answers = [], {}

    def proxy(name, _kind):
        def call(request):
            asked.append((name, request))
            answer = answers[name]
            if isinstance(answer, Exception):
                raise answer
            return answer

        return call

    monkeypatch.setattr(rospy, "wait_for_service", lambda name, timeout: None)
    monkeypatch.setattr(rospy, "ServiceProxy", proxy)
    return SimpleNamespace(asked=asked, answers=answers)


TOPICS = read_robot("simulated_panda")
TIP = Pose(Point(0.1, 0.2, 0.3), Quaternion(0.0, 0.0, 0.0, 1.0))


def test_a_clamp_reports_whether_it_met_the_end(services):
    services.answers[TOPICS.operate_clamp] = srv.OperateClampResponse(success=True, met=True)
    assert DrivenFixture(TOPICS).close_clamp("X1", "1") is True
    ((_, request),) = services.asked
    assert (request.component_id, request.terminal_id, request.close) == ("X1", "1", True)


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (srv.OperateClampResponse(message="the driver is worn"), "clamp: the driver is worn"),
        (rospy.ServiceException("broken pipe"), r"does not answer \(broken pipe\)"),
    ],
)
def test_a_clamp_that_was_not_closed_fails_the_ability_with_the_reason(services, answer, says):
    services.answers[TOPICS.operate_clamp] = answer
    with pytest.raises(AbilityError, match=says):
        DrivenFixture(TOPICS).close_clamp("X1", "1")


def test_a_service_that_never_answers_is_given_up(monkeypatch):
    ends = threading.Event()
    monkeypatch.setattr(rospy, "wait_for_service", lambda name, timeout: ends.wait(10.0))
    monkeypatch.setattr(driven_cell, "SERVICE_S", 0.01)
    with pytest.raises(AbilityError, match=r"nothing within 0.01 s; what it moves"):
        DrivenFixture(TOPICS).open_clamp("X1", "1")
    ends.set()


def test_a_panel_that_a_fixture_refuses_is_not_held(services):
    services.answers[TOPICS.load_panel] = srv.LoadPanelResponse(message="no board is in place")
    with pytest.raises(PanelError, match="no board is in place"):
        DrivenFixture(TOPICS).load(PANEL, keep=False)


def test_a_wire_is_at_hand_until_it_has_its_place_or_is_gone(services):
    present = srv.PresentWireResponse(success=True, tips=[TIP, TIP], direction=-1)
    present.fixed = [True, False]
    services.answers[TOPICS.present_wire] = present
    services.answers[TOPICS.operate_magazine] = srv.OperateMagazineResponse(success=True)
    opened = []
    magazine = DrivenMagazine(TOPICS, lambda: opened.append(True))
    shown = magazine.present("W1", "A")
    assert shown.direction == -1
    assert shown.tips[WireEnd.A].position == pytest.approx([0.1, 0.2, 0.3])
    assert magazine.is_at_hand("W1") and opened == [True]
    magazine.present("W2", "A")
    assert not magazine.is_at_hand("W1") and list(magazine.shapes()) == ["W1", "W2"]
    taken = magazine.take_up("W1", {})
    assert taken.fixed == {WireEnd.A}
    assert list(magazine.parked) == ["W2"]
    magazine.drop(np.zeros(3))
    assert list(magazine.shapes()) == ["W2"]


def test_each_interface_that_no_node_offers_is_listed():
    robot = TOPICS.robots["robot_1"]
    published = {robot.camera.image, TOPICS.overheads[0].image, TOPICS.overheads[0].depth}
    subscribed = {robot.motion[0], robot.gripper[0]}
    offered = {
        *(TOPICS.operate_clamp, TOPICS.load_panel),
        *(TOPICS.present_wire, TOPICS.operate_magazine),
    }
    assert driven_cell.missing_interfaces(TOPICS, published, subscribed, offered) == []
    assert driven_cell.missing_interfaces(
        TOPICS,
        published - {TOPICS.overheads[0].depth},
        subscribed - {robot.motion[0]},
        offered - {TOPICS.operate_clamp},
    ) == [
        "/overhead/depth/image_raw: no node publishes pictures",
        "/robot_1/equilibrium_pose: no node takes commands (geometry_msgs/PoseStamped)",
        "/fixture/operate_clamp: no such service",
    ]


def camera_of(ros, name, size):
    """Return a robot's wrist camera, whose driver answers a subscriber with a picture at once."""
    design, topics, arm = built(ros, name)
    subscribe = ros.subscriber

    def answered(topic, kind, callback, **options):
        made = subscribe(topic, kind, callback, **options)
        ros.deliver(topic, image(np.zeros((*size, 3), np.uint8), "wrist", rospy.Time.from_sec(6.0)))
        return made

    rospy.Subscriber = answered
    view = driven_robot.wrist_view(arm, design)
    return DrivenCamera(Inbox(), topics.camera, lambda: view), view, topics


def test_a_picture_is_seen_from_the_measured_hand(ros):
    camera, view, topics = camera_of(ros, "franka_ros", (480, 640))
    picture = camera.take()
    assert picture.view is view
    assert picture.rgb.shape == (480, 640, 3)
    assert ros.callbacks[topics.camera.image] == [], "nobody watches when no picture is taken"


def test_a_picture_of_another_size_than_the_lens_is_refused(ros):
    camera, _, _ = camera_of(ros, "franka_ros", (48, 64))
    with pytest.raises(AbilityError, match="64 x 48 px; the design of the cell has 640 x 480"):
        camera.take()


def test_a_camera_that_is_silent_is_named(ros, monkeypatch):
    _, topics, _ = built(ros, "franka_ros")
    monkeypatch.setattr(driven_robot, "PICTURE_S", 0.01)
    camera = DrivenCamera(Inbox(), topics.camera, lambda: None)
    with pytest.raises(AbilityError, match="no picture on /wrist/color/image_rect_color within"):
        camera.take()
