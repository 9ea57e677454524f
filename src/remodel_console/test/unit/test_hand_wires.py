"""The wires by hand of products outlive the supervisor that listed them, with their ticks."""

import threading

import pytest

from remodel_console.edge.kept_files import HandWires
from remodel_console.errors import CommandError
from remodel_run.progress import HandWire


def wire(name):
    return HandWire(name, "", "Q1/1", "X1/1", "BU", 16.0, 0.5, "it is too thick")


W7, W8 = wire("W7"), wire("W8")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "hand_wires.json"


def test_a_product_is_left_until_all_its_wires_are_ticked_off(path):
    HandWires(path).keep("SN-1", (W7, W8))
    HandWires(path).tick("SN-1", "W7", is_placed=True)
    again = HandWires(path)
    assert again.left() == ("SN-1", (W7, W8))
    assert again.ticked("SN-1") == {"W7"}
    again.tick("SN-1", "W8", is_placed=True)
    assert again.left() == ("", ())
    again.tick("SN-1", "W7", is_placed=False)
    assert HandWires(path).left() == ("SN-1", (W7, W8))


def test_the_latest_product_comes_first_and_a_list_that_comes_again_keeps_its_ticks(path):
    wires = HandWires(path)
    wires.keep("SN-1", (W7,))
    wires.keep("SN-2", (W8,))
    assert wires.left() == ("SN-2", (W8,))
    wires.tick("SN-2", "W8", is_placed=True)
    assert wires.left() == ("SN-1", (W7,))
    wires.keep("SN-2", (W7, W8))
    assert wires.ticked("SN-2") == {"W8"}
    assert wires.left() == ("SN-2", (W7, W8))


@pytest.mark.parametrize("text", ["no json", "[1]", '{"house-0001": 7}'])
def test_a_broken_file_is_named(path, text):
    path.write_text(text)
    with pytest.raises(ValueError, match=r"hand_wires\.json: .*delete it"):
        HandWires(path)


def test_a_tick_that_cannot_be_kept_is_refused(path):
    wires, changes = HandWires(path), []
    wires.on_change = lambda: changes.append(wires.ticked("SN-1"))
    wires.tick("SN-1", "W7", is_placed=True)
    path.with_suffix(".new").mkdir()  # where the file is written before it replaces the old one
    with pytest.raises(CommandError, match="by hand of SN-1 cannot be kept"):
        wires.tick("SN-1", "W8", is_placed=True)
    assert (wires.ticked("SN-1"), changes) == ({"W7"}, [{"W7"}])


def test_ticks_of_two_pages_at_once_are_all_kept(path):
    wires, names = HandWires(path), [f"W{number}" for number in range(40)]
    both = threading.Barrier(2)

    def tick(own):
        both.wait(10.0)
        for name in own:
            wires.tick("SN-1", name, is_placed=True)

    pages = [threading.Thread(target=tick, args=(names[i::2],)) for i in (0, 1)]
    for page in pages:
        page.start()
    for page in pages:
        page.join(60.0)
    assert HandWires(path).ticked("SN-1") == set(names)


def test_a_list_that_cannot_be_written_is_shown_and_reported_once(path, caplog):
    wires = HandWires(path)
    path.with_suffix(".new").mkdir()
    wires.keep("SN-1", (W7,))
    wires.keep("SN-1", (W7,))
    assert wires.left() == ("SN-1", (W7,))
    assert caplog.text.count("cannot be kept") == 1
