"""A run of an order: its words, and the production figures."""

import json
from dataclasses import replace

import numpy as np
import pytest

from remodel_console.core.commands import trouble_words
from remodel_console.core.plots import bar_plot, count_height, count_plot, line_plot, series_plot
from remodel_console.core.run_view import Phase as RunPhase
from remodel_console.core.run_view import RunView
from remodel_console.core.use_case import (
    SHOWN_TASKS,
    CableTask,
    Failure,
    Level,
    Question,
    Task,
    UseCase,
    duration_words,
    figures,
    hand_words,
    level_rows,
    shown_tasks,
    stop_words,
    with_cables,
)
from remodel_console.core.world import CellKind, Part, World, cards, notices, supervisor_words
from remodel_console.edge.kept_files import as_jpeg
from remodel_console.errors import PictureError
from remodel_console.live import Live
from remodel_console.watched import Pictures
from remodel_run.progress import Answer, Count, HandWire, Phase, Sums, TaskPhase, sums_words
from remodel_run.record import decision_words, fault_words


def task(name, phase, *, passed=False, taken_s=0.0, expected_s=0.0):
    counts = {TaskPhase.DONE: Count.DONE, TaskPhase.SET_ASIDE: Count.SKIPPED}
    counts_as = counts.get(phase, Count.OPEN)
    return Task(name, "", phase, 1, passed, taken_s, expected_s, counts_as=counts_as)


def test_the_cores_of_a_cable_follow_it_and_are_one_task():
    cores = [
        replace(task(name, phase), cable=cable)
        for name, phase, cable in (
            ("W1", TaskPhase.DONE, ""),
            ("C1.1", TaskPhase.DONE, "C1"),
            ("C1.2", TaskPhase.RUNNING, "C1"),
            ("C2.1", TaskPhase.WAITING, "C2"),
            ("W2", TaskPhase.WAITING, ""),
        )
    ]
    shown = list(with_cables(cores))
    cable = shown[1]
    assert shown == [cores[0], CableTask((cores[1], cores[2])), *cores[1:]]
    assert (cable.name, cable.phase, cable.words, cable.description) == (
        "C1",
        TaskPhase.RUNNING,
        "running",
        "cable, 1 of 2 cores done",
    )
    for phases, phase in (
        ((TaskPhase.DONE, TaskPhase.DONE), TaskPhase.DONE),
        ((TaskPhase.DONE, TaskPhase.SET_ASIDE), TaskPhase.SET_ASIDE),
        ((TaskPhase.DONE, TaskPhase.WAITING), TaskPhase.RUNNING),
        ((TaskPhase.WAITING, TaskPhase.WAITING), TaskPhase.WAITING),
    ):
        assert CableTask(tuple(task(each.value, each) for each in phases)).phase is phase


def failure(name, fault, decision):
    return Failure(0.0, name, fault, 0, "", "", decision, because="")


RUN = UseCase(
    Phase.RUNNING,
    sums=Sums(
        tasks=6, done=3, skipped=1, open=2, tried=4, first_passes=2, recovered=1, done_s=160.0
    ),
    tasks=(
        task("W1", TaskPhase.DONE, passed=True, taken_s=40),
        task("W2", TaskPhase.DONE, taken_s=80),
        task("W3", TaskPhase.SET_ASIDE, taken_s=120),
        task("W4", TaskPhase.DONE, passed=True, taken_s=40),
        task("W5", TaskPhase.RUNNING, taken_s=10, expected_s=30),
        task("W6", TaskPhase.WAITING, expected_s=40),
    ),
    failures=(
        failure("W2", "grasp_missed", "retry"),
        failure("W2", "cable_slipped", "retry_with"),
        failure("W2", "grasp_missed", "look_again"),
        failure("W3", "component_not_found", "retry"),
        failure("W3", "component_not_found", "set_aside"),
        failure("W5", "grasp_missed", "retry"),
    ),
)


def test_figures_count_tasks_that_have_ended():
    found = figures(RUN)
    assert found.tasks == ("W1", "W2", "W3", "W4")
    assert found.yields == (1.0, 0.5, pytest.approx(1 / 3), 0.5)
    assert found.sums.first_pass_yield == found.yields[-1]
    assert found.sums.mean_cycle_s == pytest.approx(sum(found.cycles_s) / len(found.cycles_s))
    assert (found.done, found.cycles_s) == (("W1", "W2", "W4"), (40, 80, 40))


def test_a_recovery_is_a_failure_of_a_task_that_is_done():
    assert figures(RUN).recoveries == (("Grasp missed", 2), ("Cable slipped", 1))


