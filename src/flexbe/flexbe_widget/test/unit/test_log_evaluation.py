"""The sums of a run log."""

import pytest

from flexbe_widget.core.log_evaluation import evaluate, table
from flexbe_widget.edge.files import LogError, read_log

SAY = "name: Say, state: LogState, path: /Say"
RECORD = f"""\
- {{behavior: Quick, autonomy: 0, logger: flexbe.initialize, time: 9.0}}
- {{event: start, {SAY}, logger: flexbe.events, time: 9.5}}
- {{event: enter, {SAY}, logger: flexbe.events, time: 10.0}}
- {{type: request, request: done, {SAY}, logger: flexbe.operator, time: 11.0}}
- {{type: forced, forced: done, requested: done, {SAY}, logger: flexbe.operator, time: 14.0}}
- {{event: exit, {SAY}, logger: flexbe.events, time: 14.0}}
- {{outcome: done, {SAY}, logger: flexbe.outcomes, time: 14.0}}
- {{event: enter, {SAY}, logger: flexbe.events, time: 20.0}}
- {{type: forced, forced: failed, requested: null, {SAY}, logger: flexbe.operator, time: 21.0}}
- {{event: exit, {SAY}, logger: flexbe.events, time: 22.0}}
- {{outcome: failed, {SAY}, logger: flexbe.outcomes, time: 22.0}}
- {{event: enter, name: Wait, state: WaitState, path: /Wait, logger: flexbe.events, time: 22.0}}
- {{event: exit, name: Wait, sta"""


@pytest.fixture
def record(tmp_path):
    file = tmp_path / "record.yaml"
    file.write_text(RECORD)
    return str(file)


def test_times_and_visits_add_up_and_a_visit_without_an_end_is_left_out(record):
    (total,) = evaluate(read_log(record), "total").values()
    assert (total.time, total.time_wait, total.time_run, total.visits) == (6.0, 3.0, 3.0, 2)
    assert (total.interact, total.count_wait, total.correct, total.wrong) == (2, 1, 1, 1)


@pytest.mark.parametrize(
    ("key", "rows"),
    [
        ("state_path", ["/Say"]),
        ("state_name", ["Say"]),
        ("state_class", ["LogState"]),
        ("transition", ["/Say > done", "/Say > failed"]),
    ],
)
def test_rows_stand_for_what_was_asked(record, key, rows):
    assert list(evaluate(read_log(record), key)) == rows


def test_the_table_is_aligned(record):
    rows = evaluate(read_log(record), "transition")
    assert table(rows, "transition", ["time", "visits"]) == (
        "transition      time  visits\n/Say > done    4.000       1\n/Say > failed  2.000       1\n"
    )


def test_what_is_no_record_is_reported_with_its_line(tmp_path):
    file = tmp_path / "other.yaml"
    file.write_text("- {a: 1}\nhello\n- {b: 2}\n")
    with pytest.raises(LogError, match=r"other\.yaml:2: not a line of a run log: hello"):
        read_log(str(file))
    file.write_text("- {path: /Say, time: at noon}\n")
    with pytest.raises(
        LogError, match=r"other\.yaml:1: 'time' is not a number of seconds: - {path"
    ):
        read_log(str(file))
    with pytest.raises(LogError, match="cannot read"):
        read_log(str(tmp_path / "nothing"))
