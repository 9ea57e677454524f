"""A device whose world is a script: what the wrist feels at each tool pose. No physics, no ROS."""

import itertools
import math
from dataclasses import dataclass, field
from functools import cache, partial
from types import MappingProxyType

import numpy as np
from drawn import boxes_of, picture

from remodel_skills.belief_state import BeliefState, EndState, Feed, Grip
from remodel_skills.device import Device
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.robot_context import Observers, RobotContext
from remodel_skills.space import Traffic
from remodel_work.camera import Lens, View
from remodel_work.cell.cell_design import (
    CellDesign,
    Gripper,
    RobotDesign,
    Table,
    WristCamera,
    find_panel_problems,
    held_panel,
)
from remodel_work.cell.presenting import plan_laying, plan_presentation
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import PanelError
from remodel_work.geometry import Pose
from remodel_work.panel import Channel, Component, Panel, PanelTerminal, PanelWire, WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, ToolPose
from remodel_work.robot.fingers import CAMERA_MOUNT
from remodel_work.routes import ParkedWire

PARAMETERS = read_parameters().parameters
TICK_S, STEPS = 1 / 120, 2
SENSOR_S = 0.008  # time constant of the wrist sensor's low pass [s]
HOME = ToolPose(0.30, 0.35, 0.30, 0.0)
LENS = Lens(640, 480, math.radians(60.0))
TERMINAL = PanelTerminal("1", (0.025, 0.0, 0.022), math.pi, 0.0038, 0.014, 0.0015, 80.0)
COMPONENT = Component("X1", "test", 1, 0.022, (0.08, 0.0, 0.0), (0.05, 0.045, 0.045), (TERMINAL,))
WIRE = PanelWire(
    *("W1", "X1", "1", "X1", "1", "BU", 1.5, 0.003, 0.5, 0.02, 1e-3, 0.012),
    *(0.8e-3, 0.5, 0.4, 8.0, 0.3),
)
PANEL = Panel(
    *("scripted", (0.4, 0.7, 0.003), (COMPONENT,), (Channel("A", 0.0, 0.11, -0.3, 0.3),)),
    wires=(WIRE,),
)
SOCKET = PANEL.world_from_panel @ PANEL.panel_from_socket("X1", "1")
GRIP_M = 0.03  # from the tip to the tool centre


@dataclass
class ScriptedArm:
    """An arm that is where it was sent, and feels what the script says.

    Attributes:
        feels: what resists a tool pose [N]: along the opening's axis, or a force (3,).
        tool: the tool pose.
        force: on the wrist, low-passed, (3,) [N].
        forces: of every step [N].
    """

    feels: object
    tool: ToolPose = HOME
    force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    forces: list = field(default_factory=list)
    hand_mass: float = 0.7
    kinematics: object = PANDA_AT_ORIGIN
    _loop: object = None

    def go(self, tool):
        self.tool, self._loop = tool, None

    def go_joints(self, joints):
        self.go(self.kinematics.tool_of(joints))

    def press(self, loop):
        self._loop = loop

    def tick(self):
        for _ in range(STEPS):
            resists = self.feels(self.tool)
            felt = resists * SOCKET.rotation[:, 0] if np.isscalar(resists) else resists
            self.forces.append(resists)
            self.force = self.force + TICK_S / STEPS / SENSOR_S * (felt - self.force)
            if self._loop is not None:
                joints = self._loop.step(felt, TICK_S / STEPS)
                self.tool = self.kinematics.tool_of(joints)


@dataclass
class ScriptedGripper:
    """Fingers that stop so far apart, `stops_at`, when they close on something [m].

    Attributes:
        opened: how far apart they were sent, or stopped [m].
        load: what each feels [N].
        between: returns how thick what is between them is, where they are [m].
    """

    opened: float = 0.003
    load: float = 30.0
    stops_at: float = 0.003
    between: object = lambda: 0.0

    @property
    def gap(self):
        return max(self.opened, self.between())

    def open_to(self, opening):
        self.opened = 2 * opening

    def close_on(self, thickness, slow_before):
        self.opened = self.stops_at


