"""What waits for a person, as cards; no ROS."""

from dataclasses import replace

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from remodel_console.core.commands import as_literal, value_words
from remodel_console.core.run_view import Asked, Phase, RunView
from remodel_console.core.running import Level, Structure, TakeOutcome, decisions_of
from remodel_console.core.use_case import Question, UseCase
from remodel_console.core.world import InputRequest, Kind, World, cards
from remodel_run.progress import Answer
from remodel_run.progress import Phase as OrderPhase

CHART = b"""<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="C" initial="Box">
<datamodel><outcome name="done"/></datamodel>
<ext:container id="Box" initial="Judge"><datamodel><outcome name="ended"/></datamodel>
<state id="Judge" type="flexbe_states.OperatorDecisionState">
  <param name="outcomes" value="['go', 'stop']"/><param name="suggestion" value="SUGGESTION"/>
  <transition event="go" target="ended"/><transition event="stop" target="ended"/>
</state>
<transition event="ended" target="done"/></ext:container></statemachine>"""
WORLD = World(run=RunView(phase=Phase.RUNNING, behavior_id=7, active="/Box/Judge"))
TREE = Structure(7, (Level("/Box/Judge", (), ("stop", "go"), ("ended", "ended")),))


def world_with(suggestion, **run):
    chart = parse_chart(CHART.replace(b"SUGGESTION", suggestion))
    decisions = decisions_of(chart, 7)
    return replace(WORLD, decisions=decisions, run=replace(WORLD.run, **run))


def test_a_state_without_suggestion_waits_for_a_decision():
    (card,) = cards(world_with(b"", level=3, structure=TREE))
    assert (card.kind, card.must_attach) == (Kind.DECISION, False)
    # As the engine numbers the outcomes, which may not be the order of the chart.
    assert [option.act for option in card.options] == [
        TakeOutcome("/Box/Judge", 1, "go", is_forced=True),
        TakeOutcome("/Box/Judge", 0, "stop", is_forced=True),
    ]
    assert card.record(card.options[1]) == "decide 'stop' of /Box/Judge"


def test_an_unattended_decision_attaches_first():
    (card,) = cards(world_with(b"", level=255))
    assert card.must_attach
    assert [option.act.index for option in card.options] == [0, 1]


def test_a_suggestion_is_decided_once_the_engine_asks():
    assert cards(world_with(b"stop", level=1, structure=TREE)) == ()
    asked = Asked("/Box/Judge", 0)
    (card,) = cards(world_with(b"stop", level=1, structure=TREE, asks=(asked,)))
    assert card.kind is Kind.DECISION
    assert [option.words for option in card.options] == ["stop", "go"]
    assert card.options[0].meaning == "the suggestion of the state"


def test_decisions_of_another_behavior_do_not_count():
    world = world_with(b"", level=1)
    assert cards(replace(world, run=replace(world.run, behavior_id=8))) == ()


def test_a_transition_is_confirmed_and_unknown_outcomes_are_not_offered():
    asked = Asked("/Box/Judge", 1)
    (card,) = cards(replace(WORLD, run=replace(WORLD.run, structure=TREE, asks=(asked,))))
    assert (card.kind, card.options[0].words) == (Kind.CONFIRMATION, "Confirm 'go'")
    (card,) = cards(replace(WORLD, run=replace(WORLD.run, asks=(asked,))))
    assert card.options == ()
    assert "attach" in card.details


def test_all_that_waits_stands_together_the_question_of_the_cell_first():
    question = Question(4, "W4", "The wire jams.", (Answer.RETRY, Answer.STOP))
    use_case = UseCase(OrderPhase.ASKING, question=question)
    world = world_with(b"", level=3, structure=TREE)
    world = replace(world, use_case=use_case, inputs=(InputRequest(1, "Which pin?"),))
    found = cards(world)
    assert [card.kind for card in found] == [Kind.QUESTION, Kind.INPUT, Kind.DECISION]
    assert found[0].record(found[0].options[0]) == "answer question 4 about W4: Try again"


def test_a_value_is_a_literal_and_else_a_text():
    for typed, sent in (
        ("7", "7"),
        (" [1, 'a'] ", "[1, 'a']"),
        ("None", "None"),
        ("A7", "'A7'"),
        ("[1,", "'[1,'"),
        ("__import__('os')", "\"__import__('os')\""),
    ):
        assert as_literal(typed) == sent
    assert value_words("A7") == "Sends the text 'A7'"
    assert value_words("(1, 2)") == "Sends the tuple (1, 2)"
