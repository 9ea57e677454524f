"""The world of a fake cell: what abilities ask of it, do to it, and find of it on disk."""

import multiprocessing
import sqlite3
from dataclasses import replace
from types import SimpleNamespace

import pytest
from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.testing.cell_ability import RobotLock
from remodel_states.testing.faults import Behaves, Cure, InjectedFault
from remodel_states.testing.operations import OPERATIONS, fail, perform
from remodel_states.testing.world import Deed, Entry, Hands, Panel, Seat, World
from remodel_states.testing.world_file import WorldFile

CELL = "cell_1"
PANEL = Panel(
    "two wires",
    {"W1": ("Q1/1", "Q1/2"), "W2": ("Q1/2", "Q1/3")},
    {"W1": 0.3, "W2": 0.4},
    {"Q1": (0.0, 0.0, 0.0, 0.0)},
    openings={f"Q1/{n}": (0.0, 0.01 * n, 0.02, 1.5) for n in (1, 2, 3)},
    channels=("A",),
    ducts={"W1": ("D1", "D2")},
)


def goal(**fields):
    usual = {
        "id": "g",
        "robot_name": "robot_1",
        "cable_id": "W1",
        "cable_end": "a",
        "component_id": "Q1",
        "terminal_id": "1",
        "grasp_distance": 0.0,
        "force_limit": 8.0,
        "pull_test_force": 10.0,
        "connector_id": "P1",
        "path": [1, 2],
    }
    return SimpleNamespace(**{**usual, **fields})


def do(world, ability, **fields):
    """Return the effect of an ability that can be done."""
    OPERATIONS[ability].check(world, CELL, goal(**fields))
    return perform(ability, world, CELL, goal(**fields))


def code_of(world, ability, **fields):
    with pytest.raises(AbilityError) as raised:
        do(world, ability, **fields)
    return raised.value.code


@pytest.fixture
def fed():
    return World(PANEL).feed(CELL, "W1", "A")


@pytest.fixture
def a_fixed(fed):
    return do(do(fed, "InsertCable").world, "FixCable").world


def test_a_wire_is_fed_in_a_channel_or_on_a_panel_without_channels_in_the_magazine():
    with pytest.raises(AbilityError, match="no channel ''"):
        World(PANEL).feed(CELL, "W1", "")
    without = World(replace(PANEL, channels=()))
    assert without.feed(CELL, "W1", "").fed == ("W1",)
    with pytest.raises(AbilityError, match="no channel 'A'"):
        without.feed(CELL, "W1", "A")


def test_a_wire_is_placed_end_by_end(a_fixed):
    assert not a_fixed.is_placed("W1")
    held = do(a_fixed, "PickCable", cable_end="b").world
    carried = do(held, "RouteWire").world
    inserted = do(carried, "InsertCable", cable_end="b", terminal_id="2").world
    fixed = do(inserted, "FixCable", terminal_id="2")
    assert fixed.world.is_placed("W1")
    assert fixed.entries == (Entry(Deed.FIX, CELL, "W1", "b", terminal="Q1/2", goal="g"),)
    assert fixed.world.hands_in(CELL) == Hands("W1")


def test_inserting_picks_first_and_goes_on_holding(fed):
    assert do(fed, "InsertCable").world.hands_in(CELL).held == {"robot_1": "a"}


@pytest.mark.parametrize(
    ("ability", "fields", "code"),
    [
        ("PickCable", {"cable_id": "W9"}, ErrorCode.UNKNOWN_NAME),
        ("PickCable", {"robot_name": "robot_9"}, ErrorCode.UNKNOWN_NAME),
        ("PickCable", {"cable_id": "W2"}, ErrorCode.WIRE_NOT_FED),
        ("PickCable", {"cable_end": "c"}, ErrorCode.INVALID_GOAL),
        ("PickCable", {"grasp_distance": 0.2}, ErrorCode.INVALID_GOAL),
        ("PlaceCable", {}, ErrorCode.NOTHING_HELD),
        ("PlaceCable", {"cable_id": ""}, ErrorCode.NOTHING_HELD),
        ("DiscardCable", {"cable_id": "W9"}, ErrorCode.UNKNOWN_NAME),
        ("DiscardCable", {"robot_name": "robot_9"}, ErrorCode.UNKNOWN_NAME),
        ("RouteWire", {}, ErrorCode.NOTHING_HELD),
        ("FixCable", {}, ErrorCode.NOTHING_HELD),
        ("DetectCable", {"cable_id": "W2"}, ErrorCode.WIRE_NOT_FED),
        ("InsertCable", {"force_limit": 70.0}, ErrorCode.INVALID_GOAL),
        ("InsertCable", {"terminal_id": "9"}, ErrorCode.UNKNOWN_NAME),
        ("LocateGearboxComponent", {"component_id": "X"}, ErrorCode.UNKNOWN_NAME),
        ("CheckConnection", {"terminal_id": "9"}, ErrorCode.UNKNOWN_NAME),
        ("PlaceConnector", {"connector_id": ""}, ErrorCode.UNKNOWN_NAME),
    ],
)
def test_what_cannot_be_is_refused(fed, ability, fields, code):
    assert code_of(fed, ability, **fields) == code


