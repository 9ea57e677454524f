"""What designs leave unsaid: where elements are mounted, what surrounds them, full terminals.

The values stand in config/catalogue.yaml; this is their form. What wires are like, a catalogue has
from the table of wire materials, which the cell reads, too.

A design joins any number of wires at a point, and the import gives each a clamp of its own; the
catalogue says how many the terminals of a component really take. The wires beyond that need a
bridge, a bar or another terminal, which a person chooses.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from typing import Any

from remodel_production.core.production import Component, Mount, Order, Role, TerminalRef
from remodel_production.errors import CatalogueError
from remodel_run.whole_task import counted
from remodel_states.core.wires import MaterialError, WireMaterial, WireMaterials


class Place(Enum):
    """Where an element of a drawing is mounted, or what it is instead of a device."""

    PLATE = "plate"
    DOOR = "door"
    OUTSIDE = "outside"
    REFERENCE = "reference"
    DRAWING = "drawing"


# Link types of QElectroTech's elements that are no devices; they hold in collections of any kind.
_PLACES_OF_LINK_TYPES = {
    "next_report": Place.REFERENCE,
    "previous_report": Place.REFERENCE,
    "thumbnail": Place.DRAWING,
}
# The link type of terminals, which stand on the plate unless their symbol says something else.
_TERMINAL = "terminal"

# Roles without rows of their own, and the role whose rows they have.
_LISTED = {Role.JOINT: Role.CONNECTOR}


@dataclass(frozen=True)
class ClampSize:
    """Clamps for wires up to a section.

    Attributes:
        pitch_m: [m] from clamp to clamp.
        chamfer_m: [m] by which the opening is wider at its front, on each side.
        retention_n: [N] that a closed clamp withstands.
        insertion_n: [N] with which a spring clamp lets a ferrule in.
    """

    pitch_m: float
    chamfer_m: float
    retention_n: float
    insertion_n: float


@dataclass(frozen=True)
class TerminalRule:
    """How wire ends go into the terminals of some components.

    Attributes:
        role: of the components.
        part: pattern of their part numbers.
        force_limit_n: [N] that an insertion must not exceed.
        clearance_m: [m] around an opening, for the gripper.
        kind: pattern of their kinds or names, in lower case.
        wires: that a terminal takes.
    """

    role: Role
    part: str
    force_limit_n: float
    clearance_m: float
    kind: str = "*"
    wires: int = 1


@dataclass(frozen=True)
class DeviceClass:
    """Sizes of devices of one class [m].

    Attributes:
        role: of the components.
        part: pattern of their part numbers.
        kind: pattern of their kinds.
        depth_m: across the rail.
        height_m: above the plate.
        opening_m: height of the openings above the plate.
        screw_m: how far behind its opening the screw of a clamp is; None: it has none.
        has_springs: whether its clamps are springs that hold a ferrule as it enters.
    """

    role: Role
    part: str
    kind: str
    depth_m: float
    height_m: float
    opening_m: float
    screw_m: float | None
    has_springs: bool = False


@dataclass(frozen=True)
class RailSize:
    """A mounting rail [m]: its width, and its height above the plate."""

    width: float
    height: float


@dataclass(frozen=True)
class DuctSize:
    """A slotted duct [m]: its slots are open at the top and begin at their bottom."""

    width: float
    height: float
    slot_pitch: float
    slot_width: float
    slot_bottom: float


@dataclass(frozen=True)
class CabinetRules:
    """What surrounds the devices of a cabinet [m].

    Attributes:
        duct_piece: longest one, between two nodes.
        device_margin: beside the outer terminals of a device.
        narrowest: device.
        tail: of a wire, at each end, for its bend and its ferrule.
        shortest: wire that is cut where the design does not say its length, if the ducts take what
            it is longer than needed.
        slack: of a wire that the ducts take.
        aspect: of the plate: its width by its height.
    """

    rail: RailSize
    duct: DuctSize
    duct_piece: float
    row_pitch: float
    device_gap: float
    device_margin: float
    narrowest: float
    tail: float
    shortest: float
    slack: float
    aspect: float
    plate_margin: float
    plate_thickness: float


@dataclass(frozen=True)
class ForkSize:
    """A fork, or two rows of posts, through which a bundle runs [m].

    Attributes:
        width: the least between the posts.
        play: between the posts and the outermost straight wires, of both sides together.
    """

    width: float
    play: float
    height: float
    length: float


@dataclass(frozen=True)
class ClipSize:
    """A clip for one wire: height of the wire's axis [m], length [m], retention force [N]."""

    height: float
    length: float
    retention: float


