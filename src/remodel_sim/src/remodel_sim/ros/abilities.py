"""The table of abilities: topic, action, how a goal message becomes a goal, and what does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from remodel_msgs import msg as messages

from remodel_sim.abilities.check_connection import check_connection
from remodel_sim.abilities.detect_cable import detect_cable
from remodel_sim.abilities.discard_cable import discard_cable
from remodel_sim.abilities.extract_cable import extract_cable
from remodel_sim.abilities.fix_cable import fix_cable
from remodel_sim.abilities.insert_cable import insert_cable
from remodel_sim.abilities.locate_gearbox_component import locate_gearbox_component
from remodel_sim.abilities.pick_cable import pick_cable
from remodel_sim.abilities.place_cable import place_cable
from remodel_sim.abilities.place_connector import place_connector
from remodel_sim.abilities.place_pin import place_pin
from remodel_sim.abilities.route_wire import route_wire
from remodel_sim.abilities.station import Steps
from remodel_sim.core import goals
from remodel_sim.core.discard_goal import DiscardGoal
from remodel_sim.core.pin_goal import PlacePinGoal
from remodel_sim.ros.conversions import pose_from


@dataclass(frozen=True)
class Ability:
    """One ability.

    Attributes:
        name: of the action, such as "InsertCable".
        parse: makes the goal of a goal message; raises AbilityError.
        perform: the steps that do it, by the robots' stations and the goal.
    """

    name: str
    parse: Callable[[Any], Any]
    perform: Callable[..., Steps[Any]]

    @property
    def topic(self) -> str:
        """The action's topic, as D5.1 writes it: lower case, run together."""
        return f"remodel_abilities/{self.name.lower()}"

    def message(self, kind: str) -> type:
        """Return a message class of the action: "Action", "Result" or "Feedback"."""
        return getattr(messages, self.name + kind)


ABILITIES = (
    Ability(
        "LocateGearboxComponent",
        lambda m: goals.LocateGoal(m.component_id, m.terminal_id, m.view),
        locate_gearbox_component,
    ),
    Ability(
        "CheckConnection",
        lambda m: goals.CheckGoal(
            m.cable_id, goals.parse_end(m.cable_end), m.component_id, m.terminal_id
        ),
        check_connection,
    ),
    Ability("DetectCable", lambda m: goals.DetectGoal(m.cable_id, m.view), detect_cable),
    Ability(
        "PickCable",
        lambda m: goals.PickGoal(
            m.robot_name, m.cable_id, goals.parse_end(m.cable_end), m.grasp_distance
        ),
        pick_cable,
    ),
    Ability(
        "PlaceCable",
        lambda m: goals.PlaceGoal(
            m.robot_name, m.cable_id, pose_from("target_pose", m.target_pose)
        ),
        place_cable,
    ),
    Ability(
        "DiscardCable",
        lambda m: DiscardGoal(m.robot_name, m.cable_id),
        discard_cable,
    ),
    Ability(
        "InsertCable",
        lambda m: goals.InsertGoal(
            m.robot_name,
            m.cable_id,
            goals.parse_end(m.cable_end),
            m.component_id,
            m.terminal_id,
            pose_from("socket_pose", m.socket_pose),
            m.force_limit,
        ),
        insert_cable,
    ),
    Ability(
        "PlaceConnector",
        lambda m: goals.ConnectGoal(
            m.robot_name,
            m.connector_id,
            m.cable_id,
            m.component_id,
            m.terminal_id,
            pose_from("socket_pose", m.socket_pose),
            m.force_limit,
        ),
        place_connector,
    ),
    Ability(
        "FixCable",
        lambda m: goals.FixGoal(
            m.robot_name, m.cable_id, m.component_id, m.terminal_id, m.pull_test_force
        ),
        fix_cable,
    ),
    Ability(
        "ExtractCable",
        lambda m: goals.ExtractGoal(
            m.robot_name,
            m.cable_id,
            m.component_id,
            m.terminal_id,
            pose_from("socket_pose", m.socket_pose),
        ),
        extract_cable,
    ),
    Ability(
        "PlacePin",
        lambda m: PlacePinGoal(
            m.robot_1_name,
            m.robot_2_name,
            m.path_space,
            m.connector_space,
            m.centered,
            m.rotate,
            m.show_in_TF,
        ),
        place_pin,
    ),
    Ability(
        "RouteWire",
        lambda m: goals.RouteGoal(
            m.robot_name,
            m.cable_id,
            tuple(pose_from(f"path[{i}]", p) for i, p in enumerate(m.path)),
        ),
        route_wire,
    ),
)
