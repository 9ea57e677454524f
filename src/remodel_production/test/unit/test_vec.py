"""The importer of VEC harnesses: roles, contacts, routes, and what is refused."""

from pathlib import Path

import pytest
from wire_lists import CATALOGUE

from remodel_production.core.imports.design_format import Asked, VariantCondition
from remodel_production.core.imports.formats import built_in_formats, format_of
from remodel_production.core.imports.vec import import_vec
from remodel_production.core.production import Clip, Role
from remodel_production.errors import DesignError

TEXT = (Path(__file__).parent / "designs" / "loom.vec").read_text()


# Modules M1, of wires W1 and W2, and M2, of W2 and W3; a configuration M3 that consists of M2.
MODULES = """<Specification xsi:type="vec:PartStructureSpecification" id="ps1">
<Content>Module</Content><DescribedPart>p_m1</DescribedPart>
<InBillOfMaterial>o_w1 o_w2</InBillOfMaterial></Specification>
<Specification xsi:type="vec:PartStructureSpecification" id="ps2">
<Content>Module</Content><DescribedPart>p_m2</DescribedPart>
<InBillOfMaterial>o_w2 o_w3</InBillOfMaterial></Specification>
<Specification xsi:type="vec:PartStructureSpecification" id="ps3">
<Content>HarnessConfiguration</Content><DescribedPart>p_m3</DescribedPart>
<InBillOfMaterial>o_m2</InBillOfMaterial></Specification>
<Specification xsi:type="vec:CompositionSpecification" id="comp2"><Component id="o_m2">
<Identification>Module 2</Identification><Role xsi:type="vec:PartWithSubComponentsRole" id="m2_r">
<PartStructureSpecification>ps2</PartStructureSpecification></Role></Component></Specification>
<Specification xsi:type="vec:BuildingBlockSpecification3D" id="bb">
<Identification>3D</Identification><BaseUnit>mm</BaseUnit>
<CartesianPoint id="pt"><X>100</X><Y>20</Y><Z>-5</Z></CartesianPoint>
<GeometryNode id="gn"><Identification>G1</Identification><CartesianPoint>pt</CartesianPoint>
<ReferenceNode>n1</ReferenceNode></GeometryNode></Specification>
<Specification xsi:type="vec:CompositionSpecification" id="comp3"><Component id="o_tape">
<Identification>TAPE</Identification>
<Role xsi:type="vec:WireProtectionRole" id="tape_r"/></Component>
<Component id="o_cl"><Identification>CL9</Identification><Role xsi:type="vec:FixingRole" id="cl_r"/>
</Component></Specification></DocumentVersion>
<PartVersion id="p_m1"><PartNumber>M1</PartNumber></PartVersion>
<PartVersion id="p_m2"><PartNumber>M2</PartNumber></PartVersion>
<PartVersion id="p_m3"><PartNumber>M3</PartNumber></PartVersion>
<PartVersion id="p_h">"""


def modular(*asked, modules=MODULES, codes=()):
    """Read the loom with modules, of which some are asked for."""
    head, end, tail = TEXT.partition('</DocumentVersion>\n  <PartVersion id="p_h">')
    assert end
    data = f"{head}{modules}{tail}".encode()
    return import_vec(data, "loom", "loom.vec", CATALOGUE, Asked(asked, tuple(codes)))


def read(*changes):
    """Read the loom with (old, new) pieces of its text exchanged."""
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return import_vec(text.encode(), "loom", "loom.vec", CATALOGUE)


def test_wire_elements_become_wires_by_their_contacts_and_cores_of_their_cables():
    order = read().order
    assert order.title == "L-200"
    assert [(w.name, str(w.a), str(w.b), w.cable, w.core) for w in order.wires] == [
        ("W1", "X1:1", "X2:1", "", ""),
        ("W2.A", "X1:2", "X2:2", "W2", "A"),
        ("W2.B", "X1:3", "S1:k6.1", "W2", "B"),
        ("W3", "S1:k6.2", "X2:3", "", ""),
    ]
    assert {(w.colour, w.section_mm2) for w in order.wires} == {("RDYE", 0.5)}
    assert [w.length_m for w in order.wires] == [0.72, 0.7, 0.4, 0.3]
    assert [(cable.name, cable.kind) for cable in order.cables] == [("W2", "LiYY")]


@pytest.mark.parametrize("key", ["RelatedWireElementReference", "RelatedWireRole"])
def test_the_wires_of_a_wire_grouping_are_cores_of_it(key):
    pair = f"<{key}>w1 w3</{key}>"
    inner = f'<ContainedWireGroupings id="g2">{pair}</ContainedWireGroupings>'
    start = '<Specification xsi:type="vec:TopologySpecification"'
    for content in (pair, inner):
        grouping = (
            '<Specification xsi:type="vec:WireGroupingSpecification" id="wgs"><WireGrouping '
            f'id="g1"><Identification>W2</Identification>{content}</WireGrouping></Specification>'
        )
        order = read((start, grouping + start)).order
        assert [(w.name, w.cable, w.core) for w in order.wires] == [
            ("W1", "W2#2", "W1"),
            ("W2.A", "W2", "A"),
            ("W2.B", "W2", "B"),
            ("W3", "W2#2", "W3"),
        ]
        assert ("W2#2", "twisted wires") in [(cable.name, cable.kind) for cable in order.cables]


