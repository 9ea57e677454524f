"""The importer of QElectroTech projects, on small drawings and on a real one."""

import re
from pathlib import Path

import pytest
from lxml import etree

from remodel_planner.core.production import Side, TerminalRef
from remodel_planner.core.qet import import_qet
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.errors import DesignError

CATALOGUE = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
EXAMPLES = Path("/usr/share/qelectrotech/examples")

COLLECTION = """
<collection><category name="import">
  <category name="20_manufacturers_articles"><element name="breaker.elmt">
    <definition link_type="master" type="element"><description>
      <terminal uuid="{t1}" x="-10" y="-20" orientation="n"/>
      <terminal uuid="{t2}" x="10" y="-20" orientation="n"/>
      <terminal uuid="{b1}" x="-10" y="20" orientation="s"/>
      <terminal uuid="{b2}" x="10" y="20" orientation="s"/>
    </description></definition></element></category>
  <category name="500_home_installation"><element name="lamp.elmt">
    <definition link_type="simple" type="element"><description>
      <terminal uuid="{l}" x="0" y="0" orientation="n"/>
    </description></definition></element></category>
  <category name="100_folio_referencing"><element name="arrow.elmt">
    <definition link_type="next_report" type="element"><description>
      <terminal uuid="{r}" x="0" y="0" orientation="w"/>
    </description></definition></element></category>
</category></collection>
"""
BREAKER = "embed://import/20_manufacturers_articles/breaker.elmt"
LAMP = "embed://import/500_home_installation/lamp.elmt"
ARROW = "embed://import/100_folio_referencing/arrow.elmt"
TERMINALS = {
    BREAKER: ((-10, -20, 0), (10, -20, 0), (-10, 20, 2), (10, 20, 2)),
    LAMP: ((0, 0, 0),),
    ARROW: ((0, 0, 3),),
}


def element(kind, uuid, label="", link="", first_id=0):
    terminals = "".join(
        f'<terminal id="{first_id + n}" x="{x}" y="{y}" orientation="{o}"/>'
        for n, (x, y, o) in enumerate(TERMINALS[kind])
    )
    return (
        f'<element type="{kind}" uuid="{uuid}"><terminals>{terminals}</terminals>'
        f'<elementInformations><elementInformation name="label">{label}</elementInformation>'
        f"</elementInformations>"
        f"<links_uuids>{f'<link_uuid uuid={link!r}/>' if link else ''}</links_uuids></element>"
    )


def wire(element1, terminal1, element2, terminal2, more=""):
    return (
        f'<conductor element1="{element1}" terminal1="{{{terminal1}}}" element2="{element2}" '
        f'terminal2="{{{terminal2}}}" {more}/>'
    )


def project(*folios):
    diagrams = "".join(
        f"<diagram><elements>{''.join(elements)}</elements>\n"
        f"<conductors>{chr(10).join(conductors)}</conductors></diagram>"
        for elements, conductors in folios
    )
    return f'<project title="Test">{diagrams}{COLLECTION}</project>'.encode()


def read(*folios):
    return import_qet(project(*folios), "test", "test.qet", CATALOGUE)


def ends(order):
    return [(str(wire.a), str(wire.b)) for wire in order.wires]


TWO = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2")]


def test_a_conductor_between_two_devices_is_a_wire():
    attributes = 'conductor_section="1.5mm²" conductor_color="Bleu"'
    order, account = read((TWO, [wire("q1", "b2", "q2", "t1", attributes)]))
    assert ends(order) == [("Q1:B2", "Q2:T1")]
    assert (order.wires[0].colour, order.wires[0].section_mm2) == ("BU", 1.5)
    assert order.components[0].terminal("B2").side is Side.BOTTOM
    assert not account.guesses
    assert not account.left_out


def test_terminals_numbered_on_the_folio_are_understood():
    elements = [element(BREAKER, "q1", "Q1"), element(BREAKER, "q2", "Q2", first_id=4)]
    order, _ = read((elements, ['<conductor terminal1="3" terminal2="4" num="2,5 mm2"/>']))
    assert ends(order) == [("Q1:B2", "Q2:T1")]
    assert order.wires[0].section_mm2 == 2.5


def test_a_conductor_to_the_field_is_left_out_with_its_place():
    elements = [*TWO, element(LAMP, "e1")]
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q2", "b1", "e1", "l")]
    order, account = read((elements, conductors))
    assert len(order.wires) == 1
    assert [(item.reason, item.source) for item in account.left_out] == [
        ("it leaves the cabinet", "folio 1, line 3")
    ]


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
    assert (account.conductors, account.joined, account.wires_joined) == (4, 4, 2)


def test_a_reference_that_leads_nowhere_is_left_out():
    elements = [*TWO, element(ARROW, "r1")]
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q1", "b2", "r1", "r")]
    _, account = read((elements, conductors))
    assert "no second device" in account.left_out[0].reason


def test_a_point_with_two_wires_becomes_two_terminals():
    conductors = [wire("q1", "b1", "q2", "t1"), wire("q1", "b1", "q2", "t2")]
    order, account = read((TWO, conductors))
    assert ends(order) == [("Q1:B1.1", "Q2:T1"), ("Q1:B1.2", "Q2:T2")]
    assert any("Q1:B1 is given 2 clamps" in guess for guess in account.guesses)


def test_what_the_file_does_not_say_is_guessed_aloud():
    elements = [element(BREAKER, "q1"), element(BREAKER, "q2")]
    order, account = read((elements, [wire("q1", "b1", "q2", "t1")]))
    assert ends(order) == [("breaker:B1", "breaker#2:T1")]
    assert (order.wires[0].colour, order.wires[0].section_mm2) == ("BK", 2.5)
    assert len(account.guesses) == 4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"not xml at all", "no XML"),
        (b"", "no XML"),
        (b"<html/>", "root element is <html>"),
        (b"<project/>", "at least one <diagram>"),
        (b'<!DOCTYPE p [<!ENTITY a "b">]><project>&a;</project>', "at least one <diagram>"),
        (project(([element(LAMP, "e1")], [])), "none of its 0 conductors"),
        (project((TWO, [wire("q1", "zz", "q2", "t1")])), "terminal {zz} is not in the definition"),
        (project((TWO, [wire("q9", "b1", "q2", "t1")])), "element q9 is not in the project"),
    ],
)
def test_what_is_no_project_is_refused_with_the_reason(text, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        import_qet(text, "test", "test.qet", CATALOGUE)


@pytest.mark.parametrize(
    "file", ["tableau_domestique.qet", "perceuse.qet", "industrial.qet", "affuteuse_250h.qet"]
)
def test_every_conductor_of_a_real_project_is_accounted_for(file):
    text = (EXAMPLES / file).read_bytes()
    order, account = import_qet(text, "real", file, CATALOGUE)
    direct = len(order.wires) - account.wires_joined
    assert account.conductors == len(etree.fromstring(text).findall(".//conductors/conductor"))
    assert account.conductors == direct + account.joined + len(account.left_out)
    used = [end for wire in order.wires for end in (wire.a, wire.b)]
    known = {TerminalRef(c.name, t.name) for c in order.components for t in c.terminals}
    assert len(used) == len(set(used))
    assert set(used) == known


def test_the_household_panel_has_its_fifty_four_wires():
    text = (EXAMPLES / "tableau_domestique.qet").read_bytes()
    order, _ = import_qet(text, "house", "tableau_domestique.qet", CATALOGUE)
    assert len(order.wires) == 54
    assert str(order.wires[0].a) == "HDA245S:B2"
    assert str(order.wires[0].b) == "Q1:T2.1"
