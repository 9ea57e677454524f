"""A run follows from its events alone: what is known, what comes next, and that it ends."""

import json
from dataclasses import replace
from random import Random

import hypothesis.strategies as st
import pytest
from hypothesis import given

from remodel_run.progress import Answer
from remodel_states.core.codes import Code
from remodel_supervision.core.recovery.judge import decide_recovery, question_about
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Answered,
    AsLeft,
    Blocked,
    Command,
    Commanded,
    Ending,
    Escalated,
    FeedRefused,
    Interrupted,
    OperationEnded,
    Part,
    PartRequested,
    Planned,
    RunBegun,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
    data_of,
    event_from,
    kind_of,
)
from remodel_supervision.core.runs.state import (
    INTERRUPTION_LIMIT,
    PERSON_FIRST,
    STUCK_HAND_LIMIT,
    Stage,
)
from remodel_supervision.core.runs.step import (
    Ask,
    Decide,
    EndRun,
    Execute,
    Plan,
    Settle,
    Wait,
    next_step,
)
from remodel_tasks.core.use_case.fault import Do, Limits, Policy, Response
from remodel_tasks.edge.fault_file import read_faults

FAULTS = read_faults()
POSSIBLE = frozenset(Do) - {Do.OTHER_METHOD, Do.RETRY_WITH}
JAM, LOST, NOTHING_HELD = Code.INSERTION_JAMMED, Code.SERVER_LOST, Code.NOTHING_HELD
NOT_SEATED, CONTRADICTORY = Code.NOT_SEATED, Code.CONTRADICTORY_RESULT
OUT_OF_DUCT = Code.OUT_OF_DUCT
MOTION_FAULT = 307


class Run:
    """A run as its events make it."""

    def __init__(self, *tasks, policy=None, possible=POSSIBLE, **begun):
        self.events = [RunBegun("house", "cabinet", "cell", tasks, **begun)]
        self.state = state_after(self.events)
        self.policy = policy or Policy()
        self.possible = possible
        self.now_s = 0.0

    @property
    def next(self):
        return next_step(self.state)

    def add(self, *events):
        self.events += events
        self.state = state_after(events, self.state)
        return self.next

    def plan(self):
        return self.add(Planned(self.state.waiting, "because"))

    def begin(self, task, part=Part.WHOLE):
        attempt = self.state.tasks[task].attempts + part.is_attempt
        if part is Part.WHOLE:
            self.add(PartRequested(task))
        begun = TaskBegun(task, attempt, part, f"Place Wire {task}", "<chart/>", self.now_s)
        return self.add(begun)

    def end(self, task, outcome="finished", code=0):
        self.now_s += 1.0
        if code:
            self.add(OperationEnded(task, operation(code, self.now_s)))
        return self.add(TaskEnded(task, outcome, self.now_s, outcome == "finished"))

    def fail(self, task, code, part=Part.WHOLE):
        """Begin a part of a task, and have it fail."""
        self.begin(task, part)
        return self.end(task, "failed", code)

    def fail_and_decide(self, task, code):
        self.fail(task, code)
        return self.decide(task)

    def interrupt(self, task):
        """Begin a task, and have it interrupted."""
        self.begin(task)
        return self.add(Interrupted("killed"))

    def clear(self, task):
        self.begin(task, Part.CLEAR)
        return self.end(task)

    def discard(self, task):
        assert self.next == Execute(task, Part.DISCARD)
        self.begin(task, Part.DISCARD)
        return self.end(task)

    def ask(self, task):
        return self.add(question_about(self.state, task, FAULTS, self.now_s))

    def decide(self, task):
        decided = decide_recovery(self.state, task, FAULTS, self.policy, self.possible, self.now_s)
        self.add(decided)
        return decided


def operation(code, at_s=0.0):
    return Operation("/Connect a/InsertCable", "InsertCable", "failed", code, "no", at_s, 1.0)


def answering(*responses):
    return Policy({"insertion_jammed": responses})


@pytest.fixture
def run():
    run = Run("W1", "W2")
    assert run.next == Plan("the run begins")
    assert run.plan() == Execute("W1", Part.WHOLE)
    return run


