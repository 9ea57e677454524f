"""Two recorded runs side by side."""

from remodel_console.core.record import Record, compare
from remodel_run.record import Entry, Kind


def record(*steps):
    """Return a record of (kind, task, what) with a report of an ability between the steps."""
    entries = []
    for kind, task, what in steps:
        fields = {"state_path": what} if kind is Kind.STATE else {"text": what}
        if kind is Kind.FAILURE:
            fault, _, text = what.partition(":")
            fields = {"fault": fault, "text": text}
        for made in (
            {"kind": Kind.FEEDBACK, "values": (("force_n", float(len(entries))),)},
            {"kind": kind, "task": task, **fields},
        ):
            place = len(entries) + 1
            entries.append(Entry(position=place, time_s=10.0 + place, **made))
    return Record(tuple(entries))


TASK, STATE, FAILURE = Kind.TASK, Kind.STATE, Kind.FAILURE
GOOD = [(TASK, "W1", "begins"), (STATE, "W1", "/A"), (STATE, "W1", "/B"), (TASK, "W1", "done")]


def test_runs_that_took_the_same_steps_have_no_difference():
    late = Record(tuple(Entry(e.position, 2 * e.time_s, e.kind, task=e.task, text=e.text,
                              state_path=e.state_path) for e in record(*GOOD).entries))  # fmt: skip
    found = compare(record(*GOOD), late)
    assert found.first is None
    assert [row.left.words for row in found.rows] == ["W1: begins", "W1: /A", "W1: /B", "W1: done"]
    assert found.rows[1].right.offset_s == 2 * found.rows[1].left.offset_s


def test_the_first_difference_is_found_and_the_rest_is_aligned_again():
    failed = [*GOOD[:2], (FAILURE, "W1", "jammed: 22 N"), (STATE, "W1", "/A"), *GOOD[2:]]
    found = compare(record(*GOOD), record(*failed))
    assert found.first == 2
    assert found.rows[2].left is None
    assert "22 N" in found.rows[2].right.words
    assert [row.is_same for row in found.rows] == [True, True, False, False, True, True]
    back = compare(record(*failed), record(*GOOD))
    assert (back.first, back.rows[2].right) == (2, None)


def test_what_was_measured_makes_no_difference():
    runs = [record(*GOOD, (FAILURE, "W2", f"jammed:{force} N")) for force in (22, 23)]
    assert compare(*runs).first is None
    other = record(*GOOD, (FAILURE, "W2", "slipped:22 N"))
    assert compare(runs[0], other).first == 4


def test_a_run_that_ends_early_differs_at_its_end():
    found = compare(record(*GOOD[:2]), record(*GOOD))
    assert found.first == 2
    assert [row.left for row in found.rows[2:]] == [None, None]
    assert compare(Record(()), Record(())).first is None


def test_long_runs_are_compared_at_once():
    long = [(STATE, f"W{n}", f"/S{n % 7}") for n in range(20_000)]
    found = compare(record(*long), record(*long[:-1], (STATE, "W0", "/Other")))
    assert found.first == 19_999
