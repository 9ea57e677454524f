"""The scene as RViz markers, for people: where components and wires really are."""

from __future__ import annotations

import time

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.sim_clock import SimClock
from remodel_states.core.wires.wire_colours import Rgb, rgbs_of
from remodel_work.component_shape import HOUSING
from remodel_work.geometry import WORLD
from remodel_work.panel import Component, PanelWire

# [s] How often the wire under way is published, by the clock of the people who watch: a cell that
# is faster than that must not be slowed down by showing more than they can see.
PERIOD_S = 0.05
# [s] of simulated time: how often everything is published at least.
WHOLE_PERIOD_S = 1.0


class Markers:
    """Publishes components as boxes and wires as lines."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock) -> None:
        """Advertise the topic."""
        self._plant = plant
        self._clock = clock
        self._published_s = self._whole_s = 0.0
        self._shown: object = None
        self._publisher = rospy.Publisher("cell/markers", MarkerArray, queue_size=2)

    def __call__(self) -> None:
        """Publish when it is time and there is a subscriber."""
        wall_s = time.monotonic()
        if wall_s - self._published_s < PERIOD_S:
            return
        self._published_s = wall_s
        viewers = self._publisher.get_num_connections()
        if not viewers:
            return
        plant = self._plant
        live = plant.live.wire.id if plant.live else ""
        shown = (viewers, live, id(plant.panel), frozenset(plant.parked))
        if shown == self._shown and self._clock.now_s - self._whole_s < WHOLE_PERIOD_S:
            if plant.live is not None:
                line = self._line(plant.live.wire, plant.live.cable.nodes())
                self._publisher.publish(MarkerArray([line]))
            return
        self._shown, self._whole_s = shown, self._clock.now_s
        markers = [Marker(action=Marker.DELETEALL)]
        markers += [self._box(component) for component in plant.panel.components]
        markers += [
            self._line(plant.panel.wire(wire_id), parked.nodes)
            for wire_id, parked in plant.parked.items()
        ]
        if plant.live is not None:
            markers.append(self._line(plant.live.wire, plant.live.cable.nodes()))
        self._publisher.publish(MarkerArray(markers))

    def _marker(self, namespace: str, name: str, kind: int, rgb: Rgb) -> Marker:
        marker = Marker(ns=f"{namespace}/{name}", type=kind, action=Marker.ADD)
        marker.header.frame_id, marker.header.stamp = WORLD, self._clock.now
        marker.pose.orientation.w = 1.0
        marker.color = ColorRGBA(*rgb, 1.0)
        return marker

    def _box(self, component: Component) -> Marker:
        marker = self._marker("component", component.id, Marker.CUBE, HOUSING)
        pose = self._plant.world_from_component(component.id)
        x, y, z = pose.position
        marker.pose = Pose(Point(x, y, z + component.size[2] / 2), Quaternion(*pose.quaternion))
        marker.scale = Vector3(*component.size)
        return marker

    def _line(self, wire: PanelWire, nodes: np.ndarray) -> Marker:
        marker = self._marker("wire", wire.id, Marker.LINE_STRIP, rgbs_of(wire.colour)[0])
        marker.scale.x = wire.diameter
        marker.points = [Point(*node) for node in nodes]
        return marker
