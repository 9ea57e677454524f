import re
import sys
from pathlib import Path

import pytest

from flexbe_core import EventState
from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.user_data import UserData

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[3] / "flexbe/flexbe_testing/test"))

from app_judge import judge

from flexbe_synthesizer.core.chart.chart_reader import parse_chart, read_chart
from flexbe_synthesizer.core.chart.model import State
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.compile import compile_chart
from flexbe_synthesizer.core.library.signature import FromParameter, chart_behavior, state_signature
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_testing.core.app_behavior import Known
from flexbe_testing.core.app_load import define_behavior
from flexbe_testing.edge.doctor import read_packages

GOLDEN = Path(__file__).parents[1] / "golden"
MOST_STEPS = 200


@pytest.fixture(scope="session")
def golden():
    return GOLDEN


@pytest.fixture(scope="session")
def package_path():
    return str(GOLDEN / "packages")


@pytest.fixture(scope="session")
def library(package_path):
    packages, path_warnings = find_packages(package_path)
    library, warnings = read_library(packages)
    assert (path_warnings, warnings) == ((), ())
    return library


@pytest.fixture(scope="session")
def known_to_app(golden):
    """Return the states and behaviors of the golden packages, as the FlexBE App reads them."""
    found = read_packages(sorted((golden / "packages").iterdir()))
    inner = (golden / "behaviors" / "place_connector_sm.py").read_text()
    module = "golden_behaviors.place_connector_sm"
    return Known(found.states, [*found.behaviors, define_behavior(inner, module)])


@pytest.fixture(scope="session")
def app_complaints(known_to_app):
    """Return a function: a behavior's file -> what keeps the App from saving it unchanged."""
    return lambda text: judge(text, known_to_app)


@pytest.fixture(scope="session")
def check(library):
    """Return a function: chart text -> (checked chart, all problems, of its form too)."""

    def check(text, file="chart.xml", charts=None):
        chart, problems = read_chart(text, file)
        if chart is None:
            return None, problems
        checked = check_chart(chart, library, charts or {})
        return checked, (*problems, *checked.problems)

    return check


@pytest.fixture(scope="session")
def machine(library, golden_behaviors):
    """Return a function: name of a golden chart -> the behavior that it becomes."""

    def machine(name):
        chart = parse_chart((GOLDEN / "charts" / name).read_text(), name)
        return compile_chart(check_chart(chart, library, golden_behaviors), "golden_behaviors")

    return machine


@pytest.fixture(scope="session")
def golden_behaviors(golden):
    path = golden / "charts" / "place_connector.xml"
    return {path.name: chart_behavior(parse_chart(path.read_text(), path.name), "golden_behaviors")}


@pytest.fixture(scope="session")
def events_of_golden(library, golden_behaviors):
    """Return what a node of the golden charts ends with, found without the checker's resolving."""

    def events(node):
        if isinstance(node, State):
            (found,) = library.find_states(node.type)
            given = (p.value for p in node.params if p.name == "outcomes")
            return next(given) if isinstance(found.outcomes, FromParameter) else found.outcomes
        found = golden_behaviors.get(node.type) or library.find_behaviors(node.type)[0]
        return found.outcomes

    return events


def scripted(state, choose, entered):
    """Return a class in place of a state class: it reads all its inputs and writes what it says."""

    class Scripted(EventState):
        def __init__(self, **arguments):
            self.offer = state_signature(
                state, {k: tuple(v) if isinstance(v, list) else v for k, v in arguments.items()}
            )
            super().__init__(
                outcomes=list(self.offer.outcomes),
                input_keys=[port.name for port in state.inputs],
                output_keys=[port.name for port in state.outputs],
            )
            self.arguments = arguments

        def on_enter(self, userdata):
            entered.append(self.path.removeprefix("/root").replace("/run", ""))

        def execute(self, userdata):
            read = {port.name: userdata[port.name] for port in state.inputs}
            if state.name == "WaitState":
                return None  # no timer runs out here
            if state.name == "CountAttemptsState":
                userdata.attempt = read["attempt"] + 1
                return "counted" if userdata.attempt <= self.arguments["attempts"] else "exhausted"
            if state.name == "DecisionState":
                return self.arguments["conditions"](read["input_value"])
            outcome = choose(self.path.removeprefix("/root").replace("/run", ""), self.outcomes)
            effect = self.offer.effect(outcome)
            for port in state.outputs:
                if effect is None or port.name in effect.certain:
                    userdata[port.name] = 0
            return outcome

    return Scripted


@pytest.fixture(scope="session")
def on_engine(library):
    """Return a function: behaviors' texts, the outermost last -> the outcome on the real engine.

    `choose` returns the outcome of a state from its path and its outcomes; the paths of the states
    that are entered are added to `entered`. A state that fails, for want of data too, raises.
    """
    imports = re.compile(r"from (p|golden_behaviors|\w+_states)[. ]")

    def on_engine(texts, choose, entered=None):
        entered = [] if entered is None else entered
        namespace = {state.name: scripted(state, choose, entered) for state in library.states}
        for text in texts:
            lines = [line for line in text.splitlines() if not imports.match(line)]
            exec(compile("\n".join(lines), "generated", "exec"), namespace)  # our own text
            (name,) = re.findall(r"^class (\w+)\(Behavior\)", text, re.MULTILINE)
        root = namespace[name]().create()
        for key in ("component_id", "cable_id"):
            root.userdata[key] = "x"
        outer = OperatableStateMachine(outcomes=list(root.outcomes))
        with outer:
            OperatableStateMachine.add("root", root, {name: name for name in root.outcomes})
        engine = Engine(outer, ErrorPolicy.FAIL)
        engine.begin(UserData())
        for now in range(MOST_STEPS):
            outcome = engine.run(float(now))
            if outcome is not None:
                return outcome
        return None

    return on_engine
