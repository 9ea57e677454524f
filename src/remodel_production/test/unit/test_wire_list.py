"""The importer of from-to lists, with the mappings that come with the package."""

import io
import re
import zipfile
from datetime import date
from pathlib import Path

import pytest
from wire_lists import CATALOGUE, MAPPINGS, read, rows, workbook

from remodel_production.core.imports import wire_list_table
from remodel_production.core.imports.documents import sheets_of
from remodel_production.core.imports.wire_list import mapping_draft
from remodel_production.core.imports.wire_list_mapping import mapping_from
from remodel_production.errors import DesignError

DESIGNS = Path(__file__).parent / "designs"


def test_an_eplan_like_list_in_windows_encoding_with_decimal_commas():
    imported = read((DESIGNS / "eplan.csv").read_bytes())
    assert imported.order.title == ""  # it is called by its file
    assert rows(imported) == [
        ("101", "=A1+C1-K1:A1", "=A1+C1-X1:3.1", "BU", 1.5, 0.35),
        ("102", "=A1+C1-K1:A2", "=A1+C1-X1:4", "GNYE", 2.5, 1.2),
        ("101#2", "=A1+C1-X1:3.2", "=A1+C1-F1:2", "BU", 2.08, None),
        ("W7.1", "=A1+C1-X1:7", "+M1:U", "BN", 0.75, 12.0),
    ]
    assert [(cable.name, cable.source) for cable in imported.order.cables] == [("W7", "line 5")]
    assert imported.account.assumptions[:6] == (
        "column 'Cross-section' states no unit: mm2 taken",
        "column 'Length' states no unit: m taken",
        "the file is no UTF-8: read as cp1252",
        "line 4: colour 'hellblau' read as BU",
        "nothing says where 4 devices are mounted: the plate taken, such as for =A1+C1-K1 (columns "
        "of places, or --placement)",
        "line 4: name 101 occurs before, at line 2; named 101#2",
    )
    assert [str(item) for item in imported.account.left_out] == [
        "line 6: left out, its second end is not given"
    ]


def test_an_autocad_like_report_with_titles_layers_and_quotes():
    imported = read((DESIGNS / "autocad_electrical.csv").read_bytes())
    assert rows(imported) == [
        ("1", "CR1:A1.1", "TB1:1", "BK", 2.08, 0.508),
        ("1#2", "CR1:A1.2", "LT1:X1", "BK", 2.08, None),
        ("24", "M1, spare:13", "TB1:2", "GNYE", 3.31, 0.9144),
    ]
    assert [str(item) for item in imported.account.left_out] == [
        "line 8: left out, the same wire is in line 7"
    ]


def test_an_elecdes_like_schedule_with_tabs_and_cores():
    imported = read((DESIGNS / "elecdes.csv").read_bytes())
    assert rows(imported) == [
        ("C100-1", "JB1:1", "PLC1:DI0", "RDWH", 1.5, None),
        ("C100-2", "JB1:2", "PLC1:DI1", "BK", 1.5, None),
        ("W3", "JB1:3", "PLC1:1", "BK", 1.5, None),
    ]
    assert [(w.cable, w.core) for w in imported.order.wires[:2]] == [("C100", "1"), ("C100", "2")]
    assert "line 6: no terminal of PLC1 is given, 1 taken" in imported.account.assumptions


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
def test_encodings_and_separators_are_found(encoding, separator):
    text = "Wire,From,To,Section\nÄ1,K1:1,X1:2,2.5\n".replace(",", separator)
    imported = read(text.encode(encoding))
    assert rows(imported) == [("Ä1", "K1:1", "X1:2", "BK", 2.5, None)]


def test_a_list_with_places_has_them():
    text = "From,To,From x,From y,To x,To y\nK1:1,X1:2,100,0,-50,-220\nK1:3,X1:4,,,,\n"
    k1, x1 = read(text).order.components
    assert (k1.pose.position, x1.pose.position) == ((0.1, 0.0, 0.0), (-0.05, -0.22, 0.0))


