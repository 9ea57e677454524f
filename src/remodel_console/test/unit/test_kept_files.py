"""What a console writes beside its work: its log, the record of commands, recordings of cells."""

import threading
import time
from collections import deque
from itertools import count
from types import SimpleNamespace

import pytest
import rospy

from flexbe_core.testing import wait_until
from remodel_console.core.cell import CellState, StateValues
from remodel_console.core.commands import Actor, Role
from remodel_console.core.running import LogLine
from remodel_console.edge.kept_files import Journal, LogFile, SceneFiles
from remodel_console.live import Desk, Live
from remodel_console.ros.watched_links import SceneRecorder


def test_the_log_survives_a_restart_and_stays_short(tmp_path):
    file = tmp_path / "log.jsonl"
    first = LogFile(file)
    lines = [LogLine(float(n), 0, f"line {n}\nwith more") for n in range(10_500)]
    for line in lines:
        first.write(line)
    with file.open("a") as cut_off:
        cut_off.write('[1.0, 0, "cut')
    assert LogFile(file).lines == tuple(lines[-499:])
    assert len(file.read_text().splitlines()) <= 500


def test_the_log_is_exported_with_what_no_page_shows_any_more(tmp_path):
    live = Live(LogFile(tmp_path / "log.jsonl"))
    at = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(1e9))
    for n in range(600):
        live.take_line(LogLine(1e9, 1, f"line {n}"))
    exported = live.exported_log().splitlines()
    assert (len(exported), exported[0]) == (600, f"{at}  warning  line 0")
    without_file = Live()
    without_file.take_line(LogLine(1e9, 0, "only"))
    assert without_file.exported_log() == f"{at}  info     only\n"


def test_the_log_goes_on_in_memory_on_a_full_disk(tmp_path, full_disk, caplog):
    file = tmp_path / "log.jsonl"
    LogFile(file).write(LogLine(0.0, 0, "before"))
    with full_disk():
        log = LogFile(file)
        for n in range(10_500):
            log.write(LogLine(float(n), 0, "lost"))
    assert len(log.lines) == 500
    assert len(caplog.records) == 1
    assert "lines are lost: [Errno" in caplog.text
    log.write(LogLine(2.0, 0, "after"))
    assert [line.text for line in LogFile(file).lines] == ["before", "after"]


def test_a_command_is_answered_though_it_cannot_be_recorded(tmp_path, full_disk, caplog):
    journal = Journal(tmp_path / "commands.jsonl")
    with full_disk():
        answer = Desk(journal).give(Actor("ada", "page", Role.OPERATOR), "pause", lambda: "paused")
    assert answer.words == "paused"
    assert "commands.jsonl cannot be written, so this is not recorded" in caplog.text
    assert "pause" in caplog.text


def test_a_full_disk_ends_the_recording_of_one_run_only(tmp_path, full_disk, monkeypatch):
    reported, values, end = threading.Event(), deque(), threading.Event()
    monkeypatch.setattr(rospy, "get_time", lambda: 100.0)
    monkeypatch.setattr(rospy, "logwarn", lambda *words: reported.set())
    under_way = {"is_under_way": True, "started_s": 100.0, "interruptions": 0, "order": "house"}
    cases = [SimpleNamespace(run=number, **under_way) for number in (1, 2)]
    scene = SimpleNamespace(now=CellState(), add_viewer=lambda count: None)
    with full_disk():
        values.append(StateValues(1.0, "/Locate", ()))
        SceneRecorder(scene, SceneFiles(tmp_path), lambda: cases[0], values, end)
        assert reported.wait(10.0)
    del cases[0]
    values.append(StateValues(2.0, "/Insert", ()))
    try:
        assert wait_until(lambda: any("/Insert" in f.read_text() for f in tmp_path.iterdir()))
    finally:
        end.set()
        next(t for t in threading.enumerate() if t.name == "scene recorder").join()


def test_a_joint_that_turns_slowly_beside_a_fast_one_is_recorded(tmp_path, monkeypatch):
    class Turning:
        """A cell whose joints turn a little further each time that it is read."""

        turns = 0
        add_viewer = staticmethod(lambda change: None)

        @property
        def now(self):
            self.turns += 1
            return CellState(joints={"fast": 0.01 * self.turns, "slow": 2e-4 * self.turns})

    monkeypatch.setattr(rospy, "get_time", count(1.0).__next__)
    case = SimpleNamespace(run=1, order="house", is_under_way=True, started_s=1.0, interruptions=0)
    cell, end, files = Turning(), threading.Event(), SceneFiles(tmp_path)
    SceneRecorder(cell, files, lambda: case, deque(), end)
    recorder = next(t for t in threading.enumerate() if t.name == "scene recorder")
    try:
        assert wait_until(lambda: cell.turns >= 20)
    finally:
        end.set()
        recorder.join()
    joints = files.read(1, "house", time.time()).at(1e9).joints
    assert joints["slow"] == pytest.approx(2e-4 * cell.turns, abs=6e-4)
