"""The supervisor does what comes next, keeps it, waits for what is lost, and goes on."""

import re
from dataclasses import replace

import pytest
from house import owner_of
from sqlalchemy import text
from supervisor_bench import GOES_ON

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import LostError, OwnerError
from remodel_run.progress import Answer
from remodel_states.core.codes import Code
from remodel_supervision.core.learning.experience import TriedResponse
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import attempts_of
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    Blocked,
    Command,
    Commanded,
    Decided,
    Ending,
    Escalated,
    FeedRefused,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
)
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.core.runs.replay import replayed
from remodel_supervision.core.runs.state import Stage, cause_of
from remodel_supervision.edge.task_leases import Holding, TaskLeases
from remodel_supervision.errors import LeavingError, RefusedError
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind, UnseenError
from remodel_tasks.core.use_case.fault import Do, Policy, QuestionLimit, Response

JAM, LOST = Code.INSERTION_JAMMED, Code.SERVER_LOST
SLIPPED, MISSING = Code.SLIPPED_IN_GRIP, Code.COMPONENT_MISSING
STALE_OWNER, SEVERAL_SERVERS = Code.STALE_OWNER, Code.SEVERAL_SERVERS
STUCK, MOTION_FAULT = Code.EXTRACTION_STUCK, Code.MOTION_FAULT


@pytest.mark.parametrize("truth", [True, None])
def test_an_order_is_done_task_by_task_whether_a_cell_has_ground_truth_or_not(bench, truth):
    bench.cell.truth = truth
    state = bench.run()
    assert state.ended.ending is Ending.COMPLETE
    first, second = bench.events(Planned)[0].tasks
    assert bench.ran == [first, second]
    assert bench.cell.fed == [first, second]
    assert bench.cell.loaded == [("house-0001", False)]
    assert [name.removeprefix("Place Wire ") for name in bench.maker.asked] == bench.ran
    attempts = attempts_of(bench.events(object))
    assert [attempt.path for attempt in attempts] == [bench.engine.path()] * 2
    assert [attempt.execution.placed for attempt in attempts] == [True, True]


def test_an_order_that_the_cell_refuses_ends_before_anything_moves(bench):
    problems = "\n".join(f"  - problem {number}" for number in range(57))
    bench.cell.refusal = RefusedError(Code.INVALID_GOAL, f"cannot load panel house:\n{problems}")
    state = bench.run()
    assert state.ended.ending is Ending.STOPPED
    assert problems in state.ended.because
    assert "Nothing has moved. Correct the design or use case cabinet" in state.ended.because
    assert (bench.ran, bench.cell.fed, bench.events(TaskBegun)) == ([], [], [])
    first = bench.events(Planned)[0].tasks[0]
    assert bench.leases.claim(first).holding is Holding.MINE, "it counts as one never begun"


def test_a_cell_learns_what_the_order_demands_before_anything_moves(bench):
    bench.run()
    assert bench.cell.demands == bench.work.planner.demands
    assert bench.cell.demands.robots == ("robot_1", "robot_2")
    assert bench.cell.demands.forces_n == (("InsertCable", 14.0),)


def test_each_event_is_kept_before_what_follows_begins(bench):
    def look():
        begun = bench.events(TaskBegun)
        assert [event.task for event in begun] == bench.ran, "kept before the goal is sent"
        assert "<statemachine" in begun[-1].chart

    assert bench.run(look, look).ended.ending is Ending.COMPLETE


def test_a_second_jam_ends_the_task_and_no_new_wire_is_fed(bench):
    state = bench.run(JAM, JAM)
    first = bench.events(Planned)[0].tasks[0]
    decided = [(event.task, event.do) for event in bench.events(Decided)]
    assert decided == [(first, Do.LOOK_AGAIN), (first, Do.SET_ASIDE)]
    assert bench.cell.fed.count(first) == 1
    assert state.ended.ending is Ending.INCOMPLETE


def test_a_wire_that_fails_from_one_end_is_begun_at_the_other(make_bench):
    other = (Response(Do.OTHER_END), Response(Do.SET_ASIDE))
    bench = make_bench(policy=Policy(responses={"slipped": other}))
    state = bench.run(SLIPPED)
    first = bench.events(Planned)[0].tasks[0]
    assert [event.do for event in bench.events(Decided)] == [Do.OTHER_END]
    assert bench.cell.fed.count(first) == 2, "the piece that slipped is discarded"
    begun = [e.chart for e in bench.events(TaskBegun) if e.task == first and e.part.is_attempt]
    ends = [list(dict.fromkeys(re.findall(r'id="Insert (.)"', chart))) for chart in begun]
    assert ends[0] == ends[1][::-1] and len(ends[0]) == 2
    assert state.ended.ending is Ending.COMPLETE


