"""Files are recognised by their content, and quantities are read as people write them."""

import re
import time
from pathlib import Path

import pytest
from wire_lists import CATALOGUE, MAPPINGS

from remodel_production.core.imports.assembly import Connection, Device, assemble
from remodel_production.core.imports.formats import built_in_formats, format_of, import_design
from remodel_production.core.imports.values import (
    awg_mm2,
    colour_code,
    length_m,
    number,
    section_mm2,
)
from remodel_production.core.imports.wireviz_parts import COLOUR_CODES, core_colours
from remodel_production.core.production import Side, TerminalRef
from remodel_production.errors import DesignError
from remodel_states.core.wires import is_colour

DESIGNS = Path(__file__).parent / "designs"
FORMATS = built_in_formats(MAPPINGS)
NAMES = {".kbl": "kbl", ".vec": "vec", ".yml": "wireviz", ".csv": "csv"}


@pytest.mark.parametrize("file", sorted(DESIGNS.iterdir()), ids=lambda file: file.name)
def test_every_example_is_recognised_and_accounted_for(file):
    data = file.read_bytes()
    form = format_of(data, FORMATS)
    assert form.name == NAMES[file.suffix]
    imported = import_design(data, form, "x", file.name, CATALOGUE)
    account = imported.account
    direct = len(imported.order.wires) - account.wires_joined
    assert account.connections == direct + account.joined + len(account.left_out)


def test_the_account_says_which_sections_have_calculated_properties_or_none():
    gauges = enumerate(("1.5 mm2", "14 AWG", "14 AWG", "0.5", "16"))
    lines = [f"K1:{n},X1:{n},BK,{gauge}" for n, gauge in gauges]
    data = "\n".join(["From,To,Colour,Section", *lines]).encode()
    imported = import_design(data, format_of(data, FORMATS), "x", "x.csv", CATALOGUE)
    expected = (
        "1 wire of 0.5 mm2: properties calculated from strands and insulation",
        "2 wires of 2.08 mm2: properties calculated between H07V-K 1.5 mm2 and H07V-K 2.5 mm2",
        "1 wire of 16 mm2: no material is known of a wire of 16 mm2; allowed: 0.129 to 10 mm2: add "
        "it to a file that REMODEL_WIRE_MATERIALS names, or give the wire all its properties",
    )
    assert imported.account.assumptions[-3:] == imported.order.notes[-3:] == expected


def test_a_design_without_a_title_is_called_by_its_file():
    text = (
        b"connectors: {X: {pincount: 1}}\ncables: {W: {wirecount: 1}}\nconnections: [[X.A, W, X.B]]"
    )
    form = format_of(text, FORMATS)
    assert import_design(text, form, "x", "loom.yml", CATALOGUE).order.title == "loom.yml"


def test_a_qelectrotech_project_is_recognised_in_any_encoding():
    text = '<?xml version="1.0" encoding="{}"?>\n<project><diagram/></project>'
    for encoding in ("utf-8", "utf-16"):
        assert format_of(text.format(encoding).encode(encoding), FORMATS).name == "qet"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b" \n", "the file is empty"),
        (b"PK\x03\x04...", "is a ZIP archive; unpack it"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "a zero byte found"),
        (b"<html/>", "the root element is <html>; what is read: QElectroTech projects"),
        (b"<!DOCTYPE a [<!ENTITY b 'c'>]><project>&b;</project>", "document type a found"),
        (b"dear colleague,\n", "line 1: 'dear colleague,' begins no format that is read"),
    ],
)
def test_what_is_none_of_the_formats_is_refused_with_what_was_found(data, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        format_of(data, FORMATS)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(
            ("1.5", 1.5),
            ("1,5", 1.5),
            ("1.234,5", 1234.5),
            ("1,234.5", 1234.5),
            ("1.234.567", 1234567),
        ),
        *(("-2", -2.0), (" 1 000 ", 1000.0), (".5", 0.5), ("2e-3", 0.002)),
        *(("", None), ("abc", None), ("1-2", None), ("nan", None), ("1e999", None), ("--1", None)),
    ],
)
def test_numbers(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *(
            ("1,5 mm²", "mm2", 1.5),
            ("2.5mm2", "mm2", 2.5),
            ("0.75", "mm2", 0.75),
            ("6 qmm", "mm2", 6),
        ),
        *(("AWG 14", "mm2", 2.08), ("14 AWG", "mm2", 2.08), ("#12 AWG", "mm2", 3.31)),
        *(
            ("12", "awg", 3.31),
            ("2/0", "awg", 67.4),
            ("0", "awg", 53.5),
            ("BLK_14AWG", "awg", 2.08),
        ),
        *(("", "mm2", None), ("thick", "awg", None), ("-1", "mm2", None), ("0", "mm2", None)),
        *(("5000", "mm2", None), ("99 AWG", "mm2", None), ("1.5 mm", "mm2", 1.5)),
    ],
)
def test_sections(text, unit, value):
    assert section_mm2(text, unit) == value


