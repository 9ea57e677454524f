"""The importer of KBL harnesses: references, routes and clips, and what is refused."""

import math
import re
from pathlib import Path

import pytest
from wire_lists import CATALOGUE

from remodel_production.core.imports.design_format import Asked
from remodel_production.core.imports.kbl import import_kbl
from remodel_production.core.imports.kbl_parts import ordered_route
from remodel_production.core.production import Clip, Role, Segment
from remodel_production.errors import DesignError

TEXT = (Path(__file__).parent / "designs" / "loom.kbl").read_text()


def read(*changes, modules=(), codes=()):
    """Read the loom with (old, new) pieces of its text exchanged."""
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    asked = Asked(tuple(modules), tuple(codes))
    return import_kbl(text.encode(), "loom", "loom.kbl", CATALOGUE, asked)


def test_connections_become_wires_by_their_references():
    order = read().order
    wire, core = order.wires
    assert order.title == "L-100 Loom"
    assert (wire.name, str(wire.a), str(wire.b)) == ("11", "X1:1", "X2:X2-1")
    assert (wire.colour, wire.section_mm2, wire.length_m, wire.cable) == ("RDYE", 0.75, 0.7455, "")
    assert (core.name, str(core.a), str(core.b)) == ("SL1.31", "X3:1", "X1:2")
    assert (core.colour, core.section_mm2, core.cable, core.core) == ("WH", 0.35, "SL1", "31")
    assert [(cable.name, cable.kind, cable.shielded) for cable in order.cables] == [
        ("SL1", "LiYCY", True)
    ]


def test_what_an_assembly_part_is_made_of_is_not_read_twice():
    imported = read()
    assert imported.account.connections == 3
    assert [component.name for component in imported.order.components] == ["X1", "X2", "X3"]


def test_connectors_without_wires_stay_and_wires_without_connections_are_reported():
    bare = '<Connector_occurrence id="x4"><Id>X4</Id><Part>housing2</Part></Connector_occurrence>'
    imported = read(('<Connector_occurrence id="x1">', f'{bare}<Connector_occurrence id="x1">'),
                    ("<Wire>w2</Wire>", ""))  # fmt: skip
    assert [c.name for c in imported.order.components] == ["X4", "X1", "X2", "X3"]
    assert imported.order.components[0].terminals == ()
    (ignored,) = imported.account.ignored
    assert str(ignored) == "line 60, wire 12: left out, it connects nothing"


def test_connectors_have_places_nodes_and_contacts():
    x1, x2, x3 = read().order.components
    assert (x1.kind, x1.role, x1.part_number, x1.node) == ("pump", Role.CONNECTOR, "H-2", "N1")
    assert x1.pose.position == (0.0, 0.0, 0.0)
    assert x1.terminal("1").kind == "T-063"
    assert (x2.kind, x2.node, x2.pose.position) == ("ring terminal", "N3", (0.7, 0.0, 0.1))
    assert (x3.node, x3.pose.position) == ("N4", (0.4, 0.2, 0.0))
    assert x3.pose.orientation == pytest.approx((0, 0, math.sqrt(0.5), math.sqrt(0.5)))


def test_routes_lead_from_a_to_b_whatever_their_order_in_the_file():
    order = read().order
    assert [wire.route for wire in order.wires] == [("S1", "S2"), ("S3", "S1")]


def test_routes_become_ordered_lists_of_clips():
    order = read().order
    there, back = ([clip.name for clip in order.clips_of(wire)] for wire in order.wires)
    assert there == ["CL1", "CL2", "CL3"]
    assert back == ["CL3", "CL2", "CL1"]
    assert order.clips[1] == Clip("CL1", "edge clip", "S1", 0.25)  # the absolute place binds


def test_lengths_of_segments_are_physical_else_virtual_else_the_distance():
    imported = read()
    lengths = {segment.name: segment.length_m for segment in imported.order.segments}
    assert lengths == {"S1": 0.4, "S2": 0.32, "S3": pytest.approx(0.2)}
    assert "line 79: length of segment S3 not given, 0.200 m taken" in imported.account.assumptions


def test_a_wire_without_a_length_gets_that_of_its_route():
    imported = read()
    assert imported.order.wires[1].length_m == pytest.approx(0.6)
    assert any(
        "length not given, that of its route taken" in g for g in imported.account.assumptions
    )


def test_a_connection_with_one_end_is_left_out_with_its_place():
    (left_out,) = read().account.left_out
    assert (
        str(left_out)
        == "line 37, connection con3: left out, 1 end at a contact point; two are needed"
    )


def test_namespaces_and_cases_do_not_matter():
    plain = [("kbl:KBL_container", "KBL_Container"), ("xmlns:kbl", "xmlns")]
    changed = read(*plain, ("kbl:", ""), ("Referenced_components", "referenced_components"))
    assert changed.order == read().order


