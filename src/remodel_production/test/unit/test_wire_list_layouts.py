"""Wire lists with the headings of many programs and people: nothing is lost without a word."""

from datetime import date
from pathlib import Path

import pytest
import yaml
from wire_lists import CATALOGUE, MAPPINGS, read, rows, workbook

from remodel_production.core.imports.formats import built_in_formats, format_of
from remodel_production.core.imports.wire_list import mapping_draft
from remodel_production.core.imports.wire_list_mapping import mapping_from
from remodel_production.core.production import Role
from remodel_production.errors import DesignError

# Name: list, its wires, and its columns that are not used.
LAYOUTS = {
    "a machine that cuts and crimps": (
        "Schneidliste;;;;;;;;;\nPos.;Leitungsnr.;Querschnitt [mm²];Farbe;Länge [mm];Kontakt links;"
        "Abisolierlänge rechts;Kontakt rechts;Von;Nach\n"
        "1;W101;0,75;sw;1.250,5;AEH 0,75;6;AEH 0,75;-K1:A1;-X1:12\n",
        [("W101", "-K1:A1", "-X1:12", "BK", 0.75, 1.2505)],
        ["Pos.", "Kontakt links", "Abisolierlänge rechts", "Kontakt rechts"],
    ),
    "a line for each end": (
        "Connector,Cavity,Wire No,Signal,Color,Gauge (AWG),Length (mm)\nP1,1,101,PWR,RED,18,\n"
        "P1,2,102,GND,BLK,18,250\nJ2,A,101,PWR,,18,300\nJ2,B,102,GND,BLK,18,\n",
        [
            ("101", "P1:1", "J2:A", "RD", 0.823, 0.3),
            ("102", "P1:2", "J2:B", "BK", 0.823, 0.25),
        ],
        ["Signal"],
    ),
    "left and right": (
        "Job;Wire;CSA;Color;Length;Left Connector;Left Cavity;Left Terminal;Right Connector;"
        "Right Cavity;Right Terminal\nJ1;W1;0.5;red;300;P1;1;T9;P2;2;T8\n",
        [("W1", "P1:1", "P2:2", "RD", 0.5, 0.3)],
        ["Job", "Left Terminal", "Right Terminal"],
    ),
    "a row of groups above the headings": (
        "Wire,From,,To,,Conductor,,\nNo.,Device,Pin,Device,Pin,Color,AWG,Length [in]\n"
        "101,PS1,+,TB1,1,RED,14,12.5\n",
        [("101", "PS1:+", "TB1:1", "RD", 2.08, 0.3175)],
        [],
    ),
    "groups, and a column without one": (
        "Wire No,From,,To,,Colour,,Remark\n,Device,Pin,Device,Pin,,Section,\n1,K1,A1,X1,3,BU,1,x\n",
        [("1", "K1:A1", "X1:3", "BU", 1.0, None)],
        ["Remark"],
    ),
    "a row of units below the headings": (
        "Wire,From,To,Section,Colour,Length\n,,,(mm²),-,cm\nW1,K1:A1,X1:1,0.75,BU,35\n",
        [("W1", "K1:A1", "X1:1", "BU", 0.75, 0.35)],
        [],
    ),
    "headings with line breaks below a comment": (
        '# exported\n"Wire\nNumber","From\nConnector","From\nPin","To\nConnector","To\nPin",'
        '"Size\n(AWG)","Length\n(in)"\n1,J1,1,J2,1,22,10\n',
        [("1", "J1:1", "J2:1", "BK", 0.326, 0.254)],
        [],
    ),
    "French harness": (
        "Repère du fil;Tenant (appareil);Tenant (borne);Aboutissant (appareil);Aboutissant (borne);"
        "Section (mm²);Couleur;Longueur (m)\n1;KM1;1/L1;QF1;2/T1;2,5;noir;0,85\n",
        [("1", "KM1:1/L1", "QF1:2/T1", "BK", 2.5, 0.85)],
        [],
    ),
    "Italian abbreviations, with the units that are usual there": (
        "Filo;Da;Morsetto;A;Morsetto;Sez.;Col.;Lungh.;Note\n1;QF1;2;KM1;1;4;nero;600;\n",
        [("1", "QF1:2", "KM1:1", "BK", 4.0, 0.6)],
        ["Note"],
    ),
    "Spanish, whose cables are wires": (
        "Cable,Desde,Terminal,Hasta,Terminal,Calibre AWG,Color,Longitud m\n"
        "C1,TB1,1,K1,13,16,rojo,0.9\nC2,TB1,2,K1,14,16,negro,0.9\n",
        [
            ("C1", "TB1:1", "K1:13", "RD", 1.31, 0.9),
            ("C2", "TB1:2", "K1:14", "BK", 1.31, 0.9),
        ],
        [],
    ),
    "two targets": (
        "Ader;Ziel 1;Anschluss 1;Ziel 2;Anschluss 2;Farbe;QS;Seite\n7;-K1;A1;-X1;1;BU;1.5;4\n",
        [("7", "-K1:A1", "-X1:1", "BU", 1.5, None)],
        ["Seite"],
    ),
    "connections as terminals": (
        "Wire number;From component;From connection;To component;To connection;Wire size;Folio\n"
        "1;-K1;A1;-X1;1;1.5;3\n",
        [("1", "-K1:A1", "-X1:1", "BK", 1.5, None)],
        ["Folio"],
    ),
    "pins beside contacts": (
        "Wire Name,From Device,From Pin,To Device,To Pin,Wire CSA,From Terminal,To Terminal\n"
        "1,J1,1,J2,2,0.5,T9,T8\n",
        [("1", "J1:1", "J2:2", "BK", 0.5, None)],
        ["From Terminal", "To Terminal"],
    ),
    "whole ends beside contacts": (
        "Wire,From,From Terminal,To,To Terminal\n1,J1:1,T9,J2:2,T8\n2,J1:2,T9,J2:1,T8\n",
        [("1", "J1:1", "J2:2", "BK", 2.5, None), ("2", "J1:2", "J2:1", "BK", 2.5, None)],
        ["From Terminal", "To Terminal"],
    ),
    "whole ends under the heading of a component": (
        "Wire ID,Starting Point,Ending Point,AWG\n1,J1:1,J2:1,22\n",
        [("1", "J1:1", "J2:1", "BK", 0.326, None)],
        [],
    ),
    "numbered ends and gauges with a sign": (
        "Wire Label;End 1;End 1 Pin;End 2;End 2 Pin;Size\nA1;P1;A;P2;B;#22\n",
        [("A1", "P1:A", "P2:B", "BK", 0.326, None)],
        [],
    ),
    "terminations, of which terminals follow a hyphen": (
        "Wire #,Termination 1,Termination 2,Wire Gauge,Length (inches)\n"
        "1,J1-1,J2-1,22,10\n2,J1-2,J2-2,22,10\n",
        [("1", "J1:1", "J2:1", "BK", 0.326, 0.254), ("2", "J1:2", "J2:2", "BK", 0.326, 0.254)],
        [],
    ),
    "ends in columns of the same name behind the number of the line": (
        "Item,Location,Device,Terminal,Location,Device,Terminal,Wire No,Size\n"
        "1,+A1,K1,13,+A2,X1,1,101,1.5\n",
        [("101", "K1:13", "X1:1", "BK", 1.5, None)],
        ["Item", "Location", "Location#2"],
    ),
    "words without blanks": (
        "SourceRefDes,SourcePin,DestRefDes,DestPin,WireGaugeAWG,LengthMM\nJ1,1,J2,1,22,100\n",
        [("W1", "J1:1", "J2:1", "BK", 0.326, 0.1)],
        [],
    ),
    "abbreviations with points": (
        "Ltg.-Nr.;Von Stecker;Von Kammer;Nach Stecker;Nach Kammer;Querschn. (mm²);Est. Length mm\n"
        "L1;X1;1;X2;1;0,35;450\n",
        [("L1", "X1:1", "X2:1", "BK", 0.35, 0.45)],
        [],
    ),
    "Excel's line about the separator, and points between thousands": (
        "sep=;\nWire;From;To;Length [mm]\n1;-K1:13;-X1:4;1.250\n2;-K1:14;-X1:5;830\n",
        [
            ("1", "-K1:13", "-X1:4", "BK", 2.5, 1.25),
            ("2", "-K1:14", "-X1:5", "BK", 2.5, 0.83),
        ],
        [],
    ),
    "gauges with lengths that are inches only": (
        "Connector,Pin,Color,AWG,Connector,Pin,Length\nJ1,1,RD,22,J2,1,12.5\n",
        [("W1", "J1:1", "J2:1", "RD", 0.326, 0.3175)],
        [],
    ),
    "empty columns around": (
        ";;;;;\n;Wire;From;To;;Color\n;1;K1:1;X1:1;;RD\n",
        [("1", "K1:1", "X1:1", "RD", 2.5, None)],
        [],
    ),
}


