"""From a seed: the files of a chart that is valid, or has a hole in its data flow.

The control structure is valid by construction: every state can be reached, the first event of each
leads on to the next, and so to an outcome. The data flow is drawn at random and then mended where
`explore` finds holes, mostly; what reads a value that may be missing is fed by the chart's caller.
"""

from __future__ import annotations

import itertools
import json
import posixpath
import random
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from lxml import etree

from random_charts.chart_xml import EXT, read_chart
from random_charts.explore import MISROUTED, UNROUTED, Fault, TooManyRunsError, explore
from random_charts.kinds import KINDS

_HOLES_LEFT = 0.25  # share of the charts that keep one hole, if they have any
_MOST_MENDINGS = 12
_IDS = [
    "Locate",
    "Insert",
    "Pick_Up",
    "pick",
    "Place-It",
    "a.b",
    "x-1",
    "Grün",
    "Übergabe",
    "run",
    "timer",
    "self",
    "None",
    "True",
    "import",
    "lambda",
    "other",
    "data",
    "name",
    "Root",
    "S1",
    "S_1",
    "root",
    "input",
    "output",
    "userdata",
    "error",
    "attempts",
    "R2D2",
    "été",
    "done2",
    "counted",
    "None_1",
    "Autonomy",
    "Behavior",
    "Logger",
]
_IDS += ["Pick up 2", "Look again", "Fix - it", "a b c", "class A".replace(" ", "-"), "x def-"]
_OUTCOMES = ["finished", "failed", "no part", "aborted", "ok", "timed_out", "exhausted", "done"]
_OUTCOMES += ["Später", "x-y"]
_KEYS = [
    "item",
    "result",
    "count",
    "target",
    "pose",
    "error_code",
    "part",
    "value",
    "data",
    "x",
    "self_",
    "name",
]
_TITLES = ["Place Connector", "Place-Wire", "Grün", "Ärm", "a.b", "R2", "Look it up", "x"]


class Source(NamedTuple):
    """A seed's charts."""

    files: Mapping[str, bytes]
    path: str


@dataclass
class _Part:
    """A node with what the scope around it must know."""

    element: etree._Element
    events: list[str]
    inputs: list[str]
    outputs: list[str]
    own: tuple[str, ...]


@dataclass
class _Chart:
    """A chart in the making.

    Attributes:
        path: name of its file.
        taken: paths that are taken, as the FlexBE App joins them.
        may_claim: whether a priority container may stand here; they cannot be nested.
    """

    path: str
    taken: set[str] = field(default_factory=set)
    may_claim: bool = True


def generate(seed: int) -> Source:
    """Return the charts of a seed."""
    return _Generator(seed).source()


