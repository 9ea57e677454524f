"""What the console starts where nothing runs: it ends with the console, or says why it ended."""

import pytest

from remodel_console.edge.processes import SAMPLE, Everything, Finished
from remodel_console.errors import CommandError

LIMIT_S = 30


class Planner:
    """Knows the sample order or not, and may refuse to import it."""

    def __init__(self, knows, refuses=""):
        self.knows, self.refuses, self.ran = knows, refuses, []

    def run(self, words, folder, database):
        self.ran.append(words[0])
        if words[0] == "tasks":
            return Finished(0 if self.knows else 1, "", "")
        return Finished(1 if self.refuses else 0, "", self.refuses)


@pytest.fixture
def everything(tmp_path, monkeypatch):
    """Return one whose nodes are a script of the test."""

    def made(script, planner=None):
        launch = tmp_path / "roslaunch"
        launch.write_text(f"#!/bin/sh\n{script}\n")
        launch.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
        made.planner = planner or Planner(knows=False)
        return Everything(tmp_path / "all", made.planner)

    return made


def test_the_sample_order_is_imported_once_and_the_nodes_are_ended(everything):
    # A shell starts what runs in its background with SIGINT ignored; roslaunch takes it there, too.
    one = everything('echo "$@"; exec env --default-signal=INT sleep 1000')
    assert one.start(fake=True, interfaces=False) == SAMPLE
    assert everything.planner.ran == ["tasks", "import"]
    assert one.is_running and not one.trouble
    with pytest.raises(CommandError, match="started already"):
        one.start(fake=True, interfaces=True)
    assert not one.was_ended
    one.stop()
    assert one.was_ended
    assert not one.is_running and not one.trouble
    everything.planner.knows = True
    one.start(fake=False, interfaces=True)
    assert everything.planner.ran == ["tasks", "import", "tasks"]
    one.stop()


def test_nodes_that_end_by_themselves_are_reported_with_the_end_of_their_log(everything):
    one = everything("echo no master >&2; exit 1")
    one.start(fake=True, interfaces=True)
    one._nodes.wait(LIMIT_S)
    assert not one.is_running
    assert one.trouble == "no master"
    one.stop()
    assert not one.was_ended


def test_without_roslaunch_or_a_disk_nothing_starts(everything, monkeypatch, tmp_path):
    one = everything("exit 1")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(CommandError, match="roslaunch cannot be started"):
        one.start(fake=True, interfaces=True)
    assert not one.is_running
    (tmp_path / "file").touch()
    nowhere = Everything(tmp_path / "file", Planner(knows=True))
    with pytest.raises(CommandError, match="cannot write to"):
        nowhere.start(fake=True, interfaces=True)


def test_an_order_that_is_refused_starts_nothing(everything):
    one = everything("exit 1", Planner(knows=False, refuses="a disk is full"))
    with pytest.raises(CommandError, match="cannot be imported: a disk is full"):
        one.start(fake=True, interfaces=True)
    assert not one.is_running
