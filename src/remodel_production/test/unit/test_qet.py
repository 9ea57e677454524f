"""The importer of QElectroTech projects, on small drawings and on a real one."""

import re
from pathlib import Path

import pytest
from lxml import etree
from qet_projects import ARROW, BREAKER, CONTACT, LAMP, element, project, wire
from wire_lists import CATALOGUE

from remodel_production.core.imports.qet import import_qet
from remodel_production.core.production import Mount, Side, TerminalRef
from remodel_production.errors import DesignError

EXAMPLES = Path("/usr/share/qelectrotech/examples")


def read(*folios):
    imported = import_qet(project(*folios), "test", "test.qet", CATALOGUE)
    return imported.order, imported.account


def ends(order):
    return [(str(wire.a), str(wire.b)) for wire in order.wires]


TWO = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2")]


def test_a_conductor_between_two_devices_is_a_wire():
    attributes = 'conductor_section="1.5mm²" conductor_color="Bleu"'
    order, account = read((TWO, [wire("q1", "b2", "q2", "t1", more=attributes)]))
    assert ends(order) == [("Q1:B2", "Q2:T1")]
    assert (order.wires[0].colour, order.wires[0].section_mm2) == ("BU", 1.5)
    assert order.components[0].terminal("B2").side is Side.BOTTOM
    assert not account.assumptions
    assert not account.left_out


def test_terminals_numbered_on_the_folio_are_understood():
    elements = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2", first_id=4)]
    order, _ = read((elements, ['<conductor terminal1="3" terminal2="4" num="2,5 mm2"/>']))
    assert ends(order) == [("Q1:B2", "Q2:T1")]
    assert order.wires[0].section_mm2 == 2.5


def test_numbers_of_conductors_are_names_of_wires_and_a_repeated_one_is_kept_as_number():
    numbers = ("635", "0V", "0V", "_", "24V 1.5mm\u00b2", "635#2")
    points = [("b1", "t1"), ("b2", "t2"), ("b1", "t2"), ("b2", "t1"), ("t1", "b1"), ("t2", "b2")]
    conductors = [
        wire("q1", a, "q2", b, more=f'num="{number}"')
        for number, (a, b) in zip(numbers, points, strict=True)
    ]
    order, account = read((TWO, conductors))
    assert [w.name for w in order.wires] == ["635", "0V", "0V#2", "W4", "24V", "635#2"]
    assert [w.number for w in order.wires] == ["635", "0V", "0V", "", "24V", "635#2"]
    assert order.wires[4].section_mm2 == 1.5
    assert any("name 0V occurs before" in line for line in account.assumptions)


def test_a_chain_through_references_has_the_number_that_any_of_its_conductors_has():
    one = ([TWO[0], element(ARROW, "r1", link="r2")], [wire("q1", "b1", "r1", "r")])
    two = ([TWO[1], element(ARROW, "r2", link="r1")], [])
    two[1].append(wire("r2", "r", "q2", "t1", more='num="L1"'))
    order, _ = read(one, two)
    assert [(w.name, w.number) for w in order.wires] == [("L1", "L1")]


def test_terminals_have_the_names_of_the_definition():
    text = project((TWO, [wire("q1", "b1", "q2", "t1"), wire("q1", "b2", "q2", "b1")]))
    for old, name in (("{b1}", "A1"), ("{b2}", "A1"), ("{t1}", " N "), ("{t2}", "_")):
        text = text.replace(f'uuid="{old}" x'.encode(), f'uuid="{old}" name="{name}" x'.encode())
    order = import_qet(text, "test", "test.qet", CATALOGUE).order
    assert ends(order) == [("Q1:A1", "Q2:N"), ("Q1:A1#2", "Q2:A1")]
    assert order.components[0].terminal("A1#2").side is Side.BOTTOM


