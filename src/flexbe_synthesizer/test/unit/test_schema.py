"""The published schemas and the chart reader agree, on our own charts and on generated ones."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from lxml import etree
from synthesizer_support.errors_page import EXAMPLES
from synthesizer_support.strategies import charts

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.problem import errors_in

ROOT = Path(__file__).parents[4]
PACKAGE = ROOT / "src" / "flexbe_synthesizer"
OURS = sorted((*PACKAGE.glob("test/golden/charts/*.xml"), *ROOT.glob("src/*/charts/*.xml")))


@pytest.fixture(scope="session")
def schema():
    return etree.XMLSchema(etree.parse(PACKAGE / "schema" / "remodel_statechart.xsd"))


def complaints(schema, text):
    schema.validate(etree.fromstring(text.encode()))
    return [f"{error.line}: {error.message}" for error in schema.error_log]


def charts_in_docs():
    """Yield every chart shown in a document: whole blocks of XML, and mended examples."""
    for path in sorted((*ROOT.glob("docs/**/*.md"), *ROOT.glob("src/**/README.md"))):
        for text in re.findall(r"```xml\n(.*?)```", path.read_text(), re.DOTALL):
            if re.match(r"\s*(<\?.*\?>\s*|<!--.*-->\s*)*<statemachine", text):
                yield f"{path.parent.name}/{path.name}", text
    for example in EXAMPLES:
        yield f"errors.md: {example.slug}", example.files("+")[example.chart]


def test_there_are_charts_to_validate():
    assert len(OURS) >= 8
    assert len(list(charts_in_docs())) > 50


def test_our_charts_are_valid(schema):
    for path in OURS:
        assert complaints(schema, path.read_text().partition("?>")[2]) == [], path.name


def test_the_charts_in_the_docs_are_valid(schema):
    for page, text in charts_in_docs():
        assert complaints(schema, text) == [], f"{page}: {text}"
        assert errors_in(read_chart(text, page)[1]) == ()


@given(charts())
def test_a_chart_that_is_written_is_valid(schema, chart):
    assert complaints(schema, write_chart(chart).partition("?>")[2]) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<datamodel>", '<datamodel name="x">'),
        ('ext:attempts="2"', 'ext:attempts="0"'),
        ('ext:timeout_s="40"', 'ext:timeout_s="-40"'),
        ('ext:timeout_s="40"', 'timeout_s="40"'),
        ('ext:autonomy="low"', 'ext:autonomy="some"'),
        ("100-199: given up", "100-199 given up"),
        ('id="Left"', 'ident="Left"'),
        ('<ext:when state="Left" event="located"/>', "<ext:whenever/>"),
        ("</ext:priority>", "<ext:important/></ext:priority>"),
        ('value="is_true"', 'values="is_true"'),
    ],
)
def test_what_the_schema_refuses_the_chart_reader_refuses_too(schema, golden, old, new):
    text = (golden / "charts" / "two_arms.xml").read_text().partition("?>")[2]
    assert old in text
    wrong = text.replace(old, new)
    assert complaints(schema, wrong) != []
    assert errors_in(read_chart(wrong, "chart.xml")[1])
