"""Laws of the importers: nothing is lost, nothing is doubled, and bad files are refused by name."""

import csv
import io
import re
from itertools import pairwise
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from wire_lists import CATALOGUE, MAPPINGS

from remodel_production.core.board.board import board_of
from remodel_production.core.imports.formats import built_in_formats, format_of, import_design
from remodel_production.core.imports.kbl_parts import ordered_route
from remodel_production.core.production import Segment, TerminalRef
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import DesignError
from remodel_tasks.core.decomposition.preparation import prepare
from remodel_tasks.core.orders.board_order import board_order
from remodel_tasks.edge.use_case_files import find_use_case

CABINET = find_use_case("cabinet")
FORMATS = built_in_formats(MAPPINGS)
BY_NAME = {form.name: form for form in FORMATS}
DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
QET = Path("/usr/share/qelectrotech/examples/schema_indus.qet")
SEEDS = [file.read_bytes() for file in (*sorted(DESIGNS.iterdir()), QET)]

words = st.text("ABCX129-+= äµ;,\"'", min_size=1, max_size=6).map(str.strip).filter(bool)
terminals = st.tuples(words, st.sampled_from(["1", "2", "A1", "13", "PE"]))


def read(data, form, name="x"):
    return import_design(data, form, name, "file", CATALOGUE)


def require_whole(imported):
    """Check what holds for every order, whatever it was read from."""
    order, account = imported.order, imported.account
    direct = len(order.wires) - account.wires_joined
    assert account.connections == direct + account.joined + len(account.left_out)
    ends = [end for wire in order.wires for end in (wire.a, wire.b)]
    assert len(set(ends)) == len(ends)
    assert set(ends) == {TerminalRef(c.name, t.name) for c in order.components for t in c.terminals}
    for things in (order.components, order.wires, order.cables, order.nodes, order.segments):
        assert len({thing.name for thing in things}) == len(things)
    nodes, segments = {n.name for n in order.nodes}, {s.name: s for s in order.segments}
    assert all({s.start, s.end} <= nodes for s in order.segments)
    for wire in order.wires:
        for before, after in pairwise(segments[name] for name in wire.route):
            assert {before.start, before.end} & {after.start, after.end}


@given(st.lists(st.tuples(terminals, terminals, st.sampled_from(["", "7", "8"])), max_size=12))
def test_a_list_loses_no_line_and_keeps_every_name(rows):
    text = io.StringIO()
    writer = csv.writer(text, delimiter=";")
    writer.writerow(["From Tag", "From Terminal", "To Tag", "To Terminal", "Wire No"])
    writer.writerows([*a, *b, name] for a, b, name in rows)
    try:
        imported = read(text.getvalue().encode(), BY_NAME["csv"])
    except DesignError as error:
        assert "names both ends" in str(error)
        assert all(a == b for a, b, _ in rows)
        return
    require_whole(imported)
    assert imported.account.connections == len(rows)
    names = {" ".join(component.split()) for row in rows for component, _ in row[:2]}
    assert {component.name for component in imported.order.components} <= names
    prepare(board_order(board_of(imported.order, CATALOGUE), CABINET, 2), CABINET)


@given(st.data())
def test_a_harness_connects_what_its_sets_say(data):
    pins = data.draw(st.integers(1, 6))
    lanes = data.draw(st.lists(st.permutations(range(1, pins + 1)), min_size=2, max_size=4))
    parts = {f"X{n}": {"pincount": pins} for n in range(len(lanes))}
    cables = {f"W{n}": {"wirecount": pins, "gauge": "1 mm2"} for n in range(len(lanes) - 1)}
    chain = [{"X0": list(lanes[0])}]
    for n, lane in enumerate(lanes[1:]):
        chain += [{f"W{n}": [f"1-{pins}"]}, {f"X{n + 1}": list(lane)}]
    text = yaml.safe_dump({"connectors": parts, "cables": cables, "connections": [chain]})
    imported = read(text.encode(), BY_NAME["wireviz"])
    require_whole(imported)
    found = {
        (wire.cable, wire.core, wire.a.terminal.split(".")[0], wire.b.terminal.split(".")[0])
        for wire in imported.order.wires
    }
    assert found == {
        (f"W{n}", str(i + 1), str(lanes[n][i]), str(lanes[n + 1][i]))
        for n in range(len(lanes) - 1)
        for i in range(pins)
    }


@given(st.integers(1, 12), st.randoms(use_true_random=False))
def test_the_segments_of_a_way_are_ordered_whatever_their_order_and_direction(count, rng):
    segments = []
    for i in range(count):
        ends = [f"N{i}", f"N{i + 1}"]
        rng.shuffle(ends)
        segments.append(Segment(f"S{i}", *ends, 1.0))
    mixed = rng.sample(segments, count)
    assert ordered_route(mixed, ["N0"], [f"N{count}"]) == tuple(segments)
    assert ordered_route(mixed, [f"N{count}"], ()) == tuple(segments[::-1])
    assert ordered_route(mixed, (), ["N0"]) == tuple(segments[::-1])


KBL_IDS = sorted(set(re.findall(r'\bid="([^"]+)"', (DESIGNS / "loom.kbl").read_text())))


@given(st.sampled_from(KBL_IDS))
def test_a_missing_element_of_a_harness_is_named_where_it_is_referred_to(key):
    text = (DESIGNS / "loom.kbl").read_text()
    broken = text.replace(f' id="{key}"', f' id="{key}_gone"')
    is_referred_to = re.search(rf"[> ]{re.escape(key)}[ <]", text)
    try:
        imported = read(broken.encode(), BY_NAME["kbl"])
    except DesignError as error:
        assert is_referred_to
        assert re.search(rf"^line \d+: .* refers to {re.escape(key)}, and no element", str(error))
    else:
        require_whole(imported)


@given(st.sampled_from([key for key in KBL_IDS if key not in ("loom", "h")]))
def test_a_doubled_element_of_a_harness_is_named_with_both_places(key):
    text = (DESIGNS / "loom.kbl").read_text()
    broken = text.replace("<Harness ", f'<Unit id="{key}"/><Harness ')
    with pytest.raises(DesignError, match=rf"line \d+: id {re.escape(key)} .* before, at line \d+"):
        read(broken.encode(), BY_NAME["kbl"])


@given(st.sampled_from(SEEDS), st.randoms(use_true_random=False))
def test_a_damaged_file_is_read_whole_or_refused_and_never_breaks_the_program(seed, rng):
    data = bytearray(seed)
    for _ in range(rng.choice([1, 1, 2, 20])):
        start = rng.randrange(len(data) or 1)
        stop = min(len(data), start + rng.choice([1, 1, 5, 200]))
        piece = bytes(data[start:stop])
        data[start:stop] = rng.choice([b"", piece * 2, bytes(rng.choices(range(256), k=3))])
    try:
        imported = read(bytes(data), format_of(bytes(data), FORMATS))
    except DesignError as error:
        assert str(error)
        return
    require_whole(imported)
    board_of(imported.order, CATALOGUE)


@given(
    st.sampled_from(FORMATS),
    st.one_of(st.binary(max_size=200), st.text().map(str.encode)),
)
def test_any_bytes_are_refused_by_every_format(form, data):
    with pytest.raises(DesignError):
        read(data, form)


@pytest.mark.parametrize("seed", SEEDS, ids=len)
def test_every_design_comes_back_equal_from_the_database(seed, url):
    order = board_of(read(seed, format_of(seed, FORMATS)).order, CATALOGUE).order
    database = ProductionDatabase(url)
    database.add_order(order)
    assert database.order("x") == order
    database.close()
