"""The elements, topology and parts of a KBL harness; a VEC container shares them.

Names are compared without namespace, case and `_`: containers of different makers differ in the
first two, and VEC writes StartNode where KBL writes Start_node.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache

from lxml import etree

from remodel_production.core.imports.assembly import unique_name
from remodel_production.core.imports.design_format import (
    Asked,
    Composite,
    ModuleChoice,
    VariantCondition,
)
from remodel_production.core.imports.documents import line_of, local_name, parse_xml
from remodel_production.core.imports.values import Assumptions, LeftOut, names_splice, number
from remodel_production.core.production import Clip, Node, Pose, Segment, Vector
from remodel_production.errors import DesignError

_ASSEMBLY = "assembly_part"
_PREFIXES = {"milli": 1e-3, "centi": 1e-2, "deci": 0.1, "micro": 1e-6, "kilo": 1e3, "": 1.0}
# Units that are named, instead of built of SI ones.
_NAMED_M = {"millimetre": 1e-3, "millimeter": 1e-3, "mm": 1e-3, "metre": 1.0, "meter": 1.0, "m": 1}
_MM = 1e-3  # coordinates have no unit; the recommendation's drawings are in mm


class KblTree:
    """A container, indexed."""

    def __init__(self, text: bytes, root: str = "KBL_container") -> None:
        """Read a container whose root element has a name.

        Raises:
            DesignError: if it is no such container, or an id stands for two elements.
        """
        self.root = parse_xml(text)
        if _key(local_name(self.root)) != _key(root):
            raise DesignError(
                f"the root element is <{local_name(self.root)}>; a <{root}> is needed"
            )
        self._by_id: dict[str, etree._Element] = {}
        self._by_name: dict[str, list[etree._Element]] = {}
        inside = {e for part in children(self.root, _ASSEMBLY) for e in part.iter()}
        for element in self.root.iter():
            if element not in inside:
                self._by_name.setdefault(_key(local_name(element)), []).append(element)
            key = element.get("id")
            if key is None or element is self.root:
                continue
            if key in self._by_id:
                before = self._by_id[key]
                raise DesignError(
                    f"{line_of(element)}: id {key} of a <{local_name(element)}> is there before, "
                    f"at {line_of(before)} of a <{local_name(before)}>; an id stands for one "
                    "element: give one of them another id"
                )
            self._by_id[key] = element

    def all(self, *names: str) -> list[etree._Element]:
        """Return all elements of these names, name by name, but those of assembly parts.

        What an assembly part is made of, its parts list repeats, and the harness has again.
        """
        return [element for name in names for element in self._by_name.get(_key(name), [])]

    def referred(self, element: etree._Element, name: str) -> list[etree._Element]:
        """Return the elements to which a child's ids refer; none if there is no such child.

        Raises:
            DesignError: if an id stands for nothing.
        """
        found = []
        for child in children(element, name):
            for key in (child.text or "").split():
                if key not in self._by_id:
                    raise DesignError(
                        f"{line_of(child)}: {local_name(child)} of {shown(element)} refers to "
                        f"{key}, and no element has that id"
                    )
                found.append(self._by_id[key])
        return found

    def part(self, occurrence: etree._Element) -> etree._Element | None:
        """Return the part that an occurrence is one of; None if it does not say."""
        return next(iter(self.referred(occurrence, "Part")), None)

    def quantity(self, element: etree._Element, name: str, power: int = 1) -> float | None:
        """Return a child's numerical value [m^power]; None if it has none, or no known unit."""
        for child in children(element, name):
            value = number(text_of(child, "Value_component"))
            units = self.referred(child, "Unit_component")
            scale = _scale(units[0], power) if units else _MM**power
            if value is not None and scale is not None:
                return round(value * scale, 9)
        return None

    def position(self, element: etree._Element) -> Vector | None:
        """Return the place [m] of what has a Cartesian point; None if it has none."""
        for point in self.referred(element, "Cartesian_point"):
            values = [number(child.text or "") for child in children(point, "Coordinates")]
            known = [value for value in values if value is not None]
            if len(known) == len(values) and len(values) in (2, 3):
                x, y, z = (round(value * _MM, 9) for value in (*known, 0.0)[:3])
                return x, y, z
            raise DesignError(
                f"{line_of(point)}: {shown(point)}: two or three numbers are needed as Coordinates"
            )
        return None


def children(element: etree._Element, name: str) -> Iterator[etree._Element]:
    """Yield the children of that name."""
    wanted = _key(name)
    for child in element:
        if _key(local_name(child)) == wanted:
            yield child


@cache
def _key(name: str) -> str:
    return name.lower().replace("_", "")