def test_components_have_roles_nodes_contacts_and_seals():
    x1, x2, s1 = read().order.components
    assert (x1.name, x1.role, x1.part_number, x1.node) == ("X1", Role.CONNECTOR, "H-3", "N1")
    assert (x2.node, s1.name, s1.role) == ("N3", "S1", Role.JOINT)
    assert [(t.name, t.is_sealed) for t in x1.terminals] == [
        ("1", True),
        ("2", False),
        ("3", False),
    ]
    assert x1.terminals[0].kind == "T-063 with seal S-9"


def test_routes_are_ordered_from_end_a_and_fixings_are_clips():
    order = read().order
    assert order.wires[0].route == ("S12", "S23")
    assert [(s.name, s.length_m) for s in order.segments] == [("S12", 0.4), ("S23", 0.3)]
    assert order.clips == (Clip("CL1", "F-1", "S23", 0.75),)


def test_a_wire_element_without_two_contacts_is_left_out_and_lengths_may_be_missing():
    imported = read(
        ("<ReferencedWireEnd>w1_b</ReferencedWireEnd>", ""),
        ("<ValueComponent>400</ValueComponent></Length>", "</Length>"),
    )
    (left,) = imported.account.left_out
    assert left.reason == "1 end at a contact point; two are needed"
    assert imported.account.connections == 4
    assert any("length of segment S12 not given" in line for line in imported.account.assumptions)


def test_versions_differ_in_nothing_that_is_read_and_the_format_is_recognised():
    assert read(("1.2.0", "2.1.0")).order == read().order
    form = format_of(TEXT.encode(), built_in_formats(()))
    assert form.name == "vec"


def test_what_is_no_vec_or_refers_to_nothing_is_refused():
    with pytest.raises(DesignError, match="the root element is <KBL_container>; a <VecContent> is"):
        read(("vec:VecContent", "vec:KBL_container"))
    with pytest.raises(DesignError, match="refers to we, and no element has that id"):
        read(('<WireElement id="we">', '<WireElement id="other">'))
    with pytest.raises(DesignError, match="none of its 4 wire elements joins two contact points"):
        read(("EquippedCavityRef>", "Other>"), ("<MountedTerminal>s1_r</MountedTerminal>", ""))


@pytest.mark.parametrize(
    ("asked", "wires"),
    [
        ((), ["W1", "W2.A", "W2.B", "W3"]),
        (("M1",), ["W1", "W2.A", "W2.B"]),
        (("M2",), ["W2.A", "W2.B", "W3"]),
        (("M3",), ["W2.A", "W2.B", "W3"]),
        (("M1", "M2"), ["W1", "W2.A", "W2.B", "W3"]),
    ],
)
def test_modules_and_configurations_select_wires(asked, wires):
    imported = modular(*asked)
    assert [wire.name for wire in imported.order.wires] == wires
    left = [item.reason for item in imported.account.left_out]
    assert left == ["its wire is in none of the modules asked for"] * (4 - len(wires))
    read_all = (
        "the parts of all 2 modules are read, as of one harness; --module chooses of M1, M2, M3"
    )
    note = f"the wires of modules {', '.join(asked)} are read" if asked else read_all
    assert imported.account.assumptions[0] == note


def test_an_unknown_module_is_refused_with_those_that_there_are():
    with pytest.raises(DesignError, match="configuration M9; there are M1, M2, M3: give one"):
        modular("M9")


def test_nodes_have_their_places_and_what_no_task_mounts_is_listed():
    imported = modular()
    assert [(node.name, node.position) for node in imported.order.nodes] == [
        ("N1", (0.1, 0.02, -0.005)),
        ("N2", None),
        ("N3", None),
    ]
    assert [str(item).partition(", ")[2] for item in imported.account.ignored] == [
        "wire protection TAPE: left out, no task wraps wires",
        "fixing CL9: left out, it is nowhere on the topology",
    ]


def test_a_point_without_coordinates_is_refused():
    with pytest.raises(DesignError, match="numbers are needed as X and Y, and a unit of length"):
        modular(modules=MODULES.replace("<X>100</X>", "<X/>"))


CONFIGURATIONS = MODULES.replace(
    "</Specification></DocumentVersion>",
    """</Specification><Specification xsi:type="vec:VariantConfigurationSpecification" id="vcs">
<VariantConfiguration id="v_a"><LogisticControlString>A+-B;</LogisticControlString>
</VariantConfiguration><VariantConfiguration id="v_b"><LogisticControlExpression>B OR C
</LogisticControlExpression></VariantConfiguration></Specification>
<Specification xsi:type="vec:ConfigurationConstraintSpecification" id="ccs">
<ConfigurationConstraint id="cc"><ConfigInfo>v_b</ConfigInfo>
<ConstrainedElements>o_m1 w3</ConstrainedElements></ConfigurationConstraint></Specification>
</DocumentVersion>""",
).replace(
    '<Component id="o_m2">\n<Identification>Module 2</Identification>',
    '<Component id="o_m1"><Identification>Module 1</Identification><Role '
    'xsi:type="vec:PartWithSubComponentsRole" id="m1_r"><PartStructureSpecification>ps1'
    "</PartStructureSpecification></Role></Component>"
    '<Component id="o_m2"><ConfigInfo>v_a</ConfigInfo><Identification>Module 2</Identification>',
)


