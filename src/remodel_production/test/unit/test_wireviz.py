"""The importer of WireViz harnesses."""

import re
from pathlib import Path

import pytest
from wire_lists import CATALOGUE

from remodel_production.core.imports.wireviz import import_wireviz, join_files
from remodel_production.core.imports.wireviz_parts import COLOUR_CODES, core_colours
from remodel_production.core.production import Role
from remodel_production.errors import DesignError

HARNESS = Path(__file__).parent / "designs" / "harness.yml"


def read(text):
    return import_wireviz(text.encode(), "test", "test.yml", CATALOGUE)


def ends(imported):
    return {wire.name: (str(wire.a), str(wire.b)) for wire in imported.order.wires}


LISTS = """
connectors:
  X1: {pincount: 2}
  X2: {pincount: 2}
cables:
  W1: {wirecount: 2, category: bundle, gauge: [0.5 mm2, 20 AWG], length: [0.3, 450 mm]}
connections:
  - [X1: [1-2], W1: [1-2], X2: [1-2]]
"""


def test_gauges_and_lengths_may_be_lists_with_one_for_each_core():
    wires = read(LISTS).order.wires
    assert [(w.section_mm2, w.length_m) for w in wires] == [(0.5, 0.3), (0.518, 0.45)]


@pytest.mark.parametrize("key", ["gauge: [0.5 mm2, 20 AWG]", "length: [0.3, 450 mm]"])
def test_a_list_with_another_number_of_values_than_cores_is_refused(key):
    name = key.partition(":")[0]
    said = rf"line 6: cable W1: {name}: 1 values found for 2 cores; give one for all, or one for"
    with pytest.raises(DesignError, match=said):
        read(LISTS.replace(key, f"{name}: [1]"))


def test_a_length_of_a_bundle_that_is_not_understood_is_reported():
    account = read(LISTS.replace("450 mm", "two ells")).account
    assert "line 6: length 'two ells' not understood" in account.assumptions


def test_a_harness_is_read_with_templates_ranges_shield_and_bundles():
    imported = import_wireviz(HARNESS.read_bytes(), "two", "harness.yml", CATALOGUE)
    assert ends(imported) == {
        "W1.1": ("X1:1", "X2:4"),
        "W1.2": ("X1:2", "X2:3"),
        "W1.3": ("X1:4", "X2:2"),
        "W1.4": ("X1:3", "X2:1"),
        "W1.s": ("X1:5", "Ground:1"),
        "W2.1": ("F~1:1", "S1:1.1"),
        "W2.2": ("F2:1", "S2:1.1"),
        "B1.1": ("S1:1.2", "F~2:1"),
        "B2.1": ("S2:1.2", "F~3:1"),
    }
    order = imported.order
    assert order.title == "Two boxes"
    assert [(c.name, c.length_m, c.shielded, c.source) for c in order.cables] == [
        ("W1", 0.8, True, "line 14")
    ]
    wires = {wire.name: wire for wire in order.wires}
    assert [wires[name].colour for name in ("W1.1", "W1.4", "W2.2", "B1.1")] == [
        *("WH", "YE", "BK", "BU")
    ]
    assert (wires["W1.s"].cable, wires["W1.s"].core, wires["W1.s"].colour) == ("W1", "s", "")
    assert (wires["W2.1"].cable, wires["W2.1"].length_m) == ("", 0.25)
    assert wires["W2.1"].section_mm2 == 0.518
    x1 = order.components[0]
    assert (x1.kind, x1.role) == ("Molex KK 254 female", Role.CONNECTOR)
    assert x1.terminal("3").kind == "RX"
    assert [str(item) for item in imported.account.ignored] == [
        "line 36: left out, connectors that mate need no wire",
        "line 12: left out, no connection set names Unused",
        "line 9: left out, 1 loops within connector X2 are no wires",
    ]


PARTS = """
connectors:
  X1: {pincount: 2, pinlabels: [A, A]}
  X2: {pins: [10, 20]}
  F: {style: simple}
cables:
  W1: {wirecount: 2, colors: [RD, RD], gauge: 1}
connections:
"""