def test_tasks_are_done_one_after_another(run):
    run.begin("W1")
    assert run.end("W1") == Execute("W2", Part.WHOLE)
    run.begin("W2")
    assert run.end("W2") == EndRun(Ending.COMPLETE, "all tasks are done")
    assert run.add(RunEnded(Ending.COMPLETE, "")) is None
    assert all(task.first_pass for task in run.state.tasks.values())


def test_what_was_interrupted_is_cleared_inspected_and_only_what_is_left_done(run):
    assert run.interrupt("W1") == Execute("W1", Part.CLEAR)
    assert run.fail("W1", NOTHING_HELD, Part.CLEAR) == Settle("W1"), "nothing was in the hand"
    assert run.add(Settled("W1", ("a",), 3)) == Execute("W1", Part.REST)
    run.begin("W1", Part.REST)
    assert run.end("W1") == Execute("W2", Part.WHOLE)
    assert not run.state.tasks["W1"].first_pass


@pytest.mark.parametrize(
    ("code", "texts", "does"),
    [
        (OUT_OF_DUCT, ("65.8% of its route", "65.8% of its route"), [Do.NEW_PART, Do.SET_ASIDE]),
        (OUT_OF_DUCT, ("65.8% of its route", "71.2% of its route"), [Do.NEW_PART, Do.NEW_PART]),
        (JAM, ("14.0 N at 3.1 mm", "14.0 N at 3.1 mm"), [Do.NEW_PART, Do.NEW_PART]),
    ],
    ids=["same figure", "another figure", "chance"],
)
def test_what_led_to_the_same_figure_again_is_not_repeated(run, code, texts, does):
    responses = (Response(Do.NEW_PART, 2), Response(Do.SET_ASIDE))
    run.policy = Policy({FAULTS.of(code).name: responses})
    run.possible = POSSIBLE - {Do.ASK_OPERATOR}
    done = []
    for text in texts:
        run.begin("W1")
        run.add(OperationEnded("W1", replace(operation(code), text=text)))
        run.end("W1", "failed")
        done.append(run.decide("W1"))
        if done[-1].do is Do.NEW_PART:
            run.add(Settled("W1", (), 5))
            run.discard("W1")
    assert [each.do for each in done] == does
    if does[-1] is Do.SET_ASIDE:
        reason = "a new part once did not help, and a new part led to the same figure again"
        assert done[-1].because == reason


def test_an_empty_hand_at_the_end_is_not_the_cause_of_a_failure(run):
    run.begin("W1")
    run.add(OperationEnded("W1", operation(JAM)))
    empty = replace(operation(NOTHING_HELD), state_path="/Lay down", ability="PlaceCable")
    run.add(OperationEnded("W1", empty))
    run.end("W1", "failed")
    decided = run.decide("W1")
    assert (decided.fault, decided.code, decided.ability) == (
        "insertion_jammed",
        JAM,
        "InsertCable",
    )


def test_each_hand_that_a_task_gives_up_with_may_be_left_full(run):
    for slipped, empty, full in ((0, 0, False), (JAM, 0, True), (0, JAM, True)):
        run.begin("W1")
        run.add(OperationEnded("W1", operation(JAM)))
        for code in (slipped, empty):
            run.add(OperationEnded("W1", replace(operation(code), ability="PlaceCable")))
        run.end("W1", "failed")
        assert run.state.tasks["W1"].hand_may_hold is full


def test_a_fixing_that_fails_is_tried_again_with_more_force_of_its_insertion(run):
    run.possible = POSSIBLE | {Do.RETRY_WITH}
    run.begin("W1")
    pushed = replace(operation(0), outcome="inserted", parameters=(("force_limit", "8.0"),))
    fixing = replace(operation(NOT_SEATED), state_path="/Connect a/FixCable", ability="FixCable")
    other = replace(pushed, state_path="/Connect b/Other", parameters=(("force_limit", "3.0"),))
    for each in (pushed, other, fixing):
        run.add(OperationEnded("W1", each))
    run.end("W1", "failed")
    decided = run.decide("W1")
    assert (decided.do, decided.change) == (Do.RETRY_WITH, (("force_limit", 12.0),))


@pytest.mark.parametrize(
    ("settled", "comes", "stage"),
    [
        (Settled("W1", (), 5), Execute("W1", Part.AGAIN), Stage.READY),
        (Settled("W1", ("a", "b"), 0), Execute("W2", Part.WHOLE), Stage.DONE),
    ],
)
def test_an_interrupted_task_is_done_again_unless_it_turns_out_to_be_done(
    run, settled, comes, stage
):
    run.interrupt("W1")
    run.clear("W1")
    assert run.add(settled) == comes
    assert run.state.tasks["W1"].stage is stage