def test_a_task_that_was_done_before_is_no_task_of_this_run():
    before = replace(task("W0", TaskPhase.DONE), counts_as=Count.DONE_BEFORE, attempts=0)
    skipped = replace(task("W7", TaskPhase.SET_ASIDE), attempts=0)  # before it was begun
    continued = replace(RUN, tasks=(before, *RUN.tasks, skipped))
    assert figures(continued) == figures(RUN)
    assert (before.words, RUN.tasks[0].words) == ("done before", "done")


def test_the_words_of_sums_leave_out_what_there_is_none_of():
    assert sums_words(RUN.sums) == "3 of 6 tasks done, 1 skipped"
    five = Sums(tasks=9, done_before=2, done=3, skipped=1, interrupted=1, open=2, by_hand=3)
    assert sums_words(five) == (
        "5 of 9 tasks done, 2 of them before this run, 1 skipped, 1 interrupted, 3 wires by hand"
    )


def test_the_time_worked_goes_on_over_a_restart():
    level = Level("task", "W5", "attempt 1", since_s=100.0)
    run = replace(RUN, sums=Sums(taken_s=180.0), started_s=95.0, stamp_s=110.0, levels=(level,))
    assert run.worked_s == 190.0
    assert replace(run, levels=()).worked_s == 180.0
    assert replace(run, stamp_s=99.0).worked_s == 180.0  # the clock was set back


def test_wires_by_hand_are_counted_until_all_are_ticked_off():
    wires = [
        HandWire(name, "17", "Q1/1", "X3/2", "BU", section_mm2=35.0, length_m=0.482, reason="thick")
        for name in ("W3", "W8")
    ]
    assert wires[0].words == "Q1/1 to X3/2, BU, 35 mm², 482 mm"
    assert hand_words(wires, {"W3"}) == "By hand: 1 of 2 to be placed"
    assert hand_words(wires, {"W3", "W8"}) == "By hand: all 2 are placed"


def test_before_anything_has_ended_there_are_no_figures():
    found = figures(UseCase(Phase.IDLE))
    assert found.sums.first_pass_yield is None
    assert found.sums.mean_cycle_s is None


def test_progress():
    assert RUN.left_s == 70
    assert RUN.is_under_way
    assert not UseCase(Phase.ENDED).is_under_way
    assert not UseCase(Phase.STARTING).is_under_way


def test_a_run_that_is_held_is_resumed_by_a_person():
    held = {phase for phase in Phase if UseCase(phase).is_held}
    assert held == {Phase.PAUSING, Phase.PAUSED, Phase.PROTECTIVE_STOP}
    assert UseCase(Phase.PROTECTIVE_STOP).is_under_way


def test_a_protective_stop_says_by_whom_it_was_requested_and_where_it_is_released():
    stopped = UseCase(Phase.PROTECTIVE_STOP, run=12, stopped_by="Ada")
    title, how = stop_words(stopped)
    assert (title, stopped.is_releasable) == ("Protective stop, requested by Ada", True)
    assert how == "No motion begins. Release ends the stop, and the run stays paused until Resume."
    held = replace(stopped, stopped_by="/plc, Ada", controllers=("/plc",))
    title, how = stop_words(held)
    assert (title, held.is_releasable) == ("Protective stop, requested by /plc, Ada", False)
    assert how.endswith("It is held by the safety controller /plc, and released there, not here.")
    assert "orders can be started" in stop_words(replace(stopped, run=0))[1]


def test_the_time_left_to_answer_a_question():
    question = Question(1, "W4", "It jams.", (Answer.RETRY,), asked_s=100.0, timeout_s=600.0)
    assert question.left_s(now_s=130.0) == 570.0
    assert question.left_s(now_s=900.0) == 0.0
    assert Question(1, "W4", "It jams.", (Answer.RETRY,)).left_s(now_s=130.0) is None


def test_all_tasks_of_a_small_order_are_shown():
    tasks = tuple(task(f"W{number}", TaskPhase.WAITING) for number in range(SHOWN_TASKS))
    assert shown_tasks(tasks) == tasks