@pytest.mark.parametrize(
    ("texts", "names"),
    [
        ((("L", -14, -18), ("N", 6, -18), ("1", -6, 18), ("2", 6, 18)), ("Q1:1", "Q2:L")),
        ((("L", -14, -18), ("N", 6, -18), ("1", -6, 18)), ("Q1:B1", "Q2:T1")),
        ((("L", -14, -18), ("N", 6, -18), ("1", -6, 18), ("2", 6, 40)), ("Q1:B1", "Q2:T1")),
        ((("L", -14, -18), ("L", 6, -18), ("1", -6, 18), ("2", 6, 18)), ("Q1:B1", "Q2:T1")),
        ((("L", -14, -18), ("N", 6, -18), ("1", -6, 18), ("QF_", 6, 18)), ("Q1:B1", "Q2:T1")),
    ],
)
def test_texts_beside_all_terminals_of_a_symbol_are_their_names(texts, names):
    drawn = "".join(f'<text text="{text}" x="{x}" y="{y}"/>' for text, x, y in texts)
    text = project((TWO, [wire("q1", "b1", "q2", "t1")]))
    text = text.replace(b'<terminal uuid="{t1}"', f'{drawn}<terminal uuid="{{t1}}"'.encode())
    found = import_qet(text, "test", "test.qet", CATALOGUE)
    assert ends(found.order) == [names]
    line = f"symbol {BREAKER.removeprefix('embed://')}: texts beside its terminals taken as names"
    assert (line in found.account.assumptions) == (names == ("Q1:1", "Q2:L"))


def test_elements_without_uuids_are_distinguished_on_one_line():
    elements = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2", first_id=4)]
    elements = [re.sub(' uuid="[^"]*"', "", text) for text in elements]
    order, _ = read((elements, ['<conductor terminal1="3" terminal2="4"/>']))
    assert ends(order) == [("Q1:B2", "Q2:T1")]


def test_a_conductor_to_the_field_is_a_wire_that_leads_away():
    elements = [*TWO, element(LAMP, "e1")]
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q2", "b1", "e1", "l")]
    order, account = read((elements, conductors))
    assert ends(order) == [("Q1:B1", "Q2:T1"), ("Q2:B1", "lamp:T1")]
    assert ends(order.in_cabinet()) == [("Q1:B1", "Q2:T1")]
    assert order.components[-1].mount is Mount.OUTSIDE
    assert not account.left_out


def test_a_contact_is_part_of_its_master():
    contact = element(CONTACT, "k1a", "K1", link="q1")
    conductors = [wire("q1", "b1", "k1a", "c1"), wire("k1a", "c2", "q2", "t1")]
    order, _ = read(([*TWO, contact], conductors))
    assert ends(order) == [("Q1:B1", "Q1:T3"), ("Q1:B3", "Q2:T1")]
    assert [component.name for component in order.components] == ["Q1", "Q2"]


def test_a_contact_whose_master_is_missing_is_a_device_of_its_own():
    contact = element(CONTACT, "k1a", "K1", link="gone")
    order, _ = read(([*TWO, contact], [wire("q1", "b1", "k1a", "c1")]))
    assert ends(order) == [("Q1:B1", "K1:T1")]


def test_terminals_of_a_definition_that_lie_outwards_are_those_of_the_instance():
    drawn = element(BREAKER, "q1", "Q1").replace('y="-20"', 'y="-16"').replace('y="20"', 'y="16"')
    order, _ = read(([drawn, TWO[1]], [wire("q1", "b2", "q2", "t1")]))
    assert ends(order) == [("Q1:B2", "Q2:T1")]


def test_a_newer_format_is_read_and_reported():
    text = project((TWO, [wire("q1", "b1", "q2", "t1")])).replace(b'"0.90"', b'"0.100.0"')
    imported = import_qet(text, "test", "test.qet", CATALOGUE)
    assert imported.account.assumptions[0] == "line 1: format 0.100.0; read as 0.90"


def test_an_underscore_is_no_label():
    elements = [element(BREAKER, "q1", "_"), element(BREAKER, "q2", "Q2")]
    order, account = read((elements, [wire("q1", "b1", "q2", "t1")]))
    assert [c.name for c in order.components] == ["breaker", "Q2"]
    assert "is named breaker" in account.assumptions[0]