def text_of(element: etree._Element, name: str) -> str:
    """Return a child's text; empty if there is none or it is the format's null."""
    for child in children(element, name):
        text = " ".join((child.text or "").split())
        return "" if text in ("/NULL", "-") else text
    return ""


def shown(element: etree._Element) -> str:
    """Return an element as an error names it."""
    name = text_of(element, "Id") or element.get("id", "")
    return f"{local_name(element)} {name}".strip()


def unit_scale(unit: etree._Element | None) -> float | None:
    """Return how many metres a unit is, a millimetre if none is given; None if none of length."""
    return _MM if unit is None else _scale(unit, 1)


def _scale(unit: etree._Element, power: int) -> float | None:
    """Return how many m^power the unit is; None if it is none of length."""
    named = text_of(unit, "Unit_name").lower()
    base = text_of(unit, "Si_unit_name").lower()
    if base in ("metre", "meter"):
        prefix = _PREFIXES.get(text_of(unit, "Si_prefix").lower())
        return None if prefix is None else prefix**power
    named = named.removeprefix("square").removesuffix("2").removesuffix("²").strip(" _-")
    return _NAMED_M[named] ** power if named in _NAMED_M else None


def placed_pose(tree: KblTree, occurrence: etree._Element) -> Pose | None:
    """Return where an occurrence is placed; None if it does not say."""
    for placement in children(occurrence, "Placement"):
        position = tree.position(placement)
        if position is not None:
            return Pose(position, _orientation(_vector(placement, "U"), _vector(placement, "V")))
    return None


def _vector(placement: etree._Element, key: str) -> Vector | None:
    values = [number(child.text or "") for child in children(placement, key)]
    known = [value for value in values if value is not None]
    if len(known) != 3 or not any(known):
        return None
    x, y, z = known
    return x, y, z


def _orientation(u: Vector | None, v: Vector | None) -> tuple[float, float, float, float]:
    """Return the quaternion of a frame by its x axis and (about) its y axis; identity by default.

    Shepperd's method, by the largest of trace and diagonal (J. Guidance and Control 1(3), 1978).
    """
    if u is None or v is None:
        return 0.0, 0.0, 0.0, 1.0
    x = _unit(u)
    z = _cross(x, v)
    if not any(abs(value) > 1e-9 for value in z):
        return 0.0, 0.0, 0.0, 1.0
    z = _unit(z)
    y = _cross(z, x)
    m = tuple(zip(x, y, z, strict=True))  # rows of the matrix with the axes as columns
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0:
        s = 2 * math.sqrt(trace + 1)
        q = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
        return q[0] / s, q[1] / s, q[2] / s, s / 4
    i = max(range(3), key=lambda n: m[n][n])
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(max(0.0, 1 + m[i][i] - m[j][j] - m[k][k]))
    parts = [0.0, 0.0, 0.0]
    parts[i], parts[j], parts[k] = s / 4, (m[j][i] + m[i][j]) / s, (m[k][i] + m[i][k]) / s
    return parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) / s


def _unit(vector: Vector) -> Vector:
    norm = math.sqrt(sum(value * value for value in vector))
    return vector[0] / norm, vector[1] / norm, vector[2] / norm


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def kbl_modules(tree: KblTree, asked: Asked) -> ModuleChoice:
    """Return the choice of modules, by their part numbers or those of configurations of them.

    Raises:
        DesignError: if the harness has no such module, configuration or code.
    """
    modules = {module: _module(tree, module) for module in tree.all("Module")}
    composites = {text_of(element, "Part_number"): each for element, each in modules.items()}
    for configuration in tree.all("Harness_configuration"):
        inside = [modules[m] for m in tree.referred(configuration, "Modules") if m in modules]
        parts = frozenset[etree._Element]().union(*(module.parts for module in inside))
        composites.setdefault(text_of(configuration, "Part_number"), Composite(parts, False))
    return ModuleChoice(composites, {}, asked)


def _module(tree: KblTree, module: etree._Element) -> Composite:
    configurations = list(children(module, "Module_configuration"))
    controlled = [
        part
        for configuration in configurations
        for part in tree.referred(configuration, "Controlled_components")
    ]
    # A connection or a wiring group among them stands for its wires.
    wires = [
        wire
        for part in controlled
        for key in ("Wire", "Assigned_wire")
        for wire in tree.referred(part, key)
    ]
    parts = frozenset([*controlled, *wires])
    return Composite(parts, True, next(_conditions(configurations), None))


def _conditions(configurations: list[etree._Element]) -> Iterator[VariantCondition]:
    """Yield the conditions of codes; the information may also be a list of modules."""
    for configuration in configurations:
        text = text_of(configuration, "Logistic_control_information")
        if text and "module" not in text_of(configuration, "Configuration_type").lower():
            yield VariantCondition(text, line_of(configuration))