def test_a_feeder_that_refuses_is_a_failure_of_the_task_and_the_hand_is_emptied(run):
    run.policy = Policy({"two_cables_grasped": (Response(Do.NEW_PART), Response(Do.SET_ASIDE))})
    run.add(PartRequested("W1"))
    assert run.add(FeedRefused("W1", 203, "the hand holds W4", 0.0)) == Decide("W1")
    decided = run.decide("W1")
    assert (decided.do, decided.ability) == (Do.NEW_PART, "FeedWire")
    assert run.next == Execute("W1", Part.CLEAR)
    assert run.clear("W1") == Execute("W1", Part.WHOLE), "nothing was presented, or is discarded"


@pytest.mark.parametrize("codes", [(200, 0), (200, Code.NOTHING_HELD)])
def test_the_hands_are_empty_when_each_of_them_is(run, codes):
    run.interrupt("W1")
    run.begin("W1", Part.CLEAR)
    for code in codes:
        run.add(OperationEnded("W1", replace(operation(code), ability="PlaceCable")))
    run.end("W1", "failed" if codes[-1] else "finished")
    assert run.next == Execute("W1", Part.CLEAR), "the first hand may hold something"
    run.begin("W1", Part.CLEAR)
    for code in (Code.NOTHING_HELD, Code.NOTHING_HELD):
        run.add(OperationEnded("W1", replace(operation(code), ability="PlaceCable")))
    run.end("W1", "failed")
    assert run.next == Settle("W1")


def test_a_hand_that_cannot_be_emptied_needs_a_person(run):
    run.interrupt("W1")
    for _ in range(STUCK_HAND_LIMIT + 1):
        assert run.next == Execute("W1", Part.CLEAR)
        run.begin("W1", Part.CLEAR)
        run.add(OperationEnded("W1", replace(operation(200), ability="PlaceCable")))
        run.end("W1", "failed")
    assert run.next == Decide("W1")
    decided = run.decide("W1")
    assert (decided.do, decided.because) == (
        Do.ASK_OPERATOR,
        "the hand could not be emptied in 3 attempts",
    )
    run.ask("W1")
    assert run.add(Answered(1, Answer.SKIP, "ann")) == Execute("W1", Part.CLEAR), "it is empty now?"


def test_without_a_person_a_hand_that_cannot_be_emptied_stops_the_run(run):
    run.possible = POSSIBLE - {Do.ASK_OPERATOR}
    run.interrupt("W1")
    for _ in range(STUCK_HAND_LIMIT + 1):
        run.fail("W1", LOST, Part.CLEAR)
    run.decide("W1")
    assert isinstance(run.next, EndRun)
    assert "could not be emptied" in run.next.because


def test_a_piece_that_cannot_be_discarded_is_not_replaced(run):
    run.policy = answering(Response(Do.NEW_PART), Response(Do.SET_ASIDE))
    run.fail_and_decide("W1", JAM)
    assert run.next == Execute("W1", Part.DISCARD)
    run.begin("W1", Part.DISCARD)
    stuck = replace(operation(306), ability="DiscardCable", state_path="/Discard")
    run.add(OperationEnded("W1", stuck))
    assert run.end("W1", "failed") == Decide("W1")
    assert run.decide("W1").do in (Do.ASK_OPERATOR, Do.SET_ASIDE)


def test_a_task_that_ended_well_against_the_evidence_is_inspected(run):
    run.begin("W1")
    assert run.add(TaskEnded("W1", "finished", 1.0, False, denied=True)) == Settle("W1")
    assert run.add(Settled("W1", ("a",), 2)) == Execute("W1", Part.REST)


def test_nothing_moves_after_a_protective_stop_until_the_run_is_resumed(run):
    run.begin("W1")
    run.add(Commanded(Command.PROTECTIVE_STOP, "", "/safety"), Interrupted("protective stop"))
    assert isinstance(run.next, Wait)
    assert "protective stop by /safety" in run.next.why
    assert run.add(Commanded(Command.RESUME, "", "ann")) == Execute("W1", Part.CLEAR)