def test_a_label_on_elements_that_are_not_linked_is_reported_with_their_folios():
    coil = element(BREAKER, "d1", "D28")
    one = ([TWO[0], coil], [wire("q1", "b1", "d1", "t1")])
    two = ([TWO[1], element(BREAKER, "d2", "D28")], [wire("q2", "b1", "d2", "t1")])
    three = ([element(BREAKER, "d3", "D28")], [])
    order, account = read(one, two, three)
    assert [c.name for c in order.components] == ["Q1", "D28", "Q2", "D28#2"]
    (line,) = (line for line in account.assumptions if "D28" in line)
    assert line.startswith(
        "2 elements that are not linked have the label D28, on folios 1, 2: read as devices D28, "
        "D28#2; link"
    )


def test_a_potential_goes_on_through_linked_references():
    one = ([element(BREAKER, "q1", "Q1"), element(ARROW, "r1", link="r2")], [])
    two = ([element(BREAKER, "q2", "Q2"), element(ARROW, "r2", link="r1")], [])
    three = ([element(BREAKER, "q3", "Q3"), element(ARROW, "r3", link="r4")], [])
    one[1].append(wire("q1", "b1", "r1", "r"))
    two[0].append(element(ARROW, "r4", link="r3"))
    two[1].extend([wire("r2", "r", "q2", "t1"), wire("r2", "r", "r4", "r")])
    three[1].append(wire("q3", "t1", "r3", "r"))
    order, account = read(one, two, three)
    assert ends(order) == [("Q1:B1", "Q2:T1.1"), ("Q2:T1.2", "Q3:T1")]
    assert (account.connections, account.joined, account.wires_joined) == (4, 4, 2)


@pytest.mark.parametrize(
    ("link", "said"),
    [("r2", "leads to no second device"), ("", "is linked to no other: link them")],
)
def test_a_reference_that_leads_nowhere_is_left_out(link, said):
    elements = [*TWO, element(ARROW, "r1", link=link), element(ARROW, "r2")]
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q1", "b2", "r1", "r")]
    _, account = read((elements, conductors))
    assert account.left_out[0].source == "folio 1, line 3"
    assert said in account.left_out[0].reason


def test_a_point_with_two_wires_becomes_two_terminals():
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q1", "b1", "q2", "t2")]
    order, account = read((TWO, conductors))
    assert ends(order) == [("Q1:B1.1", "Q2:T1"), ("Q1:B1.2", "Q2:T2")]
    assert any("Q1:B1 is given 2 clamps" in line for line in account.assumptions)