@dataclass(frozen=True)
class FormboardRules:
    """What surrounds the connectors of a harness on its formboard [m].

    Attributes:
        connector_gap: between connectors in a row.
        trunk: between two rows of connectors, if no wire's length is known.
        wire_slack: by which a wire is longer than the straight line between its openings.
        wires_beside: how far wires keep from a connector that they pass: fingers insert there.
        aside: how far a bundle leads across the trunk, as a share of its length along it.
        fork_spacing: between forks of a harness whose design has none.
        fork_before: how far a fork stands before and behind a connector.
    """

    cavity_pitch: float
    connector_gap: float
    trunk: float
    wire_slack: float
    wires_beside: float
    aside: float
    fork_spacing: float
    fork_before: float
    fork: ForkSize
    clip: ClipSize
    plate_margin: float
    plate_thickness: float


@dataclass(frozen=True)
class Catalogue:
    """Rules and tables for what a design file leaves unsaid.

    Attributes:
        placement: patterns of paths of symbols, lower case, and where these belong.
        mounts: patterns of names of devices, and where a user says that these are.
        clamps: by the largest section that they take [mm^2].
        clamp_play_m: by which an opening is wider than its wire.
        clamp_beyond_ferrule_m: by which it is deeper than the ferrule.
    """

    placement: tuple[tuple[str, Place], ...]
    colour_names: Mapping[str, str]
    colour_values: Mapping[str, str]
    default_colour: str
    default_section: float
    materials: WireMaterials
    clamps: Mapping[float, ClampSize]
    clamp_play_m: float
    clamp_beyond_ferrule_m: float
    terminals: tuple[TerminalRule, ...]
    devices: tuple[DeviceClass, ...]
    cabinet: CabinetRules
    formboard: FormboardRules
    mounts: tuple[tuple[str, Mount], ...] = ()

    def place(self, path: str, link_type: str) -> Place | None:
        """Return where an element belongs; None if nothing says it.

        Args:
            path: of its symbol in the collection; the case of letters does not matter.
            link_type: of its symbol.
        """
        if link_type in _PLACES_OF_LINK_TYPES:
            return _PLACES_OF_LINK_TYPES[link_type]
        path = path.lower()
        for pattern, place in self.placement:
            if fnmatchcase(path, pattern):
                return place
        return Place.PLATE if link_type == _TERMINAL else None

    def mount(self, device: str) -> Mount | None:
        """Return where a user says that a device is; None for nothing."""
        return next((m for pattern, m in self.mounts if fnmatchcase(device, pattern)), None)

    def terminal_rule(self, component: Component) -> TerminalRule:
        """Return the first rule that fits a component; the last one of each role fits all.

        A joint has the rules of connectors.
        """
        role = _LISTED.get(component.role, component.role)
        names = (component.kind.lower(), component.name.lower())
        return next(
            rule
            for rule in self.terminals
            if rule.role is role
            and fnmatchcase(component.part_number, rule.part)
            and any(fnmatchcase(name, rule.kind) for name in names)
        )

    def device_class(self, component: Component) -> DeviceClass:
        """Return the first class that fits a component; the last one of each role fits all.

        A joint has the classes of connectors.
        """
        role = _LISTED.get(component.role, component.role)
        return next(
            row
            for row in self.devices
            if row.role is role
            and fnmatchcase(component.part_number, row.part)
            and fnmatchcase(component.kind, row.kind)
        )

    def clamp(self, section_mm2: float) -> ClampSize:
        """Return the clamps for a section: the smallest that take it, or the largest."""
        large = [section for section in self.clamps if section >= section_mm2]
        return self.clamps[min(large, default=max(self.clamps))]

    def material(self, section_mm2: float) -> WireMaterial | None:
        """Return what wires of a section are like; None for one beyond the table of materials."""
        try:
            return self.materials.find("", section_mm2)
        except MaterialError:
            return None

    def nearest_material(self, section_mm2: float) -> WireMaterial:
        """Return what wires are like whose section is the nearest in the table of materials."""
        sections = [section for _, section in self.materials.rows]
        return self.materials.find("", min(max(section_mm2, min(sections)), max(sections)))