def test_an_end_that_is_stuck_stops_no_unattended_order(bench):
    """Its hand is empty: the wire is left, and the tasks that do not depend on it go on."""
    state = bench.run(STUCK)
    first, second = bench.events(Planned)[0].tasks
    assert [(event.task, event.do) for event in bench.events(Decided)] == [(first, Do.SET_ASIDE)]
    assert bench.cell.fed == [first, second], "no new piece for the terminal that is not free"
    assert bench.ran[-1] == second
    assert f"{first} Discard" not in bench.ran, "it is not pulled at again"
    assert state.tasks[second].stage is Stage.DONE
    assert state.ended.ending is Ending.INCOMPLETE


def test_a_task_whose_order_is_planned_again_comes_later(bench):
    state = bench.run(MISSING)
    before, after = (event.tasks for event in bench.events(Planned))
    first, second = before
    assert after == (second, first)
    assert bench.ran == [first, f"{first} Discard", second, first]
    assert state.ended.ending is Ending.COMPLETE


def test_a_server_that_had_trouble_answers_before_anything_else_moves(bench):
    bench.abilities.away = 2
    state = bench.run(LOST)
    assert bench.abilities.away < 0, "it was waited for"
    assert [event.do for event in bench.events(Decided)] == [Do.LOOK_AGAIN]
    first = bench.events(Planned)[0].tasks[0]
    assert bench.ran[:3] == [first, f"{first} Clear", first]
    assert state.ended.ending is Ending.COMPLETE


def test_a_hand_is_emptied_again_when_the_server_that_went_away_answers(bench):
    def lose():
        bench.abilities.away = 3
        bench.engine.operate(bench.engine.ran[-1], LOST, "/Release")
        bench.engine.end = BehaviorEnd(EndKind.FINISHED, "failed")

    def answers_again():
        assert bench.abilities.away < 0, "nothing is sent to a server that is not running"

    bench.engine.clearings = [lose, answers_again]
    state = bench.run(LOST)
    first = bench.events(Planned)[0].tasks[0]
    assert bench.ran[:3] == [first, f"{first} Clear", f"{first} Clear"]
    assert state.ended.ending is Ending.COMPLETE


def test_a_server_that_stays_away_is_left_to_the_policy(bench):
    bench.abilities.away = 1000
    assert bench.run(LOST).ended.ending is Ending.COMPLETE


@pytest.mark.parametrize("code", [LOST, STALE_OWNER, SEVERAL_SERVERS, MOTION_FAULT])
def test_nothing_of_a_behavior_begins_after_it_has_lost_a_server_or_run_into_something(bench, code):
    permits = []

    def lose():
        behavior = bench.engine.ran[-1]
        bench.engine.operate(behavior, code)
        permits.append(bench.engine.operate(behavior, 0, "/Release"))

    bench.run(lose)
    assert permits == [Permit.REFUSED]


def test_what_is_connected_is_not_connected_again(bench):
    first = bench.work.planner.plan(["W1", "W2"])[0]
    bench.inspection.connected = {(first, "a")}
    bench.run(JAM)
    assert bench.ran[:2] == [first, f"{first} Rest"]
    chart = next(e.chart for e in bench.events(TaskBegun) if e.part is Part.REST)
    assert 'id="Insert b"' in chart
    assert 'id="Insert a"' not in chart
    assert 'id="Hold"' in chart


def test_a_learning_supervisor_reports_what_it_chose_and_learns_from_it(make_bench):
    bench = make_bench(explore=True)
    state = bench.run(*[SLIPPED] * 2)
    assert state.ended.ending is Ending.COMPLETE
    chosen = [(event, each) for event in bench.events(TaskBegun) for each in event.chosen]
    assert chosen, "one of five attempts at two ends tries another force"
    for event, each in chosen:
        assert (each.ability, each.parameter) == ("InsertCable", "force_limit")
        assert 8.0 <= each.value <= 20.0
        assert f'name="force_limit" value="{each.value}"' in event.chart
    slips = [k for k in bench.events(OperationEnded) if k.operation.error_code == SLIPPED]
    assert bench.work.planner.experience.expectations.calls == len(slips) == 2