def test_an_occupied_terminal_takes_no_other_wire(a_fixed):
    moved = a_fixed.with_seat("W1", "a", Seat("Q1/2", True)).feed(CELL, "W2", "A")
    code = code_of(moved, "InsertCable", cable_id="W2", terminal_id="2")
    assert code == ErrorCode.TERMINAL_OCCUPIED


def test_a_fixed_end_is_neither_picked_nor_inserted_again(a_fixed):
    assert code_of(a_fixed, "PickCable") == ErrorCode.INVALID_GOAL
    assert code_of(a_fixed, "InsertCable", terminal_id="3") == ErrorCode.INVALID_GOAL


def test_the_hand_takes_one_end_at_a_time(fed):
    held = do(fed, "PickCable").world
    assert code_of(held, "PickCable", cable_end="b") == ErrorCode.OTHER_CABLE_HELD
    assert code_of(held, "InsertCable", cable_end="b") == ErrorCode.OTHER_CABLE_HELD
    with pytest.raises(AbilityError) as raised:
        held.feed(CELL, "W2", "A")
    assert raised.value.code == ErrorCode.OTHER_CABLE_HELD


def test_an_end_is_not_fixed_where_it_is_not(fed):
    inserted = do(fed, "InsertCable").world
    assert code_of(inserted, "FixCable", terminal_id="3") == ErrorCode.NOT_SEATED
    assert code_of(do(fed, "PickCable").world, "FixCable") == ErrorCode.NOT_SEATED


def test_carrying_a_seated_end_pulls_it_out(fed):
    inserted = do(fed, "InsertCable").world
    assert do(inserted, "RouteWire").world.seat("W1", "a") is None
    placed = do(inserted, "PlaceCable").world
    assert placed.seat("W1", "a") is None
    assert not placed.hands_in(CELL).held


def test_extracting_a_fixed_end_is_a_deed(a_fixed):
    effect = do(a_fixed, "ExtractCable")
    assert effect.world.seat("W1", "a") is None
    assert [entry.deed for entry in effect.entries] == [Deed.LOOSEN]
    assert do(effect.world, "ExtractCable").entries == ()


def test_an_observation_shows_whether_an_end_is_held(fed, a_fixed):
    assert do(a_fixed, "CheckConnection").found == {"connected": True}
    assert do(a_fixed, "CheckConnection", terminal_id="2").found == {"connected": False}
    assert do(do(fed, "InsertCable").world, "CheckConnection").found == {"connected": False}


def refused_feed(world, wire="W1", cell=CELL):
    with pytest.raises(AbilityError) as raised:
        world.feed(cell, wire, "A")
    return raised.value.code


def test_an_untouched_piece_is_presented_again(fed):
    assert fed.feed(CELL, "W1", "A") == fed
    other = fed.feed(CELL, "W2", "A")
    assert other.hands_in(CELL).live == "W2"
    again = other.feed(CELL, "W1", "A")
    assert (again.fed, again.hands_in(CELL).live) == (("W1", "W2"), "W1")
    assert do(fed, "DetectCable").world.feed(CELL, "W1", "A") == fed


def test_a_piece_that_was_touched_is_left_behind(fed, a_fixed):
    laid_down = do(do(fed, "PickCable").world, "PlaceCable").world
    missed = perform("PickCable", fed, CELL, goal(), code=ErrorCode.GRASP_MISSED).world
    for world in (a_fixed, laid_down, missed):
        assert refused_feed(world) == ErrorCode.WIRE_LEFT_BEHIND
        assert world.feed(CELL, "W2", "A").fed == ("W1", "W2")
    assert refused_feed(fed, cell="cell_2") == ErrorCode.WIRE_LEFT_BEHIND


def test_a_discarded_wire_is_gone_with_its_connections(a_fixed):
    held = do(a_fixed, "PickCable", cable_end="b").world
    for fields in ({}, {"cable_id": ""}):
        effect = do(held, "DiscardCable", **fields)
        assert (effect.world.fed, effect.world.seats) == ((), {})
        assert effect.world.hands_in(CELL) == Hands()
        assert effect.entries == (Entry(Deed.DISCARD, CELL, "W1", goal="g"),)
        assert effect.world.feed(CELL, "W1", "A").hands_in(CELL).live == "W1"


