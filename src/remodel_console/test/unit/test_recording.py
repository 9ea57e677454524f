"""The cell in three dimensions over time, and its files."""

import os
from dataclasses import replace

import pytest

from remodel_console.core.cell import (
    CellState,
    Line,
    Recording,
    Robot,
    Solid,
    StateValues,
    Value,
    change_between,
    differences,
    frame_text,
    read_robot,
    state_after,
)
from remodel_console.core.record import Record, force_words, recorded_wire_words
from remodel_console.edge.kept_files import RUNS_KEPT, SceneFiles
from remodel_run.record import Entry, Kind

URDF = '<robot name="r"><link name="base"/></robot>'
ROBOT = Robot(read_robot(URDF), "left_", (1.0, 0.0, 0.0), description=URDF)
STILL = Line(((0.0, 0.0, 0.0), (0.1, 0.0, 0.0)), 0.003, "#ff0000")
BOX = Solid((0.5, 0.2, 0.0), (0.0, 0.0, 0.0, 1.0), (0.1, 0.1, 0.1), "#808080")


def moved(step):
    """Return the cell at a step: a joint turns, W2 rises, and W1 is gone after the third."""
    rising = Line(((0.0, 0.0, 0.01 * step), (0.1, 0.0, 0.01 * step)), 0.003, "#0000ff")
    wires = {"W2": rising} | ({"W1": STILL} if step < 3 else {})
    return CellState((ROBOT,), {"a": 0.1 * step, "b": 1.0}, wires, {"X1": BOX})


def lines(states, first_s=10.0):
    before = CellState()
    for place, state in enumerate(states):
        yield frame_text(first_s + place, change_between(before, state))
        before = state


def test_every_moment_is_what_it_was():
    states = [moved(step) for step in range(200)]
    recording = Recording.read(lines(states))
    for place in (0, 1, 2, 3, 63, 64, 65, 128, 199):
        found = recording.at(10.0 + place)
        assert found.robots == states[place].robots
        assert found.wires == states[place].wires
        assert found.boxes == states[place].boxes
        assert found.joints == pytest.approx(states[place].joints)
    assert recording.at(0.0).wires == states[0].wires
    assert recording.at(10.6).wires == states[0].wires
    assert recording.at(1e9).wires == states[-1].wires


def test_what_lies_still_is_not_written_again():
    assert change_between(moved(1), moved(1)) != {}, "another object is another wire"
    state = moved(1)
    assert change_between(state, state) == {}
    assert set(change_between(moved(1), moved(2))) == {"joints", "wires"}
    assert change_between(moved(2), moved(3))["gone"] == ["W1"]
    assert "W1" not in change_between(moved(1), moved(2))["wires"]


def test_a_visit_of_a_state_has_the_values_that_it_found():
    frames = []
    for time_s, path, count in ((10.1, "/A", 1), (20.1, "/Box/B", 2), (30.1, "/A", 3)):
        values = (Value("", "count", "int", str(count)),)
        change = {"values": StateValues(time_s, path, values).as_json()}
        frames.append(frame_text(time_s + 0.2, change))
    recording = Recording.read([*lines([moved(1)]), *frames])
    assert [v.literal for v in recording.values_at("/A", 10.0, 20.0)] == ["1"]
    assert [v.literal for v in recording.values_at("/A", 30.0, 40.0)] == ["3"]
    assert recording.values_at("/A", 20.0, 30.0) == ()
    assert recording.values_at("/Box/B", 20.0, 30.0)[0].name == "count"
    assert recording.at(25.0).wires == moved(1).wires
    cut_off = Recording.read([*frames, '[50.0, {"values": [50.0, "/A"]}]\n', *frames])
    assert len(cut_off.frames) == len(frames), "what follows a frame that is none is left out"


def test_what_differs_in_the_cell_is_named():
    then, now = moved(1), moved(4)
    assert differences(then, then) == ()
    assert differences(then, now) == (
        "The robot stands elsewhere: joint a differs by 0.30.",
        "Not in the cell now: W1.",
        "W2 lies up to 30 mm elsewhere.",
    )
    assert "Only in the cell now: W1." in differences(now, then)
    other = replace(then, boxes={"X1": replace(BOX, position=(0.5, 0.3, 0.0))})
    assert differences(then, other) == ("Moved: X1.",)
    assert differences(then, replace(then, boxes={})) == ("Another panel is in the cell.",)


def test_a_whole_frame_counts_from_an_empty_cell():
    after_restart = change_between(CellState(), moved(5)) | {"whole": True}
    assert set(state_after(moved(1), after_restart).wires) == {"W2"}