def test_an_unanswered_question_escalates(run):
    run.policy = answering(Response(Do.ASK_OPERATOR))
    run.fail_and_decide("W1", JAM)
    run.ask("W1")
    run.add(Escalated(1, "W1", Do.SET_ASIDE))
    assert run.state.question is None
    assert run.next == Settle("W1"), "the piece is discarded only if no end is connected"
    assert run.add(Settled("W1", (), 5)) == Execute("W1", Part.DISCARD)
    assert run.discard("W1") == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE


def test_clearing_that_is_interrupted_is_done_again(run):
    run.interrupt("W1")
    run.begin("W1", Part.CLEAR)
    assert run.add(Interrupted("killed")) == Execute("W1", Part.CLEAR)
    assert run.state.tasks["W1"].interruptions == 2


def test_a_task_that_kills_its_processes_fails_at_last(run):
    for _ in range(INTERRUPTION_LIMIT):
        assert run.interrupt("W1") == Execute("W1", Part.CLEAR)
    assert run.interrupt("W1") == Decide("W1")


def test_an_interruption_between_tasks_changes_nothing(run):
    run.begin("W1")
    run.end("W1")
    assert run.add(Interrupted("killed")) == Execute("W2", Part.WHOLE)


@pytest.mark.parametrize("do", [Do.RETRY, Do.LOOK_AGAIN, Do.OTHER_METHOD])
def test_before_a_task_is_tried_again_it_is_looked(run, do):
    run.policy, run.possible = answering(Response(do)), frozenset(Do)
    assert run.fail("W1", JAM) == Decide("W1")
    assert run.decide("W1").do is do
    assert run.next == Settle("W1")
    assert run.add(Settled("W1", (), 5)) == Execute("W1", Part.AGAIN)


def test_a_new_piece_is_placed_when_the_old_one_is_discarded(run):
    run.policy = answering(Response(Do.NEW_PART), Response(Do.SET_ASIDE))
    run.fail_and_decide("W1", JAM)
    assert run.discard("W1") == Execute("W1", Part.WHOLE)
    run.fail_and_decide("W1", JAM)
    assert run.next == Settle("W1")
    run.add(Settled("W1", ("a",), 2))
    assert run.discard("W1") == Execute("W2", Part.WHOLE), "it would be in the way of W2"
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE
    assert run.end("W2") == EndRun(Ending.INCOMPLETE, "skipped: W1")


def test_a_run_whose_behaviors_are_all_interrupted_stops(run):
    run.policy = Policy(unattended=Do.SET_ASIDE)
    run.possible = POSSIBLE - {Do.ASK_OPERATOR}
    run.begin("W1")
    for _ in range(100):
        run.add(Interrupted("the cell does not answer"))
        if run.state.tasks["W1"].stage is Stage.FAILED and not run.state.stop:
            run.decide("W1")
        if not isinstance(run.next, Execute):
            break
        run.begin("W1", run.next.part)
    assert isinstance(run.next, EndRun)
    assert "W1 was interrupted" in run.next.because


def test_a_server_that_was_lost_may_have_left_something_in_the_hand(run):
    run.policy = Policy({"server_lost": (Response(Do.NEW_PART), Response(Do.SET_ASIDE))})
    run.fail_and_decide("W1", LOST)
    assert run.next == Execute("W1", Part.CLEAR)
    assert run.clear("W1") == Settle("W1"), "it may be done all the same"
    run.add(Settled("W1", (), 5))
    assert run.discard("W1") == Execute("W1", Part.WHOLE)
    run.fail_and_decide("W1", LOST)
    assert run.clear("W1") == Settle("W1")
    run.add(Settled("W1", (), 5))
    assert run.discard("W1") == Execute("W2", Part.WHOLE)


def test_a_wire_beside_its_duct_is_not_done_when_both_ends_are_connected(run):
    run.policy = Policy({"out_of_duct": (Response(Do.SET_ASIDE),)})
    run.fail_and_decide("W1", Code.OUT_OF_DUCT)
    assert run.next == Settle("W1")
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W1", Part.DISCARD)
    assert run.discard("W1") == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE


def test_a_wire_beside_its_duct_is_not_done_when_the_arms_could_not_discard_it_at_first(run):
    run.policy = Policy({"out_of_duct": (Response(Do.NEW_PART, 3),)})
    run.fail_and_decide("W1", Code.OUT_OF_DUCT)
    run.fail("W1", Code.ROBOT_IN_THE_WAY, Part.DISCARD)
    assert run.decide("W1").do is Do.LOOK_AGAIN
    assert run.add(Settled("W1", ("a", "b"), 0)) == Decide("W1")
    assert run.decide("W1").do is Do.NEW_PART
    assert run.discard("W1") == Execute("W1", Part.WHOLE)
    run.fail_and_decide("W1", Code.NOT_SEATED)
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W2", Part.WHOLE), "of the new piece"


def test_the_operator_is_asked_about_a_wire_beside_its_duct_with_both_ends_connected(run):
    assert run.fail_and_decide("W1", Code.OUT_OF_DUCT).do is Do.LOOK_AGAIN
    assert run.add(Settled("W1", ("a", "b"), 0)) == Decide("W1")
    assert run.decide("W1").do is Do.ASK_OPERATOR, "looking once more would change nothing"
    run.ask("W1")
    assert run.add(Answered(1, Answer.FIXED, "ann")) == Settle("W1")
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W2", Part.WHOLE), "laid by hand"


def test_a_skipped_wire_beside_its_duct_gets_a_new_piece_when_it_is_retried(run):
    run.fail("W1", Code.OUT_OF_DUCT)
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    run.decide("W1")
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W2", Part.WHOLE), "left to ann"
    run.add(Commanded(Command.SKIP, "W2", "ann"))
    run.add(Commanded(Command.RETRY, "W1", "ann"))
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W1", Part.DISCARD)
    assert run.discard("W1") == Execute("W1", Part.WHOLE)


@pytest.mark.parametrize("do", [Do.NEW_PART, Do.REPLAN, Do.SET_ASIDE])
def test_what_is_done_though_its_server_said_otherwise_is_not_given_up(run, do):
    run.policy = Policy({"result_contradictory": (Response(do), Response(Do.SET_ASIDE))})
    run.begin("W1")
    run.add(OperationEnded("W1", operation(CONTRADICTORY)))
    run.add(OperationEnded("W1", replace(operation(NOTHING_HELD), ability="PlaceCable")))
    run.end("W1", "failed")
    run.decide("W1")
    assert run.next == Settle("W1")
    assert run.add(Settled("W1", ("a", "b"), 0)) == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.DONE


def test_what_cannot_be_seen_is_given_up_as_it_was_decided(run):
    run.policy = Policy({"result_contradictory": (Response(Do.SET_ASIDE),)})
    run.begin("W1")
    run.add(OperationEnded("W1", operation(CONTRADICTORY)))
    run.add(OperationEnded("W1", replace(operation(NOTHING_HELD), ability="PlaceCable")))
    run.end("W1", "failed")
    run.decide("W1")
    unseen = Settled("W1", (), 1, 101, "a hand is before it")
    assert run.add(unseen) == Execute("W1", Part.DISCARD), "it would be in the way of W2"
    assert run.discard("W1") == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE


def test_what_is_put_off_is_done_when_the_rest_is(run):
    run.policy = answering(Response(Do.REPLAN), Response(Do.SET_ASIDE))
    run.fail_and_decide("W1", JAM)
    assert isinstance(run.discard("W1"), Plan)
    assert run.add(Planned(("W2", "W1"), "a failure")) == Execute("W2", Part.WHOLE)
    run.begin("W2")
    assert run.end("W2") == Execute("W1", Part.WHOLE)


def test_an_operator_is_asked_and_answers(run):
    run.policy = answering(Response(Do.ASK_OPERATOR))
    run.fail_and_decide("W1", JAM)
    assert run.next == Ask("W1")
    asked = question_about(run.state, "W1", FAULTS, run.now_s)
    assert asked.text.startswith("Insertion jammed: no. ")
    assert Answer.REPLAN in asked.choices
    assert asked.choices[0] is Answer.FIXED, "the usual answer is the one that has the cell check"
    assert run.add(asked) == Wait("question 1 is to be answered")
    assert run.add(Answered(1, Answer.FIXED, "ann")) == Settle("W1")
    run.add(Settled("W1", ("a",), 2))
    run.fail("W1", JAM, Part.REST)
    run.decide("W1")
    run.ask("W1")
    assert run.add(Answered(2, Answer.MARK_DONE, "ann")) == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.DONE