# What the elements are called, and why the order has nothing of those that are not referred to.
_PARTS = {
    "Cavity_seal_occurrence": ("cavity seal", "no contact point refers to it"),
    "Cavity_plug_occurrence": ("cavity plug", "no task closes empty cavities"),
    "Wire_protection_occurrence": ("wire protection", "no task wraps wires"),
    "Fixing_occurrence": ("fixing", "it is on no segment and at no node"),
    "Accessory_occurrence": ("accessory", "no task mounts it"),
    "Co_pack_occurrence": ("co-pack part", "no task mounts it"),
    "Assembly_part_occurrence": ("assembly part", "its parts are read where the harness has them"),
}
# By which elements a part that is used is referred to.
_USERS = (
    ("Cavity_seal_occurrence", "Contact_points", "Associated_parts"),
    ("Fixing_occurrence", "Fixing_assignment", "Fixing"),
    ("Fixing_occurrence", "Node", "Referenced_components"),
)


def is_splice(connector: etree._Element, part: etree._Element | None) -> bool:
    """Return whether a connector is a splice by its usage, or by its housing's type or text."""
    texts = [text_of(connector, "Usage")]
    if part is not None:
        texts += [text_of(part, key) for key in ("Housing_type", "Description", "Abbreviation")]
    return names_splice(*texts)


def twisted_groups(tree: KblTree) -> dict[etree._Element, str]:
    """Return the names of the twisted groups of wires, by wire."""
    groups: dict[etree._Element, str] = {}
    for group in tree.all("Wiring_group"):
        for wire in tree.referred(group, "Assigned_wire"):
            groups.setdefault(wire, name_of(group))
    return groups


def unused_parts(tree: KblTree) -> list[LeftOut]:
    """Return the occurrences of parts that the order has nothing of, and why."""
    used = {
        part
        for name, user, key in _USERS
        for element in tree.all(user)
        for part in tree.referred(element, key)
        if local_name(part).lower() == name.lower()
    }
    return [
        LeftOut(f"{line_of(part)}, {what} {text_of(part, 'Id') or part.get('id')}", why)
        for element, (what, why) in _PARTS.items()
        for part in tree.all(element)
        if part not in used
    ]


class Topology:
    """Nodes, segments and clips; each has the name that the file calls it by."""

    def __init__(self, tree: KblTree, assumptions: Assumptions) -> None:
        """Read a container's topology; DesignError if a segment has not two nodes."""
        self._tree = tree
        self._assumptions = assumptions
        self._node_names = unique_names(tree.all("Node"))
        self._segment_names = unique_names(tree.all("Segment"))
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
        keys = ("Start_node", "End_node")
        start, end = nodes_of_segment(self._tree, element, name, self._node_names, keys)
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
                    name = unique_name(name_of(fixing), taken)
                    taken.add(name)
                    pose = placed_pose(self._tree, fixing)
                    position = None if pose is None else pose.position
                    clips.append(Clip(name, self._kind(fixing), segment, along, position=position))
        for node, node_name in self._node_names.items():
            for item in self._tree.referred(node, "Referenced_components"):
                if local_name(item).lower() == "fixing_occurrence":
                    name = unique_name(name_of(item), taken)
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


def nodes_of_segment(
    tree: KblTree,
    segment: etree._Element,
    name: str,
    node_names: Mapping[etree._Element, str],
    keys: tuple[str, str],
) -> tuple[str, str]:
    """Return the nodes of a segment, one for each key; DesignError if it has not one of each."""
    ends = []
    for key in keys:
        nodes = [node for node in tree.referred(segment, key) if node in node_names]
        if len(nodes) != 1:
            raise DesignError(
                f"{line_of(segment)}: segment {name} has {len(nodes)} nodes as {key}; one is needed"
            )
        ends.append(node_names[nodes[0]])
    return ends[0], ends[1]


def lengths_by_type(
    tree: KblTree, element: etree._Element, key: str, kind: str, value: str
) -> dict[str, float]:
    """Return the lengths [m] that an element's children of a key state, by their types."""
    lengths: dict[str, float] = {}
    for information in children(element, key):
        length = tree.quantity(information, value)
        if length is not None and length > 0:
            lengths.setdefault(text_of(information, kind).lower(), length)
    return lengths


def unique_names(elements: Iterable[etree._Element], key: str = "Id") -> dict[etree._Element, str]:
    """Return the elements' names, made unique."""
    names: dict[etree._Element, str] = {}
    taken: set[str] = set()
    for element in elements:
        names[element] = unique_name(name_of(element, key), taken)
        taken.add(names[element])
    return names


def name_of(element: etree._Element, key: str = "Id") -> str:
    """Return an element's name: by the child of a key, else its id, else its line."""
    return text_of(element, key) or element.get("id") or line_of(element)