MINE = """
format: remodel-wire-list-1
name: mine
columns: {from: [Von, Start], to_component: Nach, to_terminal: Klemme, colour: Farbe, section: Q}
units: {section: awg}
terminal_separator: "/"
separator: tab
encoding: cp1252
colours: {hellblau: BU}
"""


def test_a_mapping_of_ones_own():
    text = "Start\tNach\tKlemme\tFarbe\tQ\nK/1/A1\tX1\t7\tHellblau\t12\n"
    imported = read(text.encode("cp1252"), mapping_from(MINE))
    assert rows(imported) == [("W1", "K/1:A1", "X1:7", "BU", 3.31, None)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no line of the first 30 has the headings of a wire list; found ''"),
        ("a,b\n1,2\n", "found 'a,b'; needed are headings such as From Device"),
        ("From,To\n", "none of its 0 lines names both ends"),
        ("From,To\nK1:1,\n", "none of its 1 lines names both ends; the first: line 2"),
        ("From,To\nK1:1,K1:1\n", "both its ends are at K1:1"),
        ("From,To\nK1:1,X1:1,X2:1\n", "line 2: 3 cells found; there are 2 headings: quote"),
        ('From,To\nK1:1,"X1:1\n', "line 2: is no CSV: unexpected end of data"),
        ("From,To\nK1:1," + "x" * 60000, "line 2: a cell is longer than 50000"),
        ("From,To\n" + "a:1,b:1\n" * 50001, "line 50002: more than 50000 lines"),
        ("From,To,From x,From y\nA:1,B:1,1,2\nA:2,B:2,1,3\n", "line 3: A is at ('1', '3'), and e"),
        ("From,To,From x,From y\nA:1,B:1,1,\n", "line 2: place of A: ('1', '') found; two length"),
        (b"From,To\nA:1,B:\x001\n", "line 2: a zero byte found"),
        (b"\xff\xfeF", "line 1: byte 0x46 is no utf-16"),
    ],
)
def test_a_malformed_list_is_refused_with_the_line(text, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        read(text)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("list-1", "list-2", "format 'remodel-wire-list-2' found; `format: remodel-wire-list-1`"),
        ("format:", "form:", "line 2: the mapping: key form is not known"),
        ("columns:", "name2: x\n#", "key name2 is not known; allowed: format, name, columns"),
        ("section: awg", "section: mil", "line 5: unit of section: mil found; allowed: mm2, awg"),
        ("encoding:", "synonyms: 1\nencoding:", "line 8: synonyms: 1 found; allowed: true, false"),
        ("section: awg", "length: ell", "line 5: unit of length: ell found; allowed: mm, cm"),
        ("section: awg", "weight: kg", "line 5: units: key weight is not known"),
        ("from: [Von, Start], ", "", "neither `from` nor `from_component` is given"),
        ("Farbe", "[]", "line 4: column colour: give a heading, or a list of them"),
        ("Farbe", "{a: b}", "column colour: expected a list, found a mapping"),
        ("name: mine", "name: [a]", "line 3: name: a text is needed"),
        ("name: mine", "name: mine\nname: yours", "line 4: key name is given before, at line 3"),
    ],
)
def test_a_malformed_mapping_is_refused_with_the_line(old, new, said):
    assert old in MINE
    with pytest.raises(DesignError, match=re.escape(said)):
        mapping_from(MINE.replace(old, new))


def test_a_mapping_needs_columns():
    with pytest.raises(DesignError, match="`columns` is missing"):
        mapping_from("format: remodel-wire-list-1")


def test_an_encoding_that_is_not_known_is_refused():
    with pytest.raises(DesignError, match="encoding klingon: not known"):
        read("From,To\n", mapping_from(MINE.replace("cp1252", "klingon")))


LIMITED = "From;To;From force limit N;To force limit N\nK1:1;X1:1;25,5;\nK1:1;X1:2;25.5;{}\n"


