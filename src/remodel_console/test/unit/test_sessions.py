"""Sessions of pages: each has its own, and unsaved changes outlive a page; no ROS."""

import time

import pytest

from remodel_console.core.chart_edit import new_chart, started_at
from remodel_console.core.commands import read_command
from remodel_console.edge.workspace import Workspace
from remodel_console.errors import CommandError
from remodel_console.session import Session, Sessions


@pytest.fixture
def sessions():
    return Sessions(lambda: Session(Workspace("")), Session(Workspace("")))


class Browser:
    """A page that can be closed."""

    def __init__(self, sessions, key="", who=""):
        self.is_open = True
        self.key, self.session = sessions.take(key, lambda: self.is_open, who)


def test_pages_do_not_share_a_session_while_they_are_shown(sessions):
    first = Browser(sessions)
    second = Browser(sessions, first.key)
    assert first.session is not second.session
    assert sessions.commands not in (first.session, second.session)


def test_a_reload_continues_the_session_and_unsaved_work_outlives_its_page(sessions):
    first = Browser(sessions)
    first.session.open(new_chart("Mine", "/charts/mine.xml"))
    assert sessions.left_unsaved() == ()
    first.is_open = False
    assert [(left.key, left.name) for left in sessions.left_unsaved()] == [(first.key, "Mine")]
    Browser(sessions)
    again = Browser(sessions, first.key)
    assert again.session is first.session
    again.is_open = False
    sessions.discard(first.key)
    assert sessions.left_unsaved() == ()
    assert Browser(sessions, first.key).session is not first.session


def test_unsaved_changes_of_a_chart_are_offered_once_with_the_time_of_the_last(sessions):
    pages = [Browser(sessions), Browser(sessions)]
    for page, at_s in zip(pages, (2e9, 1e9), strict=True):
        page.session.open(new_chart("Mine", "/charts/mine.xml"))
        page.session.changed_at_s = at_s
        page.is_open = False
    (left,) = sessions.left_unsaved()
    assert left.key == pages[0].key
    assert left.changed_at == time.strftime("%H:%M", time.localtime(2e9))
    sessions.discard(left.key)
    assert [left.key for left in sessions.left_unsaved()] == [pages[1].key], "nothing is lost"


def test_who_else_has_a_chart_open_is_known(sessions):
    mine, theirs = Browser(sessions, who="Ann"), Browser(sessions, who="Bob")
    mine.session.open(new_chart("Mine", "/charts/mine.xml"))
    assert sessions.others_at(mine.key) == ()
    theirs.session.open(new_chart("Mine", "/charts/mine.xml"))
    assert sessions.others_at(mine.key) == ("Bob",)
    assert sessions.others_at(theirs.key) == ("Ann",)
    theirs.is_open = False
    assert sessions.others_at(mine.key) == ()


def test_every_session_reports_changes_and_asks_the_server_once_it_is_connected(sessions):
    changes = []
    before = Browser(sessions)
    sessions.on_change(lambda: changes.append(1))
    sessions.connect(lambda _request: ())
    after = Browser(sessions)
    for session in (before.session, after.session, sessions.commands):
        session.open(new_chart("Mine", "/charts/mine.xml"))
        assert session.ask_server is not None
    assert len(changes) == 3


def test_undo_and_redo_go_back_and_forth_until_a_new_change(sessions):
    session = Browser(sessions).session
    session.open(new_chart("Mine", "/charts/mine.xml"))
    for name in ("A", "B"):
        session.change(lambda chart, name=name: started_at(chart, name))
    session.undo()
    session.undo()
    assert session.chart.initial == ""
    assert not session.can_undo
    session.redo()
    assert session.chart.initial == "A"
    session.change(lambda chart: started_at(chart, "C"))
    with pytest.raises(CommandError, match="nothing to redo"):
        session.redo()
    session.carry_out(read_command("note done"))
    assert session.can_undo
