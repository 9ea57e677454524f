"""Commands, keys and the editing session, on copies of packages; no ROS."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Container
from flexbe_synthesizer.core.export.layout import Instantiation
from remodel_console.core.commands import (
    DONE,
    CommandResult,
    Verb,
    is_allowed,
    read_answer,
    read_command,
)
from remodel_console.core.settings import Settings
from remodel_console.edge.workspace import Workspace
from remodel_console.errors import CommandError
from remodel_console.session import Session

SRC = Path(__file__).parents[3]


def path_with(package):
    """Return a package path with a package, states, and the names of error codes."""
    packages = ("remodel_msgs", "remodel_states", "flexbe/flexbe_states")
    return ":".join(map(str, (package, *(SRC / one for one in packages))))


@pytest.fixture
def package(tmp_path):
    """Return a copy of the behaviors that commands may write to."""
    return Path(shutil.copytree(SRC / "remodel_behaviors", tmp_path / "remodel_behaviors"))


@pytest.fixture
def session(package):
    path = path_with(package)
    return Session(Workspace(path))


@pytest.fixture
def give(session):
    return lambda text: session.carry_out(read_command(text))


SYNTHESIZE = "synthesize SynthesizedBehavior i: start g: TestBehaviorExample_descpt.xml"


def test_the_session_of_the_deliverable_leaves_a_saved_behavior(give, session, package):
    assert "loaded 'my_first_behavior'" in give("load my_first_behavior")
    assert "as /SynthesizedBehavior" in give(SYNTHESIZE)
    assert not session.is_saved
    assert "saved 'my_first_behavior': wrote" in give("save")
    assert session.is_saved
    chart = parse_chart((package / "charts" / "my_first_behavior.xml").read_bytes())
    assert [node.id for node in chart.nodes] == ["Say hello", "SynthesizedBehavior"]
    assert chart.nodes[0].transitions[0].target == "SynthesizedBehavior"
    assert [port.name for port in chart.inputs] == ["placepin_id"]
    code = package / "src" / "remodel_behaviors" / "my_first_behavior_sm.py"
    assert "'SynthesizedBehavior'" in code.read_text()
    assert give("check") == "no errors and no warnings"
    assert "nothing has changed" in give("save")


def test_synthesizing_again_replaces_the_container_and_keeps_its_transitions(give, session):
    give("load my_first_behavior")
    give(SYNTHESIZE)
    once = session.chart
    give(SYNTHESIZE.replace("i: start", "i: PlacePin"))
    assert session.chart == once


def test_a_container_can_be_entered_and_filled_further(give, session):
    give("load my_first_behavior")
    give(SYNTHESIZE)
    assert give("edit /SynthesizedBehavior") == "in /SynthesizedBehavior, which holds PlacePin"
    give("synthesize Again i: start g: place_connector.xml")
    outer = session.chart.nodes[1]
    assert isinstance(outer.body.nodes[1], Container)
    assert {"cable_id", "terminal_id"} <= {port.name for port in session.chart.inputs}
    assert all(port.default is None for port in outer.body.inputs)
    give("save")
    assert give("edit") == "in /, which holds Say hello, SynthesizedBehavior"
    with pytest.raises(CommandError, match="no container 'Other'"):
        give("edit /Other")


def test_errors_are_reported_with_their_lines_and_nothing_is_saved(give, session, package):
    before = {path: path.read_bytes() for path in package.rglob("*") if path.is_file()}
    give("load my_first_behavior")
    give(SYNTHESIZE.replace("SynthesizedBehavior", "finished"))
    with pytest.raises(CommandError, match=r"my_first_behavior\.xml:\d+:\d+: \[reserved-name\]"):
        give("save")
    assert "[reserved-name]" in give("check")
    assert {path: path.read_bytes() for path in package.rglob("*") if path.is_file()} == before
    assert "the unsaved changes are lost" in give("load Example Behavior")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("load my_frist_behavior", "Did you mean 'my_first_behavior'"),
        ("save", "no behavior is loaded"),
        ("edit /x", "no behavior is loaded"),
        ("update nothing", "no behavior 'nothing'"),
        ("statemachine", "refused here"),
    ],
)
def test_a_command_that_cannot_be_carried_out_says_why(give, text, reason):
    with pytest.raises(CommandError, match=reason):
        give(text)


@pytest.mark.parametrize(
    "goal", ["/etc/passwd", "../package.xml", "none.xml", "\0", "a" * 5000, "../charts"]
)
def test_a_chart_outside_the_folders_is_refused(give, goal):
    give("load my_first_behavior")
    with pytest.raises(CommandError):
        give(f"synthesize X i: start g: {goal}")


def test_a_behavior_without_a_chart_is_read_back_from_its_code(give, session, package):
    chart = package / "charts" / "place_connector.xml"
    code = package / "src" / "remodel_behaviors" / "place_connector_sm.py"
    before = code.read_bytes()
    chart.unlink()
    give("load Place Connector")
    assert session.chart.nodes[0].attempts == 3
    assert str(chart) in give("save")
    assert code.read_bytes() == before
    code.write_text(
        code.read_text().replace("# [MANUAL_INIT]\n", "# [MANUAL_INIT]\n        self.x = 1\n")
    )
    chart.unlink()
    with pytest.raises(CommandError, match="has no chart, and its code is none"):
        give("load Place Connector")


def test_notes_connections_and_uses(give, session):
    give("load my_first_behavior")
    give("note Made by hand.")
    assert session.chart.description.endswith("Made by hand.")
    with pytest.raises(CommandError):
        give("note")
    assert give("autoconnect") == "found nothing to connect"
    assert "Say hello" in give("findStateUsage flexbe_states.LogState")
    assert "no chart uses" in give("findStateUsage flexbe_states.NoState")
    assert "save lays" in give("autolayout")
    assert "read again" in give("update Example Behavior")
    assert give("show").startswith("<?xml")


@pytest.mark.parametrize(
    ("text", "verb", "given"),
    [
        ("cmd", Verb.HELP, {}),
        ("commands", Verb.HELP, {}),
        ("load A B", Verb.LOAD, {"name": "A B"}),
        ("synthesize A i:x g:y z", Verb.SYNTHESIZE, {"name": "A", "initial": "x", "goal": "y z"}),
        ("attach", Verb.ATTACH, {}),
        ("attach 2", Verb.ATTACH, {"level": "2"}),
        ("lock -1", Verb.LOCK, {"level": "-1"}),
        ("goforit", Verb.SWITCH, {}),
        ("findStateUsage('p.C')", Verb.FIND, {"state": "p.C"}),
        ("statemachine('Sub')", Verb.STATEMACHINE, {"name": "Sub"}),
    ],
)
def test_commands_are_spelled_as_in_the_app(text, verb, given):
    command = read_command(text)
    assert (command.verb, command.given) == (verb, given)


@pytest.mark.parametrize(
    "text", ["", " help", "Help", "load", "synthesize A i: x", "help me", "\n"]
)
def test_an_unknown_command_is_refused_with_its_usage(text):
    with pytest.raises(CommandError, match="is no command; "):
        read_command(text)


@pytest.mark.parametrize(
    ("given", "wanted", "allowed"),
    [
        (" ", "", True),
        ("x", "", True),
        ("x", " ", True),
        ("secret", "secret", True),
        ("Secret", "secret", False),
        ("", "secret", False),
        ("sécret", "sécret", True),
        ("secret1", "secret", False),
    ],
)
def test_keys(given, wanted, allowed):
    assert is_allowed(given, wanted) is allowed


def test_answers_come_back_as_they_were_sent():
    answer = CommandResult(DONE, "load a: b", "two\nlines")
    assert read_answer(str(answer)) == answer
    with pytest.raises(ValueError, match="no answer"):
        read_answer("hello")


def test_changes_are_taken_back_one_by_one(session, give):
    with pytest.raises(CommandError, match="no behavior is loaded"):
        session.change(lambda chart: chart)
    give("load my_first_behavior")
    loaded = session.chart
    changes = []
    session.on_change = lambda: changes.append(1)
    session.change(lambda chart: replace(chart, description="One."))
    session.change(lambda chart: chart)
    session.synthesize((), "Box", "start", "place_connector.xml")
    assert len(changes) == 3
    assert "undid" in session.undo()
    assert session.chart.description == "One."
    session.undo()
    assert session.chart == loaded
    assert session.is_saved  # as its file is
    with pytest.raises(CommandError, match="nothing to undo"):
        session.undo()
    session.open(replace(loaded, name="Other"))
    assert session.chart.name == "Other"


def test_synthesis_may_be_switched_off(package):
    path = path_with(package)
    session = Session(Workspace(path), lambda: Settings(is_synthesis_enabled=False))
    session.carry_out(read_command("load my_first_behavior"))
    with pytest.raises(CommandError, match="switched off"):
        session.carry_out(read_command(SYNTHESIZE))


def test_a_server_is_asked_for_what_is_put_in(package):
    path = path_with(package)
    settings = Settings(synthesis_topic="flexbe/synthesize", system="cell 1")
    session = Session(Workspace(path), lambda: settings)
    session.carry_out(read_command("load my_first_behavior"))
    with pytest.raises(CommandError, match="ROS is not running"):
        session.carry_out(read_command(SYNTHESIZE))
    asked = []

    def answer_late(request):
        asked.append(request)
        session.carry_out(read_command("load Example Behavior"))
        return (
            Instantiation("/", ":STATEMACHINE", "Wait", outcomes=("finished",)),
            Instantiation(
                "/Wait",
                "WaitState",
                parameter_names=("wait_time",),
                parameter_values=("0.5",),
                outcomes=("done",),
                transitions=("finished",),
            ),
        )

    session.ask_server = answer_late
    with pytest.raises(CommandError, match="another behavior was loaded meanwhile"):
        session.carry_out(read_command(SYNTHESIZE))
    assert asked[0].path == "/SynthesizedBehavior"
    assert asked[0].system == "cell 1"
    assert "as /SynthesizedBehavior" in session.carry_out(read_command(SYNTHESIZE))
    assert session.chart.nodes[-1].body.nodes[0].params[0].value == 0.5