@pytest.mark.parametrize(
    ("answer", "comes"),
    [
        (Answer.RETRY, Settle("W1")),
        (Answer.SKIP, Settle("W1")),
        (Answer.REPLAN, Execute("W1", Part.DISCARD)),
        (Answer.STOP, EndRun(Ending.STOPPED, "W1: ann answered stop to question 1")),
    ],
)
def test_each_answer_is_applied(run, answer, comes):
    run.policy = answering(Response(Do.ASK_OPERATOR))
    run.fail_and_decide("W1", JAM)
    run.ask("W1")
    assert run.add(Answered(1, answer, "ann")) == comes


def test_an_operator_pauses_skips_tries_again_and_stops(run):
    assert isinstance(run.add(Commanded(Command.PAUSE, "", "ann")), Wait)
    assert run.add(Commanded(Command.RESUME, "", "ann")) == Execute("W1", Part.WHOLE)
    assert run.add(Commanded(Command.SKIP, "W1", "ann")) == Execute("W2", Part.WHOLE)
    run.begin("W2")
    run.add(Commanded(Command.RETRY, "W1", "ann"))
    assert run.end("W2") == Settle("W1")
    run.add(Settled("W1", (), 5))
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    assert run.end("W1", "preempted") == Decide("W1")
    decided = run.decide("W1")
    assert (decided.do, decided.by, decided.because) == (Do.SET_ASIDE, "ann", "ann skipped it")
    assert run.next == Execute("W1", Part.CLEAR), "its hand may hold the wire"
    assert run.clear("W1") == Settle("W1")
    run.add(Settled("W1", (), 5))
    assert run.discard("W1") == EndRun(Ending.INCOMPLETE, "skipped: W1")
    assert run.add(Commanded(Command.STOP, "", "ann")) == EndRun(Ending.STOPPED, "ann stopped it")


def skip_half_placed(run):
    """Have W1 skipped when one of its ends is connected."""
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    run.end("W1", "preempted")
    run.decide("W1")
    run.clear("W1")
    run.add(Settled("W1", ("a",), 3))
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE


def test_a_half_placed_wire_gets_a_new_piece_when_it_is_retried_after_another_one(run):
    skip_half_placed(run)
    run.begin("W2")
    run.add(Commanded(Command.RETRY, "W1", "ann"))
    assert run.end("W2") == Settle("W1")
    assert run.add(Settled("W1", ("a",), 3)) == Execute("W1", Part.DISCARD)
    assert run.discard("W1") == Execute("W1", Part.WHOLE)


def test_a_half_placed_wire_that_was_fed_last_is_finished_when_it_is_retried(run):
    skip_half_placed(run)
    run.add(Commanded(Command.SKIP, "W2", "ann"))
    run.add(Commanded(Command.RETRY, "W1", "ann"))
    assert run.next == Settle("W1")
    assert run.add(Settled("W1", ("a",), 3)) == Execute("W1", Part.REST)


def test_a_retried_wire_that_turns_out_to_be_placed_is_left_in_place(run):
    skip_half_placed(run)
    run.begin("W2")
    run.add(Commanded(Command.RETRY, "W1", "ann"))
    run.end("W2")
    assert run.add(Settled("W1", ("a", "b"), 0)) == EndRun(Ending.COMPLETE, "all tasks are done")


def test_a_skipped_task_is_not_attempted_again_after_a_restart(run):
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    assert run.add(Interrupted("the supervisor was killed")) == Execute("W1", Part.CLEAR)
    assert run.clear("W1") == Settle("W1")
    run.add(Settled("W1", (), 5))
    assert run.discard("W1") == Execute("W2", Part.WHOLE)
    assert run.state.tasks["W1"].stage is Stage.SET_ASIDE


def test_a_skipped_task_that_ended_against_the_evidence_is_not_attempted_again(run):
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    assert run.add(TaskEnded("W1", "finished", 1.0, False, denied=True)) == Settle("W1")
    run.add(Settled("W1", (), 5))
    assert run.discard("W1") == Execute("W2", Part.WHOLE)


def test_a_behavior_that_another_client_stops_stops_the_run(run):
    run.begin("W1")
    assert run.end("W1", "preempted") == EndRun(
        Ending.STOPPED, "the behavior of task W1 was stopped by another client of the engine"
    )


