"""Chart folders with what is no chart in them, and charts that lie in no package."""

import os
import re
import shutil
import signal
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

from remodel_console.console import Console
from remodel_console.core import chart_edit
from remodel_console.core.commands import read_command
from remodel_console.edge.workspace import (
    GENERATED,
    Catalogue,
    ChartFolders,
    Workspace,
    inspect_text,
)
from remodel_console.errors import CommandError
from remodel_console.session import Session

SRC = Path(__file__).parents[3]
AT_MOST_S = 20  # what blocks is ended by then
CHART = """<statemachine name="{name}" initial="A">
  <datamodel><outcome name="finished"/></datamodel>
  <state id="A" type="WaitState">
    <param name="wait_time" value="1"/>
    <transition event="done" target="{target}"/>
  </state>
</statemachine>
"""


@pytest.fixture(autouse=True)
def in_time():
    """Fail a test that blocks."""

    def end(*_arguments):
        pytest.fail("it blocks")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(AT_MOST_S)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def package(tmp_path):
    return Path(shutil.copytree(SRC / "remodel_behaviors", tmp_path / "remodel_behaviors"))


@pytest.fixture
def user_charts(tmp_path):
    folder = tmp_path / "home" / "remodel_charts"
    folder.mkdir(parents=True)
    return folder


@pytest.fixture
def workspace(package, user_charts):
    path = f"{package}:{SRC / 'remodel_states'}:{SRC / 'flexbe' / 'flexbe_states'}"
    return Workspace(path, lambda: (user_charts,))


@pytest.fixture
def session(workspace):
    return Session(workspace)


@pytest.fixture
def give(session):
    return lambda text: session.carry_out(read_command(text))


def test_what_is_no_chart_blocks_nothing(package, user_charts, workspace, give, tmp_path):
    (tmp_path / "secret.xml").write_text(CHART.format(name="Secret", target="finished"))
    for folder in (package / "charts", user_charts):
        os.mkfifo(folder / "fifo.xml")
        (folder / "folder.xml").mkdir()
        (folder / "zero.xml").symlink_to("/dev/zero")
        (folder / "secret.xml").symlink_to(tmp_path / "secret.xml")
        (folder / "gone.xml").symlink_to(folder / "nowhere")
        (folder / "round.xml").symlink_to(folder / "round.xml")
        with (folder / "large.xml").open("wb") as large:
            large.truncate(2**33)
    os.mkfifo(package / "manifest" / "fifo.xml")
    os.mkfifo(package / "src" / "remodel_behaviors" / "fifo.py")
    assert "loaded 'my_first_behavior'" in give("load my_first_behavior")
    assert give("check") == "no errors and no warnings"
    give("synthesize Box i: start g: TestBehaviorExample_descpt.xml")
    give("save")
    assert "Say hello" in give("findStateUsage flexbe_states.LogState")
    assert "Secret" not in workspace.names()
    assert list(workspace.too_large()) == ["large.xml"]
    assert "large.xml has 8192.0 MiB; charts have 4 at most" in workspace.too_large()["large.xml"]
    for name in ("fifo.xml", "folder.xml", "zero.xml", "secret.xml", "gone.xml", "large.xml"):
        assert workspace.text_of(name) == ""
        with pytest.raises(CommandError):
            give(f"synthesize Box i: start g: {user_charts / name}")


def test_a_new_chart_goes_into_a_package_of_the_user(package, user_charts, tmp_path):
    assert Workspace(str(package), lambda: (user_charts,)).own_folder == user_charts
    assert Workspace(str(package)).own_folder == package / "charts"
    own = [tmp_path / name for name in ("lab_behaviors", "remodel_order_behaviors", "my_behaviors")]
    for folder in own:
        shutil.copytree(package, folder)
        file = folder / "package.xml"
        file.write_text(file.read_text().replace("<name>remodel_behaviors", f"<name>{folder.name}"))
    path = ":".join(map(str, (package, *own)))
    assert Workspace(path, lambda: (user_charts,)).own_folder == own[0] / "charts"
    mine = Workspace(path, lambda: (user_charts,), output="my_behaviors")
    assert mine.own_folder == own[2] / "charts"


