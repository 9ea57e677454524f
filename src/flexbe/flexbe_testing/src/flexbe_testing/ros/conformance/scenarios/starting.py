"""Start requests: the order of events, parameters, inputs, refusals."""

from __future__ import annotations

import json
from typing import Any

from flexbe_msgs.msg import BehaviorModification, BehaviorSelection, BEStatus

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.identity import checksum
from flexbe_testing.core.conformance.scenario import NotJudgedError, ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, FAULT, NEST, VALUES
from flexbe_testing.ros.conformance.tape import EVENT

_RUNS = 5


@scenario("STARTED and FINISHED carry the source's checksum; FINISHED carries the outcome", "3.2")
def runs_to_the_end(bench: Bench) -> None:
    """Run to one outcome, then to the other."""
    for word, outcome in (("done", "finished"), ("other", "failed")):
        bench.start_at("/First", CHAIN)
        bench.gate("First", word)
        if word == "done":
            bench.at("/Second")
            bench.gate("Second", word)
        bench.finished(outcome)


@scenario(
    "on_start of all states depth first, on_enter and on_exit per visit, on_stop of all", "2.2"
)
def order_of_events(bench: Bench) -> None:
    """Play a nested behavior to its end."""
    visited = ["/Box/Inner/Leaf", "/Box/Last", "/After"]
    states = ["/Box/Inner/Leaf", "/Box/Inner/Tail", "/Box/Last", "/After"]
    bench.start(NEST)
    bench.events(*(f"start {path}" for path in states))
    for path, word in zip(visited, ("other", "done", "done"), strict=True):
        bench.events(f"enter {path}")
        bench.gate(path.rpartition("/")[2], word)
        bench.events(f"exit {path}")
    bench.in_any_order(*(f"stop {path}" for path in states))
    bench.finished()
    if left := bench.wire.tape.left(EVENT):
        raise ViolationError(f"event {left[0]!r} besides")


@scenario("The next behavior may be started as soon as the last has FINISHED", "3.2")
def next_behavior_at_once(bench: Bench) -> None:
    """Start right after the status."""
    for _ in range(_RUNS):
        bench.start_at("/First", CHAIN)
        bench.gate("First", "other")
        bench.finished("failed")


def _values(bench: Bench, args: dict[str, str], piece: str | None = None) -> dict[str, Any]:
    """Return the values that the state in the contained behavior received."""
    bench.start(VALUES, args=args, inputs=None if piece is None else {"piece": piece})
    found: dict[str, Any] = json.loads(bench.text_event("values "))
    bench.at("/Hold")
    bench.gate("Hold", "done")
    bench.finished()
    return found


def _require(found: dict[str, Any], **expected: object) -> None:
    for name, value in expected.items():
        if found[name] != value or type(found[name]) is not type(value):
            raise ViolationError(f"{name} is {found[name]!r}; expected: {value!r}")


@scenario("Parameters become the type of their default: text, float, int, bool", "2.6")
def parameter_types(bench: Bench) -> None:
    """Send texts for all types; two spellings of False."""
    sent = {"word": "7", "size": "2.25", "count": "40", "is_new": "False"}
    _require(_values(bench, sent), word="7", size=2.25, count=40, is_new=False)
    _require(_values(bench, {"is_new": "0"}), word="part", size=1.5, count=2, is_new=False)


@scenario("A parameter is named `key`, `/key` or `/Contained/key`", "2.6")
def parameter_paths(bench: Bench) -> None:
    """Reach the contained behavior with each spelling."""
    for name in ("word", "/word", "/Part/word"):
        _require(_values(bench, {name: f"by {name}"}), word=f"by {name}")


@scenario("A parameter that no behavior has does not stop the start", "3.2")
def parameter_unknown(bench: Bench) -> None:
    """Send it beside one that exists."""
    _require(_values(bench, {"no_such_key": "1", "word": "known"}), word="known")


@scenario("Inputs are Python literals; dicts allow attribute access; other text stays text", "3.2")
def inputs(bench: Bench) -> None:
    """Send a dict, a number and a text."""
    _require(_values(bench, {}, "{'pins': [1, 2]}"), pins=[1, 2])
    _require(_values(bench, {}, "17"), part="17")
    _require(_values(bench, {}, "wire A 7"), part="wire A 7")
    _require(_values(bench, {}), part="nothing")


def _refused(bench: Bench, selection: BehaviorSelection) -> None:
    bench.request(selection)
    bench.status(BEStatus.ERROR, [], selection.behavior_checksum)


@scenario("An unknown behavior_id is refused with ERROR and the request's checksum", "3.2")
def unknown_behavior(bench: Bench) -> None:
    """Send an id that no package path has."""
    selection = bench.selection(CHAIN)
    selection.behavior_id = checksum("no_such_package.no_such_module")
    _refused(bench, selection)


@scenario("A checksum of another source is refused with ERROR", "3.2")
def other_checksum(bench: Bench) -> None:
    """Send the right id with another checksum; the engine remains usable."""
    selection = bench.selection(CHAIN)
    selection.behavior_checksum ^= 1
    _refused(bench, selection)
    bench.start(CHAIN)
    bench.preempt()


@scenario("A parameter value that cannot be converted is refused with ERROR", "3.2")
def bad_parameter_value(bench: Bench) -> None:
    """Send a word for a float."""
    _refused(bench, bench.selection(VALUES, args={"size": "large"}))


@scenario("A behavior whose create() raises is refused with ERROR", "3.2")
def create_raises(bench: Bench) -> None:
    """Nothing is started."""
    _refused(bench, bench.selection(FAULT, args={"how": "create"}))


@scenario("A behavior whose on_start raises ends with FAILED", "3.2")
def on_start_raises(bench: Bench) -> None:
    """STARTED may or may not precede. Supervised, no other exception ends a behavior."""
    bench.request(selection := bench.selection(FAULT, 3, args={"how": "start"}))
    failed = {"code": BEStatus.FAILED, "behavior_id": selection.behavior_checksum, "args": []}
    bench.find(topics.STATUS, failed)


@scenario("Modifications replace half-open ranges of characters, in ascending order", "3.2")
def modifications(bench: Bench) -> None:
    """Swap the targets of two outcomes in the source that is sent along."""
    text = bench.source(CHAIN)
    changes = [('"done": "finished"', '"done": "failed"'), ('"Conformance', '"Conformance')]
    changes.sort(key=lambda change: text.index(change[0]))
    selection, changed = bench.selection(CHAIN), text
    for old, new in changes:
        begin = text.index(old)
        selection.modifications.append(BehaviorModification(begin, begin + len(old), new))
        changed = changed.replace(old, new, 1)
    selection.behavior_checksum = bench.id = checksum(changed)
    bench.request(selection)
    begun = bench.find(topics.STATUS, {"behavior_id": bench.id})
    if begun.code == BEStatus.ERROR:
        raise NotJudgedError("the engine refuses modifications; perhaps an option allows them")
    bench.at("/First")
    bench.gate("First", "done")
    bench.at("/Second")
    bench.gate("Second", "done")
    bench.finished("failed")
