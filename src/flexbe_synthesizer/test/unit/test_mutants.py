"""Charts damaged at random: each has errors with places, or becomes a behavior that is closed."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.export.render_python import render_python

NASTY = (
    "",
    " ",
    "a/b",
    "'",
    "preempted",
    "Locate",
    "failed",
    "0",
    "-1",
    "[",
    "é",
    "x def y",
    "Fix",
)


@st.composite
def mutants(draw, text):
    """Draw the text with up to four attribute values, names or lines changed."""
    for _ in range(draw(st.integers(1, 4))):
        lines = text.splitlines()
        kind = draw(st.sampled_from(["value", "name", "drop", "double", "swap", "byte"]))
        index, other = (draw(st.integers(1, len(lines) - 1)) for _ in range(2))
        if kind == "drop":
            del lines[index]
        elif kind == "double":
            lines.insert(other, lines[index])
        elif kind == "swap":
            lines[index], lines[other] = lines[other], lines[index]
        elif kind == "byte":
            at = draw(st.integers(0, len(lines[index])))
            lines[index] = lines[index][:at] + draw(st.characters()) + lines[index][at:]
        else:
            values = re.findall('="([^"]*)"', text)
            new = draw(st.sampled_from(values) | st.sampled_from(NASTY) | st.text(max_size=4))
            pattern = '="[^"]*"' if kind == "value" else r"\w+(?==)"
            found = list(re.finditer(pattern, lines[index]))
            if found:
                where = draw(st.sampled_from(found))
                put = f'="{new}"' if kind == "value" else new
                lines[index] = lines[index][: where.start()] + put + lines[index][where.end() :]
        text = "\n".join(lines)
    return text


@pytest.mark.parametrize("name", ["plain.xml", "place_connector.xml"])
def test_a_damaged_chart_is_refused_or_becomes_a_closed_behavior(
    name, golden, library, app_complaints
):
    good = (golden / "charts" / name).read_text()

    @given(mutants(good))
    def hold(text):
        chart, problems = read_chart(text, "mutant.xml")
        assert chart is not None or errors_in(problems)
        if chart is None:
            return
        checked = check_units([Unit(chart, "golden_behaviors")], library)["mutant.xml"]
        problems = (*problems, *checked.problems)
        lines = text.count("\n") + 1
        for problem in problems:
            assert 1 <= problem.position.line <= lines
            assert problem.position.column >= 1
        if not errors_in(problems):
            machine = compile_chart(checked, "golden_behaviors")
            assert app_complaints(render_python(machine, lay_out(machine.root), {})) == []

    hold()
