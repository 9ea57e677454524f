"""What states find in the userdata and leave behind, as receivers know it."""

import json
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Point
from sensor_msgs.msg import Image

from flexbe_core.core import EventState
from flexbe_core.engine.visit import Known, Printer, VisitText, visit_of
from flexbe_core.ros.reporter import LONGEST, VisitPublisher, printed


class Count(EventState):
    """Adds to `count`, in place to `trace`, and ends."""

    def __init__(self):
        super().__init__(outcomes=["done"], io_keys=["count", "trace"])

    def execute(self, userdata):
        userdata.count = userdata.count + 1
        userdata.trace.append(userdata.count)
        return "done"


class Observed:
    """An engine whose visits are printed, sent and received."""

    def __init__(self, bench, root):
        self.engine = bench.engine(root)
        self.engine.observe = self.take
        self.printer = Printer(printed)
        self.known = Known()
        self.texts = []

    def take(self, leaf, has_left):
        visit = self.printer.text_of(visit_of(leaf, 1.5, has_left))
        text = VisitText.from_json(visit.as_json())
        assert text == visit
        self.texts.append(text)
        assert self.known.take(text)


@pytest.fixture
def observed(bench):
    inner = bench.machine(input_keys=["trace"], output_keys=["trace"])
    inner.userdata.count = 10
    with inner:
        bench.add("Add", Count(), {"done": "finished"}, {})
    root = bench.machine()
    root.userdata.total, root.userdata.trace = 0, []
    with root:
        bench.add("Count", Count(), {"done": "Box"}, {}, {"count": "total"})
        bench.add("Box", inner, {"finished": "Last"}, {})
        bench.add("Last", Count(), {"done": "finished"}, {}, {"count": "total"})
    return Observed(bench, root)


def test_each_state_shows_what_it_finds_and_what_it_leaves(bench, observed):
    assert bench.run(observed.engine) == "finished"
    texts = observed.texts
    assert [(t.path, t.has_left) for t in texts] == [
        (path, has_left) for path in ("/Count", "/Box/Add", "/Last") for has_left in (False, True)
    ]
    first, after = texts[:2]
    assert first.changed == {("", "total"): ("int", "0"), ("", "trace"): ("list", "[]")}
    assert first.keys == {"count": ("", "total"), "trace": ("", "trace")}
    assert after.changed == {("", "total"): ("int", "1"), ("", "trace"): ("list", "[1]")}
    inside = texts[2]
    assert (inside.complete, inside.keys["count"]) == (("/Box",), ("/Box", "count"))
    assert inside.keys["trace"] == ("", "trace"), "nothing inside the container has its own yet"
    assert observed.known.values["/Box", "count"] == ("int", "11")
    assert observed.known.values["", "total"] == ("int", "2")
    assert json.loads(observed.known.values["", "trace"][1]) == [1, 11, 2]


def test_a_second_run_begins_without_the_values_of_the_first(bench, observed):
    assert bench.run(observed.engine) == "finished"
    observed.texts.clear()
    assert bench.run(observed.engine) == "finished"
    assert {text.run for text in observed.texts} == {2}
    assert observed.texts[0].complete == ("",)
    assert observed.texts[2].complete == ("/Box",)


def test_a_receiver_that_has_missed_something_waits_for_all_values(bench, observed):
    bench.run(observed.engine)
    late = Known()
    assert not late.take(observed.texts[1]), "its values before are not known"
    assert not late.take(observed.texts[2])
    known = Known()
    assert known.take(observed.texts[0])
    assert not known.take(observed.texts[2]), "one is missing in between"
    observed.printer.is_complete = True
    observed.texts.clear()
    bench.run(observed.engine)
    assert late.take(observed.texts[0])


def test_what_is_large_is_not_printed():
    assert printed(Point(1.0, 2.0, 3.0)) == "x: 1.0\ny: 2.0\nz: 3.0"
    assert printed(Image(data=bytes(900_000))).endswith(" bytes>")
    for value in ("x" * 30_000, b"x" * 30_000, list(range(30_000))):
        assert LONGEST < len(printed(value)) < LONGEST + 10


def test_a_value_that_cannot_be_printed_is_described():
    assert printed(Point(x="one")).startswith("<Point that cannot be printed: ")


def test_a_value_that_changes_while_it_is_printed_does_not_end_the_messages(bench):
    class Changing(dict):
        times = 0

        def values(self):
            self.times += 1
            if self.times == 1:
                raise RuntimeError("dictionary changed size during iteration")
            return super().values()

    root = bench.machine()
    root.userdata.trace, root.userdata.count = Changing(), 5
    bench.sequence(root, EventState(outcomes=["done"]))
    engine, sent, publisher = bench.engine(root), [], VisitPublisher()
    engine.observe = lambda leaf, has_left: sent.append(visit_of(leaf, 0.0, has_left))
    engine.run(0.0)
    texts = []
    topic = SimpleNamespace(publish=lambda text: texts.append(VisitText.from_json(text.data)))
    for _ in range(2):
        publisher._publish_visit(topic, sent[0])
    (text,) = texts
    assert text.changed.keys() == {("", "trace"), ("", "count")}
