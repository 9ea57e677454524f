"""The topology of a KBL harness: nodes, segments, clips, and the routes of wires through them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from lxml import etree

from remodel_production.core.imports.kbl_parts import placed_pose
from remodel_production.core.imports.kbl_tree import KblTree, children, shown, text_of
from remodel_production.core.imports.shared.assembly import unique_name
from remodel_production.core.imports.shared.assumptions import Assumptions
from remodel_production.core.imports.shared.units import number
from remodel_production.core.imports.shared.xml_tree import line_of, local_name
from remodel_production.core.production import Clip, Node, Segment
from remodel_production.errors import DesignError


class Topology:
    """Nodes, segments and clips; each has the name that the file calls it by."""

    def __init__(self, tree: KblTree, assumptions: Assumptions) -> None:
        """Read a container's topology.

        Raises:
            DesignError: if a segment has not two nodes.
        """
        self._tree = tree
        self._assumptions = assumptions
        self._node_names = _names(tree.all("Node"))
        self._segment_names = _names(tree.all("Segment"))
        self.nodes = tuple(
            Node(name, tree.position(node)) for node, name in self._node_names.items()
        )
        self._position = {node.name: node.position for node in self.nodes}
        self.segments = tuple(
            self._segment(element, name) for element, name in self._segment_names.items()
        )
        self._by_name = {segment.name: segment for segment in self.segments}
        self.clips = tuple(self._clips())

    def nodes_of(self) -> dict[etree._Element, list[str]]:
        """Return the nodes at which each component or cavity sits; a box may have several."""
        nodes: dict[etree._Element, list[str]] = {}
        for node, name in self._node_names.items():
            for key in ("Referenced_components", "Referenced_cavities"):
                for item in self._tree.referred(node, key):
                    nodes.setdefault(item, []).append(name)
        return nodes

    def segments_of(self, routing: etree._Element) -> list[Segment]:
        """Return the segments of a routing, in the file's order."""
        return [
            self._by_name[self._segment_names[element]]
            for element in self._tree.referred(routing, "Segments")
            if element in self._segment_names
        ]

    def _segment(self, element: etree._Element, name: str) -> Segment:
        ends = []
        for key in ("Start_node", "End_node"):
            nodes = [n for n in self._tree.referred(element, key) if n in self._node_names]
            if len(nodes) != 1:
                raise DesignError(
                    f"{line_of(element)}: {shown(element)} has {len(nodes)} nodes as {key}; one is "
                    "needed"
                )
            ends.append(self._node_names[nodes[0]])
        start, end = ends
        return Segment(name, start, end, self._length(element, name, start, end))

    def _length(self, element: etree._Element, name: str, start: str, end: str) -> float:
        for key in ("Physical_length", "Virtual_length"):
            length = self._tree.quantity(element, key)
            if length is not None and length > 0:
                return length
        p, q = self._position[start], self._position[end]
        length = math.dist(p, q) if p is not None and q is not None else 0.0
        self._assumptions.add(
            f"{line_of(element)}: length of segment {name} not given, {length:.3f} m taken"
        )
        return length

    def _clips(self) -> list[Clip]:
        clips: list[Clip] = []
        taken: set[str] = set()
        for element, segment in self._segment_names.items():
            for assignment in children(element, "Fixing_assignment"):
                for fixing in self._tree.referred(assignment, "Fixing"):
                    along = self._along(assignment, self._by_name[segment])
                    name = unique_name(_name(fixing), taken)
                    taken.add(name)
                    pose = placed_pose(self._tree, fixing)
                    position = None if pose is None else pose.position
                    clips.append(Clip(name, self._kind(fixing), segment, along, position=position))
        for node, node_name in self._node_names.items():
            for item in self._tree.referred(node, "Referenced_components"):
                if local_name(item).lower() == "fixing_occurrence":
                    name = unique_name(_name(item), taken)
                    taken.add(name)
                    position = self._position[node_name]
                    clips.append(Clip(name, self._kind(item), node=node_name, position=position))
        return clips

    def _along(self, assignment: etree._Element, segment: Segment) -> float:
        """Return the place on the segment; the absolute one is the more binding."""
        absolute = self._tree.quantity(assignment, "Absolute_location")
        if absolute is not None and segment.length_m > 0:
            return min(1.0, max(0.0, absolute / segment.length_m))
        text = text_of(assignment, "Location")
        along = number(text)
        if along is None or not 0 <= along <= 1:
            raise DesignError(
                f"{line_of(assignment)}: {shown(assignment)}: Location {text or 'not given'}; a "
                "number from 0 to 1 is needed"
            )
        return along

    def _kind(self, fixing: etree._Element) -> str:
        part = self._tree.part(fixing)
        if part is None:
            return ""
        return text_of(part, "Description") or text_of(part, "Fixing_type")


def ordered_route(
    segments: Sequence[Segment], a: Collection[str], b: Collection[str]
) -> tuple[Segment, ...] | str:
    """Return the segments as a route from a node of a to a node of b, or why they are none.

    Args:
        segments: in any order.
        a: nodes of the first end; if the route ends at none of them, it begins as the file has it.
        b: nodes of the second end.
    """
    names = [segment.name for segment in segments]
    double = next((name for name in names if names.count(name) > 1), "")
    if double:
        return f"it passes segment {double} twice"
    at: dict[str, list[Segment]] = {}
    for segment in segments:
        at.setdefault(segment.start, []).append(segment)
        at.setdefault(segment.end, []).append(segment)
    crossing = next((node for node, there in at.items() if len(there) > 2), "")
    if crossing:
        return f"{len(at[crossing])} of its segments meet at node {crossing}, so it branches"
    ends = [node for node, there in at.items() if len(there) == 1]
    if len(ends) != 2:
        kind = "they form a cycle" if not ends else f"they form {len(ends) // 2} separate routes"
        return f"its segments {', '.join(names[:8])} are no route: {kind}"
    # The first segment's end is found first: of equal directions, that of the file is taken.
    start = max(ends, key=lambda end: (end in a) + (ends[1 - ends.index(end)] in b))
    route: list[Segment] = []
    node = start
    while len(route) < len(segments):
        following = next((s for s in at[node] if not route or s is not route[-1]), None)
        if following is None:
            return f"its segments {', '.join(names[:8])} do not hang together"
        route.append(following)
        node = following.end if following.start == node else following.start
    return tuple(route)


def ends_of(route: Sequence[Segment]) -> tuple[str, str]:
    """Return the nodes at which a route begins and ends."""
    if len(route) == 1:
        return route[0].start, route[0].end
    first, last = route[0], route[-1]
    begins = first.end if first.start in (route[1].start, route[1].end) else first.start
    ends = last.end if last.start in (route[-2].start, route[-2].end) else last.start
    return begins, ends


def _names(elements: list[etree._Element]) -> dict[etree._Element, str]:
    """Return the elements' names, made unique."""
    names: dict[etree._Element, str] = {}
    taken: set[str] = set()
    for element in elements:
        name = unique_name(_name(element), taken)
        taken.add(name)
        names[element] = name
    return names


def _name(element: etree._Element) -> str:
    return text_of(element, "Id") or element.get("id") or line_of(element)