def test_of_a_large_order_what_needs_a_person_and_what_comes_next_is_shown():
    def tasks(ended):
        phases = [TaskPhase.SET_ASIDE if n % 500 == 7 else TaskPhase.DONE for n in range(ended)]
        phases += [TaskPhase.RUNNING, *[TaskPhase.WAITING] * (4999 - ended)]
        return tuple(task(f"W{number}", phase) for number, phase in enumerate(phases))

    shown = shown_tasks(tasks(3000))
    assert len(shown) <= SHOWN_TASKS
    names = [each.name for each in shown]
    assert names[:6] == ["W7", "W507", "W1007", "W1507", "W2007", "W2507"]
    assert {"W2999", "W3000", "W3050"} <= set(names)
    assert [each.name for each in shown_tasks(tasks(3001))] == names
    for ended in (0, 1, 30, 4999):
        assert any(each.phase is TaskPhase.RUNNING for each in shown_tasks(tasks(ended)))


def test_the_four_levels_are_always_there():
    level = Level("task", "W5", "runs", 1.0)
    rows = dict(level_rows(UseCase(Phase.RUNNING, levels=(level,))))
    assert rows == {"Order": None, "Task": level, "Behavior": None, "Ability": None}


@pytest.mark.parametrize(
    ("time_s", "words"), [(-3, "0 s"), (99, "99 s"), (130, "2 min"), (7300, "2 h 02 min")]
)
def test_durations_in_words(time_s, words):
    assert duration_words(time_s) == words


def test_all_choices_and_phases_have_words():
    assert all(choice.words and choice.meaning for choice in Answer)
    assert all(phase.words for phase in Phase)
    assert decision_words("retry") == "tries again"
    assert decision_words("dance_about") == "dance about"
    assert fault_words("grasp_missed") == "Grasp missed"
    assert fault_words("") == "Unknown fault"


def test_a_plot_has_a_point_for_each_value():
    yields = line_plot(("W1", "W2"), (1.0, 0.5))
    assert yields["xAxis"]["data"] == ["W1", "W2"]
    assert yields["series"][0]["data"] == [100.0, 50.0]
    assert yields["yAxis"]["max"] == 100
    times = bar_plot(("W1", "W2"), (10.0, 5.04), "s")
    assert times["series"][0]["data"] == [10.0, 5.0]
    causes = count_plot((("Grasp missed", 2), ("Slipped", 1)))
    assert causes["yAxis"]["data"] == ["Grasp missed", "Slipped"]
    assert causes["series"][0]["data"] == [2, 1]
    assert count_height(2) == 2 * count_height(1) == 2 * count_height(0)


def test_a_series_ends_at_the_end_of_the_run():
    plot = series_plot(((0.0, 1.0), (2.5, -3.0)), 8.0)
    assert plot["series"][0]["data"] == [[0.0, 1.0], [2.5, -3.0]]
    assert (plot["xAxis"]["min"], plot["xAxis"]["max"]) == (0, 8.0)
    assert series_plot((), 0.0)["xAxis"]["max"] > 0


@pytest.mark.parametrize(
    "plot",
    [line_plot((), ()), bar_plot((), (), "s"), count_plot(()), series_plot((), 0.0)],
)
def test_a_plot_is_sent_to_the_page_as_json(plot):
    assert json.loads(json.dumps(plot)) == plot


@pytest.mark.parametrize("kind", [None, *CellKind])
@pytest.mark.parametrize("phase", list(Phase))
def test_no_sample_order_begins_in_a_real_cell_or_beside_another_order(kind, phase):
    now = UseCase(phase)
    world = World(has_master=True, cell_kind=kind, use_case=now)
    assert world.takes_sample == (not now.is_under_way and kind is not CellKind.REAL)


ENGINE, SUPERVISOR, CELL = Part.ENGINE, Part.SUPERVISOR, Part.CELL
RUNS = {ENGINE: {"run": RunView(phase=RunPhase.IDLE)}, SUPERVISOR: {"has_supervisor": True}}


@pytest.mark.parametrize("kind", list(CellKind))
@pytest.mark.parametrize("silent", [(), (CELL,), (SUPERVISOR,), (ENGINE,), (ENGINE, CELL)])
@pytest.mark.parametrize("gone", [None, *RUNS, CELL])
def test_notices_tell_what_runs_whatever_the_cell_is(kind, silent, gone):
    running = {ENGINE, SUPERVISOR, CELL} - {gone}
    fields = {key: value for part in running - {CELL} for key, value in RUNS[part].items()}
    if CELL in running:
        fields |= {"servers": 0 if CELL in silent else 12, "cell_kind": kind}
    world = World(has_master=True, has_mirror=True, silent=frozenset(silent), **fields)
    shown = {n.what: n.meaning for n in notices(world, (ENGINE, SUPERVISOR, CELL))}
    for part in (ENGINE, SUPERVISOR, CELL):
        assert (f"The {part.value} does not answer" in shown) == (part in silent)
        is_gone = part is gone and part not in silent
        assert (f"The {part.value} is not running" in shown) == is_gone
        assert world.has(part) == (part in running and part not in silent)
    assert not any("nothing moves" in meaning for meaning in shown.values())
    assert world.can_be_put_back == (world.cell_kind is not CellKind.REAL)