CASES = yaml.safe_load((Path(__file__).parents[1] / "wire_list_headings.yaml").read_text())


@pytest.mark.parametrize("case", CASES, ids=[case["headings"] for case in CASES])
def test_headings_of_five_languages_are_understood(case):
    imported = read(f"{case['headings']}\n{case['line']}\n")
    assert rows(imported) == [tuple(case["wire"])]
    omitted = [column.source for column in imported.account.unused_columns]
    assert omitted == [f"column {heading!r}" for heading in case["unused"]]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_is_read_whole(layout):
    text, wires, unused = LAYOUTS[layout]
    imported = read(text)
    assert rows(imported) == wires
    omitted = [line.source for line in imported.account.unused_columns]
    assert omitted == [f"column {heading!r}" for heading in unused]
    assert imported.account.left_out == ()


# A mapping means what it says, and none of it says that a point is between thousands.
@pytest.mark.parametrize("layout", [name for name in LAYOUTS if "thousands" not in name])
def test_the_mapping_that_is_printed_reads_the_list_alike(layout):
    text, wires, _ = LAYOUTS[layout]
    mapping = mapping_from(mapping_draft(text.encode(), CATALOGUE, MAPPINGS).text)
    assert rows(read(text, mapping)) == wires


@pytest.mark.parametrize(
    ("ends", "component"),
    [
        (("TB-1", "MTR-1"), "TB-1"),  # tags of devices, not terminals
        (("K1", "X1"), "K1"),
        (("J1-1", "J2-POWER"), "J1-1"),
    ],
)
def test_tags_with_hyphens_stay_whole_unless_all_ends_have_terminals(ends, component):
    imported = read(f"Wire,From,To\n1,{','.join(ends)}\n2,{','.join(ends)}\n")
    assert imported.order.wires[0].a.component == component
    assert f"line 2: no terminal of {component} is given, 1 taken" in imported.account.assumptions


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(512), "Excel 97 to 2003 .* save it as .xlsx"),
        (
            b"PK\x03\x04mimetypeapplication/vnd.oasis.opendocument.spreadsheetPK",
            "is an OpenDocument spreadsheet .*: save it as .xlsx or .csv",
        ),
    ],
)
def test_other_spreadsheets_are_refused_with_what_to_do(data, said):
    with pytest.raises(DesignError, match=said):
        format_of(data, built_in_formats(MAPPINGS))


