"""Place a wire without ROS, when nothing goes wrong."""

import math

from remodel_skills.abilities.extracting import ExtractGoal, extract_cable
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.abilities.lay_wire import LayGoal, lay_wire
from remodel_skills.abilities.picking import (
    DetectGoal,
    PickGoal,
    PlaceGoal,
    detect_cable,
    pick_cable,
    place_cable,
)
from remodel_skills.abilities.route_wire import RouteGoal, route_wire
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

ROBOT = "robot_1"
# In the channel, beyond end b's terminal.
BESIDE = Pose.level(0.50, 0.14, 0.028, math.pi / 2)


def do(cell, ability, goal):
    """Check a goal and run it."""
    goal.check(cell.context.panel, cell.context.belief, cell.context.parameters)
    return cell.run(ability(cell.context, goal))


def locate(cell, component, terminal):
    return do(cell, locate_gearbox_component, LocateGoal(component, terminal)).socket_pose


def insert(cell, wire, end, component, terminal, socket, force=8.0):
    goal = InsertGoal(
        robot_name=ROBOT,
        cable_id=wire,
        end=end,
        component_id=component,
        terminal_id=terminal,
        socket=socket,
        force_limit=force,
    )
    return do(cell, insert_cable, goal)


def fix(cell, wire, component, terminal, pull=10.0):
    return do(
        cell,
        fix_cable,
        FixGoal(
            robot_name=ROBOT,
            cable_id=wire,
            component_id=component,
            terminal_id=terminal,
            pull_test_force=pull,
        ),
    )


def extract(cell, wire, component, terminal, socket):
    return do(
        cell,
        extract_cable,
        ExtractGoal(
            robot_name=ROBOT,
            cable_id=wire,
            component_id=component,
            terminal_id=terminal,
            socket=socket,
        ),
    )


def carry(cell, wire, channel):
    """Pick end b and route it along the channel to beside its terminal."""
    do(cell, pick_cable, PickGoal(ROBOT, wire, WireEnd.B, 0.0))
    context = cell.context
    tool, direction = context.device.arm.tool, context.belief.feed.direction
    x = float(BOARD.position[0]) + context.panel.channel(channel).x
    target = context.panel.wire(wire).goes_to(WireEnd.B)
    y = float((BOARD @ context.panel.panel_from_socket(*target)).position[1])
    along = direction * math.pi / 2
    path = (
        Pose.level(tool.x, tool.y, 0.04, tool.yaw + context.belief.grip.flip),
        Pose.level(x, y + 0.03 * direction, 0.04, along),
    )
    do(cell, route_wire, RouteGoal(ROBOT, wire, path))


def lay_down(cell, wire, target=BESIDE):
    """Lay the end in the hand down; an empty `wire` means whatever it holds."""
    return do(cell, place_cable, PlaceGoal(ROBOT, wire, target))


def connect(cell, wire, end):
    """Locate an end's terminal, insert the end and fix it."""
    component, terminal = cell.context.panel.wire(wire).goes_to(end)
    insert(cell, wire, end, component, terminal=terminal, socket=locate(cell, component, terminal))
    fix(cell, wire, component, terminal)


def place(cell, wire, channel="A"):
    """Feed and place a whole wire."""
    cell.feed(wire, channel)
    do(cell, detect_cable, DetectGoal(wire))
    connect(cell, wire, WireEnd.A)
    carry(cell, wire, channel)
    connect(cell, wire, WireEnd.B)


def place_in_ducts(cell, wire, first, force=14.0, pull=5.0):
    """Feed and place a whole wire through ducts by two robots, as the use case cabinet does."""
    guide, holder = cell.contexts.values()
    ends = {end: cell.plant.panel.wire(wire).goes_to(end) for end in (first, first.other)}
    cell.feed(wire, "")
    do(cell, detect_cable, DetectGoal(wire))
    sockets = {end: locate(cell, *key) for end, key in ends.items()}
    cell.run(pick_cable(holder, PickGoal(holder.name, wire, first.other, 0.0)), holder.name)
    for robot, end in ((guide, first), (holder, first.other)):
        insertion = InsertGoal(robot.name, wire, end, *ends[end], sockets[end], force)
        cell.run(insert_cable(robot, insertion), robot.name)
        fixing = FixGoal(robot.name, wire, *ends[end], pull)
        cell.run(fix_cable(robot, fixing), robot.name)
        if end is first:
            laying = lay_wire(holder, guide, LayGoal(holder.name, guide.name, wire))
            cell.run(laying, holder.name, guide.name)
