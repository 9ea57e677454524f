"""How a run ends, by what the engine says."""

import pytest

from flexbe_core.engine.supervision import StatusCode
from flexbe_widget.core.run_watch import (
    SILENCE_S,
    START_LIMIT_S,
    Ending,
    RunEnd,
    RunWatch,
    is_busy,
)

MINE, OTHER = 7, 8


def fed(*statuses):
    """Return a watch of MINE after some statuses, and the first ending among them."""
    watch = RunWatch(MINE)
    for code, behavior_id, *args in statuses:
        ending = watch.on_status(code, behavior_id, tuple(args))
        if ending is not None:
            return ending
    return None


STARTED = (StatusCode.STARTED, MINE)

ROWS = [
    ("started", [STARTED], None),
    ("finished", [STARTED, (StatusCode.FINISHED, MINE, "done")], Ending(RunEnd.FINISHED, "done")),
    (
        "preempted",
        [STARTED, (StatusCode.FINISHED, MINE, "preempted")],
        Ending(RunEnd.PREEMPTED, "preempted"),
    ),
    ("failed", [STARTED, (StatusCode.FAILED, MINE)], Ending(RunEnd.FAILED)),
    ("refused", [(StatusCode.ERROR, MINE)], Ending(RunEnd.REFUSED)),
    ("the engine is restarted before it began", [(StatusCode.READY, 0)], Ending(RunEnd.RESTARTED)),
    (
        "the engine is restarted in between",
        [STARTED, (StatusCode.READY, 0)],
        Ending(RunEnd.RESTARTED),
    ),
    ("a second request for it is refused", [STARTED, (StatusCode.ERROR, MINE)], None),
    (
        "switched to another version, which ends",
        [
            STARTED,
            (StatusCode.SWITCHING, MINE),
            (StatusCode.STARTED, OTHER),
            (StatusCode.FINISHED, OTHER, "done"),
        ],
        Ending(RunEnd.FINISHED, "done"),
    ),
    (
        "a switch of another behavior",
        [STARTED, (StatusCode.SWITCHING, OTHER), (StatusCode.STARTED, OTHER)],
        None,
    ),
    ("another behavior is refused", [(StatusCode.ERROR, OTHER)], None),
    ("a launcher knows no behavior", [(StatusCode.ERROR, 0)], None),
    ("another behavior ends", [STARTED, (StatusCode.FINISHED, OTHER, "done")], None),
    ("its last run ends late", [(StatusCode.FINISHED, MINE, "done"), STARTED], None),
    ("it is switched to a new version", [STARTED, (StatusCode.SWITCHING, MINE)], None),
]


@pytest.mark.parametrize(
    ("statuses", "ending"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS]
)
def test_statuses_end_a_run(statuses, ending):
    assert fed(*statuses) == ending


def test_a_silent_engine_ends_a_run():
    watch = RunWatch(MINE)
    assert watch.on_time(1.0, SILENCE_S - 0.1) is None
    assert watch.on_time(1.0, SILENCE_S + 0.1) == Ending(RunEnd.LOST)


def test_a_run_that_is_never_started_ends():
    watch = RunWatch(MINE)
    assert watch.on_time(START_LIMIT_S + 1, 0.0) == Ending(RunEnd.LATE)
    watch.on_status(StatusCode.STARTED, MINE, ())
    assert watch.on_time(START_LIMIT_S + 1, 0.0) is None


def test_an_engine_is_busy_while_it_runs_or_switches():
    assert [code for code in StatusCode if is_busy(code)] == [
        StatusCode.STARTED,
        StatusCode.SWITCHING,
    ]
