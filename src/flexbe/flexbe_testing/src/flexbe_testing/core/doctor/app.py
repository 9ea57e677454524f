"""What the FlexBE App cannot read, or loses, by the rules of core/app."""

from __future__ import annotations

import re
from collections.abc import Iterator

from flexbe_testing.core.app.behavior import Known
from flexbe_testing.core.app.states import judge_state
from flexbe_testing.core.app.load import load_behavior
from flexbe_testing.core.app.text import AppLoadError
from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.core.doctor.module import Kind, Module

_RULE = "app"
_PLACE = re.compile(r"line (\d+): ")

# Works on every engine; only the App, and only in behaviors that it saves, loses the transition.
_ONLY_IN_THE_APP = "reads outcome "


def check_app(module: Module, known: Known) -> Iterator[Finding]:
    """Find what the App does not see of states, and what it cannot load or loses of behaviors.

    Args:
        module: a user's file.
        known: the states and behaviors that the App would find.
    """
    for text in judge_state(module.text, module.file):
        place = _PLACE.match(text)
        line = int(place[1]) if place else 1
        severity = Severity.NOTE if _ONLY_IN_THE_APP in text else Severity.WARNING
        yield module.finding(line, _RULE, severity, _PLACE.sub("", text, count=1))
    for found in module.classes:
        if found.kind is Kind.BEHAVIOR:
            try:
                for what in load_behavior(module.text, known).lost:
                    text = f"when the App loads and saves it: {what}"
                    yield module.finding(found.node, _RULE, Severity.NOTE, text)
            except AppLoadError as error:
                text = f"the App cannot load it: {error}"
                yield module.finding(found.node, _RULE, Severity.WARNING, text)