def test_what_cannot_be_seen_is_not_assumed(run):
    run.possible = POSSIBLE - {Do.ASK_OPERATOR}
    run.interrupt("W1")
    run.clear("W1")
    while isinstance(run.next, Settle | Decide) or run.next == Execute("W1", Part.DISCARD):
        if isinstance(run.next, Execute):
            run.discard("W1")
            assert run.next == Execute("W1", Part.WHOLE)
            run.fail("W1", LOST)
        elif isinstance(run.next, Settle):
            run.add(Settled("W1", (), 1, 114, "the arm is in front of it"))
        else:
            run.decide("W1")
    assert run.state.tasks["W1"].decisions[-1].text == "the arm is in front of it"
    assert all(d.do is not Do.SET_ASIDE for d in run.state.tasks["W1"].decisions[:-1])


def test_other_cells_tasks_are_left_to_them_and_taken_over(run):
    assert run.add(TaskElsewhere("W1", "other", AsLeft.RUNNING)) == Execute("W2", Part.WHOLE)
    run.begin("W2")
    assert run.end("W2") == Wait("other cells have W1")
    assert run.add(TaskReturned("W1", "other")) == Settle("W1")
    assert run.add(TaskElsewhere("W1", "third", AsLeft.DONE)) == EndRun(
        Ending.COMPLETE, "all tasks are done"
    )


def test_a_motion_fault_while_inspecting_needs_a_person_whatever_was_decided(run):
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    run.end("W1", "preempted")
    run.decide("W1")
    assert run.clear("W1") == Settle("W1")
    run.add(Settled("W1", (), 5, MOTION_FAULT, "the arm did not arrive"))
    assert run.next == Decide("W1")
    assert run.decide("W1").do is Do.ASK_OPERATOR


def test_a_skip_does_not_pass_over_a_motion_fault(run):
    run.begin("W1")
    run.add(Commanded(Command.SKIP, "W1", "ann"))
    run.end("W1", "failed", MOTION_FAULT)
    assert run.decide("W1").do is Do.ASK_OPERATOR


@pytest.mark.parametrize("code", sorted(PERSON_FIRST))
@pytest.mark.parametrize("ended", [Interrupted("killed"), TaskEnded("W1", "failed", 2.0, False)])
@pytest.mark.parametrize("part", list(Part))
def test_nothing_moves_before_a_person_has_answered_whatever_a_use_case_says(
    run, part, ended, code
):
    responses = (Response(Do.LOOK_AGAIN), Response(Do.SET_ASIDE))
    run.policy = Policy({FAULTS.of(code).name: responses})
    run.begin("W1")
    if part is not Part.WHOLE:
        run.add(Interrupted("killed"))
        run.begin("W1", part)
    run.add(OperationEnded("W1", operation(code)))
    assert run.add(ended) == Decide("W1")
    assert run.decide("W1").do is Do.ASK_OPERATOR
    run.ask("W1")
    assert run.next == Wait("question 1 is to be answered")
    assert run.add(Answered(1, Answer.FIXED, "ann")) == Execute("W1", Part.CLEAR)


def stop_reported():
    return StopReported("W1", operation(MOTION_FAULT))


@pytest.mark.parametrize("ended", [Interrupted("stopped"), TaskEnded("W1", "finished", 2.0, True)])
@pytest.mark.parametrize("part", list(Part))
def test_a_stop_that_is_reported_late_ends_the_behavior_and_a_person_is_asked(run, part, ended):
    run.interrupt("W1")
    run.begin("W1", part)
    run.add(stop_reported())
    assert "a person is to answer" in run.state.tasks["W1"].halt
    assert run.add(ended) == Decide("W1")
    assert run.decide("W1").do is Do.ASK_OPERATOR
    run.ask("W1")
    assert run.add(Answered(1, Answer.FIXED, "ann")) == Execute("W1", Part.CLEAR)
    assert not run.state.tasks["W1"].halt


def test_a_stop_that_is_reported_late_is_asked_about_whatever_was_to_come_next(run):
    run.interrupt("W1")
    for _ in range(2):
        run.clear("W1") if run.next == Execute("W1", Part.CLEAR) else None
        assert run.next in (Settle("W1"), Wait("question 1 is to be answered"))
        assert run.add(stop_reported()) == Decide("W1")
        assert run.decide("W1").do is Do.ASK_OPERATOR
        run.ask("W1")
    assert run.add(Answered(2, Answer.FIXED, "ann")) == Execute("W1", Part.CLEAR)