def test_a_response_that_never_helped_is_not_given_again(make_bench):
    bench = make_bench(explore=True)
    bench.log.tried_responses = lambda: (
        (TriedResponse("slipped", Do.LOOK_AGAIN, helped=False),) * 30
    )
    bench.run(SLIPPED)
    decided = bench.events(Decided)
    assert decided[0].do is Do.NEW_PART
    assert "looking from another view hardly ever helps" in decided[0].because


def test_a_run_goes_on_when_what_was_lost_answers_again(bench):
    state = bench.run(LostError("the engine is gone"))
    first = bench.events(Planned)[0].tasks[0]
    assert bench.ran[:3] == [first, f"{first} Clear", first]
    assert [event.because for event in bench.events(Interrupted)] == ["the engine is gone"]
    assert state.ended.ending is Ending.COMPLETE
    assert bench.cell.loaded == [("house-0001", False), ("house-0001", True)]


def test_a_cell_that_was_restarted_gets_its_panel_again(bench):
    def restart():
        bench.cell.at = "rosrpc://cell:2"

    assert bench.run(restart).ended.ending is Ending.COMPLETE
    assert bench.cell.loaded == [("house-0001", False), ("house-0001", True)]


def test_a_server_that_died_is_the_cause_and_not_what_its_heir_does_not_know():
    lost = Operation("/Insert a", "InsertCable", "failed", LOST, "away", 2.0, 1.0)
    unfed = Operation("/Release", "PlaceCable", "failed", 403, "not fed", 3.0, 1.0)
    assert cause_of([lost, unfed]) is lost
    assert cause_of([unfed]) is unfed
    laid_down = replace(unfed, outcome="placed", error_code=0)
    for given_up in ([unfed, unfed], [unfed, laid_down], [laid_down, unfed]):
        assert cause_of([lost, *given_up]) is lost
    assert cause_of([lost, unfed, lost]) is lost


def test_a_run_stops_when_what_was_lost_does_not_answer_again(bench):
    def lose():
        bench.engine.back = False
        bench.engine.trouble = "the engine is gone"
        bench.engine.end = BehaviorEnd(EndKind.LOST, "gone")

    state = bench.run(lose)
    assert state.ended.ending is Ending.STOPPED
    assert state.ended.because == "the engine does not answer"


def test_a_new_supervisor_resumes_where_the_old_one_died(bench):
    with pytest.raises(KilledError):
        bench.run("finished", KilledError())
    first, second = bench.events(Planned)[0].tasks
    bench.inspection.connected = {(second, "a"), (second, "b")}
    bench.take_up()
    state = bench.run()
    assert state.ended.ending is Ending.COMPLETE
    assert bench.ran == [first, second, f"{second} Clear"], "it was done, as the inspection shows"
    assert [event.left for event in bench.events(Settled)] == [0]
    assert state.interruptions == 1


@pytest.mark.parametrize(
    ("mover", "name", "moves", "rests"),
    [("abilities", "stalled", ("PickCable",), ()), ("cell", "feeds", True, False)],
)
def test_a_skip_during_a_resume_is_answered_when_nothing_moves(bench, mover, name, moves, rests):
    with pytest.raises(KilledError):
        bench.run("finished", KilledError())
    second = bench.events(Planned)[0].tasks[1]
    bench.take_up()
    setattr(getattr(bench, mover), name, moves)
    replies = []

    def skip():
        if not bench.events(Interrupted):
            bench.loop.arrivals.append(skip)
            return
        replies.append(bench.command(Command.SKIP, second))
        bench.loop.arrivals.append(lambda: heard.append(list(replies[0])))
        bench.loop.arrivals.append(lambda: setattr(getattr(bench, mover), name, rests))

    heard = []
    bench.loop.arrivals.append(skip)
    bench.run()
    assert heard == [[]], "what the last supervisor began still moved"
    assert replies == [[(True, "")]]


def test_a_cell_that_is_gone_while_it_is_taken_over_is_asked_again(bench):
    bench.cell.take_overs = [LostError("the cell does not answer")] * 3
    assert bench.run().ended.ending is Ending.COMPLETE
    assert not bench.events(Blocked)


