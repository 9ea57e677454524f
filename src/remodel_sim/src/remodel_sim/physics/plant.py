"""The physical cell.

Everything that has mass, light or force. Abilities reach it only through the robot context.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from remodel_sim.core.faults import Disturbances, FaultError, Stray, check_fault
from remodel_sim.core.wire_mechanics import discretise
from remodel_sim.physics.fixtures.clamps import Socket, close_clamp
from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.live_wire import LiveWire, bent_cable, lay, present
from remodel_sim.physics.robot import Robot, SimulatedArm, SimulatedCamera, SimulatedGripper
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.wires.parked_wire import add_solid, draw_parked
from remodel_sim.physics.world import (
    CONTACT_DAMPING,
    CONTACT_STIFFNESS,
    World,
    photograph,
    take_picture,
)
from remodel_skills.device import Device, PlacedEnds
from remodel_states.core.codes import Code
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import CellDesign, WristCamera, find_panel_problems, held_panel
from remodel_work.cell.presenting import Presentation
from remodel_work.component_shape import Box
from remodel_work.edge.bullet import add_static
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError, PanelError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Channel, Connector, Panel, PanelTerminal, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import ParkedWire, TerminalKey

FILM_WIDTH_PX = 640
# Commands to the arms and checks of their sensors [1/s].
TICK_HZ = 120.0
# A piece of cable that was left behind, and how far above the plate it falls from.
STRAY_LENGTH_M = 0.12
STRAY_DROP_M = 0.02
STRAY_COLOUR = "GY"
# A parked wire that is handled again comes to rest in this time [s].
REVIVED_S = 0.3
# A wire that a hand drops over a scrap bin is so near to the hand [m].
OVER_BIN_M = 0.06
# Where the fork and the magazine's clips are out of everything's way [m].
DRAWN_IN_M = -0.1
# The table ends so far beyond the magazine: loops hang in the gap between it and the robot [m].
TABLE_EDGE_M = 0.030
PLUG_RGB = (0.5, 0.1, 0.1)
# A plug begins this deep in the opening.
PLUG_FROM_M = 0.005


# Called when time has passed, with how much [s].
OnTime = Callable[[float], None]


# Called with a wire of the panel; returns the piece of it that is really delivered.
Delivered = Callable[[PanelWire], PanelWire]


def _ignore(_: float) -> None:
    """Take no notice of the time."""


def _as_stated(wire: PanelWire) -> PanelWire:
    """Deliver a wire as the panel has it."""
    return wire


class SimulatedPlant:
    """The world of one cell. Everything random follows from the seed and the order of requests.

    Attributes:
        design: of the cell.
        loaded: the panel that was asked for.
        panel: what was built of it, with the cell's own fixtures; components may since have been
            moved.
        robots: by name.
        tick_s, steps_per_tick: time between two commands to an arm [s], in steps of the physics.
        on_time: is called when time has passed, with how much [s].
        live: the wire that was fed last, until it is parked.
        parked: the wires that have been parked.
    """

    def __init__(
        self,
        panel: Panel,
        *,
        design: CellDesign | None = None,
        seed: int = 0,
        rate_hz: float = 240.0,
        gui: bool = False,
    ) -> None:
        """Build a cell, one Panda unless a design is given; raises PanelError."""
        self.design = design or read_cell()
        self.seed = seed
        self.on_time: OnTime = _ignore
        self.world = World(rate_hz, gui=gui)
        self.steps_per_tick = max(1, round(1.0 / (TICK_HZ * self.world.time_step)))
        self.tick_s = self.steps_per_tick * self.world.time_step
        self.load(panel)

    def load(self, panel: Panel, placed: Mapping[str, ParkedWire] = MappingProxyType({})) -> None:
        """Build a panel, with the wires that lie on it.

        Raises PanelError and changes nothing when it breaks the rules.
        """
        design = self.design
        problems = self.find_problems(panel)
        if problems:
            raise PanelError(panel.name, problems)
        self.loaded, self.panel = panel, held_panel(design, panel)
        self.live: LiveWire | None = None
        self.parked = dict(placed)
        self._noise = np.random.default_rng(self.seed)
        self._world_from_panel = board = self.panel.world_from_panel
        self._poses = {c.id: board @ c.panel_from_component for c in panel.components}
        self._blocked: set[tuple[str, str]] = set()
        self._disturbances = Disturbances()
        self._delivered: Delivered = _as_stated
        self._build({robot.name: robot.home for robot in design.robots})

    def differ(
        self,
        disturbances: Disturbances,
        components: Mapping[str, tuple[float, float, float]],
        delivered: Delivered,
    ) -> None:
        """Differ from the model that skills have, until a panel is built.

        Args:
            disturbances: of pads, light, cameras and force sensors.
            components: by how much each is beside its place, dx, dy, dyaw [m, rad].
            delivered: makes the wires that are fed differ from the panel's.
        """
        self._disturbances, self._delivered = disturbances, delivered
        self._weaken_hand()
        for component_id, shift in components.items():
            self.move_component(component_id, *shift)

    def find_problems(self, panel: Panel) -> tuple[str, ...]:
        """Return why a panel cannot be built, one sentence each; none: it can."""
        return find_panel_problems(self.design, panel)

    def _build(self, tools: Mapping[str, ToolPose]) -> None:
        """Build the world from what the plant knows, without a live wire.

        `tools` has where each robot stands.

        It is done for every wire: Bullet keeps traces of removed bodies, and a run would depend on
        where they lay in memory.
        """
        self.world.clear()
        self._fork: int | None = None
        self._magazine_clips: dict[WireEnd, tuple[int, ...]] = {}
        magazine = self.design.magazine
        edge = None if magazine is None else magazine.x + TABLE_EDGE_M
        self._scene = PanelScene(
            self.world,
            self.design.table,
            self.panel,
            self._poses,
            edge,
            world_from_panel=self._world_from_panel,
            labels=self.design.labels,
        )
        self._plugs: dict[tuple[str, str], int] = {}
        for component_id, terminal_id in sorted(self._blocked):
            self._add_plug(component_id, terminal_id)
        for wire_id, parked in self.parked.items():
            self._add_parked(self.panel.wire(wire_id), parked)
        self.robots = {
            robot.name: Robot(
                self.world, tools[robot.name], robot.arm, robot.gripper, (self.seed, place)
            )
            for place, robot in enumerate(self.design.robots)
        }
        self._weaken_hand()
        self._strays: list[SimulatedWire] = []
        for stray in self._disturbances.strays:
            self._add_stray(stray)

    def step(self) -> None:
        """Advance by one time step."""
        self.world.step()

    def tick(self) -> None:
        """Advance by one tick of the skills."""
        for _ in range(self.steps_per_tick):
            self.step()
        self.on_time(self.tick_s)

    def rest(self, seconds: float) -> None:
        """Let an arm that was stopped, and the wire in its hand, come to rest for a time [s]."""
        for _ in range(round(seconds / self.world.time_step)):
            self.step()
            self.on_time(self.world.time_step)

    def device_of(self, robot: str) -> Device:
        """Return a robot as a device."""
        design = next(design for design in self.design.robots if design.name == robot)
        return Device(
            arm=SimulatedArm(self, design),
            gripper=SimulatedGripper(self, robot),
            wrist_camera=SimulatedCamera(
                lambda: self.wrist_view(robot), lambda: self.take_wrist_picture(robot)
            ),
            overhead_cameras=tuple(
                SimulatedCamera(
                    partial(self._overhead_view, number),
                    partial(self.take_overhead_picture, number),
                )
                for number in range(len(self.design.overheads))
            ),
            fixture=self,
            magazine=self,
            tick_s=self.tick_s,
        )

    def shapes(self) -> dict[str, ParkedWire]:
        """Return the wires that lie in the cell, the live one among them, by name."""
        live = {} if self.live is None else {self.live.wire.id: self.live.shape}
        return {**self.parked, **live}

    def close(self) -> None:
        """Leave PyBullet."""
        self.world.close()

    def feed(self, wire_id: str, channel_id: str, tools: Mapping[str, ToolPose]) -> Presentation:
        """Present a wire of which no piece is in the cell; the wire before is parked.

        The feeder lays it into a channel; a cell with a magazine presents it there, and has no use
        for a channel. Each robot starts from where it was sent last, `tools`, with open fingers.
        """
        wire, magazine = self._delivered(self.panel.wire(wire_id)), self.design.magazine
        self._keep_shape()
        self._build(tools)
        if magazine is None:
            cable, presentation = self._lay(wire, channel_id)
        else:
            cable, presentation, self._magazine_clips = present(
                self.world, magazine, self.panel, wire, self._noise
            )
        self.live = LiveWire(wire, cable)
        self._let_rest()
        self.live.watch(self.world, self._headers, self._springs())
        return presentation

    def _lay(self, wire: PanelWire, channel_id: str) -> tuple[SimulatedWire, Presentation]:
        assert self.design.feeder is not None, "a cell has a feeder or a magazine"
        cable, laying, self._fork = lay(
            self.world,
            self.design.feeder,
            self.panel,
            wire,
            channel=self.panel.channel(channel_id),
            above=self._top_in(self.panel.channel(channel_id)),
            noise=self._noise,
        )
        return cable, laying.presentation(wire)

    def _top_in(self, channel: Channel) -> float:
        """Return how high parked wires reach in a channel [m]; 0 where none lies."""
        tops = [0.0]
        for wire_id, parked in self.parked.items():
            x, y, _ = self.panel.world_from_panel.inverse().apply(parked.nodes).T
            inside = abs(x - channel.x) <= channel.width / 2
            inside &= (y >= channel.y_min) & (y <= channel.y_max)
            radius = self.panel.wire(wire_id).radius
            tops += [float(z) + radius for z in parked.nodes[inside, 2]]
        return max(tops)

    def is_at_hand(self, wire_id: str) -> bool:
        """Return whether a wire is the live one."""
        return self.live is not None and self.live.wire.id == wire_id

    def take_up(self, wire_id: str, tools: Mapping[str, ToolPose]) -> PlacedEnds:
        """Make a parked wire live again, held where it was; the live wire is parked.

        Each robot starts from where it was sent last, `tools`, with open fingers. Raises
        WIRE_NOT_FED, and nothing changes, when no such wire lies in the cell.
        """
        if wire_id not in self.shapes():
            raise AbilityError(
                Code.WIRE_NOT_FED,
                f"no piece of wire {wire_id!r} lies in the cell; there are: "
                f"{', '.join(self.shapes()) or 'none'}; feed it",
            )
        self._keep_shape()
        parked = self.parked.pop(wire_id)
        self._build(tools)
        wire = self._delivered(self.panel.wire(wire_id))
        self.live = LiveWire(wire, bent_cable(self.world, wire, parked.nodes))
        self.live.watch(self.world, self._headers, self._springs())
        for latch in self.live.latches:
            latch.hold()
        for end in sorted(parked.fixed - self.live.fixed, key=lambda end: end.value):
            self.close_clamp(*self._terminal_at(self.live.cable.tip(end)[0]))
        for _ in range(round(REVIVED_S / self.world.time_step)):
            self.step()
        self._let_rest()
        expected = {
            end: np.array([*parked.nodes[node, :2], wire.radius])
            for end, node in ((WireEnd.A, 0), (WireEnd.B, -1))
        }
        return PlacedEnds(expected, parked.fixed)

    def _let_rest(self) -> None:
        """Let parts of the live wire rest that no robot and no stray piece of wire is near to."""
        assert self.live is not None
        self.live.cable.let_rest(self._moving_boxes)

    def _moving_boxes(self) -> tuple[Array, Array]:
        """Return the lower and upper corners of boxes around all that moves, each (n, 3) [m]."""
        boxes = [thing.boxes() for thing in (*self.robots.values(), *self._strays)]
        return np.vstack([lower for lower, _ in boxes]), np.vstack([upper for _, upper in boxes])

    def _wake(self) -> None:
        """Wake the live wire: what it lies in, or what holds it, changes."""
        if self.live is not None:
            self.live.cable.wake()

    def _terminal_at(self, tip: Array) -> TerminalKey:
        """Return the terminal that a tip (3,) [m] sits in."""

        def away(key: TerminalKey) -> float:
            return float(np.linalg.norm(self.world_from_socket(*key).position - tip))

        keys = [(c.id, terminal.id) for c in self.panel.components for terminal in c.terminals]
        return min(keys, key=away)

    def drop(self, over_bin: Array) -> None:
        """Let the live wire fall if it is where a hand opens over a bin (3,) [m]: it is gone."""
        if self.live is None:
            return
        if np.linalg.norm(self.live.cable.nodes() - over_bin, axis=1).min() <= OVER_BIN_M:
            self.live.remove()
            self.live = None

    def _headers(self, connector: Connector) -> list[Socket]:
        """Return the headers that a connector fits into."""
        return self._sockets(connector.fits)

    def _springs(self) -> list[Socket]:
        """Return the terminals that hold an end as it enters."""
        return self._sockets(lambda terminal: terminal.closes_itself)

    def _sockets(self, is_wanted: Callable[[PanelTerminal], bool]) -> list[Socket]:
        return [
            Socket(
                terminal,
                self._scene.body_of(component.id),
                partial(self.world_from_socket, component.id, terminal.id),
            )
            for component in self.panel.components
            for terminal in component.terminals
            if is_wanted(terminal)
        ]

    def move_fork(self, x: float, y: float) -> None:
        """Bring the feeder's fork up somewhere else, world frame [m]."""
        self._put_fork(x, y, 0.0)

    def lower_fork(self) -> None:
        """Draw the feeder's fork in under the plate."""
        self._put_fork(0.0, 0.0, DRAWN_IN_M)

    def open_magazine(self, end: WireEnd) -> None:
        """Draw in the magazine's clips that hold an end: a short wire's loop would hang on them."""
        self._wake()
        bullet = self.world.bullet
        for clip in self._magazine_clips.pop(end, ()):
            (x, y, z), quaternion = bullet.getBasePositionAndOrientation(clip)
            bullet.resetBasePositionAndOrientation(clip, [x, y, z + DRAWN_IN_M], quaternion)

    def _put_fork(self, x: float, y: float, z: float) -> None:
        if self._fork is not None:
            self._wake()
            place = self.world.bullet.resetBasePositionAndOrientation
            place(self._fork, [x, y, z], [0, 0, 0, 1])

    def park(self) -> None:
        """Freeze the live wire where it is."""
        if self.live is None:
            return
        live = self.live
        self._keep_shape()
        self._add_parked(live.wire, self.parked[live.wire.id])
        live.remove()

    def _add_parked(self, wire: PanelWire, parked: ParkedWire) -> None:
        draw_parked(self.world, parked.nodes, wire)
        add_solid(self.world, parked.nodes, wire)

    def _keep_shape(self) -> None:
        if self.live is not None:
            self.parked[self.live.wire.id] = self.live.shape
            self.live = None

    def close_clamp(self, component_id: str, terminal_id: str) -> bool:
        """Close a terminal's clamp; returns whether it met something before its bottom."""
        if self.live is None:
            return False
        self._wake()
        terminal = self.panel.component(component_id).terminal(terminal_id)
        socket = self.world_from_socket(component_id, terminal_id)
        housing = self._scene.body_of(component_id)
        clamp = close_clamp(
            self.world, self.live.cable, terminal, housing, world_from_socket=socket
        )
        if clamp is None:
            return False
        tips = {end: self.live.cable.tip(end)[0] for end in WireEnd}
        end = min(tips, key=lambda e: float(np.linalg.norm(tips[e] - socket.position)))
        self.live.clamps[end] = clamp
        return True

    def open_clamp(self, component_id: str, terminal_id: str) -> None:
        """Open a terminal's clamp."""
        if self.live is None:
            return
        self._wake()
        socket = self.world_from_socket(component_id, terminal_id)
        for end, clamp in list(self.live.clamps.items()):
            tip = self.live.cable.tip(end)[0]
            if np.linalg.norm(tip - socket.position) < 0.03:
                clamp.open()
                del self.live.clamps[end]

    def world_from_socket(self, component_id: str, terminal_id: str) -> Pose:
        """Return where an opening really is."""
        terminal = self.panel.component(component_id).terminal(terminal_id)
        return self._poses[component_id] @ terminal.component_from_socket

    def world_from_component(self, component_id: str) -> Pose:
        """Return where a component really stands."""
        return self._poses[component_id]

    def move_panel(self, dx: float, dy: float, dyaw: float) -> None:
        """Put a panel without wires somewhere else, with all that is mounted; world frame [m, rad].

        The robots are at home.
        """
        moved = self.panel.world_from_panel @ Pose.level(dx, dy, 0.0, dyaw)
        change = moved @ self._world_from_panel.inverse()
        self._world_from_panel = moved
        self._poses = {name: change @ pose for name, pose in self._poses.items()}
        self._build({name: robot.tool for name, robot in self.robots.items()})

    def move_component(self, component_id: str, dx: float, dy: float, dyaw: float) -> None:
        """Shift a component on the plate, with any plugs in it; panel frame [m, rad]."""
        self.panel.component(component_id)
        self._wake()
        x, y, z = self._poses[component_id].position
        moved = Pose.level(x + dx, y + dy, z, self._poses[component_id].yaw + dyaw)
        self._poses[component_id] = moved
        self._scene.place_component(component_id, moved)
        for key in [key for key in self._plugs if key[0] == component_id]:
            self.world.bullet.removeBody(self._plugs.pop(key))
            self._add_plug(*key)

    def disturb(self, kind: str, target: str, values: Sequence[float]) -> None:
        """Cause a fault; raises FaultError or, for an unknown name, AbilityError."""
        check_fault(kind, target, values)
        component, _, terminal = target.partition("/")
        causes: dict[str, Callable[[], None]] = {
            "component_moved": lambda: self.move_component(target, *values),
            "socket_blocked": lambda: self.block_socket(component, terminal),
            "socket_cleared": lambda: self.clear_socket(component, terminal),
            "friction_lowered": lambda: self._disturb(friction=values[0]),
            "grip_weakened": lambda: self._disturb(grip=values[0]),
            "camera_bumped": lambda: self._bump_camera(target, values),
            "light_changed": lambda: self._disturb(light=values[0]),
            "tip_bent": lambda: self._bend_tip(WireEnd(target), values[0]),
            "cable_in_the_way": lambda: self._drop_cable(target, *values),
        }
        if kind not in causes:
            raise FaultError(f"{kind} is a fault of the node: cell/inject_fault causes it")
        causes[kind]()

    def _disturb(self, **changes: object) -> None:
        self._disturbances = replace(self._disturbances, **changes)
        self._weaken_hand()

    def _weaken_hand(self) -> None:
        for robot in self.robots.values():
            robot.weaken(self._disturbances.friction, self._disturbances.grip)
            robot.force_noise = self._disturbances.force_noise

    def _bump_camera(self, camera: str, values: Sequence[float]) -> None:
        there_are = [name for name in self.views if name != "scene"]
        if camera not in there_are:
            raise FaultError(f"no camera {camera!r}; there are: {', '.join(there_are)}")
        *shift, turn = values
        pose = Pose.level(*shift, turn)
        self._disturb(shifts={**self._disturbances.shifts, camera: pose})

    def _bend_tip(self, end: WireEnd, angle: float) -> None:
        if self.live is None:
            raise FaultError("no wire is live; feed one first")
        self.live.cable.bend_ferrule(end, angle)

    def _drop_cable(self, channel_id: str, y: float, yaw: float) -> None:
        channel = self.panel.channel(channel_id)
        stray = Stray(channel.x, y, math.pi / 2 + yaw)
        self._disturb(strays=(*self._disturbances.strays, stray))
        self._add_stray(stray)

    def _add_stray(self, stray: Stray) -> None:
        """Let a piece of the panel's first wire fall onto what lies there."""
        wire = replace(self.panel.wires[0], length=STRAY_LENGTH_M, colour=STRAY_COLOUR)
        cable = SimulatedWire(self.world, discretise(wire, self.world.time_step), wire.colour)
        middle = self.panel.world_from_panel @ Pose.level(stray.x, stray.y, STRAY_DROP_M, stray.yaw)
        tip = middle.apply(np.array([-STRAY_LENGTH_M / 2, 0.0, 0.0]))
        cable.lay(tip, middle.yaw, np.zeros(len(cable.model.spans)))
        self._strays.append(cable)

    def block_socket(self, component_id: str, terminal_id: str) -> None:
        """Push a plug into an opening, of a header the first; the first millimetres stay free."""
        self.panel.component(component_id).terminal(terminal_id)
        if (component_id, terminal_id) not in self._blocked:
            self._blocked.add((component_id, terminal_id))
            self._wake()
            self._add_plug(component_id, terminal_id)

    def clear_socket(self, component_id: str, terminal_id: str) -> None:
        """Take the plug out of an opening."""
        self.panel.component(component_id).terminal(terminal_id)
        if (component_id, terminal_id) in self._blocked:
            self._blocked.remove((component_id, terminal_id))
            self._wake()
            self.world.bullet.removeBody(self._plugs.pop((component_id, terminal_id)))

    def _add_plug(self, component_id: str, terminal_id: str) -> None:
        terminal = self.panel.component(component_id).terminal(terminal_id)
        length = terminal.depth - PLUG_FROM_M
        size = (length, terminal.bore, terminal.bore)
        plug = Box((PLUG_FROM_M + length / 2, 0, 0), size, PLUG_RGB)
        first_bore = Pose.level(0.0, terminal.offsets[0], 0.0)
        pose = self.world_from_socket(component_id, terminal_id) @ first_bore
        body = add_static(self.world.bullet, [plug], pose)
        # It yields like the housing; a rigid one would stop the hand's mass within a step.
        self.world.bullet.changeDynamics(
            body, -1, contactStiffness=CONTACT_STIFFNESS, contactDamping=CONTACT_DAMPING
        )
        self._plugs[component_id, terminal_id] = body

    def take_overhead_picture(self, number: int = 0) -> Picture:
        """Take a colour and depth picture from above, by one of the overhead cameras."""
        name = self.design.overhead_names[number]
        return self._take_picture(name, self._overhead_view(number), depth=True)

    def _overhead_view(self, number: int) -> View:
        return self.design.overheads[number]

    def take_wrist_picture(self, robot: str) -> Picture:
        """Take a picture from a robot's hand, with depth if its camera measures it."""
        camera = self._camera(robot)
        return self._take_picture(camera.name, self.wrist_view(robot), depth=camera.depth)

    def _camera(self, robot: str) -> WristCamera:
        return next(design.camera for design in self.design.robots if design.name == robot)

    def _take_picture(self, camera: str, believed: View, *, depth: bool) -> Picture:
        shift = self._disturbances.shifts.get(camera)
        seen_from = None if shift is None else believed.world_from_camera @ shift
        return take_picture(
            self.world,
            believed,
            self._noise,
            depth=depth,
            light=self._disturbances.light,
            seen_from=seen_from,
        )

    def wrist_view(self, robot: str) -> View:
        """Return where a robot's wrist camera is."""
        return View(self._camera(robot).lens, self.robots[robot].world_from_camera)

    @property
    def views(self) -> dict[str, View]:
        """Where all cameras are, by name: above the plate, scene, and the wrists'."""
        wrists = {robot.camera.name: self.wrist_view(robot.name) for robot in self.design.robots}
        above = dict(zip(self.design.overhead_names, self.design.overheads, strict=True))
        return {**above, "scene": self.design.scene, **wrists}

    def photograph(self, camera: str) -> Picture:
        """Take a clean picture for people."""
        return photograph(self.world, self.views[camera])

    def film(self, camera: str) -> npt.NDArray[np.uint8]:
        """Take a small clean picture at once, (height, width, 3): for a film."""
        view = self.views[camera]
        height = round(FILM_WIDTH_PX * view.lens.height / view.lens.width)
        lens = replace(view.lens, width=FILM_WIDTH_PX, height=height)
        small = View(lens, view.world_from_camera)
        return photograph(self.world, small, shadow=False).rgb