def before_the_opening(feels, panel=PANEL):
    """Return the context of a robot that holds end a of W1 in front of its opening, and its arm.

    `feels` returns what resists the tip at a depth in the opening [m], in newtons.
    """
    arm = ScriptedArm(lambda tool: feels(depth_of(tool)))
    robot = RobotDesign(
        "robot_1", PANDA_AT_ORIGIN, HOME, Gripper(30.0, 1.0), WristCamera("wrist", LENS), ""
    )
    overhead = View(LENS, Pose.level(0.5, 0.0, 1.0))
    table = Table(0.5, 0.0, 1.0, 1.0)
    cell = CellDesign("scripted", None, (robot,), (overhead,), overhead, table, None, (), ())
    device = Device(arm, ScriptedGripper(), None, None, None, None, TICK_S)
    belief = BeliefState("robot_1", PANDA_AT_ORIGIN)
    robots, traffic = {}, Traffic(PARAMETERS.motion.robots_apart_m)
    robots["robot_1"] = context = RobotContext(
        *(device, cell, robot, panel, belief, robots, traffic, Observers()),
        parameters=PARAMETERS,
    )
    belief.start_wire(Feed("W1", "A", 1), {})
    belief.ends[WireEnd.A] = EndState.LOOSE
    belief.grip = Grip(WireEnd.A, GRIP_M, 0.0, 0.0, HOME)
    return context, arm


def depth_of(tool):
    """Return how deep the tip of the held end is in the opening [m]."""
    yaw = tool.yaw
    tip = tool.position + GRIP_M * np.array([math.cos(yaw), math.sin(yaw), 0.0])
    return float(SOCKET.inverse().apply(tip)[0])


# One object for each panel: what is drawn of it is drawn once.
_held_panel = cache(held_panel)


class ScriptedPlant:
    """A whole cell without a world: arms are where they were sent, wires where they were put.

    Attributes:
        live: the wire that was fed last, by name; its nodes are those of its presentation.
        boxes: what cameras see of the board, each with its frame in the world.
        wires: that cameras see, each with its nodes (n, 3) [m].
        trace: of each robot, its tool pose and the gap between its fingers [m] at every tick.
    """

    tick_s = TICK_S

    def __init__(self, panel, design=None):
        self.design = design or read_cell()
        self.load(panel)

    def load(self, panel, placed=MappingProxyType({})):
        problems = self.find_problems(panel)
        if problems:
            raise PanelError(panel.name, problems)
        self.loaded, self.panel = panel, _held_panel(self.design, panel)
        self.parked, self.live = dict(placed), None
        self.wires, self._pictures = [], itertools.count()
        self.boxes = boxes_of(self.panel, labels=self.design.labels)
        self.arms = {
            robot.name: ScriptedArm(lambda tool: 0.0, robot.home, kinematics=robot.arm)
            for robot in self.design.robots
        }
        self.grippers = {name: ScriptedGripper(2 * PARAMETERS.tool.open_m) for name in self.arms}
        self.trace = {name: [] for name in self.arms}

    def find_problems(self, panel):
        return find_panel_problems(self.design, panel)

    def device_of(self, robot):
        design = next(each for each in self.design.robots if each.name == robot)
        wrist = ScriptedCamera(self, lambda: view_from(self.arms[robot], design.camera.lens))
        above = tuple(
            ScriptedCamera(self, partial(self.overhead, number))
            for number in range(len(self.design.overheads))
        )
        return Device(self.arms[robot], self.grippers[robot], wrist, above, None, self, TICK_S)

    def overhead(self, number):
        return self.design.overheads[number]

    def take(self, view):
        return picture(view, self.boxes, self.wires, seed=next(self._pictures))

    def feed(self, wire_id, channel_id, tools):
        wire = self.panel.wire(wire_id)
        self.parked.update(self.shapes())
        if self.design.magazine is None:
            channel, noise = self.panel.channel(channel_id), np.random.default_rng(0)
            laying = plan_laying(self.design.feeder, self.panel, wire, channel, 30, noise)
            presentation = laying.presentation(wire)
        else:
            presentation = plan_presentation(self.design.magazine, self.panel, wire)
        ends = [presentation.tips[end].position for end in WireEnd]
        self.live = wire_id, ParkedWire(np.array(ends), frozenset())
        return presentation

    def is_at_hand(self, wire_id):
        return self.live is not None and self.live[0] == wire_id

    def shapes(self):
        return {**self.parked, **dict([self.live] if self.live else [])}

    def park(self):
        self.parked, self.live = self.shapes(), None

    def tick(self):
        for name, arm in self.arms.items():
            arm.tick()
            self.trace[name].append((arm.tool, self.grippers[name].gap))

    def rest(self, seconds):
        pass

    def close(self):
        pass


@dataclass
class ScriptedCamera:
    """A camera that draws what its plant's script says."""

    plant: ScriptedPlant
    see_from: object

    @property
    def view(self):
        return self.see_from()

    def take(self):
        return self.plant.take(self.view)


def view_from(arm, lens):
    """Return what an arm's wrist camera sees from where its tool is."""
    tool, fingers = arm.tool, arm.kinematics.fingers
    hand = Pose.level(tool.x, tool.y, tool.z + fingers.tool_m, tool.yaw)
    upside_down = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    mount = Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))
    return View(lens, hand @ upside_down @ mount)