def test_a_cell_that_never_rests_blocks_the_run(bench):
    bench.cell.feeds = True
    assert bench.run().ended.ending is Ending.STOPPED
    assert [event.because for event in bench.events(Blocked)] == [
        "the cell still moves; stop the cell by hand"
    ]
    assert (bench.cell.fed, bench.engine.ran) == ([], [])


def test_a_shutdown_leaves_no_event_and_the_next_start_resumes(bench):
    before = []

    def begin():
        before.append(len(bench.events(object)))
        bench.loop.arrivals.append(lambda: setattr(bench.loop, "is_leaving", True))
        bench.engine.is_idle = False
        return GOES_ON

    def cancel(own_only=False):
        bench.engine.is_idle, bench.engine.end = True, BehaviorEnd(EndKind.PREEMPTED, "stopped")

    bench.engine.cancel = cancel
    with pytest.raises(LeavingError):
        bench.run(begin)
    assert bench.engine.is_idle, "it was stopped"
    assert len(bench.events(object)) == before[0]
    bench.loop.is_leaving = False
    bench.take_up()
    assert bench.run().ended.ending is Ending.COMPLETE


def test_a_supervisor_that_is_to_end_stops_nothing_but_its_own(bench):
    stopped = []

    def skip_and_end():
        (begun,) = bench.events(TaskBegun)
        bench.command(Command.SKIP, begun.task)
        bench.loop.is_leaving = True

    def begin():
        bench.loop.arrivals.append(skip_and_end)
        return GOES_ON

    def cancel(own_only=False):
        stopped.append(own_only)
        bench.engine.end = BehaviorEnd(EndKind.PREEMPTED, "stopped")

    bench.engine.cancel = cancel
    with pytest.raises(LeavingError):
        bench.run(begin)
    assert stopped, "it stopped its behavior"
    assert all(stopped), "another supervisor may have begun the next one"


def test_what_cannot_be_seen_is_set_aside_when_no_operator_is_present(bench):
    bench.inspection.trouble = UnseenError(101, "the arm is in front of it")
    state = bench.run(JAM)
    first = bench.events(Planned)[0].tasks[0]
    assert {event.unseen for event in bench.events(Settled)} == {"the arm is in front of it"}
    assert state.tasks[first].stage in (Stage.DONE, Stage.SET_ASIDE)
    assert state.ended is not None


def test_a_refused_feed_is_a_failure_of_its_task_alone(bench):
    bench.cell.trouble = RefusedError(203, "cannot feed: the gripper holds a wire")
    state = bench.run()
    first, second = bench.events(Planned)[0].tasks
    (refused,) = bench.events(FeedRefused)
    assert (refused.task, refused.code) == (first, 203)
    assert bench.ran[0] == f"{first} Clear", "the hand is emptied first"
    assert state.ended is not None
    assert state.tasks[second].stage is Stage.DONE


def test_a_task_whose_evidence_denies_it_is_not_done(bench):
    bench.cell.truth = False
    bench.inspection.connected = {("W1", "a"), ("W1", "b"), ("W2", "a"), ("W2", "b")}
    assert bench.run().ended.ending is Ending.COMPLETE
    assert {event.task for event in bench.events(Settled)} == {"W1", "W2"}


def test_a_pause_holds_the_next_operation_and_is_answered_when_the_one_under_way_ends(bench):
    seen = []

    def pause_while_moving():
        behavior = bench.engine.ran[-1]
        tasks = bench.supervisor.tasks
        assert tasks.begin_operation(behavior, "/Find ends", "DetectCable")[0] is Permit.GRANTED
        replies = bench.command(Command.PAUSE)
        seen.append(list(replies))
        found = Operation("/Find ends", "DetectCable", "detected", 0, "", 2.0, 1.0, "goal 1")
        tasks.keep_record(behavior, found)
        bench.loop.run_until(lambda: False, 0.3)
        seen.append(list(replies))
        seen.append(tasks.begin_operation(behavior, "/Insert a", "InsertCable")[0])
        bench.command(Command.RESUME)
        seen.append(tasks.begin_operation(behavior, "/Insert a", "InsertCable")[0])

    bench.run(pause_while_moving)
    assert seen == [[], [(True, "")], Permit.HELD, Permit.GRANTED]