def test_what_is_not_given_is_assumed_with_its_line():
    text = PARTS.replace("gauge: 1", "length: two ells").replace("colors: [RD, RD], ", "")
    imported = read(text + "  - [X1: 1, W1: 1, X2: 20]")
    assert imported.account.assumptions[:3] == (
        "line 9: colour not given, BK taken",
        "line 9: section not given, 2.5 mm2 taken",
        "line 7: length 'two ells' not understood",
    )


def test_a_core_with_an_open_end_is_left_out():
    imported = read(PARTS + "  - [X1: [1, 2], W1: [1, 2]]\n  - [W1: 1, F.F1]")
    assert ends(imported) == {"W1.1": ("X1:1", "F1:1")}
    assert [str(item) for item in imported.account.left_out] == [
        "line 9: left out, one end of core 2 of W1 is open"
    ]


def test_a_core_that_is_connected_twice_is_left_out_with_both_places():
    imported = read(PARTS + "  - [X1: 1, W1: 1, X2: 10]\n  - [X1: 2, W1: 1, X2: 20]")
    assert [str(item) for item in imported.account.left_out] == [
        "line 10: left out, core 1 of W1 is connected before, in line 9"
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1, 2]", "line 1: the file: expected a mapping, found a list"),
        ("connectors: {}", "line 1: found connectors; a WireViz harness has"),
        ("connections: [", "line 2, column 1: is no YAML"),
        ("a: \t- x", "line 1"),
        (PARTS + "  - [X1: 3, W1: 1, X2: 10]", "line 9: connector X1 has no pin 3; it has 1, 2"),
        (PARTS + "  - [X1: A, W1: 1, X2: 10]", "label A stands for pins 1, 2"),
        (PARTS + "  - [X1: 1, W1: RD, X2: 10]", "colour RD stands for cores 1, 2"),
        (PARTS + "  - [X1: 1, W1: s, X2: 10]", "cable W1 has no core s"),
        (PARTS + "  - [X1: 1-2, W1: 1, X2: 10]", "(1 in line 9, 2 in line 9)"),
        (PARTS + "  - [X1: 1, X2: 10]", "X1 and X2 are both connectors"),
        (
            PARTS + "  - [X1: 1, W2: 1]",
            "line 9: 'W2' is neither a connector nor a cable; there are X1",
        ),
        (
            PARTS + "  - [XX1: 1, W1: 1]",
            "line 9: 'XX1' is neither a connector nor a cable; do you m",
        ),
        (PARTS + "  - [X1, W1: 1]", "connector X1 has 2 pins: say which"),
        (PARTS + "  - [F.A, W1: 1, X2: 10]\n  - [X1.A: 1]", "A is made from template X1, and"),
        (PARTS + "  - {X1: 1}", "line 9: a connection set: expected a list, found a mapping"),
        (PARTS + "  - [{X1: 1, W1: 1}]", "expected one connector or cable with its pins, found X1"),
        (PARTS + "  - [X1: 1, -->]", "an arrow stands between two connectors"),
        (PARTS + "  - [X1: [0-9999]]", "connector X1: 0-9999 are too many"),
        (PARTS + "  - []", "none of its connection sets joins two pins"),
        ("connectors: {X1: {}}\nconnections: []", "line 1: connector X1: give its pincount"),
        ("connectors: {X1: {pincount: -1}}\nconnections: []", "pincount: -1 found; a number from"),
        ("connectors: {X1: {pins: [1, 1]}}\nconnections: []", "pin 1 is given twice"),
        ("connectors: {X: {pincount: 1, pins: [1, 2]}}\nconnections: []", "there are 2 pins"),
        (
            "connectors:\n  X1: {}\n  X1: {}\nconnections: []",
            "line 3: key X1 is given before, at l",
        ),
        ("cables: {W1: {}}\nconnections: []", "cable W1: give its wirecount or colors"),
        ("cables: {W1: {wirecount: 1, color_code: X}}\nconnections: []", "X is not known; allowed"),
        ("connectors: {A: {pincount: 1}}\ncables: {A: {wirecount: 1}}\nconnections: []", "rename"),
        ("a: &a [*a]\nconnections: *a", "line 1: the value contains itself by an alias"),
    ],
)
def test_a_malformed_harness_is_refused_with_the_place(text, said):
    with pytest.raises(DesignError, match=re.escape(said)):
        read(text)