def test_force_limits_of_terminals_are_read_where_a_list_has_them():
    order = read(LIMITED.format("12")).order
    limits = {
        f"{component.name}:{terminal.name}": terminal.insertion_force_limit_n
        for component in order.components
        for terminal in component.terminals
    }
    assert limits == {"K1:1.1": 25.5, "K1:1.2": 25.5, "X1:1": None, "X1:2": 12.0}


def test_force_limits_that_cannot_be_are_refused_with_their_line():
    with pytest.raises(DesignError, match=r"line 3: force limit of X1:2: '-3' found; a number of"):
        read(LIMITED.format("-3"))
    twice = LIMITED.format("7") + "K1:1;X1:3;9;"
    with pytest.raises(DesignError, match=r"line 4: force limit of K1:1: 9 N found, and 25\.5 N"):
        read(twice)


def test_a_column_that_is_not_used_is_named_with_what_it_may_be():
    imported = read("From,To,Lenght (mm),Torque,Color,Colour\nK1:1,X1:2,35,0.6,blue,red\n")
    assert [str(column) for column in imported.account.unused_columns] == [
        "column 'Lenght (mm)': left out, its heading is not known; similar: length",
        "column 'Torque': left out, its heading is not known",
        "column 'Color': left out, another column is read as colour",
    ]
    assert imported.order.notes[-3:] == tuple(map(str, imported.account.unused_columns))


def test_a_mapping_of_ones_own_names_what_it_does_not_list():
    text = "Start\tNach\tKlemme\tLength\nK/1/A1\tX1\t7\t350\n"
    (column,) = read(text.encode("cp1252"), mapping_from(MINE)).account.unused_columns
    assert str(column) == "column 'Length': left out, the mapping does not list its heading"


@pytest.mark.parametrize(
    ("heading", "cell", "section_mm2", "length_m", "unit"),
    [
        ("Gauge", "18", 0.823, None, "awg"),
        ("Gauge", "0.75", 0.75, None, "mm2"),
        ("Querschnitt", "22", 0.326, None, "awg"),
        ("Querschnitt", "2,5", 2.5, None, "mm2"),
        ("Leitungslänge", "350", 2.5, 0.35, "mm"),
        ("Connection length", "350", 2.5, 0.35, "mm"),
        ("Connection length", "3.5", 2.5, 3.5, "m"),
    ],
)
def test_the_numbers_of_a_column_choose_its_unit_where_its_heading_does_not(
    heading, cell, section_mm2, length_m, unit
):
    imported = read(f"Source;Target;{heading}\nK1:1;X1:2;{cell}\n")
    (wire,) = imported.order.wires
    assert (wire.section_mm2, wire.length_m) == (section_mm2, length_m)
    assert f"column {heading!r} states no unit: {unit} taken" in imported.account.assumptions


@pytest.mark.parametrize(
    ("headings", "cells", "row"),
    [
        ("From Conn,From Cav,To Conn,To Cav,No,Name", "K1,2,X1,3,9,W4", ("W4", "K1:2", "X1:3")),
        ("Connector,Pin,Connector,Pin,Name", "K1,2,X1,3,W4", ("W4", "K1:2", "X1:3")),
        ("Pin #1,Plug #1,Pin #2,Plug #2,Nr.", "2,K1,3,X1,4", ("4", "K1:2", "X1:3")),
        ("Von,Pin,Nach,Pin,Draht", "K1,2,X1,3,W4", ("W4", "K1:2", "X1:3")),
        ("Da,A,Filo", "K1:2,X1:3,W4", ("W4", "K1:2", "X1:3")),
    ],
)
def test_headings_that_mean_something_by_what_stands_beside_them(headings, cells, row):
    imported = read(f"{headings}\n{cells}\n")
    assert [found[:3] for found in rows(imported)] == [row]


def test_misspelt_headings_are_refused_with_what_they_resemble():
    with pytest.raises(DesignError, match="similar: 'Form Device' to 'from device'; give the"):
        read("Form Device,To Device\nK1,X1\n")