def test_what_the_file_does_not_say_is_assumed_and_reported():
    elements = [element(BREAKER, "q1"), element(BREAKER, "q2")]
    order, account = read((elements, [wire("q1", "b1", "q2", "t1")]))
    assert ends(order) == [("breaker:B1", "breaker#2:T1")]
    assert (order.wires[0].colour, order.wires[0].section_mm2) == ("BK", 2.5)
    assert len(account.assumptions) == 4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"not xml at all", "is no XML"),
        (b"", "is no XML"),
        (b"<html/>", "root element is <html>"),
        (b"<project/>", "at least one <diagram>"),
        (b'<!DOCTYPE p [<!ENTITY a "b">]><project>&a;</project>', "line 1: document type p found"),
        (project(([element(LAMP, "e1")], [])), "none of its 0 conductors"),
        (project((TWO, [wire("q1", "zz", "q2", "t1")])), "terminal {zz} is not in the definition"),
        (project((TWO, [wire("q9", "b1", "q2", "t1")])), "element q9 is not in the project"),
        (project((TWO, [wire("q1", "b1", "q1", "b1")])), "both its ends are at the same terminal"),
        (project(([*TWO, TWO[0]], [])), "element q1 is there before, at line 1"),
        (project((TWO, [wire("q1", "b1", "q2", "t1")])).replace(b'x="-10"', b'x="left"'), "'left'"),
    ],
)
def test_what_is_no_project_is_refused_with_the_reason(text, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        import_qet(text, "test", "test.qet", CATALOGUE)


def test_a_number_for_two_terminals_of_a_folio_is_named():
    elements = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2", first_id=3)]
    conductors = [
        '<conductor terminal1="2" terminal2="6"/>',
        '<conductor terminal1="0" terminal2="3"/>',
    ]
    _, account = read((elements, conductors))
    assert account.left_out[0].reason == "terminal 3 is there twice, at line 1 and line 1"


# Drawings of parts for other projects: elements, and no conductor.
WITHOUT_CONDUCTORS = {"ShellyParts.qet", "pinball_williams_em.qet"}
# Charts of programs, whose conductors are no wires.
CHARTS = {"grafcet.qet", "iso_sfc_example.qet"}


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.qet")), ids=lambda file: file.stem)
def test_every_conductor_of_every_shipped_project_is_accounted_for(file):
    text = file.read_bytes()
    project = etree.fromstring(text)
    if file.name in WITHOUT_CONDUCTORS:
        assert not project.findall("diagram/conductors/conductor")
        with pytest.raises(DesignError, match="0 conductors joins two devices"):
            import_qet(text, "real", file.name, CATALOGUE)
        return
    if file.name in CHARTS:
        with pytest.raises(DesignError, match=r"nothing to wire; .* ends on a picture"):
            import_qet(text, "real", file.name, CATALOGUE)
        return
    imported = import_qet(text, "real", file.name, CATALOGUE)
    order, account = imported.order, imported.account
    direct = len(order.wires) - account.wires_joined
    assert account.connections == len(project.findall("diagram/conductors/conductor"))
    assert account.connections == direct + account.joined + len(account.left_out)
    used = [end for wire in order.wires for end in (wire.a, wire.b)]
    known = {TerminalRef(c.name, t.name) for c in order.components for t in c.terminals}
    assert len(used) == len(set(used))
    assert set(used) == known


@pytest.mark.parametrize(
    "file",
    sorted(f for f in EXAMPLES.glob("*.qet") if f.name not in WITHOUT_CONDUCTORS | CHARTS),
    ids=lambda file: file.stem,
)
def test_wires_of_every_shipped_project_have_the_numbers_of_their_conductors(file):
    text = file.read_bytes()
    drawn = {
        f"folio {folio}, line {node.sourceline}": " ".join(node.get("num", "").split())
        for folio, diagram in enumerate(etree.fromstring(text).findall("diagram"), start=1)
        for node in diagram.findall("conductors/conductor")
    }
    order = import_qet(text, "real", file.name, CATALOGUE).order
    for each in order.wires:
        number = drawn[each.source]
        if number not in ("", "_") and "mm" not in number:
            assert each.number == number
            assert each.name.startswith(number)


def test_without_references_wires_and_devices_are_conductors_and_elements():
    for name in ("schema_indus", "741", "convertisseur", "lmdg"):
        text = (EXAMPLES / f"{name}.qet").read_bytes()
        project = etree.fromstring(text)
        order = import_qet(text, name, name, CATALOGUE).order
        numbers = {
            (folio, terminal.get("id")): element
            for folio, diagram in enumerate(project.findall("diagram"))
            for element in diagram.findall("elements/element")
            for terminal in element.findall("terminals/terminal")
        }
        conductors = [
            (folio, conductor)
            for folio, diagram in enumerate(project.findall("diagram"))
            for conductor in diagram.findall("conductors/conductor")
        ]
        wired = {
            numbers[folio, conductor.get(end)]
            for folio, conductor in conductors
            for end in ("terminal1", "terminal2")
        }
        assert len(order.wires) == len(conductors)
        assert len(order.components) == len(wired)


def test_the_household_panel_has_its_fifty_eight_wires():
    text = (EXAMPLES / "tableau_domestique.qet").read_bytes()
    order = import_qet(text, "house", "tableau_domestique.qet", CATALOGUE).order.in_cabinet()
    assert len(order.wires) == 58
    assert str(order.wires[0].a) == "HDA245S:B2"
    assert str(order.wires[0].b) == "Q1:T2.1"


def test_the_industrial_project_has_all_its_conductors():
    text = (EXAMPLES / "industrial.qet").read_bytes()
    imported = import_qet(text, "industrial", "industrial.qet", CATALOGUE)
    account = imported.account
    assert account.connections == 671
    assert (account.joined, account.wires_joined, len(account.left_out)) == (324, 213, 2)
    assert len(imported.order.wires) == 558