def test_american_gauges_are_those_of_the_standard():
    # ASTM B258: 24 AWG 0.205 mm2, 10 AWG 5.26 mm2, 4/0 AWG 107 mm2.
    assert [awg_mm2(gauge) for gauge in ("24", "10", "4/0")] == [0.205, 5.26, 107.0]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *(("350", "mm", 0.35), ("0,35 m", "mm", 0.35), ("2 ft", "m", 0.6096), ('10"', "m", 0.254)),
        *(("", "m", None), ("long", "m", None), ("3 ells", "m", None), ("1e9", "m", None)),
    ],
)
def test_lengths(text, unit, value):
    assert length_m(text, unit) == value


@pytest.mark.parametrize(
    ("text", "code"),
    [
        *(
            ("BU", "BU"),
            ("bleu", "BU"),
            ("#ff0000", "RD"),
            ("GNYE", "GNYE"),
            ("green-yellow", "GNYE"),
        ),
        *(("sw/vi", "BKVT"), ("rtge", "RDYE"), ("RD/WH/BU", "RDWHBU"), ("GRN/YEL_12AWG", "GNYE")),
        # Two colours without a sign, both orders of green and yellow, all codes of IEC 60757.
        *(("WHBU", "WHBU"), ("BURD", "BURD"), ("BUWH", "BUWH"), ("YEGN", "GNYE"), ("GEGN", "GNYE")),
        *((code, code) for code in ("BK", "BN", "RD", "OG", "YE", "GN", "BU")),
        *((code, code) for code in ("VT", "GY", "WH", "PK", "GD", "TQ", "SR")),
        # As North American lists, EPLAN's projects and Komax's machines have them.
        *(("WHT/BLU", "WHBU"), ("WHTBLU", "WHBU"), ("BLK", "BK"), ("RED", "RD"), ("ORN", "OG")),
        *(("GRN-YEL", "GNYE"), ("G/Y", "GNYE"), ("W/R", "WHRD"), ("BLU W/ WHT STRIPE", "BUWH")),
        *(("SW", "BK"), ("RT", "RD"), ("GNGE", "GNYE"), ("gn/ge", "GNYE"), ("WSBL", "WHBU")),
        *(("gelbgrün", "GNYE"), ("Yellow w/ Red", "YERD"), ("weiß-blau", "WHBU"), ("vj", "GNYE")),
        *(("DB", "DB"), ("DBU", "DB"), ("dark blue", "DB"), ("DBUWH", "DBWH"), ("LB", "LB")),
        *(("dark blue/white", "DBWH"), ("BKBK", "BK"), ("TAN", "BN"), ("WH (BU)", "WHBU")),
        *(("plaid", None), ("bu plaid", None), ("", None), ("#123456", None), ("XX", None)),
        *(("BKXX", None), ("BKRDBUGN", None), ("B", None)),
    ],
)
def test_colours(text, code):
    assert colour_code(text, CATALOGUE) == code


def test_every_name_and_value_of_a_colour_in_the_catalogue_has_a_code_that_wires_have():
    for names in (CATALOGUE.colour_names, CATALOGUE.colour_values):
        assert [name for name, code in names.items() if not is_colour(code)] == []
        assert [name for name in names if name != name.lower()] == []
    assert is_colour(CATALOGUE.default_colour)


def test_every_core_of_a_coloured_cable_has_a_colour_that_wires_have():
    for code in COLOUR_CODES:
        assert all(colour_code(core, CATALOGUE) for core in core_colours(code, 70))


def connection(a, b, name=""):
    refs = [TerminalRef(*text.split(":")) for text in (a, b)]
    return Connection(*refs, "BK", 1.0, f"at {a}", name)


def test_shared_points_get_clamps_whose_names_nothing_else_has():
    connections = [connection("A:1", "B:1"), connection("A:1", "B:2"), connection("A:1.1", "B:3")]
    assembly = assemble([Device("A"), Device("B"), Device("C")], connections)
    assert [str(wire.a) for wire in assembly.wires] == ["A:1.2", "A:1.3", "A:1.1"]
    assert [c.name for c in assembly.components] == ["A", "B"]
    assert assembly.components[1].terminal("2").side is Side.BOTTOM


def test_repeated_names_of_wires_become_distinct_without_taking_others_names():
    connections = [connection(f"A:{n}", f"B:{n}", name) for n, name in enumerate("xxy")]
    connections += [connection("A:8", "B:8", "x#2"), connection("A:9", "B:9")]
    assembly = assemble([Device("A"), Device("B")], connections)
    assert [wire.name for wire in assembly.wires] == ["x", "x#3", "y", "x#2", "W5"]
    assert assembly.assumptions[0] == "at A:1: name x occurs before, at at A:0; named x#3"


def test_naming_thousands_of_wires_of_one_name_takes_seconds():
    connections = [connection(f"A:{n}", f"B:{n}", "24") for n in range(50_000)]
    before = time.process_time()
    assembly = assemble([Device("A"), Device("B")], connections)
    assert time.process_time() - before < 15.0  # [s] of CPU; it took minutes
    assert assembly.wires[-1].name == "24#50000"


def test_more_connections_than_any_design_has_are_refused():
    with pytest.raises(DesignError, match="50001 connections found; at most 50000"):
        assemble([], [connection("A:1", "B:1")] * 50001)
