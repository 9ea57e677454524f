"""A device whose world is a script: what the wrist feels at each tool pose. No physics, no ROS."""

import math
from dataclasses import dataclass, field

import numpy as np

from remodel_skills.belief_state import BeliefState, EndState, Feed, Grip
from remodel_skills.device import Device
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.observers import Observers
from remodel_skills.robot_context import RobotContext
from remodel_skills.traffic import Traffic
from remodel_work.camera import Lens, View
from remodel_work.cell.cell_design import CellDesign, Gripper, RobotDesign, Table, WristCamera
from remodel_work.geometry import Pose
from remodel_work.panel import Channel, Component, Panel, PanelTerminal, PanelWire, WireEnd
from remodel_work.robot.arm import PANDA_AT_ORIGIN, ToolPose

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
GRIP_M = 0.02  # from the tip to the tool centre


@dataclass
class ScriptedArm:
    """An arm that is where it was sent, and feels what the script says.

    Attributes:
        feels: how much resists a tool pose [N], along the opening's axis.
        tool: the tool pose.
        force: on the wrist, low-passed, (3,) [N].
        forces: of every step [N].
    """

    feels: object
    tool: ToolPose = HOME
    force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    forces: list = field(default_factory=list)
    hand_mass: float = 0.7
    _loop: object = None

    def go(self, tool):
        self.tool, self._loop = tool, None

    def go_joints(self, joints):
        self.go(PANDA_AT_ORIGIN.tool_of(joints))

    def press(self, loop):
        self._loop = loop

    def tick(self):
        for _ in range(STEPS):
            resists = self.feels(self.tool)
            felt = resists * SOCKET.rotation[:, 0]
            self.forces.append(resists)
            self.force = self.force + TICK_S / STEPS / SENSOR_S * (felt - self.force)
            if self._loop is not None:
                joints = self._loop.step(felt, TICK_S / STEPS)
                self.tool = PANDA_AT_ORIGIN.tool_of(joints)


@dataclass
class ScriptedGripper:
    """Fingers that stop so far apart, `stops_at`, when they close [m]."""

    gap: float = 0.003
    load: float = 30.0
    stops_at: float = 0.003

    def open_to(self, opening):
        self.gap = 2 * opening

    def close_on(self, thickness, slow_before):
        self.gap = self.stops_at


def before_the_opening(feels):
    """Return the context of a robot that holds end a of W1 in front of its opening, and its arm.

    `feels` returns what resists the tip at a depth in the opening [m], in newtons.
    """
    arm = ScriptedArm(lambda tool: feels(depth_of(tool)))
    robot = RobotDesign(
        "robot_1", PANDA_AT_ORIGIN, HOME, Gripper(30.0, 1.0), WristCamera("wrist", LENS), ""
    )
    overhead = View(LENS, Pose.level(0.5, 0.0, 1.0))
    cell = CellDesign(
        *("scripted", None, (robot,), overhead, overhead, Table(0.5, 0.0, 1.0, 1.0), None, (), ())
    )
    device = Device(arm, ScriptedGripper(), None, None, None, None, TICK_S)
    belief = BeliefState("robot_1", PANDA_AT_ORIGIN)
    robots, traffic = {}, Traffic(PARAMETERS.motion.robots_apart_m)
    robots["robot_1"] = context = RobotContext(
        *(device, cell, robot, PANEL, belief, robots, traffic, Observers()),
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
