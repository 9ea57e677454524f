"""What charts are expanded to means what the charts mean: golden behaviors run on flexbe_core.

The states are scripted: each ends with the event that the seed gives to its path. The reference
interpreter runs the chart with the same events and must end with the same outcome.
"""

import random
import re

import pytest

from flexbe_core import EventState
from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.user_data import UserData
from flexbe_synthesizer.core.chart_run import run
from flexbe_synthesizer.core.codec import parse_chart

CHARTS = ("place_connector", "two_arms")
SEEDS, MOST_STEPS = 40, 200


def choice(seed, path, events):
    """Return the event that a state always ends with, whoever runs it."""
    return random.Random(f"{seed} {path}").choice(events)


def scripted(state, seed):
    """Return a class in place of a state class."""

    class Scripted(EventState):
        def __init__(self, **arguments):
            outcomes = (
                state.outcomes if isinstance(state.outcomes, tuple) else arguments["outcomes"]
            )
            super().__init__(
                outcomes=list(outcomes),
                input_keys=[port.name for port in state.inputs],
                output_keys=[port.name for port in state.outputs],
            )
            self.arguments = arguments

        def execute(self, userdata):
            read = {port.name: userdata[port.name] for port in state.inputs}
            if state.name == "WaitState":
                return None  # no timer runs out here
            if state.name == "CountAttemptsState":
                userdata.attempt = read["attempt"] + 1
                return "counted" if userdata.attempt <= self.arguments["attempts"] else "exhausted"
            if state.name == "DecisionState":
                return self.arguments["conditions"](read["input_value"])
            for port in state.outputs:
                userdata[port.name] = 0
            return choice(seed, self.path.replace("/run", ""), self.outcomes)

    return Scripted


def behavior(text, library, seed):
    """Return the root container of a behavior's text, its states scripted."""
    lines = [
        li for li in text.splitlines() if not re.match(r"from (cell|flexbe|remodel)_states", li)
    ]
    namespace = {state.name: scripted(state, seed) for state in library.states}
    exec(compile("\n".join(lines), "golden", "exec"), namespace)  # our own golden file
    (found,) = (v for k, v in namespace.items() if k.endswith("SM") and "Mach" not in k)
    return found().create()


def engine_outcome(root):
    for key in ("component_id", "cable_id"):
        root.userdata[key] = "x"
    outer = OperatableStateMachine(outcomes=list(root.outcomes))
    with outer:
        same = {name: name for name in root.outcomes}
        OperatableStateMachine.add("root", root, same)
    engine = Engine(outer, ErrorPolicy.FAIL)
    engine.begin(UserData())
    for now in range(MOST_STEPS):
        outcome = engine.run(float(now))
        if outcome is not None:
            return outcome
    return None


@pytest.mark.parametrize("name", CHARTS)
@pytest.mark.parametrize("seed", range(SEEDS))
def test_the_engine_comes_to_the_outcome_of_the_chart(
    name, seed, golden, library, interfaces_of_golden
):
    chart = parse_chart((golden / "charts" / f"{name}.xml").read_bytes(), f"{name}.xml")
    expected, _steps = run(
        chart, interfaces_of_golden, lambda path, events: choice(seed, f"/root{path}", events), 99
    )
    assert expected is not None
    text = (golden / "behaviors" / f"{name}_sm.py").read_text()
    assert engine_outcome(behavior(text, library, seed)) == expected
