import os
from pathlib import Path

import pytest

from flexbe_synthesizer.core.check import check_chart
from flexbe_synthesizer.core.codec import parse_chart, read_chart
from flexbe_synthesizer.core.compile import compile_chart
from flexbe_synthesizer.core.interpreter import Interface
from flexbe_synthesizer.core.model import Behavior, State
from flexbe_synthesizer.core.signature import FromParameter, chart_behavior
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_testing.app.judge import judge
from flexbe_testing.app.known import Known
from flexbe_testing.app.load import define_behavior
from flexbe_testing.edge.app_packages import read_packages

GOLDEN = Path(__file__).parents[1] / "golden"


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
def machine(library):
    """Return a function: name of a golden chart -> the behavior that it becomes."""

    def machine(name):
        charts = GOLDEN / "charts"
        inner = parse_chart((charts / "place_connector.xml").read_text(), "place_connector.xml")
        known = {"place_connector.xml": chart_behavior(inner, "golden_behaviors")}
        chart = parse_chart((charts / name).read_text(), os.path.basename(name))
        return compile_chart(check_chart(chart, library, known), "golden_behaviors")

    return machine


@pytest.fixture(scope="session")
def golden_behaviors(golden):
    path = golden / "charts" / "place_connector.xml"
    return {path.name: chart_behavior(parse_chart(path.read_text(), path.name), "golden_behaviors")}


@pytest.fixture(scope="session")
def interfaces_of_golden(library, golden_behaviors):
    """Return what the nodes of the golden charts offer, found without the checker's resolving."""

    def interface(node):
        if isinstance(node, State):
            (found,) = library.find_states(node.type)
            outcomes = found.outcomes
            if isinstance(outcomes, FromParameter):
                (outcomes,) = (p.value for p in node.params if p.name == outcomes.parameter)
            keeps_time = any(p.name == "timeout_s" for p in found.parameters)
            inputs = tuple(port.name for port in found.inputs)
            return Interface(outcomes, inputs, tuple(p.name for p in found.outputs), keeps_time)
        assert isinstance(node, Behavior)
        found = golden_behaviors.get(node.type) or library.find_behaviors(node.type)[0]
        inputs = tuple(port.name for port in found.inputs if not port.optional)
        return Interface(found.outcomes, inputs, tuple(port.name for port in found.outputs))

    return interface
