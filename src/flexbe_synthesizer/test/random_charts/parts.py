"""The states, and the limits of nodes, that random charts are made of."""

from __future__ import annotations

import json
import random
from dataclasses import dataclass

from lxml import etree

from random_charts.chart_xml import EXT
from random_charts.kinds import KINDS

KEYS = ["item", "result", "count", "target", "pose", "error_code", "part", "value", "data", "x"]
KEYS += ["self_", "name"]


@dataclass
class Part:
    """A node with what the scope around it must know."""

    element: etree._Element
    events: list[str]
    inputs: list[str]
    outputs: list[str]
    own: tuple[str, ...]


def chance(rng: random.Random, share: float) -> bool:
    """Return whether something happens that happens with a share of the seeds."""
    return rng.random() < share


def draw_state(rng: random.Random, node_id: str) -> Part:
    """Return a state of any class, with parameters."""
    name = rng.choice(list(KINDS))
    kind = KINDS[name]
    prefix = rng.choice(["", "", "", "scripted_states/", "scripted_states__"])
    element = etree.Element("state", id=node_id)
    element.set("type", (prefix if kind.is_scripted else "") + name)
    params: dict[str, object] = {}
    own, inputs, outputs = kind.outcomes, kind.inputs, kind.outputs
    if not own:
        own = tuple(rng.sample(["left", "right", "no way", "failed", "on-hold"], rng.randint(1, 4)))
        params["outcomes"] = list(own)
    if inputs is None:
        inputs = tuple(rng.sample(KEYS[:8], rng.randint(1, 3)))
        params["input_keys"] = list(inputs)
    if outputs is None:
        outputs = tuple(rng.sample(KEYS[:8], rng.randint(1, 3)))
        params["output_keys"] = list(outputs)
    if name == "UserDataState":
        params["data"] = rng.choice([0, 7, True, None, [1, 2], "text", {"a": [None]}])
    if name == "CheckConditionState":
        params["predicate"] = rng.choice(["is_true", "is_false", "is_none", "is_given"])
    if name == "OperatorDecisionState":
        params["suggestion"] = rng.choice(own)
    if name == "WaitState":
        params["wait_time"] = rng.choice([0.25, 0.6, 2.0])
    if kind.keeps_time and chance(rng, 0.4):
        element.set("topic", "other_cell/ability")
    for key, value in params.items():
        etree.SubElement(element, "param", name=key, value=json.dumps(value))
    return Part(element, list(own), list(inputs), list(outputs), own=own)


def draw_limits(rng: random.Random, part: Part, concurrent: bool) -> None:
    """Add limits of attempts and time, and error routes; these lead somewhere later."""
    element = part.element
    name = element.get("type", "").rpartition("/")[2].rpartition("__")[2]
    kind = KINDS.get(name) if element.tag == "state" else None
    is_alone = element.tag == f"{EXT}priority"  # its timer would stand still
    if not is_alone and chance(rng, 0.2):
        element.set(f"{EXT}timeout_s", str(rng.choice([0.25, 0.7, 1.5, 4.0])))
        if (kind is None or not kind.keeps_time) and "timed_out" not in part.events:
            part.events.append("timed_out")
    if not concurrent and chance(rng, 0.25):
        element.set(f"{EXT}attempts", str(rng.randint(1, 3)))
        if "exhausted" not in part.events:
            part.events.append("exhausted")
    is_routed = "failed" in part.own and "error_code" in part.outputs
    if is_routed and not concurrent and chance(rng, 0.6):
        by_name = "JAMMED: ?; above_behavior: ?; 1-4: ?"
        element.set(f"{EXT}on_error", rng.choice(["1-2: ?; 5: ?", by_name]))


def container_part(element: etree._Element, scope: etree._Element) -> Part:
    """Return what the scope around a container or behavior must know of it."""
    data = scope.find("datamodel")
    own = tuple(o.get("name") for o in data.iter("outcome"))
    names = {tag: [p.get("name") for p in data.findall(tag)] for tag in ("input", "output")}
    return Part(element, list(own), names["input"], names["output"], own=own)