def test_behaviors_that_the_supervisor_has_made_are_known_from_others(package, tmp_path):
    made = Path(shutil.copytree(package, tmp_path / GENERATED))
    for file in (made / "package.xml", *(made / "manifest").glob("*.xml")):
        file.write_text(file.read_text().replace("remodel_behaviors", GENERATED))
    (made / "src" / "remodel_behaviors").rename(made / "src" / GENERATED)
    for folder, is_generated in ((package, False), (made, True)):
        path = str(folder)
        console = SimpleNamespace(catalogue=Catalogue(path), workspace=Workspace(path))
        names = Console.list_names(console)
        assert names
        assert console.generated == (set(names) if is_generated else set())


def test_folders_that_take_too_long_are_named(package, monkeypatch):
    monkeypatch.setattr("remodel_console.edge.workspace.time.monotonic", count(0, 20).__next__)
    with pytest.raises(CommandError, match=r"takes more than .* move other files out of .*"):
        list(ChartFolders((package / "charts",)).names())


def test_a_chart_in_no_package_is_checked_as_any_other(workspace, user_charts, give):
    file = user_charts / "lost.xml"
    file.write_text(CHART.format(name="Lost", target="nowhere"))
    give("load Lost")
    assert "lost.xml:5:" in give("check")
    _chart, inspection = inspect_text(workspace, file.read_text(), str(file))
    assert inspection.error_count == 1
    assert inspection.unchecked == ""
    with pytest.raises(CommandError, match="unknown-target"):
        give("save")


def test_a_chart_in_no_package_is_saved_where_it_lies_its_behavior_in_the_output_package(
    session, package, user_charts, give
):
    file = user_charts / "found.xml"
    file.write_text(CHART.format(name="Found", target="finished"))
    give("load Found")
    assert str(package / "src" / "remodel_behaviors" / "found_sm.py") in give("save")
    limited = chart_edit.limited(session.chart, "A", None, 9.0)
    session.change(lambda _chart: chart_edit.led(limited, "A", "timed_out", "finished"))
    answer = give("save")
    assert str(file) in answer
    assert 'ext:timeout_s="9.0"' in file.read_text()
    assert not list(user_charts.glob("*/"))


def test_a_chart_is_not_saved_over_the_behavior_of_another_chart_of_its_name(
    package, user_charts, give
):
    file = user_charts / "mine.xml"
    file.write_text(CHART.format(name="Example Behavior", target="finished"))
    first = package / "charts" / "example_behavior.xml"
    code = package / "src" / "remodel_behaviors" / "example_behavior_sm.py"
    give("load Example Behavior")
    before = code.read_bytes()
    with pytest.raises(CommandError, match=f"{file} and {first} both have the name"):
        give("save")
    assert code.read_bytes() == before


def other_package(folder):
    """Make a package for behaviors; return its folder."""
    (folder / "charts").mkdir(parents=True)
    (folder / "package.xml").write_text(
        f"<package><name>{folder.name}</name><export><flexbe_behaviors/></export></package>"
    )
    return folder


@pytest.mark.parametrize("found", ["Outer", "Inner"])
def test_a_behavior_that_the_engine_would_not_run_is_not_saved(
    found, package, user_charts, tmp_path
):
    first = other_package(tmp_path / "first")
    rest = f"{package}:{SRC / 'remodel_states'}:{SRC / 'flexbe' / 'flexbe_states'}"

    def save(path, name):
        session = Session(Workspace(path, lambda: (user_charts,)))
        session.carry_out(read_command(f"load {name}"))
        return session.carry_out(read_command("save"))

    chart = first / "charts" / "before.xml"
    chart.write_text(CHART.format(name=found, target="finished"))
    save(f"{first}:{rest}", found)
    chart.unlink()
    (user_charts / "inner.xml").write_text(CHART.format(name="Inner", target="finished"))
    use = '<behavior id="In" type="inner.xml"><transition event="finished" target="finished"/>'
    text = CHART.format(name="Outer", target="In")
    text = text.replace("</statemachine>", f"{use}</behavior></statemachine>")
    (user_charts / "outer.xml").write_text(text)
    code = package / "src" / "remodel_behaviors" / "outer_sm.py"
    with pytest.raises(CommandError, match=f"'{found}' .*{package}: {first} has one of that name"):
        save(f"{first}:{rest}", "Outer")
    assert not code.exists()
    assert str(code) in save(f"{rest}:{first}", "Outer"), "it comes after"