def test_a_record_of_a_behavior_that_was_stopped_is_dropped(bench):
    answers = []

    def send(owner):
        behavior = bench.engine.ran[-1] if bench.engine.ran else "W1"
        goal = f"{owner}:{behavior}/Find ends#1"
        found = Operation("/Find ends", "DetectCable", "detected", 0, "", 2.0, 1.0, goal)
        answers.append(bench.supervisor.tasks.keep_record(behavior, found))

    stopped = (True, "the record is of a behavior that was stopped, and is not kept")
    send(bench.owner)  # before this supervisor has stopped what runs
    bench.run(lambda: send(bench.owner + 1), lambda: send(bench.owner))
    assert answers == [stopped, stopped, (True, "")]
    second = bench.events(Planned)[0].tasks[1]
    assert [event.task for event in bench.events(OperationEnded)] == [second]


class KilledError(Exception):
    """The supervisor's process is killed."""


def stopped_at(owner, code):
    """Return an operation that an owner of the cell has granted, with its error code."""
    path = "/Insert a"
    goal = f"{owner}:Place Wire W1{path}#1"
    return Operation(path, "InsertCable", "failed", code, "stopped", 2.0, 1.0, goal)


def killed_before_it_kept_a_record(bench):
    """Kill the supervisor during a behavior, have another one take over; return its token."""
    with pytest.raises(KilledError):
        bench.run(KilledError())
    return bench.take_over()


@pytest.mark.parametrize("code", [MOTION_FAULT, SEVERAL_SERVERS])
@pytest.mark.parametrize("while_it_moves", [False, True])
def test_a_stop_whose_record_a_killed_supervisor_did_not_keep_is_asked_about(
    attended_bench, code, while_it_moves
):
    bench = attended_bench
    stop = stopped_at(killed_before_it_kept_a_record(bench), code)
    first = bench.events(Planned)[0].tasks[0]
    moved, sent = [], []

    def send():
        sent.append(bench.supervisor.tasks.keep_record(f"Place Wire {first}", stop))

    def empty():
        """Empty the hand: the state asks after the record was sent."""
        send()
        moved.append(bench.engine.operate(bench.engine.ran[-1], 0, "/Release"))

    if while_it_moves:
        bench.engine.clearings = [empty]
    else:
        bench.loop.arrivals += [lambda: None] * 3 + [send, send]
    bench.answer_questions(Answer.FIXED)
    state = bench.run()
    assert [event.operation for event in bench.events(StopReported)] == [stop]
    assert [event.do for event in bench.events(Decided)] == [Do.ASK_OPERATOR]
    assert ["stopped" in event.text for event in bench.events(Asked)] == [True]
    cleared = [name for name in bench.ran if name.endswith("Clear")]
    assert len(cleared) == (2 if while_it_moves else 1), "the hand is emptied after the answer"
    assert moved == ([Permit.REFUSED] if while_it_moves else [])
    assert sent[0] == (True, "")
    assert state.ended.ending is Ending.COMPLETE
    assert not [frame.differs for frame in replayed(bench.events(object)) if frame.differs]


def test_the_refused_goal_of_an_earlier_owner_is_no_stop(bench):
    refused = stopped_at(killed_before_it_kept_a_record(bench), STALE_OWNER)
    bench.loop.arrivals.append(lambda: bench.supervisor.tasks.keep_record("W1", refused))
    assert bench.run().ended.ending is Ending.COMPLETE
    assert not bench.events(StopReported)


def test_a_stop_between_two_tasks_ends_the_run(bench):
    stop = stopped_at(bench.owner + 1, MOTION_FAULT)
    plan = bench.work.planner.plan

    def plan_while_it_is_reported(*args):
        bench.supervisor.tasks.keep_record("Place Wire W1", stop)
        return plan(*args)

    object.__setattr__(bench.work.planner, "plan", plan_while_it_is_reported)
    state = bench.run()
    assert state.ended.ending is Ending.STOPPED
    assert "a person is needed" in state.ended.because
    assert bench.ran == []


def test_a_late_stop_that_is_not_kept_is_sent_again_and_ends_an_unattended_run(bench):
    stop = stopped_at(killed_before_it_kept_a_record(bench), MOTION_FAULT)
    append, answers = bench.log.append, []

    def fail(*_):
        raise LostError("the database does not answer")

    def send():
        bench.log.append = fail
        answers.append(bench.supervisor.tasks.keep_record("W1", stop))
        bench.log.append = append
        answers.append(bench.supervisor.tasks.keep_record("W1", stop))

    bench.loop.arrivals.append(send)
    assert bench.run().ended.ending is Ending.STOPPED
    assert answers == [(False, "the database does not answer"), (True, "")]
    assert len(bench.events(StopReported)) == 1
    assert len(bench.ran) == 1, "nothing moves after it"