def catalogue_from(data: Mapping[str, Any], materials: WireMaterials) -> Catalogue:
    """Build a catalogue of a document in the form of config/catalogue.schema.json.

    Raises:
        CatalogueError: if a role has no rule for terminals of any part.
    """
    terminals = tuple(
        TerminalRule(
            Role(row["role"]),
            row["part"],
            float(row["force_limit"]),
            float(row["clearance"]),
            kind=row.get("kind", "*"),
            wires=row["wires"],
        )
        for row in data["terminals"]
    )
    devices = tuple(
        DeviceClass(
            Role(row["role"]),
            row["part"],
            row["kind"],
            float(row["depth"]),
            height_m=float(row["height"]),
            opening_m=float(row["opening"]),
            screw_m=float(row["screw"]) if "screw" in row else None,
            has_springs=row.get("spring", False),
        )
        for row in data["devices"]
    )
    for role in (Role.DEVICE, Role.CONNECTOR):
        if not any(rule.role is role and rule.part == rule.kind == "*" for rule in terminals):
            raise CatalogueError(
                f"terminals: no rule with part '*' for role {role.value}: add one at the end"
            )
        if not any(row.role is role and row.part == row.kind == "*" for row in devices):
            raise CatalogueError(
                f"devices: no row with part '*' and kind '*' for role {role.value}: add one at the "
                "end"
            )
    return Catalogue(
        placement=tuple(
            (pattern, Place(rule["place"]))
            for rule in data["placement"]
            for pattern in rule["patterns"]
        ),
        colour_names=data["colour_names"],
        colour_values=data["colour_values"],
        default_colour=data["default_colour"],
        default_section=float(data["default_section"]),
        materials=materials,
        clamps={
            float(section): ClampSize(
                pitch_m=float(row["pitch"]),
                chamfer_m=float(row["chamfer"]),
                retention_n=float(row["retention"]),
                insertion_n=float(row["insertion"]),
            )
            for section, row in data["clamps"]["sections"].items()
        },
        clamp_play_m=float(data["clamps"]["play"]),
        clamp_beyond_ferrule_m=float(data["clamps"]["beyond_ferrule"]),
        terminals=terminals,
        devices=devices,
        cabinet=_cabinet(data["cabinet"]),
        formboard=_formboard(data["formboard"]),
    )


def _cabinet(data: Mapping[str, Any]) -> CabinetRules:
    sizes = {"rail": RailSize(**data["rail"]), "duct": DuctSize(**data["duct"])}
    return CabinetRules(**{**data, **sizes})


def _formboard(data: Mapping[str, Any]) -> FormboardRules:
    sizes = {"fork": ForkSize(**data["fork"]), "clip": ClipSize(**data["clip"])}
    return FormboardRules(**{**data, **sizes})


@dataclass(frozen=True)
class FullTerminal:
    """A point of a component at which more wires meet than it takes.

    Attributes:
        takes: how many wires it takes.
        wires: names of all that meet there.
        beyond: names of those that it has no place for.
    """

    name: TerminalRef
    takes: int
    wires: tuple[str, ...]
    beyond: tuple[str, ...]

    @property
    def reason(self) -> str:
        """Why the wires beyond are by hand."""
        takes = counted(self.takes, "wire")
        return f"{self.name} takes {takes}, and has {len(self.wires)}: it needs a bridge or a bar"


def full_terminals(order: Order, catalogue: Catalogue) -> Iterator[FullTerminal]:
    """Yield the points at which more wires meet than the catalogue allows, but those of joints.

    The wires of a point are counted in the order of its clamps.
    """
    wire_at = {end: wire.name for wire in order.wires for end in (wire.a, wire.b)}
    for component in order.components:
        if component.role is Role.JOINT:
            continue
        takes = catalogue.terminal_rule(component).wires
        for point, ends in _points(component).items():
            wires = tuple(wire_at[end] for end in ends if end in wire_at)
            if len(wires) > takes:
                yield FullTerminal(
                    TerminalRef(component.name, point), takes, wires, beyond=wires[takes:]
                )


def reasons_by_wire(order: Order, catalogue: Catalogue) -> dict[str, str]:
    """Return why the wires that some terminal has no place for are by hand, by their names."""
    reasons: dict[str, list[str]] = defaultdict(list)
    for full in full_terminals(order, catalogue):
        for wire in full.beyond:
            reasons[wire].append(full.reason)
    return {wire: "; ".join(lines) for wire, lines in reasons.items()}


def _points(component: Component) -> dict[str, list[TerminalRef]]:
    """Return the clamps of each point of a component."""
    points: dict[str, list[TerminalRef]] = defaultdict(list)
    for terminal in component.terminals:
        point = terminal.point or terminal.name
        points[point].append(TerminalRef(component.name, terminal.name))
    return points