def test_discarding_nothing_succeeds(fed):
    for world, wire in ((World(PANEL), "W1"), (fed, "W2"), (fed, "")):
        effect = do(world, "DiscardCable", cable_id=wire)
        assert (effect.world, effect.entries) == (world, ())


def test_a_hand_discards_no_wire_but_its_own(fed):
    held = do(fed, "PickCable").world
    assert code_of(held, "DiscardCable", cable_id="W2") == ErrorCode.OTHER_CABLE_HELD
    other = held.feed("cell_2", "W2", "A").with_held("cell_2", "robot_1", "a")
    wire_of_other = do(other, "PlaceCable").world
    code = code_of(wire_of_other, "DiscardCable", cable_id="W2")
    assert code == ErrorCode.ROBOT_IN_THE_WAY


def test_discarding_extracts_the_ends_that_are_connected(fed, a_fixed):
    includes = OPERATIONS["DiscardCable"].includes
    assert includes(a_fixed, CELL, goal()) == ("ExtractCable",)
    assert includes(fed, CELL, goal()) == ()
    inserted = do(fed, "InsertCable").world
    assert includes(inserted, CELL, goal(cable_id="")) == ("ExtractCable",)


def test_what_the_hand_holds_is_laid_down_without_its_name(fed):
    placed = do(do(fed, "PickCable").world, "PlaceCable", cable_id="")
    assert not placed.world.hands_in(CELL).held
    assert "W1" in placed.said


def test_a_failed_insertion_leaves_the_wire_in_the_hand(fed):
    jammed = fail(fed, CELL, "InsertCable", ErrorCode.INSERTION_JAMMED, goal=goal())
    assert jammed.hands_in(CELL).of("robot_1") == "a"
    assert jammed.seat("W1", "a") is None
    contested = perform("InsertCable", fed, CELL, goal(), code=ErrorCode.SEVERAL_SERVERS)
    assert contested.world == fed
    slipped = fail(jammed, CELL, "RouteWire", ErrorCode.GRASP_SLIPPED, goal=goal())
    assert not slipped.hands_in(CELL).held


# --- two robots


@pytest.fixture
def both_held(fed):
    """Return a world in which robot_1 holds end a, and robot_2 end b."""
    return do(do(fed, "PickCable").world, "PickCable", robot_name="robot_2", cable_end="b").world


@pytest.fixture
def to_be_laid(both_held):
    """Return a world in which end a is fixed, and robot_2 holds end b."""
    return do(do(both_held, "InsertCable").world, "FixCable").world


LAY = {"robot_name": "robot_2", "guide_name": "robot_1"}


def test_one_robot_inserts_an_end_while_another_holds_the_other_one(both_held, to_be_laid):
    assert both_held.hands_in(CELL).held == {"robot_1": "a", "robot_2": "b"}
    assert to_be_laid.seat("W1", "a") == Seat("Q1/1", True)
    assert to_be_laid.hands_in(CELL).held == {"robot_2": "b"}
    second = {"robot_name": "robot_2", "cable_end": "b", "terminal_id": "2"}
    inserted = do(to_be_laid, "InsertCable", **second).world
    fixed = do(inserted, "FixCable", **second).world
    assert fixed.is_placed("W1")
    assert not fixed.hands_in(CELL).held


def test_an_end_that_another_robot_holds_is_neither_picked_nor_inserted(both_held, to_be_laid):
    other = {"robot_name": "robot_1", "cable_end": "b"}
    assert code_of(to_be_laid, "PickCable", **other) == ErrorCode.OTHER_CABLE_HELD
    assert code_of(to_be_laid, "InsertCable", **other) == ErrorCode.OTHER_CABLE_HELD
    assert refused_feed(to_be_laid, "W2") == ErrorCode.OTHER_CABLE_HELD
    for wire in ("W1", ""):
        assert code_of(both_held, "DiscardCable", cable_id=wire) == ErrorCode.OTHER_CABLE_HELD


def test_each_robot_places_and_loses_only_what_it_holds(both_held):
    assert do(both_held, "PlaceCable").world.hands_in(CELL).held == {"robot_2": "b"}
    slipped = fail(both_held, CELL, "FixCable", ErrorCode.GRASP_SLIPPED, goal=goal())
    assert slipped.hands_in(CELL).held == {"robot_2": "b"}
    assert code_of(slipped, "PlaceCable") == ErrorCode.NOTHING_HELD
    pins = SimpleNamespace(robot_1_name="robot_1", robot_2_name="robot_2")
    slipped = fail(both_held, CELL, "PlacePin", ErrorCode.GRASP_SLIPPED, goal=pins)
    assert not slipped.hands_in(CELL).held