def granted_and_stopped(bench, behavior, record):
    """Have an operation begin whose server ends it with a fault; return it as it was published.

    Args:
        record: code of the record that its state sends; None: the record is lost.
    """
    tasks, path = bench.supervisor.tasks, "/Insert a"
    assert tasks.begin_operation(behavior, path, "InsertCable")[0] is Permit.GRANTED
    stop = replace(stopped_at(bench.owner, MOTION_FAULT), state_path="", outcome="")
    bench.abilities.stops = (stop,)
    if record is not None:
        kept = replace(stop, state_path=path, outcome="failed", error_code=record)
        assert tasks.keep_record(behavior, kept) == (True, "")
    return stop


@pytest.mark.parametrize("record", [None, Code.PREEMPTED])
@pytest.mark.parametrize("is_lost", [False, True])
def test_a_published_stop_whose_record_does_not_say_so_is_asked_about(
    attended_bench, record, is_lost
):
    bench, stops = attended_bench, []

    def stop():
        stops.append(granted_and_stopped(bench, bench.engine.ran[-1], record))
        assert bench.engine.operate(bench.engine.ran[-1], 0, "/Release") is Permit.REFUSED
        if is_lost:
            bench.engine.trouble = "the engine has gone"
        else:
            bench.engine.end = BehaviorEnd(EndKind.FINISHED, "failed")

    bench.answer_questions(Answer.FIXED)
    state = bench.run(stop)
    answered = [type(event) for event in bench.events(Answered, TaskBegun)]
    assert answered[:3] == [TaskBegun, Answered, TaskBegun], "nothing begins before the answer"
    assert [event.operation for event in bench.events(StopReported)] == stops
    assert state.ended.ending is Ending.COMPLETE
    assert not [frame.differs for frame in replayed(bench.events(object)) if frame.differs]


def test_a_published_stop_whose_record_is_kept_is_asked_about_once(bench):
    def stop():
        granted_and_stopped(bench, bench.engine.ran[-1], MOTION_FAULT)
        bench.engine.end = BehaviorEnd(EndKind.FINISHED, "failed")

    assert bench.run(stop).ended.ending is Ending.STOPPED
    assert not bench.events(StopReported)
    assert [event.operation.error_code for event in bench.events(OperationEnded)] == [MOTION_FAULT]


def test_a_record_that_arrives_after_its_published_stop_is_not_kept_again(attended_bench):
    bench, late, answers = attended_bench, [], []

    def stop():
        stopped = granted_and_stopped(bench, bench.engine.ran[-1], None)
        bench.engine.end = BehaviorEnd(EndKind.FINISHED, "failed")
        late.append(replace(stopped, state_path="/Insert a"))

    def answer():
        if question := bench.supervisor.state.question:
            answers.append(bench.supervisor.tasks.keep_record(bench.engine.ran[-1], late[0]))
            event = Answered(question.number, Answer.STOP, "ann")
            bench.supervisor.answer(event, lambda *reply: None)

    bench.loop.every(10.0, answer)
    bench.run(stop)
    assert answers == [(True, "the operation was reported before; its record is not kept again")]
    assert len(bench.events(StopReported)) == 1
    assert not bench.events(OperationEnded)


def test_a_running_task_that_is_skipped_leaves_an_empty_hand_and_is_retried(bench):
    replies = []

    def skip():
        replies.append(bench.command(Command.SKIP, bench.supervisor.state.current))
        bench.engine.cancel()

    def retry():
        (skipped,) = bench.supervisor.state.in_stage(Stage.SET_ASIDE)
        assert bench.command(Command.RETRY, skipped) == [(True, "")]

    state = bench.run(skip, retry)
    first, second = bench.events(Planned)[0].tasks
    assert replies == [[(True, "")]]
    assert bench.events(Decided)[0].by == "ann"
    assert bench.ran == [first, f"{first} Clear", f"{first} Discard", second, first]
    assert state.ended.ending is Ending.COMPLETE


def test_a_stop_ends_the_run(bench):
    replies = []

    def stop():
        replies.append(bench.command(Command.STOP))
        bench.engine.cancel()

    state = bench.run(stop)
    assert (state.ended.ending, state.ended.because) == (Ending.STOPPED, "ann stopped it")
    assert replies == [[(True, "")]]
    assert bench.command(Command.STOP) == [(False, "the run has ended")]