@pytest.mark.parametrize("cut", ["[12.0,{", '{"a": 1}', "[1]", '[1,{"wires":{"W1":[]}}]', "[1,[]]"])
def test_a_line_that_was_cut_off_ends_a_recording(cut):
    good = list(lines([moved(0), moved(1)]))
    assert len(Recording.read([*good, cut, *good]).frames) == 2


def test_robots_that_were_not_known_at_first_stand_there_from_the_beginning():
    states = [CellState(wires={"W1": STILL}), moved(1)]
    assert Recording.read(lines(states)).at(10.0).robots == (ROBOT,)


def test_no_frames_are_an_empty_cell():
    assert Recording.read([]).at(3.0) == CellState()


def record(files, run, begun_s, states, order="cabinet", goes_on=False, started_s=None):
    started_s = begun_s if started_s is None else started_s
    with files.begin(run, order, begun_s, started_s, goes_on=goes_on) as file:
        file.writelines(lines(states))


def test_runs_of_one_number_are_told_apart_by_order_and_time(tmp_path):
    files = SceneFiles(tmp_path / "scenes")
    assert files.read(1, "cabinet", 100.0) is None
    record(files, 1, 100.0, [moved(1)])
    record(files, 1, 5000.0, [moved(2), moved(3)])
    record(files, 1, 110.0, [moved(1), moved(2), moved(3)], order="other")
    counts = [
        len(files.read(1, order, begun_s).frames)
        for order, begun_s in (("cabinet", 101.0), ("cabinet", 4999.0), ("other", 100.0))
    ]
    assert counts == [1, 2, 3]
    assert files.read(2, "cabinet", 100.0) is None


def test_a_run_that_goes_on_is_one_recording(tmp_path):
    files = SceneFiles(tmp_path)
    record(files, 1, 100.0, [moved(1)])
    record(files, 1, 700.0, [moved(2)], goes_on=True)
    assert len(files.read(1, "cabinet", 100.0).frames) == 2
    record(files, 7, 900.0, [moved(2)], goes_on=True)
    assert len(files.read(7, "cabinet", 900.0).frames) == 1


def test_a_console_that_restarts_goes_on_with_the_recording_of_the_run(tmp_path):
    files = SceneFiles(tmp_path)
    record(files, 1, 100.0, [moved(1)], started_s=3.5)
    record(files, 1, 160.0, [moved(2)], started_s=3.5)
    record(files, 1, 900.0, [moved(2)], started_s=4.25)
    assert len(files.read(1, "cabinet", 100.0).frames) == 2
    assert len(files.read(1, "cabinet", 900.0).frames) == 1


def test_the_oldest_recordings_are_deleted(tmp_path):
    files = SceneFiles(tmp_path)
    runs = range(1, RUNS_KEPT + 3)
    for run in runs:
        record(files, run, 100.0 * run, [moved(1)])
        for path in tmp_path.glob(f"*-{run}.scene.jsonl"):
            os.utime(path, (run, run))
    kept = [run for run in runs if files.read(run, "cabinet", 100.0 * run) is not None]
    assert kept == list(runs[2:])


def test_a_wire_has_its_forces_and_its_history():
    entries = (
        Entry(1, 5.0, Kind.TASK, task="W4", text="begins"),
        Entry(2, 6.0, Kind.FEEDBACK, task="W4", values=(("force_n", 3.0), ("depth_m", 0.01))),
        Entry(3, 7.0, Kind.FEEDBACK, task="W4", values=(("force_n", 9.0),)),
        Entry(4, 8.0, Kind.FEEDBACK, task="W4", values=(("force_n", 4.0),)),
        Entry(5, 9.0, Kind.FAILURE, task="W4", fault="jammed", text="9 N"),
        Entry(6, 12.0, Kind.TASK, task="W5", text="begins"),
    )
    record = Record(entries)
    assert force_words(record, "W4") == ("force [N]: 9 at most, 4 last",)
    assert force_words(record, "W4", 1) == ("force [N]: 3 at most, 3 last",)
    words = recorded_wire_words(record, "W4", 5)
    assert words[0] == "force [N]: 9 at most, 4 last"
    assert words[1].startswith("4.0 s: ")
    assert words[2] == "0.0 s: begins"
    assert recorded_wire_words(record, "W5", 3) == ("Its task begins later in this run.",)
    assert recorded_wire_words(record, "W9", 5) == ("No task is about this wire.",)