def test_the_mapping_of_a_list_that_is_not_understood_is_drafted_as_far_as_it_goes():
    draft = mapping_draft(
        "Cut list\nAb;Nach;Länge [cm]\nK1:1;X1:2;7\nK1:2;X1:3;8;9\n".encode(), CATALOGUE, MAPPINGS
    )
    assert draft.rows == (("K1:1", "X1:2", "7"),), "up to the row that cannot be read"
    assert draft.document["columns"] == {"to": "Nach", "length": "Länge [cm]"}
    assert draft.document["separator"] == ";"
    draft = draft.text
    assert '  to: "Nach"\n' in draft
    assert "  # missing: from, or from_component\n" in draft
    assert '  # not used: "Ab"\n' in draft
    assert "units: {section: mm2, length: cm, position: mm}\n" in draft
    assert 'separator: ";"\n' in draft
    with pytest.raises(DesignError, match="no line of it has cells"):
        mapping_draft(b"dear colleague\n", CATALOGUE, MAPPINGS)


def test_a_column_without_a_heading_is_named_by_its_number_if_it_has_content():
    imported = read("From,To,,\nK1:1,X1:2,,spare\nK1:3,X1:4,,\n")
    assert [str(column) for column in imported.account.unused_columns] == [
        "column 4, without a heading: left out, its heading is not known"
    ]


HEADINGS = ["Wire", "From Device", "From Pin", "To Device", "To Pin", "Section mm²", "Length (mm)"]


def test_a_workbook_is_unpacked_once_for_all_mappings(monkeypatch):
    data = workbook(Cover=[["Title"]], Wires=[HEADINGS, ["1", "K1", "1", "K2", "2", "1", "900"]])
    unpacked = []
    monkeypatch.setattr(
        wire_list_table, "sheets_of", lambda data: unpacked.append(1) or sheets_of(data)
    )
    assert wire_list_table.has_headings(data, MAPPINGS)
    assert len(MAPPINGS) > 1
    assert len(unpacked) == 1


def test_the_sheet_of_a_workbook_with_headings_is_read_and_the_others_are_named():
    lines = [["List of 2026"], [], HEADINGS, ["W1", "K1", 13.0, "K2", "A\n2", 0.75, 200]]
    imported = read(workbook(Cover=[["by hand"]], Wires=lines, Empty=[]))
    assert rows(imported) == [("W1", "K1:13", "K2:A 2", "BK", 0.75, 0.2)]
    assert imported.order.wires[0].source == "line 4"
    assert "sheet 'Wires' is read" in imported.account.assumptions
    assert [column.source for column in imported.account.unused_columns] == ["sheet 'Cover'"]


def test_a_date_in_a_workbook_is_refused_since_it_was_a_terminal():
    lines = [HEADINGS, ["W1", "K1", date(2026, 2, 1), "K2", 1, 1, 1]]
    with pytest.raises(
        DesignError, match=r"sheet 'Wires': line 2: from_terminal: a cell is the date 2026-02-01"
    ):
        read(workbook(Wires=lines))


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (["W1", "K1", 1, "K2", 1, 1, "", "9"], "sheet 'Wires': line 2: 8 cells found"),
        (["W1", "", 1, "", 1], "sheet 'Wires': none of its 1 lines names both ends"),
    ],
)
def test_an_error_about_a_workbook_names_the_sheet(cells, said):
    with pytest.raises(DesignError, match=said):
        read(workbook(Cover=[["by hand"]], Wires=[HEADINGS, cells]))


def test_a_workbook_without_ends_is_refused_with_the_headings_of_the_sheet_that_has_most():
    data = workbook(Cover=[["Parts", "Price"]], Wires=[["Wire", "From Device", "Colour"], [1, 2]])
    with pytest.raises(DesignError) as error:
        read(data)
    assert "found 'Wire\\tFrom Device\\tColour'" in str(error.value)
    assert "read as headings in sheet 'Wires': 'Wire' as wire" in str(error.value)