def test_a_waiting_task_that_was_skipped_is_retried(bench):
    skipped = []

    def skip():
        skipped.append(bench.events(Planned)[0].tasks[1])
        bench.command(Command.SKIP, skipped[0])
        bench.command(Command.RETRY, skipped[0])

    state = bench.run(skip)
    assert state.ended.ending is Ending.COMPLETE
    assert bench.ran[-1] == skipped[0]


def test_a_protective_stop_cuts_the_behavior_short_and_the_run_waits(bench):
    def stop():
        bench.command(Command.PROTECTIVE_STOP)
        bench.engine.cancel()
        bench.loop.arrivals += [lambda: None] * 20 + [lambda: bench.command(Command.RESUME)]

    state = bench.run(stop)
    first = bench.events(Planned)[0].tasks[0]
    assert [event.because for event in bench.events(Interrupted)] == ["protective stop by ann"]
    assert bench.ran[:3] == [first, f"{first} Clear", first]
    assert state.ended.ending is Ending.COMPLETE


@pytest.mark.parametrize(
    ("command", "ending"),
    [(Command.PROTECTIVE_STOP, Ending.COMPLETE), (Command.STOP, Ending.STOPPED)],
)
def test_a_behavior_that_fails_because_it_is_halted_counts_as_stopped(bench, command, ending):
    def fail():
        """End by itself since a goal is refused, before the supervisor stops the behavior."""
        bench.command(command)
        assert bench.engine.operate(bench.engine.ran[-1], JAM) is Permit.REFUSED
        bench.engine.end = BehaviorEnd(EndKind.FINISHED, "failed")
        bench.loop.arrivals += [lambda: None] * 20 + [lambda: bench.command(Command.RESUME)]

    state = bench.run(fail)
    assert bench.events(Decided) == []
    assert state.ended.ending is ending
    stopped = [event.outcome for event in bench.events(TaskEnded)][:1]
    assert stopped == (["preempted"] if command is Command.STOP else ["finished"])


def test_a_protective_stop_that_is_released_at_once_does_not_end_the_run(bench):
    permits = []

    def stop():
        bench.engine.cancel = resume
        bench.command(Command.PROTECTIVE_STOP)
        return GOES_ON

    def resume(own_only=False):
        """The run is resumed before the engine has stopped the behavior."""
        del bench.engine.cancel
        bench.command(Command.RESUME)
        permits.append(bench.engine.operate(bench.engine.ran[-1], JAM))
        bench.engine.cancel()

    state = bench.run(stop)
    assert permits == [Permit.REFUSED]
    assert [event.because for event in bench.events(Interrupted)] == ["protective stop by ann"]
    assert state.ended.ending is Ending.COMPLETE


def during(bench, port, name, command):
    """Give a command once, while a port is being called after the first behavior."""
    original = getattr(port, name)

    def called(*arguments, **named):
        if not bench.engine.ran:
            return original(*arguments, **named)
        setattr(port, name, original)
        bench.command(command)
        bench.loop.arrivals += [lambda: None] * 20 + [lambda: bench.command(Command.RESUME)]
        return original(*arguments, **named)

    setattr(port, name, called)


@pytest.mark.parametrize(
    ("port", "name", "command"),
    [
        ("maker", "make", Command.PAUSE),
        ("maker", "make", Command.PROTECTIVE_STOP),
        ("inspection", "is_connected", Command.PAUSE),
        ("inspection", "is_connected", Command.PROTECTIVE_STOP),
        ("abilities", "answers", Command.STOP),
    ],
)
def test_what_a_command_has_overtaken_is_not_recorded(bench, port, name, command):
    during(bench, getattr(bench, port), name, command)
    state = bench.run(*([] if port == "maker" else [LOST]))
    assert command in [event.command for event in bench.events(Commanded)]
    events = [kept.event for kept in bench.log.events(bench.number)]
    assert [frame.differs for frame in replayed(events) if frame.differs] == []
    expected = Ending.STOPPED if command is Command.STOP else Ending.COMPLETE
    assert state.ended.ending is expected