def test_aliases_that_multiply_are_refused_at_once():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 30)]
    with pytest.raises(DesignError, match="more than 200000 values"):
        read("\n".join([*lines, "connections: []"]))


def test_a_connector_that_is_only_mentioned_stays():
    imported = read(PARTS + "  - [X1: 1, W1: 1, F.F1]\n  - [X2]")
    assert [component.name for component in imported.order.components] == ["X1", "F1", "X2"]


@pytest.mark.parametrize("text", [" [\n" * 100_000, "\n".join(" " * n + "-" for n in range(200))])
def test_a_document_that_nests_without_end_is_refused_at_once(text):
    with pytest.raises(DesignError, match="51 levels found; at most 50 levels"):
        read(f"connections:\n{text}")


def test_a_document_that_is_too_long_is_refused():
    with pytest.raises(DesignError, match="values found; at most 50 levels and 200000 values"):
        read("connections:\n" + "- [a, b]\n" * 150_000)


def test_colour_codes_begin_again():
    assert core_colours("BW", 3) == ["BK", "WH", "BK"]
    assert core_colours("TEL", 3) == ["BUWH", "WHBU", "OGWH"]
    assert core_colours("TELALT", 12)[-2:] == ["RDBU", "BURD"]
    assert all(core_colours(code, 70) for code in COLOUR_CODES)


def test_a_file_is_read_after_others_whose_anchors_it_uses():
    common = (
        b"templates:\n  - &pair {wirecount: 2, gauge: 0.25 mm2, length: 1}\n"
        b"connectors:\n  X: {pincount: 2}"
    )
    main = (
        "cables:\n  W1: {<<: *pair}\n"
        "connections:\n  - [{X.X1: [1, 2]}, {W1: [1, 2]}, {X.X2: [2, 1]}]\n"
    )
    joined = join_files([("common.yml", common)], main.encode())
    assert ends(read(joined.data.decode())) == {
        "W1.1": ("X1:1", "X2:2"),
        "W1.2": ("X1:2", "X2:1"),
    }
    assert joined.parts == " (lines 1 to 4 are those of common.yml; its own begin at line 5)"
    with pytest.raises(DesignError, match="line 2, column 12: is no YAML: found undefined alias"):
        read(main)


def test_a_section_of_a_file_read_before_is_replaced_by_that_of_a_later_one():
    common = b"connectors:\n  T: &T {pinlabels: [P, G]}\n  S: {pincount: 9}\n"
    main = b"connectors: {A: *T, B: *T}\ncables: {W: {wirecount: 2}}\n"
    sets = b"connections: [[{A: [P, G]}, {W: [1, 2]}, {B: [P, G]}]]\n"
    before = [("common.yml", common)]
    joined = join_files(before, main + sets)
    assert ends(read(joined.data.decode())) == {"W.1": ("A:1", "B:1"), "W.2": ("A:2", "B:2")}
    assert joined.parts == (
        " (lines 1 to 3 are those of common.yml, whose connectors those of a later file replace; "
        "its own begin at line 4)"
    )
    with pytest.raises(DesignError, match=r"line 6: .*S"):
        other = main + b"connections: [[{S: 1}, {W: 1}, {B: 1}]]\n"
        read(join_files(before, other).data.decode())


def test_parts_that_no_task_mounts_are_listed():
    text = """connectors:
  A: {pincount: 1, additional_components: [{type: seal, subtype: red, qty: 1}]}
  B: {pincount: 1}
cables:
  C: {wirecount: 1, additional_components: [Sleeve]}
connections: [[{A: 1}, {C: 1}, {B: 1}]]
additional_bom_items: [{description: Label, qty: 2}, {qty: 1}]
"""
    assert [str(item) for item in read(text).account.ignored] == [
        "line 2: left out, no task mounts seal red of A",
        "line 5: left out, no task mounts Sleeve of C",
        "line 7: left out, no task mounts Label",
        "line 7: left out, no task mounts a part without a type",
    ]


def test_splices_are_joints():
    text = """connectors:
  A: {pincount: 1}
  S: {style: simple, type: Splice}
cables: {C: {wirecount: 1}}
connections: [[{A: 1}, {C: 1}, S]]
"""
    roles = {component.name: component.role for component in read(text).order.components}
    assert roles == {"A": Role.CONNECTOR, "S": Role.JOINT}
