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
from random_charts.data_flow import mend, wire
from random_charts.explore import TooManyRunsError, explore
from random_charts.parts import KEYS, Part, chance, container_part, draw_limits, draw_state

_HOLES_LEFT = 0.25  # share of the charts that keep one hole, if they have any
_MOST_MENDINGS = 12
_IDS = ["Locate", "Insert", "Pick_Up", "pick", "Place-It", "a.b", "x-1", "Grün", "Übergabe", "run"]
_IDS += ["timer", "self", "None", "True", "import", "lambda", "other", "data", "name", "Root", "S1"]
_IDS += ["S_1", "root", "input", "output", "userdata", "error", "attempts", "R2D2", "été", "done2"]
_IDS += ["counted", "None_1", "Autonomy", "Behavior", "Logger"]
_IDS += ["Pick up 2", "Look again", "Fix - it", "a b c", "class-A", "x def-"]
_OUTCOMES = ["finished", "failed", "no part", "aborted", "ok", "timed_out", "exhausted", "done"]
_OUTCOMES += ["Später", "x-y"]
_TITLES = ["Place Connector", "Place-Wire", "Grün", "Ärm", "a.b", "R2", "Look it up", "x"]


class Source(NamedTuple):
    """A seed's charts."""

    files: Mapping[str, bytes]
    path: str


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
        self._chart("main.xml", 0)
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
            mend(self._roots, "main.xml", mendable)
        return self._written()

    def _written(self) -> Source:
        rng = random.Random(self._seed)
        is_pretty = rng.random() < 0.7
        files = {
            path: etree.tostring(root, encoding="UTF-8", pretty_print=is_pretty)
            for path, root in self._roots.items()
        }
        return Source(files, "main.xml")

    def _chart(self, path: str, depth: int) -> etree._Element:
        rng = self._random
        root = etree.Element("statemachine", nsmap={"ext": EXT[1:-1]})
        self._roots[path] = root
        root.set("name", f"{rng.choice(_TITLES)} {next(self._numbers)}")
        self._fill(root, _Chart(path), "", depth, concurrent=False)
        for port in root.find("datamodel").findall("input"):
            if chance(self._random, 0.3):
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
        around = etree.SubElement(data, "outcomes") if chance(self._random, 0.2) else data
        for outcome in outcomes:
            etree.SubElement(around, "outcome", name=outcome)
        for name in rng.sample(KEYS, rng.randint(0, 2)):
            etree.SubElement(data, "input", name=name)
        count = rng.randint(2, 3) if concurrent else rng.randint(1, max(1, min(5, self._budget)))
        parts = []
        for _ in range(count):
            taken = {
                *outcomes,
                scope.get("name", scope.get("id")),
                *(p.element.get("id") for p in parts),
            }
            parts.append(self._node(chart, above, taken, depth, concurrent=concurrent))
        if concurrent:
            self._conditions(scope, parts, outcomes)
        else:
            self._transitions(parts, outcomes)
            scope.set("initial", parts[0].element.get("id"))
            rng.shuffle(shuffled := list(parts))
            parts = shuffled
        scope.extend(part.element for part in parts)
        self._drop_unused(scope)
        wire(rng, scope, parts, concurrent)

    def _node(
        self, chart: _Chart, above: str, taken: Iterable[str], depth: int, concurrent: bool
    ) -> Part:
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
            part = draw_state(rng, node_id)
        elif tag == "behavior":
            part = self._behavior(node_id, chart, depth)
        else:
            element = etree.Element(f"{EXT}{tag}", id=node_id)
            may_claim, chart.may_claim = chart.may_claim, chart.may_claim and tag != "priority"
            self._fill(element, chart, path, depth + 1, concurrent=tag == "concurrency")
            chart.may_claim = may_claim
            part = container_part(element, element)
        draw_limits(rng, part, concurrent)
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

    def _behavior(self, node_id: str, chart: _Chart, depth: int) -> Part:
        rng = self._random
        here = posixpath.dirname(chart.path)
        known = [
            path
            for path in self._roots
            if path not in ("main.xml", chart.path)
            and len(self._roots[path])
            and self._roots[path].get("initial")
        ]
        if known and chance(self._random, 0.4) and depth < 2:
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
        return container_part(element, self._roots[path])

    def _transitions(self, parts: list[Part], outcomes: list[str]) -> None:
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
                if chance(self._random, 0.1):
                    levels = ["off", "low", "high", "full"]
                    transition.set(f"{EXT}autonomy", rng.choice(levels))
            routes = part.element.get(f"{EXT}on_error")
            while routes and "?" in routes:
                routes = routes.replace("?", rng.choice([*ids, *outcomes]), 1)
                part.element.set(f"{EXT}on_error", routes)

    def _conditions(self, scope: etree._Element, parts: list[Part], outcomes: list[str]) -> None:
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
            if not is_used and chance(self._random, 0.9):
                outcome.getparent().remove(outcome)


def _is_endless(joins: list[dict[str, str]], events: Mapping[str, list[str]]) -> bool:
    """Return whether all nodes can end so that no condition holds; all other events end it."""
    joined = {pair for group in joins for pair in group.items()}
    for ended in itertools.product(*([(n, e) for e in found] for n, found in events.items())):
        if joined.issuperset(ended) and not any(
            set(group.items()) <= set(ended) for group in joins
        ):
            return True
    return False