def test_commands_that_make_no_sense_are_refused(bench):
    refused = []

    def command():
        refused.extend(bench.command(Command.SKIP, "W9"))
        refused.extend(bench.command(Command.RETRY, "W1"))
        bench.supervisor.answer(
            Answered(1, Answer.RETRY, "ann"),
            lambda granted, text: refused.append((granted, text)),
        )

    assert bench.run(command).ended.ending is Ending.COMPLETE
    assert [granted for granted, _ in refused] == [False] * 3
    texts = [text for _, text in refused]
    assert texts[0] == "there is no task 'W9'; there are W1, W2"
    assert "only a skipped task can be retried" in texts[1]
    assert texts[2] == "question 1 is not open; open is none"
    assert bench.events(Commanded) == []


def test_a_question_is_asked_escalates_and_notifies(make_bench):
    policy = Policy(
        {"insertion_jammed": (Response(Do.ASK_OPERATOR),)},
        question=QuestionLimit(10.0, Do.SET_ASIDE),
    )
    bench = make_bench(attended=True, policy=policy)
    state = bench.run(JAM)
    first = bench.events(Planned)[0].tasks[0]
    assert [event.do for event in bench.events(Escalated)] == [Do.SET_ASIDE]
    assert [each["event"] for each in bench.notified] == ["question_asked", "question_timed_out"]
    assert state.tasks[first].stage is Stage.SET_ASIDE


def test_an_operator_answers(make_bench):
    policy = Policy({"insertion_jammed": (Response(Do.ASK_OPERATOR),)})
    bench = make_bench(attended=True, policy=policy)
    replies = []

    def answer():
        for number, choice in ((9, Answer.REPLAN), (1, Answer.MARK_DONE)):
            bench.supervisor.answer(
                Answered(number, choice, "ann"), lambda *reply: replies.append(reply)
            )

    bench.loop.every(30.0, lambda: answer() if bench.supervisor.state.question else None)
    state = bench.run(JAM)
    first = bench.events(Planned)[0].tasks[0]
    assert replies[:2] == [(False, "question 9 is not open; open is question 1"), (True, "")]
    assert state.tasks[first].stage is Stage.DONE


def test_another_cells_task_is_left_to_it_and_taken_over_when_it_dies(bench, house_url):
    database = ProductionDatabase(house_url)
    other = TaskLeases(database, "house", "other", 60.0, owner_of(database, "other"))
    bench.leases.lease_s = 3.0
    other.claim("W1")
    bench.inspection.connected = {("W1", "a")}

    def die():
        other.lease_s = 0.0
        other.renew("W1")

    state = bench.run(die)
    assert state.ended.ending is Ending.COMPLETE
    assert [event.cell for event in bench.events(TaskElsewhere)] == ["other"]
    assert bench.ran == ["W2", "W1 Rest"]
    database.close()


def test_a_task_that_another_cell_has_taken_over_is_stopped(bench, house_url):
    database = ProductionDatabase(house_url)
    other = TaskLeases(database, "house", "other", 600.0, owner_of(database, "other"))
    taken = []

    def lose():
        name = bench.supervisor.state.current
        with database.transaction() as connection:
            task = other._locked(connection, name)
            connection.execute(text(f"UPDATE tasks SET cell = 'other' WHERE id = {task.id}"))
        taken.append(name)
        bench.loop.arrivals += [lambda: None] * 400 + [lambda: bench.command(Command.STOP)]
        return GOES_ON

    bench.run(lose)
    assert [event.task for event in bench.events(TaskElsewhere)][:1] == taken
    database.close()


def test_a_lease_that_cannot_be_renewed_stops_what_runs(bench, monkeypatch):
    def lose(task):
        raise LostError("the database does not answer")

    def cut():
        monkeypatch.setattr(bench.leases, "renew", lose)
        bench.loop.every(60.0, monkeypatch.undo)
        return GOES_ON

    state = bench.run(cut)
    (interrupted,) = bench.events(Interrupted)[:1]
    assert "the lease of task" in interrupted.because
    assert state.ended.ending is Ending.COMPLETE


def test_the_time_of_a_run_is_limited_also_after_a_restart(make_bench):
    bench = make_bench(timeout_s=5.0)

    def take_long():
        bench.loop.wall += 8.0

    state = bench.run(take_long)
    assert state.ended.because == "the run's time limit of 5 s has passed"


def test_nothing_is_kept_for_a_supervisor_that_was_replaced(bench, house_url):
    database = ProductionDatabase(house_url)

    with pytest.raises(OwnerError):
        bench.run(lambda: owner_of(database))
    assert bench.engine.is_idle
    database.close()