def presence(live, **changes):
    live.set_presence(**{"mirror": False, "servers": 0, "cell_kind": None, **changes})


def test_what_a_supervisor_published_stays_and_is_out_of_date_when_it_is_gone():
    times = iter([10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0])
    live = Live(clock=lambda: next(times))
    live.set_master(True)
    asking = replace(RUN, run=12, question=Question(1, "W4", "It jams.", (Answer.RETRY,)))

    def words():
        return supervisor_words(live.world, lambda since_s: f"12:03:{since_s:.0f}")

    assert words() == "The supervisor is not running."
    presence(live, supervisor=True)  # 10
    live.take_use_case(asking)  # 11
    assert (words(), len(cards(live.world))) == ("", 1)
    presence(live, supervisor=False)  # 12
    presence(live, supervisor=False)  # 13: it is gone since 12
    last = "This is the last known state, out of date since 12:03:12."
    assert live.world.use_case == asking
    assert (live.world.current_use_case, cards(live.world)) == (None, ())
    assert words() == f"The supervisor is not running. {last}"
    presence(live, supervisor=True)  # 14
    live.take_use_case(UseCase(Phase.STARTING))  # 15
    assert (live.world.use_case, words()) == (asking, f"The supervisor is starting. {last}")
    live.take_use_case(UseCase(Phase.STARTING, message="bench 2 owns the cell"))  # 16
    assert words() == f"The supervisor cannot take an order: bench 2 owns the cell. {last}"
    live.take_use_case(RUN)  # 17
    assert (live.world.current_use_case, words()) == (RUN, "")


def test_the_state_of_a_supervisor_that_hangs_is_out_of_date():
    live = Live(clock=lambda: 12.0)
    live.set_master(True)
    live.take_use_case(RUN)
    presence(live, supervisor=True, silent=frozenset({Part.SUPERVISOR}))
    assert live.world.current_use_case is None
    assert supervisor_words(live.world, str).startswith("The supervisor does not answer. This is")


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        ("", "the supervisor has not answered within 8 s"),
        ("unable to connect to service: [Errno 111] Connection refused", "is not running, or"),
        ("timeout exceeded while waiting for service /a", "is not running, or does not answer"),
        ("transport error completing service call: unable to receive data", "before it answered"),
        ("service cannot process request: no run", "could not be called: service cannot process"),
    ],
)
def test_no_error_number_of_the_system_reaches_an_operator(reason, words):
    found = trouble_words("/remodel/use_case/runs", reason, 8.0)
    assert words in found
    assert "Errno" not in found


def test_a_picture_becomes_a_jpeg_no_larger_than_it_is_shown():
    rows = np.zeros((1000, 2000, 3), np.uint8)
    small = as_jpeg(rows.tobytes(), 1000, 2000, 6000, encoding="rgb8")
    assert small.startswith(b"\xff\xd8")
    assert len(small) < 50_000
    grey = as_jpeg(bytes(8 * 4), 4, 6, 8, encoding="mono8")  # rows may be longer than their pixels
    assert grey.startswith(b"\xff\xd8")


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((bytes(12), 2, 2, 6, "16UC1"), "this one is '16UC1'"),
        ((bytes(11), 2, 2, 6, "rgb8"), "11 bytes are no picture of 2 x 2"),
        ((bytes(8), 2, 2, 4, "rgb8"), "no picture"),
        ((b"", 0, 0, 0, "rgb8"), "no picture"),
    ],
)
def test_what_is_no_picture_is_reported(size, words):
    with pytest.raises(PictureError, match=words):
        as_jpeg(*size)


def test_the_newest_picture_is_kept_and_counted():
    pictures, woken = Pictures(), []
    pictures.on_change(lambda: woken.append(1))
    assert pictures.newest("wrist") is None
    pictures.take("wrist", b"1")
    pictures.take("wrist", b"2")
    assert pictures.newest("wrist").number == 2
    assert pictures.newest("wrist").jpeg == b"2"
    assert len(woken) == 2
    pictures.add_viewer(1)
    assert pictures.is_wanted
    pictures.add_viewer(-1)
    assert not pictures.is_wanted
