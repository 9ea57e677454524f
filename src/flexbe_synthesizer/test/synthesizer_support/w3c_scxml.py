"""For tests: the rules of W3C SCXML 1.0 (https://www.w3.org/TR/scxml/) that charts can break.

W3C's own schema is in no package registry, so the sections of the recommendation are tables here:
what an element must have, may have and may hold (3.2 to 3.9, 4.2 to 4.9, 5.2 to 5.4, 6.2, 6.3), and
what holds between elements. What is not in the tables is refused.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from lxml import etree

NAMESPACE = "http://www.w3.org/2005/07/scxml"
EXECUTABLE = {"raise", "if", "foreach", "log", "assign", "script", "send", "cancel"}
INSIDE = {"state", "parallel", "final", "history", "transition", "onentry", "onexit", "invoke"}
# element: required attributes, optional ones, children
ELEMENTS: Mapping[str, tuple[set[str], set[str], set[str]]] = {
    "scxml": (
        {"version"},
        {"initial", "name", "datamodel", "binding"},
        {"state", "parallel", "final", "datamodel", "script"},
    ),
    "state": (set(), {"id", "initial"}, {*INSIDE, "initial", "datamodel"}),
    "parallel": (set(), {"id"}, {*INSIDE, "datamodel"} - {"final"}),
    "final": (set(), {"id"}, {"onentry", "onexit", "donedata"}),
    "transition": (set(), {"event", "cond", "target", "type"}, EXECUTABLE),
    "onentry": (set(), set(), EXECUTABLE),
    "onexit": (set(), set(), EXECUTABLE),
    "datamodel": (set(), set(), {"data"}),
    "data": ({"id"}, {"src", "expr"}, set()),
    "assign": ({"location"}, {"expr"}, set()),
    "raise": ({"event"}, set(), set()),
    "send": (set(), {"id", "event", "target", "type", "delay", "namelist"}, set()),
    "cancel": (set(), {"sendid", "sendidexpr"}, set()),
}
ID = re.compile(r"[^\W\d][\w.-]*\Z")  # xsd:ID, an NCName
EVENT = re.compile(r"(\*|[\w-]+(\.[\w-]+)*(\.\*)?)\Z")  # 3.12.1, one descriptor
DELAY = re.compile(r"\d*(\.\d+)?(ms|s)\Z")  # CSS2, 6.2.2
NMTOKEN = re.compile(r"[\w.:-]+\Z")


def faults(text: str) -> list[str]:
    """Return what in a document is not as W3C SCXML says."""
    root = etree.fromstring(text.encode())
    found = [] if root.tag == f"{{{NAMESPACE}}}scxml" else ["the root is no <scxml>"]
    found += [] if root.get("version") == "1.0" else ["version must be 1.0"]
    found += [] if NMTOKEN.match(root.get("name", "a")) else ["name is no NMTOKEN"]
    for element in root.iter():
        found += _faults_of_element(element)
    ids = [element.get("id") for element in root.iter() if element.get("id") is not None]
    found += [f"id {name} stands twice" for name in {n for n in ids if ids.count(n) > 1}]
    found += [f"{name!r} is no id" for name in ids if not ID.match(name)]
    states = {e.get("id"): e for e in root.iter() if _tag(e) in ("state", "parallel", "final")}
    for element in root.iter():
        found += _faults_between(element, states)
    return found


def _tag(element: etree._Element) -> str:
    name: str = etree.QName(element).localname
    return name


def _faults_of_element(element: etree._Element) -> list[str]:
    tag = _tag(element)
    if etree.QName(element).namespace != NAMESPACE or tag not in ELEMENTS:
        return [f"<{tag}> is no element of SCXML"]
    required, optional, children = ELEMENTS[tag]
    found = [f"<{tag}> lacks {name}" for name in required - set(element.attrib)]
    found += [f"<{tag}> has {name}" for name in set(element.attrib) - required - optional]
    found += [f"<{_tag(c)}> in <{tag}>" for c in element if _tag(c) not in children]
    if (element.text or "").strip() or (element.tail or "").strip():
        found.append(f"text at <{tag}>")
    for event in (element.get("event") or "").split():
        found += [] if EVENT.match(event) else [f"{event!r} is no event"]
    if tag == "transition" and not {"event", "cond", "target"} & set(element.attrib):
        found.append("a transition needs an event, a condition or a target (3.5.1)")
    if tag == "transition" and _tag(element.getparent()) == "final":
        found.append("nothing leads out of a final state")
    if tag == "send" and not DELAY.match(element.get("delay", "0s")):
        found.append(f"{element.get('delay')!r} is no delay")
    if tag == "data" and element.get("id", "").startswith("_"):
        found.append("data that begin with _ are the processor's (5.10)")
    if tag == "cancel" and ("sendid" in element.attrib) == ("sendidexpr" in element.attrib):
        found.append("<cancel> names one message")
    return found


def _faults_between(element: etree._Element, states: Mapping[str, etree._Element]) -> list[str]:
    tag = _tag(element)
    found: list[str] = []
    for target in (element.get("target") or "").split() if tag == "transition" else ():
        found += [] if target in states else [f"no state {target}"]
    initial = element.get("initial")
    if initial is not None:
        inside = {e.get("id") for e in element.iterdescendants()}
        found += [] if initial in inside else [f"initial {initial} is not inside (3.3.1)"]
        found += [] if initial in states else [f"no state {initial}"]
    if tag == "cancel":
        sent = {e.get("id") for e in element.getroottree().iter(f"{{{NAMESPACE}}}send")}
        found += [] if element.get("sendid") in sent else ["<cancel> of what is never sent"]
    return found