def test_a_cut_list_is_refused_with_what_it_lacks():
    with pytest.raises(
        DesignError,
        match="missing: from or from_component and to or to_component; "
        "a cut list states how wires are cut, not where they end",
    ):
        read("Wire;Section mm2;Colour;Length mm;Terminal left;Terminal right\nW1;0.5;red;300;A;B\n")


HEADINGS = ["Wire", "From", "From Pin", "To", "To Pin", "mm²"]


def test_a_date_or_a_formula_beside_the_list_is_no_reason_to_refuse_it():
    lines = ["Drawn", date(2024, 3, 1), "=NOW()"], HEADINGS, ["W1", "K1", 1, "X1", 1, 0.75]
    assert rows(read(workbook(Wires=lines))) == [("W1", "K1:1", "X1:1", "BK", 0.75, None)]


def test_cells_that_span_others_stand_for_all_of_them():
    lines = [
        ["Wires of rack 1"],
        [],
        ["Wire", "From", None, "To", None, "mm²"],
        ["ID", "Device", "Pin", "Device", "Pin", None],
        ["W1", "K1", 1, "X1", 1, 0.75],
        ["W2", None, 2, "X1", 2, 0.75],
    ]
    assert rows(read(workbook(Wires=lines, merged=("A1:F1", "B3:C3", "D3:E3", "B5:B6")))) == [
        ("W1", "K1:1", "X1:1", "BK", 0.75, None),
        ("W2", "K1:2", "X1:2", "BK", 0.75, None),
    ]


def test_rows_that_repeat_the_headings_are_no_wires():
    imported = read("Wire,From,To,Note\nW1,K1:1,X1:1,\nWire,From,To,Note\nW2,K1:2,X1:2,\n")
    assert [wire.name for wire in imported.order.wires] == ["W1", "W2"]
    assert [str(item) for item in imported.account.left_out] == [
        "line 3: left out, it repeats the headings"
    ]


def test_splices_are_joints():
    imported = read("Wire,From,To\nW1,K1:1,SPLICE-1:1\nW2,X1:1,SPLICE-1:1\n")
    roles = {component.name: component.role for component in imported.order.components}
    assert roles == {"K1": Role.DEVICE, "X1": Role.DEVICE, "SPLICE-1": Role.JOINT}


