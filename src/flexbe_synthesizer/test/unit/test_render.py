"""Golden charts become golden behaviors, byte for byte, that the FlexBE App can read."""

import ast
import dataclasses

import pytest
from app_judge import saved_by_app
from hypothesis import given
from hypothesis import strategies as st
from synthesizer_support.rendering import rendered

from flexbe_synthesizer.core.chart.model import freeze
from flexbe_synthesizer.core.chart.problem import ChartError
from flexbe_synthesizer.core.compile import compile_chart, manifest_of
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.library.sources import write_manifest
from flexbe_synthesizer.core.machine.machine import Container, walk
from flexbe_synthesizer.core.machine.machine_reader import ManualSectionError, read_manual_sections

CHARTS = ["plain.xml", "place_connector.xml", "wire_task.xml", "two_arms.xml"]


@pytest.mark.parametrize("chart", CHARTS)
def test_a_golden_chart_becomes_the_golden_behavior(chart, machine, golden):
    found = machine(chart)
    code = golden / "behaviors" / chart.replace(".xml", "_sm.py")
    manifest = golden / "behaviors" / chart
    assert rendered(found) == code.read_text()
    assert write_manifest(manifest_of(found), found.description) == manifest.read_text()


@pytest.mark.parametrize("chart", CHARTS)
def test_the_app_saves_a_golden_behavior_unchanged(chart, golden, app_complaints):
    text = (golden / "behaviors" / chart.replace(".xml", "_sm.py")).read_text()
    assert app_complaints(text) == []


@given(st.text(), st.text())
def test_no_description_or_value_can_break_out_of_its_place(
    machine, app_complaints, description, value
):
    found = machine("place_connector.xml")
    hostile = dataclasses.replace(
        found,
        description=f"x{description}",
        root=dataclasses.replace(
            found.root,
            userdata=tuple(pair._replace(value=freeze(value)) for pair in found.root.userdata),
        ),
    )
    text = rendered(hostile)
    assert app_complaints(text) == []
    assigned = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Assign)]
    found_values = [n.value.value for n in assigned if "userdata" in ast.unparse(n.targets[0])]
    assert found_values == [value] * len(found.root.userdata)


def test_manual_sections_are_kept_to_the_byte(machine, app_complaints, known_to_app):
    found = machine("plain.xml")
    manual = {
        "IMPORT": "\nimport math  # [keep] def this:\n",
        "INIT": "\n        self.x = 1\n\n        ",
        "CREATE": "\n        return_ = {'a': (1)}\n        ",
        "FUNC": "\n    def mine(self):\n        return self.x\n    ",
    }
    text = rendered(found, manual)
    assert read_manual_sections(text) == manual
    assert rendered(found, read_manual_sections(text)) == text
    assert app_complaints(text) == []
    assert read_manual_sections(saved_by_app(text, known_to_app)) == manual


@pytest.mark.parametrize(
    "text",
    [
        "class A: pass",
        "# [MANUAL_INIT]\n",
        "# [/MANUAL_INIT]\n# [MANUAL_INIT]",
        "# [MANUAL_INIT]# [/MANUAL_INIT]# [MANUAL_INIT]# [/MANUAL_INIT]",
        "# [MANUAL_INIT]# [/MANUAL_INIT]# [/MANUAL_INIT]",
    ],
)
def test_sections_that_cannot_be_kept_are_refused(text):
    with pytest.raises(ManualSectionError):
        read_manual_sections(text)


def test_a_chart_with_errors_becomes_nothing(check):
    text = (
        '<statemachine name="A" initial="S"><datamodel><outcome name="done"/></datamodel>'
        '<state id="S" type="NoSuchState"/></statemachine>'
    )
    with pytest.raises(ChartError, match="unknown-class"):
        compile_chart(check(text)[0], "p")


@pytest.mark.parametrize("chart", CHARTS)
def test_nothing_overlaps_on_the_canvas(chart, machine):
    root = machine(chart).root
    layout = lay_out(root)
    containers = {"": root} | {p: c.content for p, c in walk(root)}
    for path, container in containers.items():
        if not isinstance(container, Container):
            continue
        boxes = [(*layout.children[path][c.label], width_of(c)) for c in container.children] + [
            (*point, 80) for point in layout.outcomes[path].values()
        ]
        for index, (x, y, width) in enumerate(boxes):
            assert x >= 0 <= y
            for other_x, other_y, other_width in boxes[:index]:
                apart_x = x >= other_x + other_width or other_x >= x + width
                assert apart_x or abs(y - other_y) >= 60


def width_of(child):
    """Return the width that a box has in the App, about: its longer line at 8 pixels a letter."""
    name = getattr(getattr(child.content, "state", None), "name", child.label)
    return max(len(child.label), len(name)) * 8 + 20


def test_every_golden_chart_is_tested(golden):
    assert {p.name for p in (golden / "charts").glob("*.xml")} == set(CHARTS)


@pytest.mark.parametrize(
    ("spelled", "code"),
    [("404", "'404'"), ("true", "'true'"), ("1.50", "'1.50'"), ("'5'", "'5'"), ("null", "None")],
)
def test_what_is_declared_a_string_takes_its_text_as_it_stands(check, spelled, code):
    checked, problems = check(
        '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="Look">'
        '<datamodel><outcome name="x"/><input name="component_id" type="string"/></datamodel>'
        '<state id="Look" type="LocateComponentState">'
        f'<param name="view" value="{spelled}"/><transition event="located" target="x"/>'
        '<transition event="failed" target="x"/></state></statemachine>'
    )
    assert problems == ()
    text = rendered(compile_chart(checked, "cell"))
    assert f"view={code}" in text


def test_a_container_may_have_any_name_that_a_chart_can_give_it(check, golden):
    text = (golden / "charts" / "two_arms.xml").read_text().replace('"Place"', '"Bü²½"')
    checked, problems = check(text)
    assert problems == ()
    code = rendered(compile_chart(checked, "cell"))
    ast.parse(code)
    assert "_sm_b____" in code


def test_the_app_saves_a_container_with_any_letters_in_its_name_unchanged(
    check, golden, app_complaints
):
    text = (golden / "charts" / "two_arms.xml").read_text().replace('"Place"', '"Über gabe"')
    checked, problems = check(text)
    assert problems == ()
    code = rendered(compile_chart(checked, "cell"))
    assert "_sm_über_gabe_" in code
    assert app_complaints(code) == []