@pytest.mark.parametrize(
    ("codes", "wires"),
    [
        (("A",), ["W2.A", "W2.B"]),
        (("B",), ["W1", "W2.A", "W2.B"]),
        (("A", "C"), ["W1", "W2.A", "W2.B", "W3"]),
        (("A", "B"), ["W1", "W2.A", "W2.B"]),
    ],
)
def test_variant_codes_select_modules_and_wires(codes, wires):
    imported = modular(modules=CONFIGURATIONS, codes=codes)
    assert [wire.name for wire in imported.order.wires] == wires
    assert imported.account.connections == 4
    assert len(imported.account.left_out) == 4 - len(wires)
    note = f"the wires of a vehicle with the variant codes {', '.join(codes)} are read"
    assert note in imported.account.assumptions


def test_without_codes_all_variants_are_read_with_a_note():
    imported = modular(modules=CONFIGURATIONS)
    assert len(imported.order.wires) == 4
    assert any("--variant gives the codes" in line for line in imported.account.assumptions)
    with pytest.raises(DesignError, match="none of its 4 wire elements joins two"):
        modular(modules=CONFIGURATIONS, codes=("",))
    some = modular("M2", modules=CONFIGURATIONS, codes=("A",))
    assert [wire.name for wire in some.order.wires] == ["W2.A", "W2.B"]
    reasons = {item.reason for item in some.account.left_out}
    assert "its variant B OR C is not asked for" in reasons
    with pytest.raises(DesignError, match="no variant code X; there are A, B, C: give one of them"):
        modular(modules=CONFIGURATIONS, codes=("X",))


def test_of_several_routes_of_a_wire_the_variant_chooses_one():
    two = MODULES.replace(
        "</Specification></DocumentVersion>",
        """</Specification><Specification xsi:type="vec:RoutingSpecification" id="rr">
<Routing id="r2"><RoutedElement>w3</RoutedElement><Path id="p2"><Segment>s23</Segment></Path>
</Routing><Routing id="r3"><RoutedElement>w3</RoutedElement><Path id="p3"><Segment>s12</Segment>
</Path></Routing></Specification>
<Specification xsi:type="vec:VariantConfigurationSpecification" id="vcs">
<VariantConfiguration id="v_r"><LogisticControlExpression>RL</LogisticControlExpression>
</VariantConfiguration><VariantConfiguration id="v_l"><LogisticControlExpression>LL
</LogisticControlExpression></VariantConfiguration></Specification>
<Specification xsi:type="vec:ConfigurationConstraintSpecification" id="ccs">
<ConfigurationConstraint id="cc1"><ConfigInfo>v_r</ConfigInfo><ConstrainedElements>s23 r2
</ConstrainedElements></ConfigurationConstraint>
<ConfigurationConstraint id="cc2"><ConfigInfo>v_l</ConfigInfo><ConstrainedElements>s12 r3
</ConstrainedElements></ConfigurationConstraint></Specification></DocumentVersion>""",
    )
    routes = {}
    for codes in ((), ("RL",), ("LL",)):
        imported = modular(modules=two, codes=codes)
        routes[codes] = next(w.route for w in imported.order.wires if w.name == "W3")
        notes = [line for line in imported.account.assumptions if "another route of W3" in line]
        assert len(notes) == (not codes)
    assert routes == {(): ("S23",), ("RL",): ("S23",), ("LL",): ("S12",)}


@pytest.mark.parametrize(
    ("text", "codes", "holds"),
    [
        ("A", "A", True),
        ("A+B", "A", False),
        ("A/B;", "B", True),
        ("-A", "", True),
        ("A+-(B/C)", "AC", False),
        ("A+-(B/C)", "A", True),
        ("(A + B) / C", "C", True),
        ("not A and (B or C)", "C", True),
        ("A UND NICHT B", "AB", False),
        ("A & B | C", "C", True),
    ],
)
def test_a_condition_of_codes_holds(text, codes, holds):
    assert VariantCondition(text, "line 7").holds(set(codes)) is holds


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("A+B/C", "whether . or / binds stronger differs between companies: put brackets"),
        ("A+", "a code is missing"),
        ("(A", "a bracket is not closed"),
        ("A B", "'B' is not expected there"),
        ("A = B", "'=' is not known"),
        ("A-B", "'-' is not expected there"),
    ],
)
def test_a_condition_that_cannot_be_read_is_refused_with_its_place(text, why):
    with pytest.raises(DesignError, match=f"line 7: variant condition .* cannot be read: {why}"):
        VariantCondition(text, "line 7").holds("A")