def test_a_wire_is_laid_by_one_robot_while_another_holds_its_free_end(to_be_laid):
    effect = do(to_be_laid, "LayWire", **LAY)
    assert effect.world == to_be_laid
    assert effect.said == "W1 laid into D1, D2"


def test_a_wire_is_not_laid_unless_it_is_fixed_held_and_to_be_led(fed, both_held, to_be_laid):
    for world in (both_held, do(both_held, "InsertCable").world):
        assert code_of(world, "LayWire", **LAY) == ErrorCode.INVALID_GOAL
    placed = do(to_be_laid, "PlaceCable", robot_name="robot_2").world
    assert code_of(placed, "LayWire", **LAY) == ErrorCode.NOTHING_HELD
    turned = {"robot_name": "robot_1", "guide_name": "robot_2"}
    by_guide = do(placed, "PickCable", cable_end="b").world.with_held(CELL, "robot_2", "a")
    assert code_of(by_guide, "LayWire", **turned) == ErrorCode.OTHER_CABLE_HELD
    for fields, code in (
        ({"guide_name": "robot_9"}, ErrorCode.UNKNOWN_NAME),
        ({"robot_name": "robot_1"}, ErrorCode.INVALID_GOAL),
        ({"cable_id": "W2"}, ErrorCode.WIRE_NOT_FED),
    ):
        assert code_of(to_be_laid, "LayWire", **{**LAY, **fields}) == code
    without = replace(to_be_laid, panel=replace(PANEL, ducts={}))
    assert code_of(without, "LayWire", **LAY) == ErrorCode.INVALID_GOAL


# --- on disk


def test_the_file_gives_back_what_it_was_given(tmp_path, a_fixed):
    file = WorldFile(tmp_path / "world")
    jammed = InjectedFault("insertion_jammed", "InsertCable", 301, cure=Cure.NEW_PART)
    faults = (jammed, InjectedFault("server_hung", "FixCable", behaves=Behaves.HANGS))
    entry = Entry(Deed.FEED, CELL, "W1", terminal="A")
    with file.change() as draft:
        draft.world, draft.faults, draft.goals = a_fixed, faults, {"FixCable": 3}
        draft.owners = {CELL: 17}
        draft.entries.append(entry)
    again = WorldFile(tmp_path / "world")
    read = again.read()
    assert (read.world, read.faults, read.goals) == (a_fixed, faults, {"FixCable": 3})
    assert read.owners == {CELL: 17}
    (written,) = again.ledger()
    assert (written.deed, written.wire, written.terminal) == (Deed.FEED, "W1", "A")


def test_a_change_that_fails_changes_nothing(tmp_path, a_fixed):
    file = WorldFile(tmp_path / "world")
    with pytest.raises(AbilityError), file.change() as draft:
        draft.world = a_fixed
        draft.entries.append(Entry(Deed.FEED, CELL, "W1"))
        raise AbilityError(ErrorCode.UNKNOWN_NAME, "no")
    assert file.read().world == World()
    assert file.ledger() == ()


def test_a_second_change_waits_for_the_first(tmp_path, fed):
    file = WorldFile(tmp_path / "world")
    with file.change() as draft:
        draft.world = fed
        with pytest.raises(sqlite3.OperationalError, match="locked"):
            sqlite3.connect(tmp_path / "world", timeout=0).execute("BEGIN IMMEDIATE")


def test_processes_may_open_a_new_world_at_once(tmp_path):
    forking = multiprocessing.get_context("fork")
    for name in "abcde":
        together = forking.Barrier(4)

        def opened(path=tmp_path / name, together=together):
            together.wait(60)
            WorldFile(path)

        processes = [forking.Process(target=opened) for _ in range(4)]
        for process in processes:
            process.start()
        for process in processes:
            process.join(60)
        assert [process.exitcode for process in processes] == [0] * 4


def test_a_panel_stays_that_is_there_or_that_another_cell_has_loaded(a_fixed):
    panel = a_fixed.panel
    loaded = replace(a_fixed, loaded_by=CELL)
    assert loaded.load(CELL, panel, keep=True) is loaded
    assert loaded.load("other", panel, keep=False) is loaded
    assert loaded.load(CELL, panel, keep=False) == World(panel, loaded_by=CELL)
    for cell in (CELL, "other"):
        later = replace(panel, serial="another")
        assert loaded.load(cell, later, keep=True) == World(later, loaded_by=cell)


def test_a_robot_does_one_goal_at_a_time(tmp_path):
    first, second = (RobotLock(str(tmp_path / "lock")) for _ in range(2))
    assert first.take()
    assert not second.take()
    first.free()
    assert second.take()
    second.free()