def test_a_route_that_ends_elsewhere_is_taken_and_reported():
    imported = read(("<Segments>seg2 seg1</Segments>", "<Segments>seg2</Segments>"))
    assert imported.order.wires[0].route == ("S2",)
    assert (
        "line 29, connection K1: its route leads from N2 to N3, and its connectors sit at N1 and "
        "N3; the route is taken"
    ) in imported.account.assumptions


def test_a_route_with_a_gap_is_left_out_and_named():
    apart = '<Segment id="seg9"><Start_node>n1</Start_node><End_node>n4</End_node></Segment>'
    imported = read(
        ("<Segments>seg1 seg3</Segments>", "<Segments>seg2 seg9</Segments>"),
        ('<Unit id="mm">', f'{apart}<Unit id="mm">'),
    )
    (ignored,) = imported.account.ignored
    assert ignored.source == "line 33, connection K2, its route"
    assert ignored.reason == "its segments S2, seg9 are no route: they form 2 separate routes"
    assert imported.order.wires[1].route == ()


def test_a_box_at_two_nodes_has_wires_from_both():
    both = read(
        (">f3<", ">f3 x1<"), ("<Segments>seg2 seg1</Segments>", "<Segments>seg2</Segments>")
    )
    assert both.order.wires[0].route == ("S2",)
    assert not any("its connectors sit at" in line for line in both.account.assumptions)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<Wire>w1</Wire>", "<Wire>w9</Wire>", "line 29: Wire of Connection K1 refers to w9"),
        (">cp3<", ">cp9<", "Contact_point of Extremities e2 refers to cp9"),
        (">cp3<", ">t1<", "refers to Terminal_occurrence t1, which is no contact point"),
        ("<Start_node>n2", "<Start_node>n9", "Start_node of Segment S2 refers to n9"),
        ("<Start_node>n2</Start_node>", "", "segment S2 has 0 nodes as Start_node"),
        ('id="seg2"', 'id="seg1"', "id seg1 of a <Segment> is there before, at line 72"),
        ('<Routing id="r2"><Routed_wire>core1', '<Routing id="r2"><Routed_wire>con1', "K1 has a r"),
        ("<Location>0.75", "<Location>1.5", "Location 1.5; a number from 0 to 1 is needed"),
        ("<Position_on_wire>0.0", "<Position_on_wire>end", "Position_on_wire 'end'"),
        ("<Coordinates>400.0", "<Coordinates>far", "two or three numbers are needed"),
        ("kbl:KBL_container", "kbl:Other", "the root element is <Other>"),
        ("</kbl:KBL_container>", "", "is no XML"),
        ("<Harness", "<!-- --><Harness2", "is no XML"),
    ],
)
def test_a_broken_container_is_refused_with_the_place(old, new, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        read((old, new))


def test_a_container_without_connections_is_refused():
    with pytest.raises(DesignError, match="none of its 3 connections joins two contact points"):
        read(("Contact_point>cp", "Contact>cp"), ("</Contact_point>", "</Contact>"))


SEGMENTS = [
    Segment("S1", "A", "B", 1.0),
    Segment("S2", "C", "B", 1.0),
    Segment("S3", "C", "D", 1.0),
]


@pytest.mark.parametrize(
    ("segments", "said"),
    [
        ([*SEGMENTS, SEGMENTS[0]], "passes segment S1 twice"),
        ([*SEGMENTS, Segment("S4", "D", "A", 1.0)], "they form a cycle"),
        ([SEGMENTS[0], SEGMENTS[2]], "they form 2 separate routes"),
        ([*SEGMENTS, Segment("S4", "B", "E", 1.0)], "3 of its segments meet at node B"),
        (
            [*SEGMENTS, Segment("S4", "E", "F", 1.0), Segment("S5", "F", "E", 1.0)],
            "do not hang together",
        ),
    ],
)
def test_segments_that_form_no_route_are_reported(segments, said):
    assert said in ordered_route(segments, (), ())


HARNESS = '<Harness id="h"><Part_number>L-100</Part_number><Description>Loom</Description>'


def module(name, *parts, codes=""):
    return (
        f'<Module id="m_{name}"><Part_number>{name}</Part_number><Module_configuration '
        f'id="mc_{name}"><Logistic_control_information>{codes}</Logistic_control_information>'
        f"<Configuration_type>option code</Configuration_type><Controlled_components>"
        f"{' '.join(parts)}</Controlled_components></Module_configuration></Module>"
    )


def test_a_module_selects_its_wires_and_those_of_no_module():
    variant = (
        '<Harness_configuration id="v"><Part_number>V-1</Part_number><Modules>m_M2</Modules>'
        "</Harness_configuration>"
    )
    modules = (HARNESS, HARNESS + module("M1", "w1", "x1") + module("M2", "s1", "x1") + variant)
    whole = read(modules)
    assert [wire.name for wire in whole.order.wires] == ["11", "SL1.31"]
    assert any(
        line.endswith("as of one harness; --module chooses of M1, M2, V-1")
        for line in whole.account.assumptions
    )
    assert [wire.name for wire in read(modules, modules=["M1"]).order.wires] == ["11"]
    for name in ("M2", "V-1"):
        some = read(modules, modules=[name])
        assert [wire.name for wire in some.order.wires] == ["SL1.31"]
        assert "its wire is in none of the modules asked for" in [
            item.reason for item in some.account.left_out
        ]
    both = read(modules, modules=["M1", "M2"])
    assert [wire.name for wire in both.order.wires] == ["11", "SL1.31"]
    with pytest.raises(DesignError, match="no module or harness configuration M9; there are M1"):
        read(modules, modules=["M9"])


def test_variant_codes_select_modules_by_their_logistic_control_information():
    one, two = module("M1", "w1", codes="LOL/LOR"), module("M2", "s1", codes="LOL+CFL")
    modules = (HARNESS, HARNESS + one + two)
    for codes, wires in (("LOR", ["11"]), ("LOL", ["11"]), ("LOL CFL", ["11", "SL1.31"])):
        some = read(modules, codes=codes.split())
        assert [wire.name for wire in some.order.wires] == wires
    with pytest.raises(DesignError, match="no variant code X; there are CFL, LOL, LOR: give one"):
        read(modules, codes=["X"])
    with pytest.raises(DesignError, match="the file has no variant code X: omit --variant"):
        read(codes=["X"])
    with pytest.raises(DesignError, match="module or harness configuration M9: omit --module"):
        read(modules=["M9"])


def test_a_connection_or_a_wiring_group_in_a_module_stands_for_its_wires():
    group = (
        '<Wiring_group id="g"><Id>TW1</Id><Assigned_wire>w2 core1</Assigned_wire></Wiring_group>'
    )
    parts = HARNESS + group + module("M1", "con1") + module("M2", "g")
    for name, wires in (("M1", ["11"]), ("M2", ["SL1.31"])):
        some = read((HARNESS, parts), modules=[name])
        assert [wire.name for wire in some.order.wires] == wires


def test_a_splice_is_a_joint_by_its_usage_or_its_housing():
    by_usage = read(("<Usage>ring terminal</Usage>", "<Usage>Splice</Usage>"))
    roles = {c.name: c.role for c in by_usage.order.components}
    assert roles == {"X1": Role.CONNECTOR, "X2": Role.JOINT, "X3": Role.CONNECTOR}
    by_housing = read(
        ("<Description>two cavities</Description>", "<Description>Spleiß</Description>")
    )
    assert by_housing.order.components[0].role is Role.JOINT


def test_a_seal_is_of_the_wire_end_and_parts_that_no_task_mounts_are_listed():
    parts = (
        '<Cavity_seal id="seal"><Part_number>S-9</Part_number></Cavity_seal>'
        '<Cavity_seal_occurrence id="s_1"><Id>D1</Id><Part>seal</Part></Cavity_seal_occurrence>'
        '<Cavity_seal_occurrence id="s_2"><Id>D2</Id><Part>seal</Part></Cavity_seal_occurrence>'
        '<Wire_protection_occurrence id="p_1"><Id>T1</Id></Wire_protection_occurrence>'
        '<Fixing_occurrence id="f9"><Id>CL9</Id><Part>clip_part</Part></Fixing_occurrence>'
    )
    imported = read(
        (HARNESS, HARNESS + parts),
        ("<Associated_parts>t1</Associated_parts>", "<Associated_parts>t1 s_1</Associated_parts>"),
    )
    terminals = {t.name: t for t in imported.order.components[0].terminals}
    assert (terminals["1"].kind, terminals["1"].is_sealed) == ("T-063 with seal S-9", True)
    assert not terminals["2"].is_sealed
    assert [str(item).split(", ", 1)[1] for item in imported.account.ignored] == [
        "cavity seal D2: left out, no contact point refers to it",
        "wire protection T1: left out, no task wraps wires",
        "fixing CL9: left out, it is on no segment and at no node",
    ]


def test_the_wires_of_a_twisted_group_are_cores_of_it():
    group = '<Wiring_group id="g"><Id>TW1</Id><Assigned_wire>w1 w2</Assigned_wire></Wiring_group>'
    order = read((HARNESS, HARNESS + group)).order
    assert (order.wires[0].cable, order.wires[0].core) == ("TW1", "11")
    assert ("TW1", "twisted wires") in [(cable.name, cable.kind) for cable in order.cables]