def test_source_and_sink_are_the_ends_of_a_wire():
    imported = read("Circuit,Source,Sink,Wiring Gauge\nHorn,X1:2,H1:+,16 AWG\n")
    assert rows(imported) == [("Horn", "X1:2", "H1:+", "BK", 1.31, None)]
    imported = read("Wire,Source Device,Source Pin,Sink Device,Sink Pin\n1,K1,A1,X1,2\n")
    assert rows(imported) == [("1", "K1:A1", "X1:2", "BK", 2.5, None)]


def test_a_workbook_that_is_damaged_or_declares_entities_is_refused():
    data = workbook(Wires=[HEADINGS, ["W1", "K1", 1, "K2", 1, 1, 1]])
    whole = zipfile.ZipFile(io.BytesIO(data))
    for name, content, reason in (
        ("xl/workbook.xml", b"<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "has a document type"),
        ("xl/worksheets/sheet1.xml", b"<worksheet><sheetData><row>", "is a damaged XLSX workbook"),
    ):
        changed = io.BytesIO()
        with zipfile.ZipFile(changed, "w") as archive:
            for part in whole.namelist():
                archive.writestr(part, content if part == name else whole.read(part))
        with pytest.raises(DesignError, match=reason):
            read(changed.getvalue())


@pytest.mark.parametrize(
    "headings",
    [
        # EPLAN
        "Source;Target;Connection designation;Connection color / number;Cross-section / diameter",
        "Quelle;Ziel;Verbindung: Bezeichnung;Verbindung: Farbe / Nummer;Querschnitt / Durchmesser",
        "Source DT;Source connection point;Target DT;Target connection point;Color;Cross-section",
        # E3.series
        "Device designation from;Pin name from;Device designation to;Pin name to;Conductor",
        "Ader;Von Gerät;Von Pin;Nach Gerät;Nach Pin;Kabel;Farbe;Querschnitt [mm²];Länge [mm]",
        # Zuken's harness tools
        "Wire Number;From Ref Des;From Pin;To Ref Des;To Pin;Gauge;Color;Length",
        "From Reference;From Pin;To Reference;To Pin;Wire Size;Wire Color",
        # Inventor
        "Wire ID;RefDes1;Pin1;RefDes2;Pin2;Length;Color",
        "Wire ID;From: RefDes;From: Pin;To: RefDes;To: Pin;Wire Length;Gauge;Color",
        # Elecdes
        "Wire No;From Tag;From Terminal;To Tag;To Terminal;Wire Size;Colour;Cable No;Core",
    ],
)
def test_the_headings_of_exports_lose_no_column(headings):
    cells = ";".join(str(number) for number in range(1, headings.count(";") + 2))
    imported = read(f"{headings}\n{cells}\n")
    assert [str(column) for column in imported.account.unused_columns] == []
    assert len(imported.order.wires) == 1


def test_jumpers_and_bars_are_parts_and_no_wires():
    text = """Wire,From Device,From Terminal,To Device,To Terminal,Color,AWG
101,K1,A1,TB1,1,RED,18
J1,TB1,1,TB1,3,JUMPER,
J2,TB1,3,TB1,4,,
Drahtbrücke,X1,1,X1,2,SW,16
103,TB1,5,TB1,6,BLU,18
BAR1,X1,5,X2,5,Busbar,
104,K1,A2,TB1,2,,
BAR2,X1,6,X2,6,Shorting bar,
"""
    imported = read(text)
    assert [wire.name for wire in imported.order.wires] == ["101", "103", "104"]
    reason = "it is a jumper or bar, a part for a person to set"
    assert [(item.source, item.reason) for item in imported.account.left_out] == [
        (f"line {line}", reason) for line in (3, 4, 5, 7, 9)
    ]
    # Without columns for it nothing says that a line is no wire.
    assert len(read("From,To\nTB1:1,TB1:3\n").order.wires) == 1
