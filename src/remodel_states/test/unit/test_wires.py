"""Colours of wires by their codes, and properties of wires by construction and section."""

import os

import pytest
import yaml

from remodel_states.core.wires import (
    DISTINCT_COLOURS,
    PROPERTIES,
    WIRE_RGB,
    MaterialError,
    hex_colours,
    is_colour,
    joined_colours,
    materials_from,
    nearest_code,
    rgbs_of,
)
from remodel_states.edge.exported_tables import read_wire_materials


@pytest.mark.parametrize(
    ("codes", "colour"),
    [
        (["BU"], "BU"),
        (["WH", "BU"], "WHBU"),
        (["BU", "WH"], "BUWH"),
        (["GN", "YE"], "GNYE"),
        (["YE", "GN"], "GNYE"),
        (["BK", "BK"], "BK"),
    ],
)
def test_the_colours_of_a_wire_are_joined(codes, colour):
    assert joined_colours(codes) == colour
    assert is_colour(colour)


def test_a_wire_of_two_colours_looks_like_both_the_ground_first():
    assert rgbs_of("WHBU") == (WIRE_RGB["WH"], WIRE_RGB["BU"])
    assert hex_colours("BKRD") == ("#0f0f12", "#cc0f0d")


@pytest.mark.parametrize("colour", ["", "XX", "B", "WHB", "WHXX"])
def test_what_is_no_colour_is_none_and_has_a_grey_swatch(colour):
    assert not is_colour(colour)
    assert "#808080" in hex_colours(colour)


def test_the_nearest_colour_of_each_is_itself_and_of_a_screens_colours_what_a_person_calls_them():
    single = [code for code in DISTINCT_COLOURS if code in WIRE_RGB]
    assert [nearest_code(WIRE_RGB[code]) for code in single] == single
    screen = {(1, 1, 0): "YE", (0, 0, 1): "BU", (0, 1, 1): "TQ", (1, 0.5, 0): "OG"}
    assert {rgb: nearest_code(rgb) for rgb in screen} == screen


ROW = dict.fromkeys(PROPERTIES, 0.5)
# American wire gauges 26 to 10 [mm^2], ASTM B258, and the metric sections of control cabinets.
GAUGES = (0.129, 0.205, 0.326, 0.518, 0.823, 1.31, 2.08, 3.31, 5.26)
METRIC = (0.14, 0.25, 0.34, 0.5, 0.75, 1.0, 1.5, 2.5, 4.0, 6.0, 10.0)


def test_the_table_has_data_sheets_of_the_usual_wires():
    materials = read_wire_materials()
    assert materials.find("H07V-K", 1.5).bending_stiffness == 1.0e-3
    assert materials.find("", 0.75).diameter == 0.0026
    assert materials.origin("", 0.75) == ""


def test_every_section_of_a_cabinet_has_a_material_and_thicker_wires_are_thicker_and_stiffer():
    sections = sorted((*GAUGES, *METRIC))
    found = [read_wire_materials().find("", section) for section in sections]
    for name in ("diameter", "linear_density", "bending_stiffness", "torsional_stiffness"):
        values = [getattr(material, name) for material in found]
        assert values == sorted(values)
    assert len({material.bending_stiffness for material in found}) == len(sections)


def test_between_two_sections_what_grows_with_the_strands_is_linear_and_the_rest_the_thickers():
    thin, thick = ROW | {"diameter": 1.0}, ROW | {"diameter": 3.0, "bending_stiffness": 1.5}
    materials = materials_from({"K": {1.0: thin, 9.0: thick | {"ferrule_length": 0.7}}})
    between = materials.find("", 4.0)
    assert between.diameter == 2.0
    assert between.bending_stiffness == pytest.approx(0.5 + 3 / 8)
    assert between.linear_density == 0.5
    assert between.ferrule_length == 0.7
    assert materials.origin("K", 4.0) == "calculated between K 1 mm2 and K 9 mm2"


def test_a_row_from_no_data_sheet_says_so():
    assert read_wire_materials().origin("", 0.5) == "calculated from strands and insulation"
    with pytest.raises(MaterialError, match="K 1: calculated is 'yes'; it must be true or false"):
        materials_from({"K": {1: {**ROW, "calculated": "yes"}}})


@pytest.mark.parametrize("section", [0.1, 16.0])
def test_a_section_beyond_the_table_is_refused_with_what_is_allowed_and_what_to_do(section):
    with pytest.raises(MaterialError) as caught:
        read_wire_materials().find("", section)
    assert str(caught.value) == (
        f"no material is known of a wire of {section:g} mm2; allowed: 0.129 to 10 mm2: add it to a "
        "file that REMODEL_WIRE_MATERIALS names, or give the wire all its properties"
    )


def test_the_sections_of_a_construction_are_its_own():
    materials = read_wire_materials()
    with pytest.raises(MaterialError, match=r"wire of H07V-K 1 mm2; allowed: 1\.5 to 10 mm2"):
        materials.find("H07V-K", 1.0)
    with pytest.raises(MaterialError, match="allowed: constructions LiY, H05V-K, H07V-K"):
        materials.find("H99", 1.0)


def test_a_users_materials_are_preferred_and_widen_the_range(tmp_path, monkeypatch):
    files = {"first": {"Own": {16: ROW}}, "second": {"Own": {1.5: ROW, 16: ROW | {"friction": 0}}}}
    for name, rows in files.items():
        (tmp_path / name).write_text(yaml.safe_dump(rows))
    paths = os.pathsep.join(str(tmp_path / name) for name in files)
    monkeypatch.setenv("REMODEL_WIRE_MATERIALS", paths)
    materials = read_wire_materials()
    assert materials.find("", 16.0).friction == 0.5
    assert materials.find("", 1.5).diameter == 0.5
    assert materials.find("H07V-K", 1.5).diameter == 0.0031
    assert materials.origin("", 13.0) == "calculated between H07V-K 10 mm2 and Own 16 mm2"


@pytest.mark.parametrize(
    ("parsed", "words"),
    [
        ([], r"the file is \[\]"),
        ({}, "it has no wire"),
        ({"K": {1.5: 3}}, "K 1.5 is 3"),
        ({"K": {"thin": ROW}}, "thin: section must be a number"),
        ({"K": {1.5: {**ROW, "colour": 1}}}, r"unknown \['colour'\]"),
        ({"K": {1.5: {"friction": 1}}}, "missing .*'diameter'"),
        ({"K": {1.5: {**ROW, "friction": "much"}}}, "K 1.5: friction must be a number"),
        ({"K": {1.5: {**ROW, "friction": -1.0}}}, "K 1.5: friction must be a number"),
    ],
)
def test_a_malformed_table_says_where(parsed, words):
    with pytest.raises(MaterialError, match=words):
        materials_from(parsed)


@pytest.mark.parametrize("content", [None, b"a: [", b"\xff\xfe\xff"])
def test_a_table_that_cannot_be_read_names_its_file(content, tmp_path, monkeypatch):
    file = tmp_path / "own.yaml"
    if content is not None:
        file.write_bytes(content)
    monkeypatch.setenv("REMODEL_WIRE_MATERIALS", str(file))
    with pytest.raises(MaterialError, match=r"own\.yaml"):
        read_wire_materials()