class _Generator:
    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._random = random.Random(seed)
        self._roots: dict[str, etree._Element] = {}
        self._numbers = itertools.count(1)
        self._budget = self._random.choice((3, 5, 8, 12, 16))

    def source(self) -> Source:
        root = self._chart("main.xml", 0)
        kept: set[tuple[str, str]] = set()  # the hole that is left, if one is
        has_hole = self._random.random() < _HOLES_LEFT
        for _ in range(_MOST_MENDINGS):
            try:
                faults = explore(read_chart(self._written().files, "main.xml"))
            except TooManyRunsError:
                break
            if has_hole and faults and not kept:
                kept = {self._random.choice(faults)[:2]}
            mendable = [fault for fault in faults if fault[:2] not in kept]
            if not mendable:
                break
            self._mend(root, "main.xml", mendable)
        return self._written()

    def _written(self) -> Source:
        rng = random.Random(self._seed)
        is_pretty = rng.random() < 0.7
        files = {
            path: etree.tostring(root, encoding="UTF-8", pretty_print=is_pretty)
            for path, root in self._roots.items()
        }
        return Source(files, "main.xml")

    def _chance(self, share: float) -> bool:
        return self._random.random() < share

    # Structure

    def _chart(self, path: str, depth: int) -> etree._Element:
        rng = self._random
        root = etree.Element("statemachine", nsmap={"ext": EXT[1:-1]})
        self._roots[path] = root
        root.set("name", f"{rng.choice(_TITLES)} {next(self._numbers)}")
        self._fill(root, _Chart(path), "", depth, concurrent=False)
        for port in root.find("datamodel").findall("input"):
            if self._chance(0.3):
                value = rng.choice([0, 5, None, "a", [1], {"k": 2.5}, True, "it's"])
                port.set(f"{EXT}default", json.dumps(value))
        return root

    def _fill(
        self, scope: etree._Element, chart: _Chart, above: str, depth: int, concurrent: bool
    ) -> None:
        """Put a datamodel and nodes into a chart or container."""
        rng = self._random
        data = etree.SubElement(scope, "datamodel")
        outcomes = rng.sample(_OUTCOMES, rng.randint(1, 3))
        around = etree.SubElement(data, "outcomes") if self._chance(0.2) else data
        for outcome in outcomes:
            etree.SubElement(around, "outcome", name=outcome)
        for name in rng.sample(_KEYS, rng.randint(0, 2)):
            etree.SubElement(data, "input", name=name)
        count = rng.randint(2, 3) if concurrent else rng.randint(1, max(1, min(5, self._budget)))
        parts = []
        for _ in range(count):
            taken = {
                *outcomes,
                scope.get("name", scope.get("id")),
                *(p.element.get("id") for p in parts),
            }
            parts.append(self._node(chart, above, taken, depth, concurrent))
        if concurrent:
            self._conditions(scope, parts, outcomes)
        else:
            self._transitions(parts, outcomes)
            scope.set("initial", parts[0].element.get("id"))
            rng.shuffle(shuffled := list(parts))
            parts = shuffled
        scope.extend(part.element for part in parts)
        self._drop_unused(scope)
        self._wire(scope, parts, concurrent)

    def _node(
        self, chart: _Chart, above: str, taken: Iterable[str], depth: int, concurrent: bool
    ) -> _Part:
        rng = self._random
        self._budget -= 1
        node_id = self._id(chart, above, set(taken))
        path = f"{above}/{node_id}"
        is_deep = depth > 2 or self._budget <= 0
        tag = (
            "state"
            if is_deep
            else rng.choices(
                ["state", "container", "priority", "concurrency", "behavior"],
                [52, 17, 5 * chart.may_claim, 12, 14],
            )[0]
        )
        if tag == "state":
            part = self._state(node_id)
        elif tag == "behavior":
            part = self._behavior(node_id, chart, depth)
        else:
            element = etree.Element(f"{EXT}{tag}", id=node_id)
            may_claim, chart.may_claim = chart.may_claim, chart.may_claim and tag != "priority"
            self._fill(element, chart, path, depth + 1, concurrent=tag == "concurrency")
            chart.may_claim = may_claim
            part = _container_part(element, element)
        self._limit(part, concurrent)
        return part

    def _id(self, chart: _Chart, above: str, taken: set[str]) -> str:
        for wanted in itertools.chain(
            self._random.sample(_IDS, 8), (f"N{n}" for n in itertools.count())
        ):
            joined = f"{above}/{wanted}".replace("/", "_")
            added = {joined, *(f"{joined}_{s}" for s in ("attempts", "error", "run", "timer"))}
            inner = {f"{wanted}_{s}" for s in ("attempts", "error", "run", "timer")}
            bases = {name.rpartition("_")[0] for name in [wanted] if "_" in name}
            if not added & chart.taken and wanted not in taken and not (inner | bases) & taken:
                chart.taken |= added
                return wanted
        raise AssertionError

    def _state(self, node_id: str) -> _Part:
        rng = self._random
        name = rng.choice(list(KINDS))
        kind = KINDS[name]
        prefix = rng.choice(["", "", "", "scripted_states/", "scripted_states__"])
        element = etree.Element("state", id=node_id)
        element.set("type", (prefix if kind.is_scripted else "") + name)
        params: dict[str, object] = {}
        own, inputs, outputs = kind.outcomes, kind.inputs, kind.outputs
        if not own:
            own = tuple(
                rng.sample(["left", "right", "no way", "failed", "on-hold"], rng.randint(1, 4))
            )
            params["outcomes"] = list(own)
        if inputs is None:
            inputs = tuple(rng.sample(_KEYS[:8], rng.randint(1, 3)))
            params["input_keys"] = list(inputs)
        if outputs is None:
            outputs = tuple(rng.sample(_KEYS[:8], rng.randint(1, 3)))
            params["output_keys"] = list(outputs)
        if name == "UserDataState":
            params["data"] = rng.choice([0, 7, True, None, [1, 2], "text", {"a": [None]}])
        if name == "CheckConditionState":
            params["predicate"] = rng.choice(["is_true", "is_false", "is_none", "is_given"])
        if name == "OperatorDecisionState":
            params["suggestion"] = rng.choice(own)
        if name == "WaitState":
            params["wait_time"] = rng.choice([0.25, 0.6, 2.0])
        if kind.keeps_time and self._chance(0.4):
            element.set("topic", "other_cell/ability")
        for key, value in params.items():
            etree.SubElement(element, "param", name=key, value=json.dumps(value))
        return _Part(element, list(own), list(inputs), list(outputs), own)

    def _behavior(self, node_id: str, chart: _Chart, depth: int) -> _Part:
        rng = self._random
        here = posixpath.dirname(chart.path)
        known = [
            path
            for path in self._roots
            if path not in ("main.xml", chart.path)
            and len(self._roots[path])
            and self._roots[path].get("initial")
        ]
        if known and self._chance(0.4) and depth < 2:
            path = rng.choice(known)
            if chart.path != "main.xml":
                path = ""  # it may be around this one
        else:
            path = ""
        if not path:
            path = rng.choice(["inner {}.xml", "parts/inner_{}.xml"]).format(next(self._numbers))
            self._chart(path, depth + 1)
        element = etree.Element("behavior", id=node_id)
        element.set("type", posixpath.relpath(path, here or "."))
        return _container_part(element, self._roots[path])

    def _limit(self, part: _Part, concurrent: bool) -> None:
        """Add limits of attempts and time, and error routes; these lead somewhere later."""
        rng, element = self._random, part.element
        name = element.get("type", "").rpartition("/")[2].rpartition("__")[2]
        kind = KINDS.get(name) if element.tag == "state" else None
        is_alone = element.tag == f"{EXT}priority"  # its timer would stand still
        if not is_alone and self._chance(0.2):
            element.set(f"{EXT}timeout_s", str(rng.choice([0.25, 0.7, 1.5, 4.0])))
            if (kind is None or not kind.keeps_time) and "timed_out" not in part.events:
                part.events.append("timed_out")
        if not concurrent and self._chance(0.25):
            element.set(f"{EXT}attempts", str(rng.randint(1, 3)))
            if "exhausted" not in part.events:
                part.events.append("exhausted")
        is_routed = "failed" in part.own and "error_code" in part.outputs
        if is_routed and not concurrent and self._chance(0.6):
            element.set(f"{EXT}on_error", "1-2: ?; 5: ?")

    def _transitions(self, parts: list[_Part], outcomes: list[str]) -> None:
        """Lead the first event of each node on, and the others anywhere."""
        rng = self._random
        ids = [part.element.get("id") for part in parts]
        for index, part in enumerate(parts):
            later = ids[index + 1 :]
            rng.shuffle(part.events)
            own = [event for event in part.events if event in part.own]
            own = [e for e in own if e != "exhausted"] or own
            for event in part.events:
                if event == own[0]:
                    target = later[0] if later else rng.choice(outcomes)
                elif event == "exhausted":
                    target = rng.choice(later + outcomes)
                else:
                    target = rng.choice([*outcomes, *outcomes, *ids, *later])
                transition = etree.SubElement(
                    part.element, "transition", event=event, target=target
                )
                if self._chance(0.1):
                    levels = ["off", "low", "high", "full"]
                    transition.set(f"{EXT}autonomy", rng.choice(levels))
            routes = part.element.get(f"{EXT}on_error")
            while routes and "?" in routes:
                routes = routes.replace("?", rng.choice([*ids, *outcomes]), 1)
                part.element.set(f"{EXT}on_error", routes)

    def _conditions(self, scope: etree._Element, parts: list[_Part], outcomes: list[str]) -> None:
        """Put each event of each node into one condition, so that some condition always holds."""
        rng = self._random
        groups: list[dict[str, str]] = []
        for _ in range(rng.randint(0, 2)):
            members = rng.sample(parts, rng.randint(2, len(parts)))
            groups.append({m.element.get("id"): rng.choice(m.events) for m in members})
        events = {part.element.get("id"): part.events for part in parts}
        seen: set[tuple[str, str]] = set()
        joins = []
        for group in groups:
            if not seen & set(group.items()) and not _is_endless([*joins, group], events):
                joins.append(group)
                seen |= set(group.items())
        singles = [{n: e} for n, found in events.items() for e in found if (n, e) not in seen]
        conditions = [*joins, *singles]
        rng.shuffle(conditions)
        for group in conditions:
            condition = etree.SubElement(scope, f"{EXT}condition", outcome=rng.choice(outcomes))
            for node, event in group.items():
                etree.SubElement(condition, f"{EXT}when", state=node, event=event)

    def _drop_unused(self, scope: etree._Element) -> None:
        """Drop the outcomes that nothing leads to, mostly."""
        routes = " ".join(child.get(f"{EXT}on_error", "") for child in scope)
        used = {t.get("target") for t in scope.findall("*/transition")}
        used |= {condition.get("outcome") for condition in scope.findall(f"{EXT}condition")}
        for outcome in list(scope.find("datamodel").iter("outcome")):
            is_used = outcome.get("name") in used or outcome.get("name") in routes
            if not is_used and self._chance(0.9):
                outcome.getparent().remove(outcome)

    # Data

    def _wire(self, scope: etree._Element, parts: list[_Part], concurrent: bool) -> None:
        """Connect the inputs of the nodes and the outputs of the scope at random."""
        rng, data = self._random, scope.find("datamodel")
        name = scope.get("name", scope.get("id"))
        givers = [
            (part.element.get("id"), key)
            for part in parts
            for key in part.outputs
            for _ in range(1 if part.element.tag == "state" else 3)
        ]
        for part in parts:
            node_id = part.element.get("id")
            for key in part.inputs:
                own = [i.get("name") for i in data.findall("input")]
                others = [] if concurrent and self._chance(0.95) else givers
                if key in own and self._chance(0.5):
                    continue
                if others and self._chance(0.75):
                    giver = rng.choice([g for g in others if g[0] != node_id] or others)
                elif own and self._chance(0.7):
                    giver = (name, rng.choice(own))
                else:
                    if key not in own:
                        etree.SubElement(data, "input", name=key)
                    continue
                _connect(scope, giver, (node_id, key))
        self._wire_outputs(scope, data, name, parts)

    def _wire_outputs(
        self, scope: etree._Element, data: etree._Element, name: str, parts: list[_Part]
    ) -> None:
        rng = self._random
        free = [(p.element.get("id"), k) for p in parts for k in p.outputs if k not in p.inputs]
        rng.shuffle(free)
        for _ in range(rng.randint(0, 3)):
            connected = {key for _node, key in self._connected_to(scope, name)}
            by_name = {key for _node, key in free} - connected
            if by_name and self._chance(0.5):
                output = rng.choice(sorted(by_name))
            elif free:
                output = rng.choice([*_KEYS, "out", "found"])
            else:
                return
            if any(o.get("name") == output for o in data.findall("output")):
                continue
            if output in by_name and self._chance(0.8):
                etree.SubElement(data, "output", name=output)
                free = [port for port in free if port[1] != output]
            elif free:
                etree.SubElement(data, "output", name=output)
                for _ in range(min(len(free), rng.randint(1, 2))):
                    _connect(scope, free.pop(), (name, output))

    def _connected_to(self, scope: etree._Element, name: str) -> set[tuple[str, str]]:
        """Return the outputs of nodes that feed outputs of the scope."""
        found = [c for c in scope.findall("connection") if c.get("input_state_id") == name]
        return {(c.get("output_state_id"), c.get("output")) for c in found}

    def _mend(self, root: etree._Element, path: str, faults: Iterable[Fault]) -> None:
        for fault in faults:
            scopes, file = [(root, path)], path
            *above, node_id = fault.path.split("/")[1:]
            for part in above:
                element = _child(scopes[-1][0], part)
                if element.tag == "behavior":
                    file = _inner_path(file, element)
                    element = self._roots[file]
                scopes.append((element, file))
            node = _child(scopes[-1][0], node_id)
            if fault.what in (MISROUTED, UNROUTED):
                node.attrib.pop(f"{EXT}on_error", None)
            else:
                self._feed_from_outside(scopes[-1][0], node_id, fault.key)

    def _feed_from_outside(self, scope: etree._Element, node_id: str, key: str) -> None:
        """Feed an input by a new input of the scope, that input by one around it, and so on."""
        data = scope.find("datamodel")
        taken = {port.get("name") for port in data if port.tag in ("input", "output")}
        name = next(
            n
            for n in itertools.chain([f"{key}_given"], (f"{key}_{i}" for i in itertools.count(2)))
            if n not in taken
        )
        etree.SubElement(data, "input", name=name)
        for connection in scope.findall("connection"):
            if (connection.get("input_state_id"), connection.get("input")) == (node_id, key):
                scope.remove(connection)
        _connect(scope, (scope.get("name", scope.get("id")), name), (node_id, key))
        if scope.get("id") is not None:
            around = scope.getparent()
            self._feed_from_outside(around, scope.get("id"), name)
            return
        path = next(p for p, root in self._roots.items() if root is scope)
        for other_path, root in self._roots.items():
            for behavior in list(root.iter("behavior")):
                if _inner_path(other_path, behavior) == path:
                    self._feed_from_outside(behavior.getparent(), behavior.get("id"), name)


def _container_part(element: etree._Element, scope: etree._Element) -> _Part:
    data = scope.find("datamodel")
    own = tuple(o.get("name") for o in data.iter("outcome"))
    names = {tag: [p.get("name") for p in data.findall(tag)] for tag in ("input", "output")}
    return _Part(element, list(own), names["input"], names["output"], own)


def _inner_path(path: str, behavior: etree._Element) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), behavior.get("type")))


def _child(scope: etree._Element, node_id: str) -> etree._Element:
    return next(child for child in scope if child.get("id") == node_id)


def _connect(scope: etree._Element, giver: tuple[str, str], taker: tuple[str, str]) -> None:
    etree.SubElement(
        scope,
        "connection",
        output_state_id=giver[0],
        output=giver[1],
        input_state_id=taker[0],
        input=taker[1],
    )


def _is_endless(joins: list[dict[str, str]], events: Mapping[str, list[str]]) -> bool:
    """Return whether all nodes can end so that no condition holds; all other events end it."""
    joined = {pair for group in joins for pair in group.items()}
    for ended in itertools.product(*([(n, e) for e in found] for n, found in events.items())):
        if joined.issuperset(ended) and not any(
            set(group.items()) <= set(ended) for group in joins
        ):
            return True
    return False