def test_without_an_operator_a_stop_that_is_reported_late_ends_the_run(run):
    run.possible = POSSIBLE - {Do.ASK_OPERATOR}
    run.begin("W1")
    run.add(Interrupted("killed"), stop_reported())
    assert run.decide("W1").do is Do.STOP
    assert isinstance(run.next, EndRun)


@pytest.mark.parametrize("late", [False, True])
def test_a_run_whose_task_another_cell_has_taken_ends_if_a_person_is_needed_at_the_arm(run, late):
    run.begin("W1")
    run.add(stop_reported() if late else OperationEnded("W1", operation(MOTION_FAULT)))
    run.add(TaskElsewhere("W1", "other", AsLeft.RUNNING))
    assert isinstance(run.next, EndRun)
    assert "a person is needed" in run.next.because


def test_a_person_is_asked_first_where_the_table_asks_one_at_once_and_stops_without_one():
    asked = {
        code
        for name in FAULTS.names
        for code in FAULTS[name].codes
        if FAULTS[name].responses[0].do is Do.ASK_OPERATOR and FAULTS[name].stops_unattended
    }
    assert asked == PERSON_FIRST


def test_what_cannot_go_on_ends(run):
    assert run.add(Blocked("no panel")) == EndRun(Ending.STOPPED, "no panel")


def live(run, random, steps=400):
    """Let anything happen to a run: failures, interruptions, commands and answers at any time."""
    codes = [0, 0, JAM, LOST, 200, 105, 8]
    for _ in range(steps):
        step = run.next
        if step is None:
            break
        if random.random() < 0.1:
            run.add(Interrupted("killed"))
            continue
        if random.random() < 0.03:
            kind = random.choice([Command.PAUSE, Command.RESUME, Command.PROTECTIVE_STOP])
            run.add(Commanded(kind, "", "ann"))
            continue
        if random.random() < 0.03 and run.state.current:
            run.add(Commanded(Command.SKIP, run.state.current, "ann"))
            continue
        match step:
            case Plan():
                waiting = run.state.waiting
                run.add(Planned(tuple(random.sample(waiting, len(waiting))), "x"))
            case Execute():
                run.begin(step.task, step.part)
                if random.random() < 0.15:
                    if random.random() < 0.5:
                        run.now_s += 1.0
                        run.add(OperationEnded(step.task, operation(0, run.now_s)))
                    run.add(Interrupted("killed"))
                    continue
                code = random.choice(codes)
                outcome = random.choice(["failed", "preempted"]) if code else "finished"
                skipped = step.task in run.state.skipped
                run.end(step.task, outcome if skipped or code == 0 else "failed", code)
            case Settle():
                connected = random.choice([(), ("a",), ("a", "b")])
                unseen = random.random() < 0.1
                left = 5 - 2 * len(connected) if len(connected) < 2 else 0
                run.add(Settled(step.task, connected, left, 114 * unseen, "dark" * unseen))
            case Decide():
                run.decide(step.task)
            case Ask():
                run.ask(step.task)
            case Wait() if run.state.question:
                asked = run.state.question
                run.add(Answered(asked.number, random.choice(asked.choices), "ann"))
            case Wait():
                run.add(Commanded(Command.RESUME, "", "ann"))
            case EndRun():
                run.add(RunEnded(step.ending, step.because))


@given(st.integers(0, 10_000))
def test_every_run_ends_and_every_event_survives_the_database(seed):
    """Random worlds: failures of all kinds, interruptions, commands and answers at any time."""
    random = Random(seed)
    limits = Limits(task_attempts=4, run_failures=20)
    run = Run("W1", "W2", "W3", policy=Policy(limits=limits), possible=frozenset(Do))
    live(run, random)
    assert run.next is None, "it ends"
    kept = [(kind_of(e), json.loads(json.dumps(data_of(e)))) for e in run.events]
    assert [event_from(kind, data) for kind, data in kept] == run.events
    done = [e.task for e in run.events if isinstance(e, TaskEnded) and e.outcome == "finished"]
    assert state_after(run.events) == run.state
    assert len(done) < 400