def test_seals_and_twisted_groups_are_used():
    imported = read(
        "Wire,From,Cavity Seal From,To,To Seal P/N,Twist Group\n"
        "W1,K1:1,S-9,X1:1,-,TP1\nW2,K1:2,,X1:2,S-8,TP1\nW3,K1:3,,X1:3,,TP2\nW4,K1:4,,X1:4,,yes\n"
    )
    sealed = {
        f"{component.name}:{terminal.name}": terminal.kind
        for component in imported.order.components
        for terminal in component.terminals
        if terminal.is_sealed
    }
    assert sealed == {"K1:1": "with seal S-9", "X1:2": "with seal S-8"}
    assert [(cable.name, cable.kind) for cable in imported.order.cables] == [
        ("TP1", "twisted wires")
    ]
    assert [wire.cable for wire in imported.order.wires] == ["TP1", "TP1", "", ""]
    assert imported.account.unused_columns == ()
    assert (
        "which wires are twisted with each other is not given by yes: they are single wires"
        in imported.account.assumptions
    )


def test_a_sheet_with_rows_is_read_before_an_empty_one_and_a_mapping_chooses_another():
    racks = {f"Rack {n}": [HEADINGS, [f"W{n}", "K1", 1, "X1", 1, 0.75]] for n in (1, 2)}
    data = workbook(Template=[HEADINGS], **racks)
    imported = read(data)
    assert [wire.name for wire in imported.order.wires] == ["W1"]
    assert [str(item) for item in imported.account.unused_columns] == [
        f"sheet {title!r}: left out, sheet 'Rack 1' is read; `sheet` in a mapping chooses another"
        for title in ("Template", "Rack 2")
    ]
    text = "format: remodel-wire-list-1\nsynonyms: true\ncolumns: {from: From, to: To}\nsheet: "
    chosen = read(data, mapping_from(f"{text}Rack 2"))
    assert [wire.name for wire in chosen.order.wires] == ["W2"]
    with pytest.raises(DesignError, match="no sheet 'Rack 3'; the workbook has 'Template', 'Rack"):
        read(data, mapping_from(f"{text}Rack 3"))


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("=1+1", r"line 2: from_terminal: =1\+1 has no value: open the workbook"),
        ("#REF!", "line 2: from_terminal: #REF! found, the error of a formula"),
    ],
)
def test_formulas_without_a_value_are_refused(cell, said):
    with pytest.raises(DesignError, match=said):
        read(workbook(Wires=[HEADINGS, ["W1", "K1", cell, "X1", 1, 0.75]]))


def test_what_has_not_two_ends_in_a_pin_list_is_left_out_and_disagreements_are_named():
    imported = read(
        "Device,Pin,Wire,Colour\nA,1,W1,RD\nB,1,W1,BK\nA,2,W2,RD\nA,3,W3,\nB,3,W3,\nC,3,W3,\n"
        "A,4,,RD\n,5,W4,RD\nDevice,Pin,Wire,Colour\n"
    )
    assert rows(imported) == [("W1", "A:1", "B:1", "RD", 2.5, None)]
    assert (imported.account.unit, imported.account.connections) == ("wires", 6)
    assert [str(item) for item in imported.account.left_out] == [
        "line 8: left out, it names no wire",
        "line 9: left out, it names no component",
        "line 10: left out, it repeats the headings",
        "line 4: left out, wire W2 has one end; two are needed",
        "line 5: left out, wire W3 has 3 ends, in lines 5, 6, 7; two are needed: name each wire "
        "between two of them",
    ]
    assert "line 2, wire W1: colour is 'RD', and 'BK' in line 3: the first taken" in (
        imported.account.assumptions
    )
    with pytest.raises(DesignError, match="none of its 1 wires names both ends; the first: line 2"):
        read("Device,Pin,Wire\nA,1,W1\n")


def test_a_mapping_may_name_the_columns_of_a_pin_list():
    text = "format: remodel-wire-list-1\ncolumns: {wire: N, component: C, terminal: P}\n"
    imported = read("N,C,P\nW1,A,1\nW1,B,2\n", mapping_from(text))
    assert rows(imported) == [("W1", "A:1", "B:2", "BK", 2.5, None)]
    draft = mapping_draft(b"Device,Pin,Wire\nA,1,W1\nB,1,W1\n", CATALOGUE, MAPPINGS).text
    assert read("Device,Pin,Wire\nA,1,W1\nB,1,W1\n", mapping_from(draft)).order.wires
    assert "missing" not in draft
    with pytest.raises(DesignError, match="or a line for each with `wire`, `component` and `term"):
        mapping_from(text.replace("wire: N, ", ""))