def test_without_an_output_package_saving_says_what_to_do(user_charts):
    (user_charts / "lost.xml").write_text(CHART.format(name="Lost", target="finished"))
    session = Session(Workspace(str(SRC / "flexbe" / "flexbe_states"), lambda: (user_charts,)))
    session.carry_out(read_command("load Lost"))
    with pytest.raises(CommandError, match="no package 'remodel_behaviors'") as caught:
        session.carry_out(read_command("save"))
    assert "--output" not in str(caught.value)
    assert session.carry_out(read_command("check")) == "no errors and no warnings"


def test_while_a_chart_is_typed_the_charts_that_it_names_are_not_checked_again(
    workspace, user_charts
):
    (user_charts / "inner.xml").write_text(CHART.format(name="Inner", target="finished"))
    outer = user_charts / "outer.xml"
    text = CHART.format(name="Outer", target="In").replace(
        "</statemachine>",
        '<behavior id="In" type="inner.xml"><transition event="finished" target="finished"/>'
        "</behavior></statemachine>",
    )
    found = []
    for value in ("1", "2"):
        typed = text.replace('value="1"', f'value="{value}"')
        chart, inspection = inspect_text(workspace, typed, str(outer))
        assert (chart.nodes[0].params[0].value, inspection.problems) == (int(value), ())
        found.append(workspace.look(typed, str(outer)).charts)
    first, second = found
    inner = str(user_charts / "inner.xml")
    assert first[inner].resolved is second[inner].resolved
    assert first[str(outer)].resolved is not second[str(outer)].resolved
    (user_charts / "inner.xml").write_text(CHART.format(name="Inner", target="finisht"))
    _chart, inspection = inspect_text(workspace, typed, str(outer))
    assert "unknown-target" in [problem.code.slug for problem in inspection.problems]


WRONG = CHART.format(name="Wrong", target="nowhere")


LATIN = '<?xml version="1.0" encoding="ISO-8859-1"?>\n<!-- Größe -->\n'


@pytest.mark.parametrize("text", [WRONG, LATIN + WRONG])
def test_a_chart_with_errors_is_kept_as_a_draft_and_survives_the_console(
    text, user_charts, workspace
):
    file = user_charts / "wrong.xml"
    session = Session(workspace)
    session.open(chart_edit.new_chart("Wrong", str(file)))
    session.retype(text)
    answer = session.save_or_keep()
    assert re.match(r"kept 'Wrong' as a draft, which has \d errors?: .*wrong\.xml\.draft$", answer)
    assert session.is_kept and not session.is_saved
    assert not file.exists(), "nothing that could run"
    session.undo()
    assert not session.is_kept

    again = Session(workspace)
    assert "Wrong" in workspace.names()
    again.carry_out(read_command("load Wrong"))
    assert again.text == text
    assert again.is_kept and not again.is_saved


def test_a_draft_is_gone_once_its_chart_is_saved(user_charts, workspace):
    (user_charts / "mine.xml").write_text(CHART.format(name="Mine", target="finished"))
    session = Session(workspace)
    session.carry_out(read_command("load Mine"))
    right = session.text
    session.retype(right.replace('target="', 'target="nowhere', 1))
    assert "as a draft" in session.save_or_keep()
    (draft,) = user_charts.glob("*.draft")
    other = Session(workspace)
    answer = other.carry_out(read_command("load Mine"))
    assert answer.startswith("loaded the draft of 'Mine'")
    with pytest.raises(CommandError, match="error"):
        other.carry_out(read_command("save"))
    other.retype(right)
    assert "saved 'Mine'" in other.save_or_keep()
    assert other.is_saved
    assert not draft.exists()


def test_only_the_editor_opens_a_draft_and_none_that_is_older_than_its_chart(
    user_charts, workspace
):
    file = user_charts / "mine.xml"
    text = CHART.format(name="Mine", target="finished")
    file.write_text(text)
    session = Session(workspace)
    session.carry_out(read_command("load Mine"))
    session.retype(CHART.format(name="Mine", target="nowhere"))
    session.save_or_keep()
    commands = Session(workspace, opens_drafts=False)
    commands.carry_out(read_command("load Mine"))
    assert commands.text == text and commands.is_saved

    (draft,) = user_charts.glob("*.draft")
    os.utime(draft, ns=(0, file.stat().st_mtime_ns - 1))  # another program wrote the chart since
    again = Session(workspace)
    again.carry_out(read_command("load Mine"))
    assert again.text == text
    assert draft.exists()
    file.unlink()
    with pytest.raises(CommandError, match="there is no behavior 'Mine'"):
        commands.carry_out(read_command("load Mine"))
